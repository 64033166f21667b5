#pragma once

#include <checker/vector.hpp>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <string_view>

namespace modsearch_check {

using Json = nlohmann::json;

/// What was given cannot be read: exit status 2.
struct Malformed : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// What was given can be read and is not proved: exit status 1.
struct Rejected : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// `number` with so many significant digits, in decimals, whatever the locale of the program.
[[nodiscard]] std::string in_digits(double number, int digits);
/// The whole of a regular file. Throws Malformed.
[[nodiscard]] std::string read_file(const std::string& path);

/// A document without duplicate keys and nested at most 64 deep. `name`: for messages. Throws Malformed.
[[nodiscard]] Json parse(const std::string& text, const std::string& name);

/// A value and the place where it stands ("FILE: at /goals/0"); every refusal throws Malformed and names the place.
class Value {
 public:
  Value(const Json& json, std::string place) : json_{&json}, place_{std::move(place)} {}

  [[nodiscard]] const Json& json() const { return *json_; }
  [[nodiscard]] const std::string& place() const { return place_; }
  [[noreturn]] void fail(const std::string& what) const;

  /// An object with these keys at most, and free text (author, notes, ..).
  void only(std::initializer_list<std::string_view> keys) const;
  [[nodiscard]] bool has(const std::string& key) const;
  [[nodiscard]] Value operator[](const std::string& key) const;
  [[nodiscard]] std::vector<Value> items() const;
  [[nodiscard]] std::vector<Value> items(std::size_t n) const;
  /// A list, or the one object that stands for a list of one.
  [[nodiscard]] std::vector<Value> items_or_one() const;
  /// [key, value] of an object.
  [[nodiscard]] std::vector<std::pair<std::string, Value>> members() const;

  [[nodiscard]] std::string text() const;
  [[nodiscard]] std::size_t choice(std::initializer_list<std::string_view> choices) const;
  [[nodiscard]] bool boolean() const;
  /// A number of at most 1e12 in size: nothing here overflows.
  [[nodiscard]] double number() const;
  [[nodiscard]] double number_or(const std::string& key, double missing) const;
  [[nodiscard]] std::uint64_t natural(std::uint64_t largest) const;
  /// A real as a text with a hexadecimal float ("0x1.8p+0"), at most 1e12 in size.
  [[nodiscard]] double hex() const;
  [[nodiscard]] Numbers numbers3() const;
  /// The constant pose of a row-major 4x4 matrix whose rotation is right within 1e-6: the rotation meant is the
  /// nearest.
  [[nodiscard]] Pose pose() const;

 private:
  const Json* json_;
  std::string place_;
};

/// Encloses the rotation nearest to `given` (its polar factor). Throws Malformed at `value` where none is within 1e-6.
[[nodiscard]] Matrix nearest_rotation(const std::array<Numbers, 3>& given, const Value& value);

}  // namespace modsearch_check
