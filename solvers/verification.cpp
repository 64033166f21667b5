#include <fmt/format.h>

#include <cmath>
#include <modsearch/solvers/verification.hpp>

namespace modsearch {
namespace {

std::string yes_no(bool value) { return value ? "true" : "false"; }

// Scores are functions of the design: a claim differs by rounding in the file and across machines, no more.
bool same_score(double a, double b) { return std::abs(a - b) <= 1e-9 * std::max(1.0, std::abs(b)); }

void check_claims(const Claims& claims, const Evaluation& evaluation, std::vector<std::string>& findings) {
  if (claims.score && !same_score(*claims.score, evaluation.score)) {
    findings.push_back(fmt::format("the score is {:.9g}, not {:.9g} as claimed", evaluation.score, *claims.score));
  }
  if (claims.reached && *claims.reached != evaluation.attempt.reached) {
    findings.push_back(
        fmt::format("reached is {}, not {} as claimed", yes_no(evaluation.attempt.reached), yes_no(*claims.reached)));
  }
  if (claims.achieved && *claims.achieved != evaluation.attempt.achieved) {
    findings.push_back(fmt::format("achieved is {}, not {} as claimed", yes_no(evaluation.attempt.achieved),
                                   yes_no(*claims.achieved)));
  }
}

// The rounding of another machine may lead to another one of several equally good postures.
constexpr double kSameLength = 1e-4;  // [m]

bool same_length(double a, double b) { return a == b || std::abs(a - b) <= kSameLength; }

// A design that was found at level path has the lengths of that level's postures.
void check_lengths(const Claims& claims, const Attempt& attempt, const Attempt& at_path_level,
                   std::vector<std::string>& findings) {
  const auto check = [&](std::string_view what, const std::optional<double>& claimed, double Attempt::*length) {
    if (!claimed || same_length(attempt.*length, *claimed) || same_length(at_path_level.*length, *claimed)) return;
    findings.push_back(fmt::format("the {} is {:.4g} m, not {:.4g} m as claimed", what, attempt.*length, *claimed));
  };
  check("goal error", claims.goal_error, &Attempt::goal_error);
  check("clearance", claims.clearance, &Attempt::clearance);
}

// Postures from a file are rounded: the region may be missed by as much as that moves the tip.
constexpr double kPostureSlack = 1e-6;

bool nearly_contains(const PoseRegion& region, const Eigen::Isometry3d& X_WE) {
  // all() of nothing is true: a region without tolerances contains every pose.
  return (region.violations(X_WE).array().abs() <= kPostureSlack).all();
}

void check_postures(const RobotProblem& problem, const Arm& arm, const Eigen::MatrixXd& postures,
                    std::vector<std::string>& findings) {
  const auto goals = problem.task().goals();
  if (postures.rows() != static_cast<Eigen::Index>(goals.size()) || postures.cols() != arm.n_joints()) {
    findings.push_back(fmt::format("{} x {} posture values given, {} goals and {} joints need {} x {}", postures.rows(),
                                   postures.cols(), goals.size(), arm.n_joints(), goals.size(), arm.n_joints()));
    return;
  }
  for (std::size_t g = 0; g < goals.size(); ++g) {
    const Posture posture = arm.forward(postures.row(static_cast<Eigen::Index>(g)).transpose());
    if (!nearly_contains(goals[g].region, posture.tip)) {
      findings.push_back(fmt::format("the posture given for goal '{}' misses it by {:.3g} m", goals[g].id,
                                     (posture.tip.translation() - goals[g].position()).norm()));
    }
  }
}

// A claimed path has to start at home and pass all goals in order at its own waypoints.
bool fits_task(const RobotProblem& problem, const Arm& arm, const Path& path, std::vector<std::string>& findings) {
  if (path.waypoints.rows() < 1 || path.waypoints.cols() != arm.n_joints() || !path.waypoints.allFinite()) {
    findings.push_back(fmt::format("the path given is {} x {}, the arm has {} joints", path.waypoints.rows(),
                                   path.waypoints.cols(), arm.n_joints()));
    return false;
  }
  const Eigen::VectorXd home = home_posture(problem.task(), arm.chain());
  const double off = (path.waypoints.row(0).transpose() - home).cwiseAbs().maxCoeff();
  if (off > kPostureSlack) {
    findings.push_back(fmt::format("the path given starts {:.3g} rad away from home", off));
    return false;
  }
  Eigen::Index row = 0;
  for (const Goal& goal : problem.task().goals()) {
    while (row < path.waypoints.rows() &&
           !nearly_contains(goal.region, arm.forward(path.waypoints.row(row).transpose()).tip)) {
      ++row;
    }
    if (row == path.waypoints.rows()) {
      findings.push_back(fmt::format("the path given does not pass goal '{}'", goal.id));
      return false;
    }
  }
  return true;
}

}  // namespace

Verification verify(const RobotProblem& problem, const Design& design, const Claims& claims,
                    const VerificationOptions& options) {
  Verification result;
  const RobotProblem at_path_level = problem.with_level(Level::kPath);
  result.evaluation = problem.evaluate(design);
  result.path_evaluation = at_path_level.evaluate(design);
  check_claims(claims, result.evaluation, result.findings);
  check_lengths(claims, result.evaluation.attempt, result.path_evaluation.attempt, result.findings);

  const Attempt& attempt = result.path_evaluation.attempt;
  const std::vector<int> types = design.types();
  const Arm arm = at_path_level.chain(types).at(design.parameters());
  if (claims.postures) check_postures(problem, arm, *claims.postures, result.findings);

  const Evaluation screen = at_path_level.evaluate(design, Fidelity::kScreen);
  if (screen.attempt.achieved) result.level = "posture";
  if (!attempt.achieved) {
    result.findings.push_back(fmt::format("not achieved at level path: {}", name(attempt.why)));
  }

  if (claims.path && claims.path->waypoints.rows() > 0) {
    if (fits_task(problem, arm, *claims.path, result.findings)) result.path = claims.path;
  } else {
    result.path = attempt.path;
  }
  if (result.path) {
    const double resolution = problem.spec().planner.resolution / options.refinement;
    result.check = check_path(arm, problem.scene(), *result.path, resolution, problem.spec().planner.self_collision);
    if (!result.check->free) {
      result.findings.push_back(
          fmt::format("the path is not free when looked at in steps of {:.3g} m: {}", resolution,
                      result.check->within_limits ? "a body overlaps something" : "a joint leaves its limits"));
    } else if (attempt.achieved) {
      result.level = "path";
    }
  }
  result.verified = result.level == "path" && result.findings.empty();
  return result;
}

}  // namespace modsearch
