#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <modsearch/problem/geometry_internal.hpp>
#include <modsearch/problem/json_internal.hpp>

namespace modsearch::detail {
namespace {

/// Words, numbers and brackets of a VRML 2.0 file. Commas are white space, and a comment runs from # to the end of its
/// line (ISO/IEC 14772-1:1997, 5.1).
class VrmlTokens {
 public:
  explicit VrmlTokens(std::string_view text) : text_{text} { advance(); }

  /// The current word, number or bracket; empty at the end of the file.
  [[nodiscard]] std::string_view current() const { return current_; }
  [[nodiscard]] bool at_end() const { return current_.empty(); }
  void advance() {
    skip_space();
    std::size_t length = 0;
    while (length < text_.size() && !is_space(text_[length]) && !is_mark(text_[length])) ++length;
    if (length == 0 && !text_.empty()) length = 1;  // a bracket
    current_ = text_.substr(0, length);
    text_.remove_prefix(length);
  }
  [[nodiscard]] std::string_view take() {
    const std::string_view word = current_;
    require_more();
    advance();
    return word;
  }
  void expect(std::string_view word) {
    require_more();
    if (current_ != word) refuse(fmt::format("'{}' stands where '{}' is due", current_, word));
    advance();
  }
  template <typename Number>
  [[nodiscard]] Number number() {
    require_more();
    Number value{};
    const char* const end = current_.data() + current_.size();
    const auto [stop, error] = std::from_chars(current_.data(), end, value);
    if (error != std::errc{} || stop != end) refuse(fmt::format("'{}' is not a number of this kind", current_));
    advance();
    return value;
  }
  [[noreturn]] void refuse(const std::string& what) const {
    throw std::runtime_error(fmt::format("cannot be read: line {}: {}", line_, what));
  }

 private:
  void require_more() const {
    if (at_end()) refuse("the file ends too early");
  }
  static bool is_space(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n' || c == ','; }
  static bool is_mark(char c) { return c == '{' || c == '}' || c == '[' || c == ']' || c == '#'; }
  void skip_space() {
    while (!text_.empty() && (is_space(text_.front()) || text_.front() == '#')) {
      if (text_.front() == '#') {
        text_.remove_prefix(std::min(text_.find('\n'), text_.size()));
      } else {
        if (text_.front() == '\n') ++line_;
        text_.remove_prefix(1);
      }
    }
  }

  std::string_view text_;
  std::string_view current_;
  int line_ = 1;
};

/// The file as a whole: any number of Shape { appearance .. geometry IndexedFaceSet {..} }.
class VrmlReader {
 public:
  explicit VrmlReader(std::string_view text) : tokens_{text} {}

  [[nodiscard]] TriangleMesh read() {
    while (!tokens_.at_end()) {
      if (tokens_.current() != "Shape") {
        tokens_.refuse(fmt::format("'{}' is not supported, only Shape nodes are", tokens_.current()));
      }
      tokens_.advance();
      read_shape();
    }
    return std::move(mesh_);
  }

 private:
  void read_shape() {
    tokens_.expect("{");
    while (tokens_.current() != "}") {
      const std::string_view field = tokens_.take();
      if (field == "appearance") {
        tokens_.advance();  // the kind of node
        skip_node();
      } else if (field == "geometry") {
        tokens_.expect("IndexedFaceSet");
        read_faces();
      } else {
        tokens_.refuse(fmt::format("field '{}' of a Shape is not supported", field));
      }
    }
    tokens_.advance();
  }

  /// Looks stay aside: everything up to the brace that closes the node.
  void skip_node() {
    tokens_.expect("{");
    for (int depth = 1; depth > 0;) {
      const std::string_view word = tokens_.take();
      if (word == "{") ++depth;
      if (word == "}") --depth;
      if (word.front() == '"') tokens_.refuse("texts are not supported");  // they may hold braces
    }
  }

  void read_faces() {
    const auto first = static_cast<int>(mesh_.vertices.size());
    std::vector<int> indices;
    tokens_.expect("{");
    while (tokens_.current() != "}") {
      const std::string_view field = tokens_.take();
      if (field == "coord") {
        read_points();
      } else if (field == "coordIndex") {
        tokens_.expect("[");
        while (tokens_.current() != "]") indices.push_back(tokens_.number<int>());
        tokens_.advance();
      } else if (field == "solid" || field == "ccw") {
        tokens_.advance();  // which side is out, which a surface does not ask
      } else {
        tokens_.refuse(fmt::format("field '{}' of an IndexedFaceSet is not supported", field));
      }
    }
    add_faces(indices, first);
    tokens_.advance();
  }

  void read_points() {
    tokens_.expect("Coordinate");
    tokens_.expect("{");
    tokens_.expect("point");
    tokens_.expect("[");
    while (tokens_.current() != "]") {
      const auto x = tokens_.number<double>();
      const auto y = tokens_.number<double>();
      mesh_.vertices.emplace_back(x, y, tokens_.number<double>());
    }
    tokens_.advance();
    tokens_.expect("}");
  }

  /// Faces are convex polygons whose ends are marked by -1 (6.23 of the standard); each becomes a fan of triangles.
  void add_faces(const std::vector<int>& indices, int first) {
    const auto n_points = static_cast<int>(mesh_.vertices.size()) - first;
    std::vector<int> face;
    const auto close = [&] {
      if (face.size() == 1 || face.size() == 2) tokens_.refuse("a face has fewer than 3 points (limit 3)");
      for (std::size_t i = 2; i < face.size(); ++i) mesh_.triangles.emplace_back(face[0], face[i - 1], face[i]);
      face.clear();
    };
    for (const int index : indices) {
      if (index == -1) {
        close();
        continue;
      }
      if (index < 0 || index >= n_points) tokens_.refuse(fmt::format("point {} is not in [0, {})", index, n_points));
      face.push_back(first + index);
    }
    close();
  }

  VrmlTokens tokens_;
  TriangleMesh mesh_;
};

}  // namespace

TriangleMesh load_vrml(const std::filesystem::path& file) {
  const std::string text = read_text(file, file.string());
  if (!text.starts_with("#VRML V2.0 utf8")) {
    throw std::runtime_error("cannot be read: it does not begin with \"#VRML V2.0 utf8\"");
  }
  return VrmlReader{text}.read();
}

}  // namespace modsearch::detail
