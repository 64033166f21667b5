#include <algorithm>
#include <cmath>
#include <modsearch/kinematics/space_time.hpp>
#include <modsearch/problem/motion_internal.hpp>
#include <modsearch/problem/visiting_order_internal.hpp>

namespace modsearch::detail {
namespace {

using Kind = TaskStep::Kind;

// A step as the motion sees it: where it begins and ends in joint space.
struct Act {
  const TaskStep* step = nullptr;
  Eigen::VectorXd begin, end;
  const Eigen::MatrixXd* rows = nullptr;  // kFollow: the postures at all poses
};

// Steps that are done one after the other, whatever the order of the others.
struct Block {
  std::vector<std::size_t> acts;
};

std::vector<Act> acts_of(const std::vector<TaskStep>& steps, const Eigen::VectorXd& home, const Attempt& attempt) {
  std::vector<Act> acts;
  std::size_t trajectory = 0;
  const auto posture = [&](int goal) { return attempt.postures.row(goal).transpose().eval(); };
  for (const TaskStep& step : steps) {
    Act act{.step = &step, .begin = {}, .end = {}};
    switch (step.kind) {
      case Kind::kVisit:
        act.begin = act.end = posture(step.goal);
        break;
      case Kind::kFollow:
        act.rows = &attempt.trajectories[trajectory++];
        act.begin = act.rows->topRows(1).transpose();
        act.end = act.rows->bottomRows(1).transpose();
        break;
      case Kind::kReturn:
        act.begin = act.end = step.goal < 0 ? home : posture(step.goal);
        break;
      case Kind::kPause:
        break;  // wherever the arm is
    }
    acts.push_back(std::move(act));
  }
  return acts;
}

std::vector<Block> blocks_of(const std::vector<Act>& acts) {
  std::vector<Block> blocks;
  for (std::size_t i = 0; i < acts.size(); ++i) {
    const Kind kind = acts[i].step->kind;
    if (blocks.empty() || kind == Kind::kVisit || kind == Kind::kFollow) blocks.emplace_back();
    blocks.back().acts.push_back(i);
  }
  return blocks;
}

bool has_goal(const TaskStep& step, int goal) {
  return (step.kind == Kind::kVisit || step.kind == Kind::kFollow) && goal >= step.goal &&
         goal < step.goal + step.n_goals;
}

// Indices of the acts in the order in which they are done.
std::vector<std::size_t> order_of(const Task& task, const Chain& chain, const std::vector<Act>& acts,
                                  const Eigen::VectorXd& home) {
  const std::vector<Block> blocks = blocks_of(acts);
  std::vector<int> order;
  if (task.any_order() && blocks.size() > 1) {
    const auto n = static_cast<Eigen::Index>(blocks.size());
    // Where the arm is when a block begins and ends; a pause moves nothing.
    std::vector<const Eigen::VectorXd*> begin(blocks.size(), &home), end(blocks.size(), &home);
    std::vector<std::pair<int, int>> before;
    for (std::size_t b = 0; b < blocks.size(); ++b) {
      bool first = true;
      for (const std::size_t i : blocks[b].acts) {
        const TaskStep& step = *acts[i].step;
        if (step.kind == Kind::kPause) continue;
        if (first) begin[b] = &acts[i].begin;
        first = false;
        end[b] = &acts[i].end;
        if (step.kind != Kind::kReturn || step.goal < 0) continue;
        for (std::size_t c = 0; c < blocks.size(); ++c) {
          const bool theirs = std::any_of(blocks[c].acts.begin(), blocks[c].acts.end(),
                                          [&](std::size_t k) { return has_goal(*acts[k].step, step.goal); });
          if (theirs && c != b) before.emplace_back(static_cast<int>(c), static_cast<int>(b));
        }
      }
    }
    Eigen::VectorXd first(n);
    Eigen::MatrixXd ways(n, n);
    for (Eigen::Index b = 0; b < n; ++b) {
      first[b] = travel_time(chain, home, *begin[static_cast<std::size_t>(b)]);
      for (Eigen::Index c = 0; c < n; ++c) {
        ways(b, c) = travel_time(chain, *end[static_cast<std::size_t>(b)], *begin[static_cast<std::size_t>(c)]);
      }
    }
    order = visiting_order(first, ways, before);
  } else {
    for (std::size_t b = 0; b < blocks.size(); ++b) order.push_back(static_cast<int>(b));
  }
  std::vector<std::size_t> result;
  for (const int b : order) {
    const std::vector<std::size_t>& more = blocks[static_cast<std::size_t>(b)].acts;
    result.insert(result.end(), more.begin(), more.end());
  }
  return result;
}

// A motion that grows step by step.
class Motion {
 public:
  Motion(const Task& task, const Arm& arm, const Scene& scene, const AttemptOptions& options,
         const Eigen::VectorXd& home, LegPlanner& legs, Attempt& attempt)
      : arm_{arm},
        scene_{scene},
        options_{options},
        legs_{legs},
        attempt_{attempt},
        timed_{is_timed(task, scene)},
        rows_{home},
        times_{0.0} {}

  // The arm moves to `q`, and stands there for `hold` seconds at least before it goes on.
  [[nodiscard]] Failure go_to(const Eigen::VectorXd& q, double hold) {
    const bool first = rows_.size() == 1;
    const Plan plan = legs_.plan(rows_.back(), times_.back(), q, hold, attempt_.work);
    switch (plan.status) {
      case PlanStatus::kExact:
        break;
      case PlanStatus::kInvalidStart:
        return first ? Failure::kHomeInCollision : Failure::kNoPath;
      case PlanStatus::kInvalidGoal:
      case PlanStatus::kNotFound:
        return Failure::kNoPath;
    }
    for (Eigen::Index row = 1; row < plan.path.waypoints.rows(); ++row) {
      const Eigen::VectorXd to = plan.path.waypoints.row(row).transpose();
      const double t = plan.path.times.empty()
                           ? times_.back() + whole_steps(travel_time(arm_.chain(), rows_.back(), to))
                           : plan.path.times[static_cast<std::size_t>(row)];
      add(to, t);
    }
    return Failure::kNone;
  }

  // The arm stands still. Where obstacles move, the motion before has seen to it that it may.
  void wait(double seconds) {
    if (timed_ && seconds > 0.0) add(rows_.back(), times_.back() + seconds);
  }

  // The arm, which is at the first of them, runs through `postures` and may stand at the last for `hold` seconds; `row`
  // [n_poses] gets the rows of the path.
  [[nodiscard]] Failure run_along(const Eigen::MatrixXd& postures, const Trajectory& trajectory, double hold,
                                  std::vector<int>& row) {
    Path path{postures, std::vector<double>{0.0}};
    for (Eigen::Index k = 1; k < postures.rows(); ++k) {
      const auto i = static_cast<std::size_t>(k);
      const double least = travel_time(arm_.chain(), postures.row(k - 1).transpose(), postures.row(k).transpose());
      path.times.push_back(path.times.back() +
                           (trajectory.times.empty() ? least : trajectory.times[i] - trajectory.times[i - 1]));
    }
    const PathCheck check =
        check_path(arm_, scene_, path, options_.planner.resolution, options_.planner.self_collision);
    attempt_.work += check.work;
    if (!check.free) return Failure::kNoPath;
    const std::optional<double> delay = scene_.any_moves() ? free_delay(path, hold) : std::optional{0.0};
    if (!delay) return Failure::kNoPath;
    wait(*delay);
    const double start = times_.back();
    row.push_back(last_row());
    for (std::size_t k = 1; k < path.times.size(); ++k) {
      add(postures.row(static_cast<Eigen::Index>(k)).transpose(), start + path.times[k]);
      row.push_back(last_row());
    }
    return Failure::kNone;
  }

  [[nodiscard]] int last_row() const { return static_cast<int>(rows_.size()) - 1; }
  [[nodiscard]] const Eigen::VectorXd& last() const { return rows_.back(); }

  [[nodiscard]] Path path() const {
    Path path;
    path.waypoints.resize(static_cast<Eigen::Index>(rows_.size()), rows_.front().size());
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      path.waypoints.row(static_cast<Eigen::Index>(i)) = rows_[i].transpose();
    }
    if (timed_) path.times = times_;
    return path;
  }

 private:
  void add(Eigen::VectorXd q, double t) {
    rows_.push_back(std::move(q));
    times_.push_back(t);
  }

  [[nodiscard]] double whole_steps(double seconds) const {
    constexpr double kRounding = 1e-6;  // of a step
    return options_.time_step * std::ceil(seconds / options_.time_step - kRounding);
  }

  // How long to wait before `path`, whose times begin at 0, so that no moving obstacle is met: neither on it nor before
  // it nor `hold` seconds after it.
  [[nodiscard]] std::optional<double> free_delay(const Path& path, double hold) {
    constexpr double kWait = 0.25;     // [s], as in plan_in_time
    constexpr double kLongest = 60.0;  // [s]
    for (double delay = 0.0; delay <= kLongest; delay += kWait) {
      Path late = path;
      late.waypoints.conservativeResize(late.waypoints.rows() + 1, Eigen::NoChange);
      late.waypoints.bottomRows(1) = path.waypoints.bottomRows(1);
      late.times.push_back(late.times.back() + hold);
      for (double& t : late.times) t += times_.back() + delay;
      SpaceTimeCheck check = check_in_time(arm_, scene_, late, options_.planner.resolution);
      attempt_.work += check.work;
      if (check.free) return delay;
      const Path waiting{late.waypoints.row(0).replicate(2, 1), {times_.back() + delay, times_.back() + delay + kWait}};
      check = check_in_time(arm_, scene_, waiting, options_.planner.resolution);
      attempt_.work += check.work;
      if (!check.free) return std::nullopt;
    }
    return std::nullopt;
  }

  const Arm& arm_;
  const Scene& scene_;
  const AttemptOptions& options_;
  LegPlanner& legs_;
  Attempt& attempt_;
  bool timed_;
  std::vector<Eigen::VectorXd> rows_;
  std::vector<double> times_;
};

// Seconds of the pauses right behind act `at` of `order`.
double pause_after(const std::vector<Act>& acts, const std::vector<std::size_t>& order, std::size_t at) {
  double seconds = 0.0;
  for (std::size_t i = at + 1; i < order.size() && acts[order[i]].step->kind == Kind::kPause; ++i) {
    seconds += acts[order[i]].step->duration;
  }
  return seconds;
}

// The goal whose posture the arm assumes by act `act`; -1: none of its own.
int goal_of(const Act& act) {
  return act.step->kind == Kind::kVisit || act.step->kind == Kind::kReturn ? act.step->goal : -1;
}

}  // namespace

MotionEnd plan_motion(const Task& task, const Arm& arm, const Scene& scene, const AttemptOptions& options,
                      const Eigen::VectorXd& home, LegPlanner& legs, Attempt& attempt) {
  const std::vector<TaskStep> steps = steps_of(task);
  const std::vector<Act> acts = acts_of(steps, home, attempt);
  const std::vector<std::size_t> order = order_of(task, arm.chain(), acts, home);
  Motion motion{task, arm, scene, options, home, legs, attempt};
  attempt.goal_waypoints.assign(task.goals().size(), 0);
  attempt.step_waypoints.assign(steps.size(), 0);

  int at = -1;  // the goal at whose posture the arm is
  for (std::size_t i = 0; i < order.size(); ++i) {
    const Act& act = acts[order[i]];
    const TaskStep& step = *act.step;
    if (step.kind == Kind::kPause) {
      // The first pause of all is at home: the others have been seen to by the motion before.
      if (motion.last_row() == 0) {
        if (const Failure failure = motion.go_to(home, step.duration); failure != Failure::kNone) return {failure};
      }
      motion.wait(step.duration);
    } else {
      const double hold = step.kind == Kind::kFollow ? 0.0 : pause_after(acts, order, i);
      const Failure failure = motion.go_to(act.begin, hold);
      if (failure != Failure::kNone) return {failure, at, goal_of(act)};
      at = goal_of(act);
    }
    if (step.kind == Kind::kVisit) attempt.goal_waypoints[static_cast<std::size_t>(step.goal)] = motion.last_row();
    if (step.kind == Kind::kFollow) {
      std::vector<int> rows;
      const Failure failure = motion.run_along(*act.rows, *step.trajectory, pause_after(acts, order, i), rows);
      if (failure != Failure::kNone) return {failure};
      for (int k = 0; k < step.n_goals; ++k) {
        const auto knot = static_cast<std::size_t>(step.knots[static_cast<std::size_t>(k)]);
        attempt.goal_waypoints[static_cast<std::size_t>(step.goal + k)] = rows[knot];
      }
    }
    attempt.step_waypoints[order[i]] = motion.last_row();
  }
  attempt.path = motion.path();
  return {};
}

}  // namespace modsearch::detail
