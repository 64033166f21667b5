#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <modsearch/problem/base_placement.hpp>
#include <modsearch/problem/rng.hpp>
#include <modsearch/problem/robot_problem.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace modsearch {

/// A file that cannot be used. `what()` is one sentence: file (the one the user gave, then the one it refers to), JSON
/// pointer, value, limit.
class FileError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Which instance of a problem with sampled goals; ignored by the others.
struct Instance {
  std::uint64_t seed = 0;
  std::uint64_t index = 0;
};

/// Where the target of a goal is drawn from.
struct Sampling {
  std::string goal;  ///< ID of the goal whose position is drawn
  Eigen::Vector3d lower = Eigen::Vector3d::Zero();
  Eigen::Vector3d upper = Eigen::Vector3d::Zero();
  double min_clearance = 0.0;  ///< a target closer to an obstacle than this is drawn again [m]
};

/// A family of generated tasks (whitman.hpp).
struct WhitmanTasks {
  int goals = 3;
  int boxes = 3;
  /// Goals are drawn again until one of this library's end effectors, at the nominal pose, keeps clear of every box.
  /// Null: they are taken as they come.
  std::shared_ptr<const ModuleLibrary> free_ends{};
};

/// A problem file: one problem, or a distribution of instances.
struct ProblemFile {
  RobotProblemSpec spec;
  std::vector<Goal> goals;  ///< of the task; the sampled one at its nominal place
  std::optional<Sampling> sampling;
  std::optional<WhitmanTasks> whitman;  ///< the tasks are generated; `spec` and `goals` are those of instance 0:0

  /// A distribution of instances.
  [[nodiscard]] bool sampled() const { return sampling.has_value() || whitman.has_value(); }
  /// The problem itself, or instance `instance` of it: equal on every machine.
  /// Throws std::runtime_error if 10 000 draws in a row are too close to an obstacle.
  [[nodiscard]] std::shared_ptr<const RobotProblem> instance(Instance instance = {}) const;
};

/// How files are read.
struct FileOptions {
  /// Folder in which meshes are looked for first, such as the top of the package that a task of CoBRA's belongs to.
  /// Otherwise, and where it holds no such file: beside the file that names them, then in the folders above.
  std::optional<std::filesystem::path> mesh_root{};
};

/// Reads a module library: Timor's `modules.json`, also in its older form of a bare list, with or without parameters,
/// or the ID of a built-in one ("seed").
[[nodiscard]] std::shared_ptr<const ModuleLibrary> load_library(const std::string& file_or_id);
/// What a CoBRA task file describes.
struct TaskFile {
  std::shared_ptr<const Task> task;
  std::vector<Goal> goals;
  std::shared_ptr<const Scene> scene;
  Eigen::Isometry3d X_WB = Eigen::Isometry3d::Identity();
  std::optional<BasePlacement> base;  ///< where the base may be placed; X_WB is its nominal pose
  double time_step = 0.01;            ///< [s]
};
/// Reads a task. What is not supported is named precisely in the FileError. A task without goals is a TaskFile whose
/// `task` is null.
[[nodiscard]] TaskFile load_task(const std::filesystem::path& file, const FileOptions& options = {});
/// Reads a problem file, or a built-in one by its ID ("seed/fixed").
[[nodiscard]] ProblemFile load_problem_file(const std::string& file_or_id, const FileOptions& options = {});
/// The problem, or instance 0:0 of it: load_problem_file(file_or_id).instance(instance).
[[nodiscard]] std::shared_ptr<const RobotProblem> load_problem(const std::string& file_or_id, Instance instance = {},
                                                               const FileOptions& options = {});

/// IDs of the built-in problems and libraries, sorted.
[[nodiscard]] std::vector<std::string> builtin_problems();
[[nodiscard]] std::vector<std::string> builtin_libraries();

/// Reads a design for `library`: a JSON array [{"type":.., "parameters":{..}}], or a solution file that holds one.
[[nodiscard]] Design load_design(const std::filesystem::path& file, const ModuleLibrary& library);
/// The postures that a solution file gives for the goals of its task, for an evaluation of its design; none where the
/// file holds a design alone.
[[nodiscard]] Witness load_witness(const std::filesystem::path& file);
/// A design as JSON text, the inverse of load_design.
[[nodiscard]] std::string design_to_json(const ModuleLibrary& library, const Design& design);

/// What a solution file says (FORMATS 4): CoBRA's keys plus the design.
struct SolutionRecord {
  std::string problem;  ///< file relative to the solution file, or ID
  std::optional<Instance> instance;
  std::optional<Eigen::Vector3d> target;  ///< of the instance
  Design design;
  Eigen::Isometry3d X_WB = Eigen::Isometry3d::Identity();
  Evaluation evaluation;          ///< score, terms, attempt with postures and path
  std::string verified = "none";  ///< "none", "posture", "path"
  std::string solver;
  std::vector<std::pair<std::string, std::string>> solver_options;
  std::uint64_t seed = 0;
  std::int64_t evaluations = 0;
  double seconds = 0.0;
};
/// Writes `record` of `problem` to `file`, whole or not at all.
void write_solution(const std::filesystem::path& file, const RobotProblem& problem, const SolutionRecord& record);
/// Solution file as text.
[[nodiscard]] std::string solution_to_json(const RobotProblem& problem, const SolutionRecord& record);

/// A solution file read back: the claims, to be verified, and the problem it belongs to.
struct LoadedSolution {
  SolutionRecord record;
  std::shared_ptr<const RobotProblem> problem;
  bool claims = true;  ///< the file says how good its design is; one of CoBRA's own gives a design and a motion only
};
/// `problem`: overrides the problem named in the file. Throws FileError.
[[nodiscard]] LoadedSolution load_solution(const std::filesystem::path& file,
                                           const std::optional<std::string>& problem = std::nullopt,
                                           const FileOptions& options = {});

/// Writes `text` whole or not at all: beside `file`, then renamed; follows links, writes into devices. Throws
/// FileError.
void write_file(const std::filesystem::path& file, std::string_view text);

}  // namespace modsearch
