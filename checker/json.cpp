#include <algorithm>
#include <charconv>
#include <checker/json.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>

namespace modsearch_check {
namespace {

constexpr std::uintmax_t kLargestFile = std::uintmax_t{1} << 29;
constexpr int kDeepest = 64;
constexpr double kLargestNumber = 1e12;
constexpr std::string_view kFreeText[] = {"author", "email",       "affiliation", "acknowledgement", "notes",
                                          "tags",   "publication", "date",        "visual"};

template <typename Names>
bool contains(const Names& names, std::string_view name) {
  return std::find(std::begin(names), std::end(names), name) != std::end(names);
}

std::string shown(const Json& json) {
  if (json.is_structured()) return json.is_array() ? "a list" : "an object";
  const std::string text = json.dump(-1, ' ', true, Json::error_handler_t::replace);
  return text.size() <= 40 ? text : text.substr(0, 37) + "...";
}

// Counted from 1; `byte` as nlohmann-json counts them, from 1, 0 where it does not know.
std::ptrdiff_t line_of(std::string_view text, std::size_t byte) {
  const std::string_view before = text.substr(0, std::min(text.size(), byte > 0 ? byte - 1 : 0));
  return 1 + std::count(before.begin(), before.end(), '\n');
}

}  // namespace

std::string in_digits(double number, int digits) {
  char text[64];
  const auto [end, error] = std::to_chars(std::begin(text), std::end(text), number, std::chars_format::general, digits);
  return error == std::errc{} ? std::string(text, end) : std::string{};
}

std::string read_file(const std::string& path) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(path, error);
  if (!std::filesystem::exists(status)) throw Malformed(path + ": there is no such file");
  if (!std::filesystem::is_regular_file(status)) throw Malformed(path + ": is not a regular file");
  if (std::filesystem::file_size(path, error) > kLargestFile) throw Malformed(path + ": is larger than 512 MiB");
  std::ifstream stream{path, std::ios::binary};
  std::string text{std::istreambuf_iterator<char>{stream}, {}};
  if (!stream) throw Malformed(path + ": cannot be read");
  if (text.empty()) throw Malformed(path + ": is empty");
  return text;
}

Json parse(const std::string& text, const std::string& name) {
  std::vector<std::set<std::string>> keys;  // of the objects that are open; an empty set for a list
  const Json::parser_callback_t watch = [&](int depth, Json::parse_event_t event, Json& value) {
    using Event = Json::parse_event_t;
    if (event == Event::object_start || event == Event::array_start) {
      if (depth >= kDeepest) throw Malformed(name + ": is nested deeper than 64 levels");
      keys.emplace_back();
    }
    if (event == Event::object_end || event == Event::array_end) keys.pop_back();
    if (event == Event::key && !keys.back().insert(value.get<std::string>()).second) {
      throw Malformed(name + ": key " + shown(value) + " occurs twice");
    }
    return true;
  };
  try {
    return Json::parse(text, watch);
  } catch (const Json::parse_error& error) {
    throw Malformed(name + ":" + std::to_string(line_of(text, error.byte)) + ": is not JSON");
  } catch (const Json::exception&) {
    throw Malformed(name + ": is not JSON");
  }
}

void Value::fail(const std::string& what) const { throw Malformed(place_ + ": " + what); }

void Value::only(std::initializer_list<std::string_view> keys) const {
  if (!json_->is_object()) fail(shown(*json_) + " is not an object");
  for (const auto& [key, value] : json_->items()) {
    if (!contains(keys, key) && !contains(kFreeText, key)) fail("key " + shown(Json(key)) + " is not known here");
  }
}

bool Value::has(const std::string& key) const {
  if (!json_->is_object()) fail(shown(*json_) + " is not an object");
  return json_->contains(key);
}

Value Value::operator[](const std::string& key) const {
  if (!has(key)) fail("key \"" + key + "\" is missing");
  return {json_->at(key), place_ + "/" + key};
}

std::vector<Value> Value::items() const {
  if (!json_->is_array()) fail(shown(*json_) + " is not a list");
  std::vector<Value> result;
  result.reserve(json_->size());
  for (std::size_t i = 0; i < json_->size(); ++i) result.emplace_back((*json_)[i], place_ + "/" + std::to_string(i));
  return result;
}

std::vector<Value> Value::items(std::size_t n) const {
  if (!json_->is_array() || json_->size() != n) fail(shown(*json_) + " is not a list of " + std::to_string(n));
  return items();
}

std::vector<Value> Value::items_or_one() const {
  if (json_->is_object()) return {*this};
  return items();
}

std::vector<std::pair<std::string, Value>> Value::members() const {
  if (!json_->is_object()) fail(shown(*json_) + " is not an object");
  std::vector<std::pair<std::string, Value>> result;
  for (const auto& [key, value] : json_->items()) result.emplace_back(key, Value{value, place_ + "/" + key});
  return result;
}

std::string Value::text() const {
  if (!json_->is_string()) fail(shown(*json_) + " is not a text");
  return json_->get<std::string>();
}

std::size_t Value::choice(std::initializer_list<std::string_view> choices) const {
  const std::string given = text();
  const auto found = std::find(choices.begin(), choices.end(), given);
  if (found == choices.end()) fail(shown(*json_) + " is not one of the words known here");
  return static_cast<std::size_t>(found - choices.begin());
}

bool Value::boolean() const {
  if (!json_->is_boolean()) fail(shown(*json_) + " is not true or false");
  return json_->get<bool>();
}

double Value::number() const {
  if (!json_->is_number()) fail(shown(*json_) + " is not a number");
  const double number = json_->get<double>();
  if (!(std::abs(number) <= kLargestNumber)) fail(shown(*json_) + " is larger than 1e12");
  return number;
}

double Value::number_or(const std::string& key, double missing) const {
  return has(key) ? (*this)[key].number() : missing;
}

std::uint64_t Value::natural(std::uint64_t largest) const {
  if (json_->is_number_unsigned() && json_->get<std::uint64_t>() <= largest) return json_->get<std::uint64_t>();
  if (json_->is_number_float()) {  // 3.0 is an integer in JSON, which knows one kind of number
    const double number = json_->get<double>();
    if (number >= 0.0 && number <= 0x1p53 && number == std::floor(number) &&
        static_cast<std::uint64_t>(number) <= largest) {
      return static_cast<std::uint64_t>(number);
    }
  }
  fail(shown(*json_) + " is not an integer in [0, " + std::to_string(largest) + "]");
}

double Value::hex() const {
  if (!json_->is_string()) fail(shown(*json_) + " is not a text with a hexadecimal float");
  std::string_view digits = json_->get_ref<const std::string&>();
  const bool negative = digits.starts_with('-');
  if (negative) digits.remove_prefix(1);
  double size = -1.0;
  if (digits.starts_with("0x") && digits.size() > 2 && std::isxdigit(static_cast<unsigned char>(digits[2]))) {
    digits.remove_prefix(2);
    const auto [end, error] = std::from_chars(digits.begin(), digits.end(), size, std::chars_format::hex);
    if (error != std::errc{} || end != digits.end()) size = -1.0;
  }
  if (!(size >= 0.0 && size <= kLargestNumber)) fail(shown(*json_) + " is not a hexadecimal float of at most 1e12");
  return negative ? -size : size;
}

Numbers Value::numbers3() const {
  const std::vector<Value> entries = items(3);
  return {entries[0].number(), entries[1].number(), entries[2].number()};
}

Pose Value::pose() const {
  const std::vector<Value> rows = items(4);
  std::array<Numbers, 3> turn{};
  Pose pose;
  for (std::size_t i = 0; i < 4; ++i) {
    const std::vector<Value> entries = rows[i].items(4);
    for (std::size_t k = 0; k < 4; ++k) {
      const double number = entries[k].number();
      if (i == 3 && !(std::abs(number - (k == 3 ? 1.0 : 0.0)) <= 1e-6))
        entries[k].fail("the last row of a pose is 0 0 0 1");
      if (i < 3 && k < 3) turn[i][k] = number;
      if (i < 3 && k == 3) pose.move.offset[i] = number;
    }
  }
  pose.turn = nearest_rotation(turn, *this);
  return pose;
}

namespace {

/// An entry of a rotation as it is meant: within 1e-12 of -1, 0 or 1 it is that number.
double meant(double entry) {
  const double whole = std::round(entry);
  return std::abs(entry - whole) <= 1e-12 ? whole + 0.0 : entry;
}

/// Where the powers of E, from the first on, can be anything but 0.
std::array<std::array<bool, 3>, 3> support_of_powers(const Matrix& E) {
  std::array<std::array<bool, 3>, 3> support{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t k = 0; k < 3; ++k) support[i][k] = !E[i][k].is_zero();
  }
  for (std::size_t via = 0; via < 3; ++via) {
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t k = 0; k < 3; ++k) support[i][k] = support[i][k] || (support[i][via] && support[via][k]);
    }
  }
  return support;
}

}  // namespace

Matrix nearest_rotation(const std::array<Numbers, 3>& given, const Value& value) {
  // With R' R = 1 + E, the nearest rotation is R (1 + E)^(-1/2) = R (1 - E/2 + 3/8 E^2 - ..). The terms left out are
  // below |E|^3 (their coefficients are below 5/16 and |E| is small) in every entry.
  std::array<Numbers, 3> entries = given;
  for (Numbers& row : entries) std::transform(row.begin(), row.end(), row.begin(), meant);
  const Matrix R = {vector_of(entries[0]), vector_of(entries[1]), vector_of(entries[2])};
  Matrix E = transposed(R) * R;
  double largest = 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    E[i][i] -= 1.0;
    for (const Interval& entry : E[i]) largest = std::max(largest, abs(entry).upper());
  }
  if (!(largest <= 2e-6) || !(dot(R[0], cross(R[1], R[2])).lower() > 0.0)) value.fail("the pose holds no rotation");
  if (largest == 0.0) return R;
  const double size = 3.0 * largest;  // of E as a linear map
  const double left_out = size * size * size;
  const Matrix E2 = E * E;
  const auto support = support_of_powers(E);
  Matrix root;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      root[i][k] = Interval{i == k ? 1.0 : 0.0} - E[i][k] * 0.5 + E2[i][k] * 0.375;
      if (support[i][k]) root[i][k] += Interval{-left_out, left_out};
    }
  }
  return R * root;
}

}  // namespace modsearch_check
