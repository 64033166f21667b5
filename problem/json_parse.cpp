#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <modsearch/problem/files.hpp>
#include <modsearch/problem/json_internal.hpp>

namespace modsearch::detail {
namespace {

/// Line and column of byte `position` (0-based) of `text`, both counted from 1.
std::string place(std::string_view text, std::size_t position) {
  position = std::min(position, text.size());
  const std::string_view before = text.substr(0, position);
  const auto line = 1 + std::count(before.begin(), before.end(), '\n');
  const std::size_t line_start = before.rfind('\n') == std::string_view::npos ? 0 : before.rfind('\n') + 1;
  return fmt::format("line {}, column {}", line, position - line_start + 1);
}

[[noreturn]] void refuse(const JsonSource& source, std::string_view text, std::size_t position,
                         const std::string& what) {
  throw FileError(fmt::format("{}: {}: {}", source.label, place(text, position), what));
}

// What stands for bare Infinity while nlohmann's parser, which knows none, is at work: texts of the same length, so
// that columns stay right, with a character that no genuine text may contain.
constexpr std::string_view kInfinity = "Infinity";
constexpr std::string_view kPlusStandIn = "\"\\u0000\"";
constexpr std::string_view kMinusStandIn = "\"-\\u0000\"";

/// Looks at everything outside texts: replaces bare Infinity and refuses deep nesting, before any parser recurses.
void prepare(std::string& text, const JsonSource& source) {
  int depth = 0;
  bool within_text = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    const std::string_view rest = std::string_view{text}.substr(i);
    if (within_text) {
      if (c == '\0' || rest.starts_with("\\u0000"))
        refuse(source, text, i, "the character U+0000 is not allowed in a text");
      if (c == '\\') ++i;  // whatever follows does not end the text
      if (c == '"') within_text = false;
      continue;
    }
    if (c == '"') {
      within_text = true;
    } else if (c == '[' || c == '{') {
      if (++depth > kDeepestNesting) {
        refuse(source, text, i,
               fmt::format("nested deeper than {} levels (limit {})", kDeepestNesting, kDeepestNesting));
      }
    } else if (c == ']' || c == '}') {
      --depth;
    } else if (rest.starts_with("NaN")) {
      refuse(source, text, i, "NaN is not a number that a file may hold");
    } else if (rest.starts_with(kInfinity)) {
      const bool negative = i > 0 && text[i - 1] == '-';
      if (negative) {
        text.replace(i - 1, kMinusStandIn.size(), kMinusStandIn);
      } else {
        text.replace(i, kPlusStandIn.size(), kPlusStandIn);
      }
      i += kInfinity.size() - 1;
    }
  }
}

/// Builds the document from the parser's events, so that duplicate keys are seen.
class Builder final : public nlohmann::json_sax<Json> {
 public:
  Builder(const JsonSource& source, std::string_view text) : source_{source}, text_{text} {}

  [[nodiscard]] Json take() { return std::move(root_); }

  bool null() override { return add(nullptr); }
  bool boolean(bool value) override { return add(value); }
  bool number_integer(number_integer_t value) override { return add(value); }
  bool number_unsigned(number_unsigned_t value) override { return add(value); }
  bool number_float(number_float_t value, const string_t& /*token*/) override { return add(value); }
  bool string(string_t& value) override {
    constexpr double kInf = std::numeric_limits<double>::infinity();
    if (value == std::string_view("\0", 1)) return add(kInf);
    if (value == std::string_view("-\0", 2)) return add(-kInf);
    return add(std::move(value));
  }
  bool binary(binary_t& /*value*/) override { return false; }
  bool start_object(std::size_t /*size*/) override { return open(Json::object()); }
  bool start_array(std::size_t /*size*/) override { return open(Json::array()); }
  bool end_object() override { return close(); }
  bool end_array() override { return close(); }
  bool key(string_t& name) override {
    if (open_.back()->contains(name)) {
      const JsonCursor here{*open_.back(), std::make_shared<JsonSource>(source_), pointer()};
      here.fail(fmt::format("key {} occurs twice", preview(name)));
    }
    keys_.back() = std::move(name);
    return true;
  }
  bool parse_error(std::size_t position, const std::string& token, const nlohmann::detail::exception& error) override {
    // `position` counts the bytes read, the culprit's last one and even the end of the file included.
    if (position > text_.size()) refuse(source_, text_, text_.size(), "the file ends too early");
    constexpr int kOutOfRange = 406;
    if (error.id == kOutOfRange) {
      refuse(source_, text_, position - std::min(position, token.size()),
             fmt::format("the number {} is too large (limit: 1.8e308)", token));
    }
    constexpr std::size_t kShown = 16;
    const std::size_t begin = position > kShown ? position - kShown : 0;
    std::string near{text_.substr(begin, position - begin)};
    std::replace_if(
        near.begin(), near.end(), [](char c) { return c < ' ' || c > '~'; }, ' ');  // one line, ASCII
    refuse(source_, text_, std::max<std::size_t>(position, 1) - 1,
           fmt::format("this is not JSON: {} at the end of '{}'", reason(error.what()), near));
  }

 private:
  /// The parser's own reason without its prefixes: "... - invalid literal; last read: ..." and the like.
  static std::string reason(const std::string& message) {
    std::string text = message;
    for (const std::string_view prefix : {"syntax error while parsing ", "parse error: ", " - "}) {
      const std::size_t found = text.find(prefix);
      if (found != std::string::npos) text = text.substr(found + prefix.size());
    }
    text = text.substr(0, text.find("; last read"));
    text.erase(std::remove_if(text.begin(), text.end(), [](char c) { return c == '\n' || c == '\r'; }), text.end());
    return text;
  }

  [[nodiscard]] std::string pointer() const {
    std::string result;
    for (std::size_t i = 0; i + 1 < open_.size(); ++i) {
      result += "/" + (open_[i]->is_array() ? std::to_string(open_[i]->size() - 1) : keys_[i]);
    }
    return result;
  }

  Json* place_value(Json value) {
    if (open_.empty()) {
      root_ = std::move(value);
      return &root_;
    }
    Json& parent = *open_.back();
    if (parent.is_array()) {
      parent.push_back(std::move(value));
      return &parent.back();
    }
    return &(parent[keys_.back()] = std::move(value));
  }
  bool add(Json value) {
    place_value(std::move(value));
    return true;
  }
  bool open(Json value) {
    Json* const placed = place_value(std::move(value));
    open_.push_back(placed);  // stays valid: its parents do not grow before it is closed
    keys_.emplace_back();
    return true;
  }
  bool close() {
    open_.pop_back();
    keys_.pop_back();
    return true;
  }

  const JsonSource& source_;
  std::string_view text_;
  Json root_;
  std::vector<Json*> open_;
  std::vector<std::string> keys_;  // of the member that is being read, one per open value
};

}  // namespace

std::string read_text(const std::filesystem::path& file, const std::string& label, std::uintmax_t largest) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(file, error);
  if (status.type() == std::filesystem::file_type::not_found) throw FileError(label + ": there is no such file");
  if (std::filesystem::is_directory(status)) throw FileError(label + ": is a directory, not a file");
  if (error) throw FileError(fmt::format("{}: cannot be read: {}", label, error.message()));
  if (!std::filesystem::is_regular_file(status)) throw FileError(label + ": is not a regular file");
  const std::uintmax_t size = std::filesystem::file_size(file, error);
  if (!error && size > largest) {
    throw FileError(fmt::format("{}: has {} bytes, which is too many (limit {})", label, size, largest));
  }
  std::ifstream stream{file, std::ios::binary};
  if (!stream) throw FileError(fmt::format("{}: cannot be opened: {}", label, std::strerror(errno)));
  std::string text{std::istreambuf_iterator<char>{stream}, {}};
  if (stream.bad()) throw FileError(label + ": cannot be read to its end");
  return text;
}

JsonDocument parse_json(std::string text, JsonSource source) {
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
  if (text.starts_with(kByteOrderMark)) text.erase(0, kByteOrderMark.size());
  if (text.starts_with("\xFF\xFE") || text.starts_with("\xFE\xFF")) {
    throw FileError(source.label + ": is UTF-16 text, but JSON is UTF-8");
  }
  if (text.find_first_not_of(" \t\r\n") == std::string::npos) throw FileError(source.label + ": is empty");
  prepare(text, source);
  Builder builder{source, text};
  Json::sax_parse(text, &builder);
  Json root = builder.take();
  return {std::make_shared<const JsonSource>(std::move(source)), std::move(root)};
}

JsonDocument load_json(const std::filesystem::path& file, const std::string& referrer,
                       const std::optional<std::filesystem::path>& mesh_root) {
  const std::string label = referrer.empty() ? file.string() : fmt::format("{} -> {}", referrer, file.string());
  return parse_json(read_text(file, label), {.label = label, .directory = file.parent_path(), .mesh_root = mesh_root});
}

}  // namespace modsearch::detail
