#include <algorithm>
#include <modsearch/problem/reach_bound.hpp>
#include <modsearch/problem/trial_internal.hpp>
#include <numbers>
#include <optional>
#include <utility>

namespace modsearch::detail {
namespace {

// A limit keeps the arm from the pose: a joint that does not turn all round stands at its end.
bool at_a_limit(const Chain& chain, const Eigen::VectorXd& q) {
  constexpr double kAtTheEnd = 1e-9;  // [rad] or [m]
  for (int j = 0; j < chain.n_joints(); ++j) {
    const Joint& joint = chain.joints()[static_cast<std::size_t>(j)];
    if (!joint.full_circle() && (q[j] <= joint.lower + kAtTheEnd || q[j] >= joint.upper - kAtTheEnd)) return true;
  }
  return false;
}

bool fits(const Witness& witness, const Task& task, const Arm& arm) {
  return !witness.empty() && witness.postures.rows() == static_cast<Eigen::Index>(task.goals().size()) &&
         witness.postures.cols() == arm.n_joints() && witness.postures.allFinite();
}

}  // namespace

Trial::Trial(const Task& task, const Arm& arm, const Scene& scene, const AttemptOptions& options)
    : task_{task},
      arm_{arm},
      options_{options},
      witnessed_{fits(options.witness, task, arm)},
      judge_{task, arm, scene, options},
      found_(task.goals().size()),
      choices_(task.goals().size()),
      all_choices_(task.goals().size(), false) {
  attempt_.reached = true;
  attempt_.why = Failure::kNone;
  attempt_.postures.resize(static_cast<Eigen::Index>(task.goals().size()), arm.n_joints());
}

// The posture that was given for the goal; the nearest one within the limits where it is not within them.
Eigen::VectorXd Trial::witnessed(int goal) const {
  return arm_.chain().clamped(options_.witness.postures.row(goal).transpose());
}

void Trial::seek(int goal_index) {
  const auto at = static_cast<std::size_t>(goal_index);
  const Goal& goal = task_.goals()[at];
  // Without a step of a search, a posture near one that is given is that posture, and a look at where it leads.
  found_[at] = witnessed_ ? nearby_posture(arm_, goal.region, witnessed(goal_index), 0)
                          : inverse_kinematics(arm_, goal.region, judge_.ik());
  const IkSolution& ik = found_[at];
  count(ik.iterations, ik.forward);
  ++errors_;
  attempt_.goal_error = std::max(attempt_.goal_error, ik.position_error);
  if (!ik.reached) miss(goal, ik);
}

void Trial::visit(int goal_index) {
  const auto at = static_cast<std::size_t>(goal_index);
  const IkSolution& ik = found_[at];
  Candidate chosen = attempt_.reached ? judge_.best(ik, load_at(task_, goal_index), attempt_.clearance, attempt_.work)
                                      : judge_.free_one(ik, attempt_.work);
  attempt_.postures.row(goal_index) = chosen.q.transpose();
  look_at(chosen);
  choices_[at].push_back(std::move(chosen));
}

// Postures at the first pose of a trajectory.
IkSolution Trial::begun(const TaskStep& step) {
  const PoseRegion& first = step.trajectory->poses.front();
  IkSolution ik;
  if (witnessed_) {
    ik = nearby_posture(arm_, first, witnessed(step.goal), options_.follow.iterations);
  } else {
    IkOptions ik_options = options_.ik;  // the same starts at every level
    ik_options.all = true;
    ik_options.family_points = kMostStarts;
    ik = inverse_kinematics(arm_, first, ik_options);
  }
  count(ik.iterations, ik.forward);
  return ik;
}

// A joint that may turn farther than once around can run into a limit on the way, and would not if it had begun a turn
// back. Inverse kinematics gives one posture of those that are whole turns apart.
Following Trial::followed(const Trajectory& trajectory, const Eigen::VectorXd& q) {
  const auto from = [&](const Eigen::VectorXd& start) {
    Following way = follow_poses(arm_, trajectory.poses, trajectory.times, start, options_.follow);
    count(way.iterations, way.forward);
    return way;
  };
  Following best = from(q);
  for (bool better = best.n_followed > 0; better && best.end != FollowEnd::kDone;) {
    better = false;
    const Eigen::VectorXd start = best.postures.row(0);
    const Eigen::VectorXd end = best.postures.row(static_cast<Eigen::Index>(best.n_followed) - 1);
    for (int j = 0; j < arm_.n_joints() && !better; ++j) {
      const Joint& joint = arm_.chain().joints()[static_cast<std::size_t>(j)];
      if (!joint.rotates()) continue;
      const double turn = end[j] > joint.upper - options_.follow.largest_step   ? -2.0 * std::numbers::pi
                          : end[j] < joint.lower + options_.follow.largest_step ? 2.0 * std::numbers::pi
                                                                                : 0.0;
      if (turn == 0.0 || start[j] + turn < joint.lower || start[j] + turn > joint.upper) continue;
      Eigen::VectorXd other = start;
      other[j] += turn;
      Following way = from(other);
      better = way.n_followed > best.n_followed;
      if (better) best = std::move(way);
    }
  }
  return best;
}

void Trial::follow(const TaskStep& step) {
  const std::vector<PoseRegion>& poses = step.trajectory->poses;
  const auto n = static_cast<double>(poses.size());
  const IkSolution ik = begun(step);
  ++errors_;
  std::optional<Following> best;
  Candidate worst_of_best;
  if (ik.reached) {
    const std::size_t n_starts = std::min<std::size_t>(ik.postures.size(), kMostStarts);
    for (std::size_t i = 0; i < n_starts; ++i) {
      const std::size_t pick = i * ik.postures.size() / n_starts;
      Following way = followed(*step.trajectory, ik.postures[pick]);
      if (best && way.n_followed < best->n_followed) continue;
      Candidate worst = worst_along(way, step);
      if (best && way.n_followed == best->n_followed && !worst.better_than(worst_of_best)) continue;
      best = std::move(way);
      worst_of_best = std::move(worst);
      const bool free = worst_of_best.holds() && worst_of_best.clearance() >= 0.0;
      if (best->end == FollowEnd::kDone && free) break;  // any way that is free will do
    }
    attempt_.goal_error = std::max(attempt_.goal_error, best->position_error);
    look_at(worst_of_best);
    if (best->end != FollowEnd::kDone) {
      const Failure why = best->end == FollowEnd::kJump      ? Failure::kJump
                          : best->end == FollowEnd::kTooFast ? Failure::kLimit
                                                             : Failure::kUnreachable;
      fail(why, 1.0 - static_cast<double>(best->n_followed) / n);
    }
  } else {
    const Goal& goal = task_.goals()[static_cast<std::size_t>(step.goal)];
    attempt_.goal_error = std::max(attempt_.goal_error, ik.position_error);
    miss(goal, ik);
    attempt_.relative_error += 1.0;  // not even begun
    best.emplace();
    best->postures = ik.postures.front().transpose().replicate(static_cast<Eigen::Index>(poses.size()), 1);
  }
  for (int k = 0; k < step.n_goals; ++k) {
    attempt_.postures.row(step.goal + k) = best->postures.row(step.knots[static_cast<std::size_t>(k)]);
  }
  followed_.push_back(std::move(worst_of_best));
  attempt_.trajectories.push_back(std::move(best->postures));
}

const std::vector<Candidate>& Trial::choices(int goal) {
  const auto at = static_cast<std::size_t>(goal);
  std::vector<Candidate>& known = choices_[at];
  if (!all_choices_[at] && !known.empty()) {
    std::vector<Candidate> others = judge_.others(found_[at], known.front().q, load_at(task_, goal), attempt_.work);
    std::move(others.begin(), others.end(), std::back_inserter(known));
  }
  all_choices_[at] = true;
  return known;
}

int Trial::n_choices(int goal) { return std::max(1, static_cast<int>(choices(goal).size())); }

void Trial::choose(int goal, int choice) {
  const auto at = static_cast<std::size_t>(goal);
  if (choices_[at].empty()) return;
  const Eigen::VectorXd& q = choices_[at][static_cast<std::size_t>(choice)].q;
  moved_ = moved_ || attempt_.postures.row(goal) != q.transpose();
  attempt_.postures.row(goal) = q.transpose();
}

Attempt Trial::result() && {
  if (moved_) {
    // What was seen at the postures that the attempt began with was measured as far as it mattered for these.
    attempt_.clearance = Candidate{}.obstacle_clearance;
    attempt_.torque_share = 0.0;
    for (const Candidate& worst : followed_) look_at(worst);
    for (std::size_t goal = 0; goal < choices_.size(); ++goal) {
      if (choices_[goal].empty()) continue;
      const Eigen::VectorXd q = attempt_.postures.row(static_cast<Eigen::Index>(goal)).transpose();
      look_at(judge_.judge(q, load_at(task_, static_cast<int>(goal)), attempt_.work, attempt_.clearance));
    }
  }
  attempt_.relative_error /= static_cast<double>(errors_);
  return std::move(attempt_);
}

void Trial::count(std::int64_t iterations, std::int64_t forward) {
  attempt_.work.ik_iterations += iterations;
  attempt_.work.forward += forward;
}

void Trial::fail(Failure why, double relative_error) {
  attempt_.reached = false;
  if (attempt_.why == Failure::kNone) attempt_.why = why;
  attempt_.relative_error += relative_error;
}

void Trial::miss(const Goal& goal, const IkSolution& ik) {
  constexpr double kRounding = 1e-9;  // [m]
  const double away = (goal.position() - arm_.segment(0).translation()).norm() - position_slack(goal.region);
  Failure why = Failure::kUnreachable;
  if (away > arm_.reach() + kRounding) {
    why = Failure::kProvedInfeasible;
  } else if (at_a_limit(arm_.chain(), ik.postures.front())) {
    why = Failure::kLimit;
  }
  sure_to_miss_ = sure_to_miss_ || ik.exact || why == Failure::kProvedInfeasible;
  fail(why, ik.position_error / std::max((goal.position() - options_.p_WB).norm(), 1e-9));
}

void Trial::look_at(const Candidate& chosen) {
  attempt_.clearance = std::min(attempt_.clearance, chosen.obstacle_clearance);
  attempt_.torque_share = std::max(attempt_.torque_share, chosen.torque_share);
  if (collision_ == Failure::kNone) collision_ = chosen.collision();
}

Candidate Trial::worst_along(const Following& way, const TaskStep& step) {
  Candidate worst;
  if (!judge_.choosy()) return worst;
  const StaticLoad load = load_at(task_, step.goal);
  for (std::size_t k = 0; k < way.n_followed; ++k) {
    const Candidate at = judge_.judge(way.postures.row(static_cast<Eigen::Index>(k)).transpose(), load, attempt_.work,
                                      worst.obstacle_clearance);
    worst.obstacle_clearance = std::min(worst.obstacle_clearance, at.obstacle_clearance);
    worst.self_clearance = std::min(worst.self_clearance, at.self_clearance);
    worst.torque_share = std::max(worst.torque_share, at.torque_share);
  }
  return worst;
}

}  // namespace modsearch::detail
