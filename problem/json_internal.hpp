#pragma once

// Reading JSON so that every complaint is one sentence with file, place, value and limit. Internal to the problem
// floor.

#include <Eigen/Geometry>
#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace modsearch::detail {

using Json = nlohmann::json;

/// Where a document comes from, for messages and for the files it refers to.
struct JsonSource {
  std::string label;                ///< the file the user gave; "given -> referred" for one that another refers to
  std::filesystem::path directory;  ///< relative paths in the document start here
  bool open_meshes = true;          ///< else one triangle stands in for each
  /// Where meshes are looked for first, if given; the same for the documents that this one refers to.
  std::optional<std::filesystem::path> mesh_root{};
};

/// What a number may be; both ends belong to it. Infinity is never allowed unless said so.
struct NumberLimits {
  double lower = -std::numeric_limits<double>::infinity();
  double upper = std::numeric_limits<double>::infinity();
  bool above_lower = false;     ///< `lower` itself is not allowed
  bool allow_infinity = false;  ///< Infinity and -Infinity are numbers here
};

/// A value within a document that knows where it is: typed access, each refusal a FileError.
class JsonCursor {
 public:
  JsonCursor(const Json& value, std::shared_ptr<const JsonSource> source, std::string pointer = {})
      : value_{&value}, source_{std::move(source)}, pointer_{std::move(pointer)} {}

  [[nodiscard]] const Json& value() const { return *value_; }
  [[nodiscard]] const JsonSource& source() const { return *source_; }
  [[nodiscard]] const std::string& pointer() const { return pointer_; }

  /// Throws FileError: "FILE: at /pointer: " + `what`.
  [[noreturn]] void fail(const std::string& what) const;
  /// Likewise for the value itself: "VALUE is not " + `expected`.
  [[noreturn]] void fail_value(const std::string& expected) const;
  /// Runs `make`; std::invalid_argument from below becomes a FileError of this place.
  template <typename Make>
  [[nodiscard]] auto guard(Make&& make) const {
    try {
      return make();
    } catch (const std::invalid_argument& error) {
      fail(error.what());
    }
  }

  /// An object with no other keys than `known` and the free-text ones (author, notes, visual, ..).
  void expect_keys(std::initializer_list<std::string_view> known) const;
  [[nodiscard]] bool has(const std::string& key) const;
  /// Member `key` of an object; a refusal names the object where it is missing.
  [[nodiscard]] JsonCursor at(const std::string& key) const;
  [[nodiscard]] std::optional<JsonCursor> find(const std::string& key) const;
  /// Members of an object in the order of their names.
  [[nodiscard]] std::vector<std::pair<std::string, JsonCursor>> members() const;

  /// Elements of an array.
  [[nodiscard]] std::vector<JsonCursor> items() const;
  /// Elements of an array of exactly `n`.
  [[nodiscard]] std::vector<JsonCursor> items(std::size_t n) const;
  /// Elements of an array, or the one value where a list is meant.
  [[nodiscard]] std::vector<JsonCursor> items_or_single() const;

  [[nodiscard]] double number(NumberLimits limits = {}) const;
  [[nodiscard]] double number_or(const std::string& key, double missing, NumberLimits limits = {}) const;
  [[nodiscard]] std::int64_t integer(std::int64_t lower, std::int64_t upper) const;
  [[nodiscard]] std::uint64_t unsigned_integer() const;
  [[nodiscard]] bool boolean() const;
  [[nodiscard]] std::string text() const;
  /// Where the key is missing or null, which is how Python writes a name that nobody gave: `missing`.
  [[nodiscard]] std::string text_or(const std::string& key, std::string missing) const;
  /// Index into `choices` of a text that has to be one of them.
  [[nodiscard]] std::size_t choice(std::initializer_list<std::string_view> choices) const;

  /// [n] finite numbers.
  [[nodiscard]] Eigen::VectorXd vector(std::size_t n) const;
  /// A finite vector of any length.
  [[nodiscard]] Eigen::VectorXd vector() const;
  /// A row-major 4x4 matrix that is a pose within 1e-6; its rotation is re-orthonormalised.
  [[nodiscard]] Eigen::Isometry3d pose() const;

 private:
  [[nodiscard]] JsonCursor child(const Json& value, const std::string& key) const;

  const Json* value_;
  std::shared_ptr<const JsonSource> source_;
  std::string pointer_;
};

/// A parsed document with its origin.
struct JsonDocument {
  std::shared_ptr<const JsonSource> source;
  Json root;

  [[nodiscard]] JsonCursor cursor() const { return {root, source}; }
};

/// Most bytes of a JSON file: far beyond any real one, and parsed within a second.
inline constexpr std::uintmax_t kLargestJsonFile = 64U << 20U;
/// Deepest nesting of arrays and objects.
inline constexpr int kDeepestNesting = 64;

/// The bytes of `file`. Throws FileError, beginning with `label`, if it is no readable regular file of at most
/// `largest`.
[[nodiscard]] std::string read_text(const std::filesystem::path& file, const std::string& label,
                                    std::uintmax_t largest = kLargestJsonFile);
/// Parses JSON: no duplicate keys, bounded depth, UTF-8, numbers within range, and bare Infinity as a number.
/// Throws FileError with line and column.
[[nodiscard]] JsonDocument parse_json(std::string text, JsonSource source);
/// Reads and parses `file`, which `referrer` refers to where that is not empty.
[[nodiscard]] JsonDocument load_json(const std::filesystem::path& file, const std::string& referrer = {},
                                     const std::optional<std::filesystem::path>& mesh_root = std::nullopt);

/// Nearest rotation to `R` if every entry of R^T R is within 1e-6 of the identity's and R is no reflection. Entries within
/// 1e-12 of -1, 0 or 1 are these: that is what a file says that was written with rounding errors (docs/certificates.md).
[[nodiscard]] std::optional<Eigen::Matrix3d> nearest_rotation(const Eigen::Matrix3d& R);

/// A short form of a value for messages.
[[nodiscard]] std::string preview(const Json& value);

/// Numbers, lists and poses to write, -0 as 0.
[[nodiscard]] nlohmann::ordered_json to_json(const Eigen::Isometry3d& X);
[[nodiscard]] nlohmann::ordered_json to_json(const Eigen::VectorXd& v);
/// Document as text: indented, but lists of numbers and short objects on one line. Infinity stands as null.
[[nodiscard]] std::string to_text(const nlohmann::ordered_json& document);

}  // namespace modsearch::detail
