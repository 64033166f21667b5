#include <fmt/format.h>

#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cmath>
#include <modsearch/problem/files.hpp>
#include <modsearch/problem/json_internal.hpp>

namespace modsearch::detail {
namespace {

constexpr std::array<std::string_view, 9> kFreeTextKeys = {
    "author", "email", "affiliation", "acknowledgement", "notes", "tags", "publication", "date", "visual"};

std::string escaped(const std::string& key) {
  std::string result;
  for (const char c : key) {
    if (c == '~') {
      result += "~0";
    } else if (c == '/') {
      result += "~1";
    } else {
      result += c;
    }
  }
  return result;
}

std::string shortened(std::string text, std::size_t most) {
  if (text.size() <= most) return text;
  std::size_t end = most - 3;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0U) == 0x80U) --end;  // not within a character
  return text.substr(0, end) + "...";
}

/// "at least 0", "in [0, 1]", "above 0", ...
std::string in_words(const NumberLimits& limits) {
  const bool below = std::isfinite(limits.lower);
  const bool above = std::isfinite(limits.upper);
  if (below && above && !limits.above_lower) return fmt::format("in [{}, {}]", limits.lower, limits.upper);
  if (below && above) return fmt::format("in ({}, {}]", limits.lower, limits.upper);
  if (below) return fmt::format("{} {}", limits.above_lower ? "above" : "at least", limits.lower);
  return fmt::format("at most {}", limits.upper);
}

std::string joined(std::initializer_list<std::string_view> words) {
  std::string result;
  for (const std::string_view word : words) {
    if (!result.empty()) result += ", ";
    result += fmt::format("\"{}\"", word);
  }
  return result;
}

}  // namespace

std::string preview(const Json& value) {
  constexpr std::size_t kMost = 60;
  if (value.is_number_float()) {
    const double number = value.get<double>();
    if (std::isinf(number)) return number > 0.0 ? "Infinity" : "-Infinity";
    return fmt::format("{}", number);
  }
  if (value.is_array() && value.size() > 8) return fmt::format("a list of {}", value.size());
  if (value.is_object() && value.size() > 4) return fmt::format("an object of {} keys", value.size());
  return shortened(value.dump(-1, ' ', false, Json::error_handler_t::replace), kMost);
}

void JsonCursor::fail(const std::string& what) const {
  throw FileError(fmt::format("{}: at {}: {}", source_->label, pointer_.empty() ? "the top level" : pointer_, what));
}

void JsonCursor::fail_value(const std::string& expected) const {
  fail(fmt::format("{} is not {}", preview(*value_), expected));
}

JsonCursor JsonCursor::child(const Json& value, const std::string& key) const {
  return {value, source_, pointer_ + "/" + escaped(key)};
}

void JsonCursor::expect_keys(std::initializer_list<std::string_view> known) const {
  if (!value_->is_object()) fail_value("an object");
  for (const auto& [key, value] : value_->items()) {
    const std::string_view name = key;
    if (std::find(known.begin(), known.end(), name) != known.end()) continue;
    if (std::find(kFreeTextKeys.begin(), kFreeTextKeys.end(), name) != kFreeTextKeys.end()) continue;
    fail(fmt::format("key \"{}\" is not known here (known: {})", shortened(key, 40), joined(known)));
  }
}

bool JsonCursor::has(const std::string& key) const {
  if (!value_->is_object()) fail_value("an object");
  return value_->contains(key);
}

JsonCursor JsonCursor::at(const std::string& key) const {
  if (!has(key)) fail(fmt::format("key \"{}\" is missing", key));
  return child((*value_)[key], key);
}

std::optional<JsonCursor> JsonCursor::find(const std::string& key) const {
  if (!has(key)) return std::nullopt;
  return at(key);
}

std::vector<std::pair<std::string, JsonCursor>> JsonCursor::members() const {
  if (!value_->is_object()) fail_value("an object");
  std::vector<std::pair<std::string, JsonCursor>> result;
  for (const auto& [key, value] : value_->items()) result.emplace_back(key, child(value, key));
  return result;
}

std::vector<JsonCursor> JsonCursor::items() const {
  if (!value_->is_array()) fail_value("a list");
  std::vector<JsonCursor> result;
  result.reserve(value_->size());
  for (std::size_t i = 0; i < value_->size(); ++i) result.push_back(child((*value_)[i], std::to_string(i)));
  return result;
}

std::vector<JsonCursor> JsonCursor::items(std::size_t n) const {
  if (!value_->is_array() || value_->size() != n) fail_value(fmt::format("a list of {}", n));
  return items();
}

std::vector<JsonCursor> JsonCursor::items_or_single() const {
  if (value_->is_array()) return items();
  if (!value_->is_object()) fail_value("a list of objects");
  return {*this};
}

double JsonCursor::number(NumberLimits limits) const {
  if (!value_->is_number()) fail_value("a number");
  const double number = value_->get<double>();
  if (!limits.allow_infinity && !std::isfinite(number)) fail_value("a finite number");
  if (number < limits.lower || number > limits.upper || (limits.above_lower && number == limits.lower)) {
    fail_value(in_words(limits));
  }
  return number;
}

double JsonCursor::number_or(const std::string& key, double missing, NumberLimits limits) const {
  const std::optional<JsonCursor> found = find(key);
  return found ? found->number(limits) : missing;
}

std::int64_t JsonCursor::integer(std::int64_t lower, std::int64_t upper) const {
  const std::string expected = fmt::format("an integer in [{}, {}]", lower, upper);
  // 3.0 is an integer in JSON, which knows one kind of number.
  if (value_->is_number_float()) {
    const double number = value_->get<double>();
    constexpr double kExact = 9007199254740992.0;  // 2^53
    if (!(std::abs(number) <= kExact) || number != std::floor(number)) fail_value(expected);
    const auto whole = static_cast<std::int64_t>(number);
    if (whole < lower || whole > upper) fail_value(expected);
    return whole;
  }
  if (!value_->is_number_integer()) fail_value(expected);
  constexpr auto kLargest = static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max());
  if (value_->is_number_unsigned() && value_->get<std::uint64_t>() > kLargest) fail_value(expected);
  const auto whole = value_->get<std::int64_t>();
  if (whole < lower || whole > upper) fail_value(expected);
  return whole;
}

std::uint64_t JsonCursor::unsigned_integer() const {
  if (value_->is_number_unsigned()) return value_->get<std::uint64_t>();
  constexpr double kTooLarge = 18446744073709551616.0;  // 2^64
  const double number = value_->is_number() ? value_->get<double>() : -1.0;
  if (!(number >= 0.0 && number < kTooLarge)) {
    fail_value(fmt::format("an integer in [0, {}]", std::numeric_limits<std::uint64_t>::max()));
  }
  return static_cast<std::uint64_t>(integer(0, std::numeric_limits<std::int64_t>::max()));
}

bool JsonCursor::boolean() const {
  if (!value_->is_boolean()) fail_value("true or false");
  return value_->get<bool>();
}

std::string JsonCursor::text() const {
  if (!value_->is_string()) fail_value("a text");
  return value_->get<std::string>();
}

std::string JsonCursor::text_or(const std::string& key, std::string missing) const {
  const std::optional<JsonCursor> found = find(key);
  return found && !found->value().is_null() ? found->text() : std::move(missing);
}

std::size_t JsonCursor::choice(std::initializer_list<std::string_view> choices) const {
  const std::string expected = "one of " + joined(choices);
  if (!value_->is_string()) fail_value(expected);
  const auto found = std::find(choices.begin(), choices.end(), value_->get_ref<const std::string&>());
  if (found == choices.end()) fail_value(expected);
  return static_cast<std::size_t>(found - choices.begin());
}

Eigen::VectorXd JsonCursor::vector() const {
  const std::vector<JsonCursor> entries = items();
  Eigen::VectorXd result(static_cast<Eigen::Index>(entries.size()));
  for (std::size_t i = 0; i < entries.size(); ++i) result[static_cast<Eigen::Index>(i)] = entries[i].number();
  return result;
}

Eigen::VectorXd JsonCursor::vector(std::size_t n) const {
  static_cast<void>(items(n));
  return vector();
}

Eigen::Isometry3d JsonCursor::pose() const {
  Eigen::Matrix4d matrix;
  const std::vector<JsonCursor> rows = items(4);
  for (std::size_t i = 0; i < 4; ++i) matrix.row(static_cast<Eigen::Index>(i)) = rows[i].vector(4);
  if (!matrix.row(3).isApprox(Eigen::RowVector4d::UnitW(), 1e-6))
    rows[3].fail_value("[0, 0, 0, 1], the last row of a pose");
  const std::optional<Eigen::Matrix3d> rotation = nearest_rotation(matrix.topLeftCorner<3, 3>());
  if (!rotation) fail("the upper left 3x3 of the pose is not a rotation (limit: within 1e-6)");
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.linear() = *rotation;
  X.translation() = matrix.topRightCorner<3, 1>();
  return X;
}

std::optional<Eigen::Matrix3d> nearest_rotation(const Eigen::Matrix3d& given) {
  constexpr double kAccepted = 1e-6;
  // cos(pi / 2) is 6e-17 in a file, and an axis that is turned by that is one that is not turned.
  const auto whole = [](double rounding) {
    return [rounding](double entry) {
      return std::abs(entry - std::round(entry)) <= rounding ? std::round(entry) + 0.0 : entry;
    };
  };
  if (!given.allFinite()) return std::nullopt;
  const Eigen::Matrix3d R = given.unaryExpr(whole(1e-12));
  const double error = (R.transpose() * R - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (!(error <= kAccepted) || R.determinant() < 0.0) return std::nullopt;
  constexpr double kRounding = 4.0 * std::numeric_limits<double>::epsilon();
  if (error <= kRounding) return R;  // exact ones stay exact
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd{R, Eigen::ComputeFullU | Eigen::ComputeFullV};
  return (svd.matrixU() * svd.matrixV().transpose()).unaryExpr(whole(kRounding)).eval();
}

}  // namespace modsearch::detail
