#pragma once

#include <cstdint>
#include <filesystem>
#include <modsearch/problem/files.hpp>
#include <modsearch/solvers/meter.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace modsearch::app {

/// What every command understands.
struct CommonArguments {
  bool json = false;
  bool quiet = false;
  std::string command;  ///< the command line as it was typed, for records
  FileOptions files;    ///< how problems and what they refer to are read
};

struct SolveArguments {
  std::string problem;
  std::string solver = "auto";
  std::optional<Instance> instance;
  std::optional<std::int64_t> evaluations;
  std::optional<double> seconds;
  std::uint64_t seed = 0;
  std::optional<double> verify_seconds;  ///< for what follows the search
  bool until_achieved = false;           ///< the first achieved design will do
  bool at_path_level = false;
  bool refine = false;
  std::optional<std::filesystem::path> checkpoint;
  double checkpoint_seconds = 10.0;  ///< least time between two [s]; arbitrary: what a crash may cost
  bool resume = false;
  std::optional<std::filesystem::path> out;
};

struct TrainArguments {
  std::string problem;
  std::string agent = "mpdqn";
  std::optional<std::int64_t> episodes;
  std::uint64_t seed = 0;
  double checkpoint_seconds = 5.0;  ///< least time between two [s]; arbitrary: what a crash may cost
  bool resume = false;
  std::optional<std::filesystem::path> out;
};

struct CompareArguments {
  std::string study;
  int jobs = 1;
  bool resume = false;
  int recheck = 0;
  std::filesystem::path out;
};

struct EvaluateArguments {
  std::string problem;
  std::string design;
  std::optional<Instance> instance;
};

struct VerifyArguments {
  std::string solution;
  std::optional<std::string> problem;
};

struct RenderArguments {
  std::string solution;
  std::optional<std::string> problem;
  std::optional<std::filesystem::path> out;
};

struct ConvertArguments {
  std::string in;
  std::filesystem::path out;
  std::optional<std::string> to;
  std::optional<std::string> library;
};

struct GenerateArguments {
  std::string family;
  int goals = 3;
  int boxes = 3;
  bool free_ends = false;
  std::uint64_t seed = 0;
  int count = 100;
  std::filesystem::path out;
};

struct CertifyArguments {
  std::string problem;
  std::optional<Instance> instance;
  double gap = 1e-4;
  std::optional<double> seconds;
  std::optional<int> fewer;
  std::filesystem::path out = "certificate.json";
};

struct CheckCertificateArguments {
  std::string file;
};

struct BestKnownArguments {
  std::vector<std::string> files;
  std::filesystem::path tables = "data/best_known";
};

struct ListArguments {
  std::string what;  ///< "solvers", "agents", "problems" or "studies"
};

/// A whole number in [0, `most`] for `option`. Throws std::invalid_argument (option, text, limit) for anything else,
/// such as a sign, a point, an exponent or a number that is too large.
[[nodiscard]] std::uint64_t parse_whole_number(std::string_view option, std::string_view text, std::uint64_t most);

/// Seconds in [0, 1e9]. Throws std::invalid_argument for anything else.
[[nodiscard]] double parse_seconds(std::string_view option, std::string_view text);

/// A word as a shell takes it, in quotes where it needs them.
[[nodiscard]] std::string shell_word(std::string_view word);

/// "SEED:INDEX". Throws std::invalid_argument for anything else.
[[nodiscard]] Instance parse_instance(std::string_view text);

/// The budget of a run: as given, else until the solver can prove or improve nothing more, at the latest after 30 s; in
/// either case until the first achieved design, where that is all that was asked for.
[[nodiscard]] Budget budget_of(const SolveArguments& arguments);

}  // namespace modsearch::app
