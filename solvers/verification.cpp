#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <modsearch/kinematics/space_time.hpp>
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

// " from .. to ..", where the attempt says between which goals no path was found.
std::string missing_motion(const Task& task, const Attempt& attempt) {
  if (!attempt.missing_motion) return {};
  const auto place = [&](int goal) {
    return goal < 0 ? std::string{} : fmt::format("goal '{}'", task.goals()[static_cast<std::size_t>(goal)].id);
  };
  const auto [from, to] = *attempt.missing_motion;
  if (to < 0) return {};
  return fmt::format(" {} to {}", from < 0 ? "on the way" : "from " + place(from), place(to));
}

// Looks whether a claimed path does what the task asks for, step by step.
class PathReader {
 public:
  PathReader(const RobotProblem& problem, const Arm& arm, const Path& path, std::vector<std::string>& findings)
      : problem_{problem}, arm_{arm}, path_{path}, findings_{findings} {}

  [[nodiscard]] bool fits_task() {
    if (path_.waypoints.rows() < 1 || path_.waypoints.cols() != arm_.n_joints() || !path_.waypoints.allFinite()) {
      findings_.push_back(fmt::format("the path given is {} x {}, the arm has {} joints", path_.waypoints.rows(),
                                      path_.waypoints.cols(), arm_.n_joints()));
      return false;
    }
    const Eigen::VectorXd home = home_posture(problem_.task(), arm_, problem_.scene());
    const double off = (path_.waypoints.row(0).transpose() - home).cwiseAbs().maxCoeff();
    if (off > kPostureSlack) {
      findings_.push_back(fmt::format("the path given starts {:.3g} rad away from home", off));
      return false;
    }
    if (is_timed(problem_.task(), problem_.scene()) && !in_time()) return false;
    const std::vector<TaskStep> steps = steps_of(problem_.task());
    std::vector<Eigen::Index> end(steps.size(), 0);  // row at which each step is done
    for (std::size_t i = 0; i < steps.size(); ++i) {
      // Where the order is free, what is not bound to the step before may be done at any time.
      const bool bound = steps[i].kind == TaskStep::Kind::kPause || steps[i].kind == TaskStep::Kind::kReturn;
      const Eigen::Index from = i > 0 && (bound || !problem_.task().any_order()) ? end[i - 1] : 0;
      const std::optional<Eigen::Index> row = done(steps, steps[i], from, end, home);
      if (!row) return false;
      end[i] = *row;
    }
    return true;
  }

 private:
  [[nodiscard]] Eigen::VectorXd q(Eigen::Index row) const { return path_.waypoints.row(row).transpose(); }

  // No joint is faster than it may be, and there are times at all.
  [[nodiscard]] bool in_time() {
    constexpr double kRounding = 1e-6;
    if (path_.times.size() != static_cast<std::size_t>(path_.waypoints.rows())) {
      findings_.push_back("the path given has no times, which the task asks for");
      return false;
    }
    for (std::size_t i = 1; i < path_.times.size(); ++i) {
      const auto row = static_cast<Eigen::Index>(i);
      for (int j = 0; j < arm_.n_joints(); ++j) {
        const double limit = arm_.chain().joints()[static_cast<std::size_t>(j)].velocity;
        const double way = std::abs(q(row)[j] - q(row - 1)[j]);
        const double time = path_.times[i] - path_.times[i - 1];
        if (time >= 0.0 && way <= limit * time * (1.0 + kRounding) + kPostureSlack) continue;
        findings_.push_back(fmt::format(
            "joint {} of the path given moves by {:.4g} in {:.4g} s (limit: {:.4g} per second)", j, way, time, limit));
        return false;
      }
    }
    return true;
  }

  [[nodiscard]] std::optional<Eigen::Index> pass(const PoseRegion& region, Eigen::Index from) const {
    for (Eigen::Index row = from; row < path_.waypoints.rows(); ++row) {
      if (nearly_contains(region, arm_.forward(q(row)).tip)) return row;
    }
    return std::nullopt;
  }

  [[nodiscard]] std::optional<Eigen::Index> assume(const Eigen::VectorXd& posture, Eigen::Index from) const {
    constexpr double kSamePosture = 1e-4;  // CoBRA's
    for (Eigen::Index row = from; row < path_.waypoints.rows(); ++row) {
      if ((q(row) - posture).norm() <= kSamePosture) return row;
    }
    return std::nullopt;
  }

  // A run of rows that fulfils the poses of a trajectory one after the other; where it has times, at these.
  [[nodiscard]] std::optional<Eigen::Index> followed(const Trajectory& trajectory, Eigen::Index from) const {
    constexpr double kSameTime = 1e-6;  // [s]
    for (std::optional<Eigen::Index> start = pass(trajectory.poses.front(), from); start;
         start = pass(trajectory.poses.front(), *start + 1)) {
      std::optional<Eigen::Index> row = start;
      for (std::size_t k = 1; row && k < trajectory.poses.size(); ++k) {
        if (trajectory.times.empty()) {
          row = pass(trajectory.poses[k], *row);
          continue;
        }
        const double due = path_.times[static_cast<std::size_t>(*start)] + trajectory.times[k] - trajectory.times[0];
        Eigen::Index next = *row;
        while (next < path_.waypoints.rows() && path_.times[static_cast<std::size_t>(next)] < due - kSameTime) ++next;
        const bool there = next < path_.waypoints.rows() &&
                           path_.times[static_cast<std::size_t>(next)] <= due + kSameTime &&
                           nearly_contains(trajectory.poses[k], arm_.forward(q(next)).tip);
        row = there ? std::optional{next} : std::nullopt;
      }
      if (row) return row;
      if (*start + 1 >= path_.waypoints.rows()) break;
    }
    return std::nullopt;
  }

  // The arm stands still for `seconds` somewhere from row `from` on.
  [[nodiscard]] std::optional<Eigen::Index> paused(double seconds, Eigen::Index from) const {
    constexpr double kRounding = 1e-6;  // [s]
    for (Eigen::Index first = from; first < path_.waypoints.rows(); ++first) {
      Eigen::Index last = first;
      while (last + 1 < path_.waypoints.rows() && (q(last + 1) - q(first)).norm() <= kPostureSlack) ++last;
      const double time = path_.times[static_cast<std::size_t>(last)] - path_.times[static_cast<std::size_t>(first)];
      if (time >= seconds - kRounding) return last;
    }
    return std::nullopt;
  }

  // The row at which `step` is done, sought from row `from` on.
  [[nodiscard]] std::optional<Eigen::Index> done(const std::vector<TaskStep>& steps, const TaskStep& step,
                                                 Eigen::Index from, const std::vector<Eigen::Index>& end,
                                                 const Eigen::VectorXd& home) {
    std::optional<Eigen::Index> row;
    std::string_view verb = "pass";
    switch (step.kind) {
      case TaskStep::Kind::kVisit:
        row = pass(problem_.task().goals()[static_cast<std::size_t>(step.goal)].region, from);
        break;
      case TaskStep::Kind::kFollow:
        row = followed(*step.trajectory, from);
        verb = "follow";
        break;
      case TaskStep::Kind::kPause:
        row = paused(step.duration, from);
        verb = "pause for";
        break;
      case TaskStep::Kind::kReturn: {
        Eigen::VectorXd posture = home;
        for (std::size_t i = 0; i < steps.size(); ++i) {
          const bool theirs = step.goal >= steps[i].goal && step.goal < steps[i].goal + steps[i].n_goals &&
                              (steps[i].kind == TaskStep::Kind::kVisit || steps[i].kind == TaskStep::Kind::kFollow);
          if (step.goal >= 0 && theirs) posture = q(end[i]);
        }
        row = assume(posture, from);
        verb = "return as asked by";
        break;
      }
    }
    if (!row) findings_.push_back(fmt::format("the path given does not {} goal '{}'", verb, step.id));
    return row;
  }

  const RobotProblem& problem_;
  const Arm& arm_;
  const Path& path_;
  std::vector<std::string>& findings_;
};

}  // namespace

Verification verify(const RobotProblem& problem, const Design& design, const Claims& claims,
                    const VerificationOptions& options) {
  Verification result;
  const RobotProblem at_path_level = problem.with_level(Level::kPath);
  const Witness witness{claims.postures.value_or(Eigen::MatrixXd{})};
  result.evaluation = problem.evaluate(design, Fidelity::kFull, witness);
  const bool same_level = problem.spec().level == Level::kPath;
  result.path_evaluation = same_level ? result.evaluation : at_path_level.evaluate(design, Fidelity::kFull, witness);
  check_claims(claims, result.evaluation, result.findings);
  check_lengths(claims, result.evaluation.attempt, result.path_evaluation.attempt, result.findings);

  const Attempt& attempt = result.path_evaluation.attempt;
  const std::vector<int> types = design.types();
  const std::shared_ptr<const Chain> chain = at_path_level.chain(types);
  const Arm arm = chain->at(design.parameters());
  if (claims.postures) check_postures(problem, arm, *claims.postures, result.findings);

  // What a path goes through are postures that touch nothing.
  const bool postures = attempt.achieved || at_path_level.evaluate(design, Fidelity::kScreen, witness).attempt.achieved;
  if (postures) result.level = "posture";
  if (!attempt.achieved) {
    result.findings.push_back(fmt::format("not achieved at level path: {}{}", name(attempt.why),
                                          missing_motion(at_path_level.task(), attempt)));
  }

  if (claims.path && claims.path->waypoints.rows() > 0) {
    if (PathReader{problem, arm, *claims.path, result.findings}.fits_task()) result.path = claims.path;
  } else {
    result.path = attempt.path;
  }
  if (result.path) {
    const double resolution = problem.spec().planner.resolution / options.refinement;
    result.check = check_path(arm, problem.scene(), *result.path, resolution, problem.spec().planner.self_collision);
    bool in_time = true;
    if (problem.scene().any_moves()) {
      const SpaceTimeCheck met = check_in_time(arm, problem.scene(), *result.path, resolution);
      in_time = met.free;
      result.check->clearance = std::min(result.check->clearance, met.clearance);
      result.check->states += met.states;
      result.check->free = result.check->free && in_time;
    }
    if (!result.check->free) {
      const std::string_view why = !result.check->within_limits ? "a joint leaves its limits"
                                   : !in_time                   ? "a body meets an obstacle that moves"
                                                                : "a body overlaps something";
      result.findings.push_back(
          fmt::format("the path is not free when looked at in steps of {:.3g} m: {}", resolution, why));
    } else if (attempt.achieved) {
      result.level = "path";
    }
  }
  result.verified = result.level == "path" && result.findings.empty();
  return result;
}

Evaluation with_path(Evaluation found, const Verification& verification) {
  const Attempt& planned = verification.path_evaluation.attempt;
  if (!planned.path) return found;
  Attempt& attempt = found.attempt;
  attempt.path = planned.path;
  attempt.postures = planned.postures;
  attempt.goal_waypoints = planned.goal_waypoints;
  attempt.step_waypoints = planned.step_waypoints;
  attempt.goal_error = planned.goal_error;
  attempt.clearance = planned.clearance;
  attempt.torque_share = planned.torque_share;
  attempt.trajectories = planned.trajectories;
  return found;
}

}  // namespace modsearch
