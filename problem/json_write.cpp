#include <modsearch/problem/json_internal.hpp>

namespace modsearch::detail {
namespace {

using Ordered = nlohmann::ordered_json;

constexpr std::size_t kLineWidth = 110;

std::string on_one_line(const Ordered& value) {
  std::string compact = value.dump(-1, ' ', false, Ordered::error_handler_t::replace);
  std::string result;
  bool within_text = false;
  for (std::size_t i = 0; i < compact.size(); ++i) {
    result += compact[i];
    if (within_text && compact[i] == '\\') {
      result += compact[++i];
    } else if (compact[i] == '"') {
      within_text = !within_text;
    } else if (!within_text && (compact[i] == ',' || compact[i] == ':')) {
      result += ' ';
    }
  }
  return result;
}

void write(const Ordered& value, std::size_t indent, std::string& out) {
  std::string line = on_one_line(value);
  const bool fits = line.size() + indent <= kLineWidth;
  if (value.empty() || !value.is_structured() || (fits && indent > 0)) {
    out += line;
    return;
  }
  const std::string padding(indent + 2, ' ');
  const bool is_object = value.is_object();
  out += is_object ? "{\n" : "[\n";
  bool first = true;
  for (const auto& [key, element] : value.items()) {
    if (!first) out += ",\n";
    first = false;
    out += padding;
    if (is_object) out += Ordered(key).dump(-1, ' ', false, Ordered::error_handler_t::replace) + ": ";
    write(element, indent + 2, out);
  }
  out += '\n';
  out.append(indent, ' ');
  out += is_object ? '}' : ']';
}

/// -0 reads as a slip of the pen.
double plain(double number) { return number == 0.0 ? 0.0 : number; }

}  // namespace

Ordered to_json(const Eigen::Isometry3d& X) {
  Ordered rows = Ordered::array();
  for (Eigen::Index i = 0; i < 4; ++i) {
    Ordered row = Ordered::array();
    for (Eigen::Index j = 0; j < 4; ++j) row.push_back(plain(X.matrix()(i, j)));
    rows.push_back(std::move(row));
  }
  return rows;
}

Ordered to_json(const Eigen::VectorXd& v) {
  Ordered list = Ordered::array();
  for (const double number : v) list.push_back(plain(number));
  return list;
}

std::string to_text(const Ordered& document) {
  std::string text;
  write(document, 0, text);
  return text + "\n";
}

}  // namespace modsearch::detail
