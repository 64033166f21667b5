#pragma once

#include <modsearch/problem/robot_problem.hpp>
#include <optional>
#include <string>
#include <vector>

namespace modsearch {

/// What somebody says about a design; whatever is empty is not checked.
struct Claims {
  std::optional<double> score{};
  std::optional<bool> reached{};
  std::optional<bool> achieved{};
  std::optional<double> goal_error{};         ///< [m]
  std::optional<double> clearance{};          ///< at the postures [m]; infinite without obstacles
  std::optional<Eigen::MatrixXd> postures{};  ///< [n_goals x n_joints]; the design is evaluated with them as witnesses
  std::optional<Path> path{};                 ///< home through all goals
};

struct VerificationOptions {
  /// A path is checked in steps this many times finer than the planner's.
  double refinement = 10.0;
};

/// What became of checking a design from scratch.
struct Verification {
  bool verified = false;       ///< achieved at level path, the path is free when looked at finer, and all claims hold
  std::string level = "none";  ///< highest level that holds: "none", "posture", "path"
  std::vector<std::string> findings;  ///< one sentence per thing that is not as claimed or as asked
  Evaluation evaluation;              ///< at the problem's own level
  Evaluation path_evaluation;         ///< at level path
  std::optional<Path> path;           ///< the path that was checked: the claimed one, else a new one
  std::optional<PathCheck> check;     ///< what the finer look found
};

/// Evaluates `design` again from scratch, at the problem's level and at level path, checks every segment of its path
/// finer than the planner did, and holds the claims against the result. Nothing is taken over from the claims but
/// postures to try first, which are checked like any other. Throws std::invalid_argument for a design outside the
/// search space.
[[nodiscard]] Verification verify(const RobotProblem& problem, const Design& design, const Claims& claims = {},
                                  const VerificationOptions& options = {});

/// What a solution says of a design that was evaluated as `found` and then verified: where that gave a path, the path,
/// and the postures that it passes through at the goals, with their goal error and clearance.
[[nodiscard]] Evaluation with_path(Evaluation found, const Verification& verification);

}  // namespace modsearch
