#include <algorithm>
#include <cmath>
#include <modsearch/kinematics/low_discrepancy.hpp>
#include <modsearch/kinematics/pose_following.hpp>
#include <modsearch/kinematics/weights_internal.hpp>
#include <modsearch/problem/clearance_rows_internal.hpp>
#include <modsearch/problem/pose_rows_internal.hpp>
#include <modsearch/problem/task_program.hpp>
#include <numbers>

namespace modsearch {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
// Continuous joints get two turns either way: more than any optimum needs, and finite for methods that want boxes.
constexpr double kContinuousLimit = 2.0 * std::numbers::pi;

// Shrinks an interval by `margin` on both sides, by at most a quarter of its width.
std::pair<double, double> shrunk(double lower, double upper, double margin) {
  const double by = std::min(margin, 0.25 * (upper - lower));
  return {std::isfinite(lower) ? lower + by : lower, std::isfinite(upper) ? upper - by : upper};
}

// Poses of the step's trajectory that get a posture: its own knots, and `most` evenly spread ones.
std::vector<int> knots_of(const TaskStep& step, int most) {
  std::vector<int> knots = step.knots;
  const int last = static_cast<int>(step.trajectory->poses.size()) - 1;
  const int n = std::min(most, last + 1);
  for (int k = 0; n > 1 && k < n; ++k) knots.push_back(k * last / (n - 1));
  std::sort(knots.begin(), knots.end());
  knots.erase(std::unique(knots.begin(), knots.end()), knots.end());
  return knots;
}

// As far as the joints may move from one pose of a trajectory to another [n_joints].
Eigen::VectorXd way_between(const Chain& chain, const Trajectory& trajectory, int from, int to) {
  Eigen::VectorXd way(chain.n_joints());
  for (int j = 0; j < chain.n_joints(); ++j) {
    way[j] = FollowOptions{}.largest_step * (to - from);
    if (trajectory.times.empty()) continue;
    const double seconds =
        trajectory.times[static_cast<std::size_t>(to)] - trajectory.times[static_cast<std::size_t>(from)];
    way[j] = std::min(way[j], chain.joints()[static_cast<std::size_t>(j)].velocity * seconds);
  }
  return way;
}

}  // namespace

// The arm at the goals, and the rows that speak of it.
struct TaskProgram::Goals {
  struct Goal {
    StaticLoad load;
    detail::GoalColumns columns;
    detail::PoseRows rows;
    Posture posture{};
    std::vector<detail::Move> moves{};
  };
  std::vector<Goal> all;
  detail::ArmMoves order;
  detail::Weights weights;
  detail::ClearanceRows clearance;
};

class TaskProgram::Sink final : public RowSink {
 public:
  explicit Sink(TaskProgram& program) : program_{program} {}
  void add(double lower, double upper, Row row) override {
    program_.add_row(lower, upper);
    program_.task_rows_.push_back({std::move(row)});
  }
  [[nodiscard]] int parameter(int i) const override { return i; }
  [[nodiscard]] int joint(int g, int j) const override {
    return static_cast<int>(program_.q_at(program_.place_of_goal_[static_cast<std::size_t>(g)])) + j;
  }

 private:
  TaskProgram& program_;
};

TaskProgram::~TaskProgram() = default;

TaskProgram::TaskProgram(const RobotProblem& problem, std::span<const int> types, const Relaxation& relaxation)
    : problem_{problem},
      relaxation_{relaxation},
      types_{types.begin(), types.end()},
      kept_{problem.chain(types)},
      chain_{*kept_},
      arm_{chain_, parameter_box(problem.library(), types).lower} {
  const ParameterBox box = parameter_box(problem.library(), types);
  choose_goals();
  n_x_ = box.lower.size();
  n_q_ = chain_.n_joints();
  mass_gradient_ = chain_.mass().gradient(static_cast<int>(n_x_));

  lower_.resize(n_x_ + n_goals() * n_q_);
  upper_.resize(lower_.size());
  lower_.head(n_x_) = box.lower;
  upper_.head(n_x_) = box.upper;
  for (int goal = 0; goal < n_goals(); ++goal) {
    lower_.segment(q_at(goal), n_q_) = chain_.lower_limits().cwiseMax(-kContinuousLimit);
    upper_.segment(q_at(goal), n_q_) = chain_.upper_limits().cwiseMin(kContinuousLimit);
  }

  const Level level = problem.spec().level;
  const bool obstacles = level != Level::kNone && problem.scene().any_rests();
  const bool self = level == Level::kPostureSelf || level == Level::kPath;
  compares_bodies_ = obstacles || self;
  goals_ =
      std::make_unique<Goals>(Goals{.all = {},
                                    .order = detail::ArmMoves{chain_},
                                    .weights = detail::Weights{chain_},
                                    .clearance = {chain_, problem.scene(), obstacles, self, chain_.at(box.upper)}});
  for (int goal = 0; goal < n_goals(); ++goal) add_goal(goal, relaxation.tolerance_margin);
  first_torque_row_ = n_rows();
  add_torques(relaxation);
  first_way_row_ = n_rows();
  add_ways();
  first_task_row_ = n_rows();
  Sink sink{*this};
  problem.task().add_rows(sink, chain_);
  first_clearance_row_ = n_rows();
  if (!relaxation.all_rows) return;
  for (int goal = 0; goal < n_goals(); ++goal) goals_->clearance.add(arm_, {}, goal, kInfinity);
  fit_clearance_rows();
}

void TaskProgram::choose_goals() {
  const Task& task = problem_.task();
  std::vector<const TaskStep*> followed(task.goals().size(), nullptr);  // the step that begins with a goal
  for (const TaskStep& step : task.steps()) {
    if (step.kind == TaskStep::Kind::kFollow) followed[static_cast<std::size_t>(step.goal)] = &step;
  }
  place_of_goal_.resize(task.goals().size());
  for (int goal = 0; goal < static_cast<int>(task.goals().size());) {
    const TaskStep* const step = followed[static_cast<std::size_t>(goal)];
    const StaticLoad load = load_at(task, goal);
    if (step == nullptr) {
      place_of_goal_[static_cast<std::size_t>(goal)] = n_goals();
      wanted_.push_back({task.goals()[static_cast<std::size_t>(goal++)].region, load});
      continue;
    }
    const Trajectory& trajectory = *step->trajectory;
    const std::vector<int> knots = knots_of(*step, relaxation_.knots);
    for (std::size_t k = 0; k < knots.size(); ++k) {
      wanted_.push_back({trajectory.poses[static_cast<std::size_t>(knots[k])], load});
      if (goal < step->goal + step->n_goals && knots[k] == step->knots[static_cast<std::size_t>(goal - step->goal)]) {
        place_of_goal_[static_cast<std::size_t>(goal)] = n_goals() - 1;
        wanted_.back().region = task.goals()[static_cast<std::size_t>(goal++)].region;
      }
      if (k > 0) wanted_.back().way = way_between(chain_, trajectory, knots[k - 1], knots[k]);
    }
  }
}

void TaskProgram::add_row(double lower, double upper) {
  const Eigen::Index n = row_lower_.size();
  row_lower_.conservativeResize(n + 1);
  row_upper_.conservativeResize(n + 1);
  row_lower_[n] = lower;
  row_upper_[n] = upper;
}

void TaskProgram::add_ball(int count, double radius) {
  balls_.push_back({n_rows(), count, radius});
  for (int i = 0; i < count; ++i) add_row(-kInfinity, kInfinity);
}

void TaskProgram::add_goal(int index, double margin) {
  const Wanted& wanted = wanted_[static_cast<std::size_t>(index)];
  const detail::GoalColumns columns{static_cast<int>(n_x_), q_at(index)};
  detail::PoseRows rows{wanted.region.nominal(), columns};
  for (const Tolerance& tolerance : wanted.region.tolerances()) {
    rows.add(tolerance, n_rows());
    if (const int count = detail::PoseRows::count(tolerance); count > 1) {
      add_ball(count, tolerance.upper - std::min(margin, 0.25 * tolerance.upper));
    } else {
      const auto [lower, upper] = shrunk(tolerance.lower, tolerance.upper, margin);
      add_row(lower, upper);
    }
  }
  goals_->all.push_back({wanted.load, columns, std::move(rows)});
}

void TaskProgram::add_torques(const Relaxation& relaxation) {
  if (!problem_.task().statics().limited) return;
  for (int j = 0; j < static_cast<int>(n_q_); ++j) {
    if (std::isfinite(chain_.joints()[static_cast<std::size_t>(j)].peak_torque)) limited_joints_.push_back(j);
  }
  for (int goal = 0; goal < n_goals(); ++goal) {
    for (const int j : limited_joints_) {
      const double peak =
          chain_.joints()[static_cast<std::size_t>(j)].peak_torque * (1.0 - relaxation.tolerance_margin);
      add_row(-peak, peak);
    }
  }
}

void TaskProgram::add_ways() {
  for (const Wanted& wanted : wanted_) {
    for (Eigen::Index j = 0; wanted.way && j < n_q_; ++j) add_row(-(*wanted.way)[j], (*wanted.way)[j]);
  }
}

void TaskProgram::fit_clearance_rows() {
  const Eigen::Index before = row_lower_.size();
  const Eigen::Index n = first_clearance_row_ + static_cast<Eigen::Index>(goals_->clearance.n_rows());
  row_lower_.conservativeResize(n);
  row_upper_.conservativeResize(n);
  for (Eigen::Index row = before; row < n; ++row) {
    row_lower_[row] = relaxation_.clearance_margin;
    row_upper_[row] = kInfinity;
  }
}

int TaskProgram::do_grow(const Eigen::VectorXd& v) {
  if (!compares_bodies_ || relaxation_.all_rows) return 0;
  place(v);
  const int before = n_rows();
  const double distance = relaxation_.clearance_margin + relaxation_.near;
  for (int goal = 0; goal < n_goals(); ++goal) {
    goals_->clearance.add(arm_, goals_->all[static_cast<std::size_t>(goal)].posture, goal, distance);
  }
  fit_clearance_rows();
  return n_rows() - before;
}

void TaskProgram::do_shrink() {
  if (relaxation_.all_rows) return;
  goals_->clearance.clear();
  fit_clearance_rows();
}

void TaskProgram::place(const Eigen::VectorXd& v) {
  if (is_placed_ && placed_ == v) return;
  is_placed_ = false;  // until nothing can throw any more
  x_ = v.head(n_x_);
  arm_.set_parameters(x_);
  goals_->order.set_parameters(arm_.parameters());
  if (!limited_joints_.empty()) goals_->weights.set_parameters(arm_.parameters());
  goals_->clearance.set_parameters(arm_);
  for (Goals::Goal& goal : goals_->all) {
    arm_.forward(v.data() + goal.columns.q_at, goal.posture);
    goals_->order.place(goal.posture, goal.moves);
  }
  placed_ = v;
  is_placed_ = true;
}

void TaskProgram::do_evaluate(const Eigen::VectorXd& v, Values& values) {
  place(v);
  const Eigen::Index n = n_variables();
  values.rows.resize(n_rows());
  values.gradient.setZero(n);
  values.jacobian.setZero(n_rows(), n);
  values.objective = arm_.mass();
  values.gradient.head(n_x_) = mass_gradient_;

  for (int index = 0; index < n_goals(); ++index) {
    const Goals::Goal& goal = goals_->all[static_cast<std::size_t>(index)];
    goal.rows.evaluate(goal.posture.tip, goal.moves, values);
    if (!limited_joints_.empty()) torque_values(index, values);
    goals_->clearance.evaluate(arm_, goal.posture, goals_->order, goal.moves, index, goal.columns, first_clearance_row_,
                               values);
  }
  way_values(v, values);
  task_values(v, values);
}

void TaskProgram::torque_values(int index, Values& values) {
  const Goals::Goal& goal = goals_->all[static_cast<std::size_t>(index)];
  goals_->weights.hang(goal.posture, goals_->order, goal.moves, goal.load);
  Eigen::Index row = first_torque_row_ + index * static_cast<Eigen::Index>(limited_joints_.size());
  for (const int j : limited_joints_) {
    values.rows[row] = goals_->weights.torque(j);
    goals_->weights.for_each_slope(
        j, [&](int variable, double slope) { values.jacobian(row, goal.columns.of(variable)) += slope; });
    ++row;
  }
}

void TaskProgram::way_values(const Eigen::VectorXd& v, Values& values) const {
  Eigen::Index row = first_way_row_;
  for (int goal = 0; goal < n_goals(); ++goal) {
    if (!wanted_[static_cast<std::size_t>(goal)].way) continue;
    for (Eigen::Index j = 0; j < n_q_; ++j, ++row) {
      values.rows[row] = v[q_at(goal) + j] - v[q_at(goal - 1) + j];
      values.jacobian(row, q_at(goal) + j) = 1.0;
      values.jacobian(row, q_at(goal - 1) + j) = -1.0;
    }
  }
}

void TaskProgram::task_values(const Eigen::VectorXd& v, Values& values) {
  Eigen::Index row = first_task_row_;
  for (const TaskRow& task_row : task_rows_) {
    task_gradient_.setZero(n_variables());
    values.rows[row] = task_row.row(v, task_gradient_);
    values.jacobian.row(row) = task_gradient_;
    ++row;
  }
}

Eigen::MatrixXd TaskProgram::do_hessian(const Eigen::VectorXd& v, double /*objective_factor*/,
                                        const Eigen::VectorXd& multipliers) {
  // Mass is linear: the objective contributes nothing.
  place(v);
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(n_variables(), n_variables());
  for (const Goals::Goal& goal : goals_->all) goal.rows.add_curvature(goal.posture.tip, goal.moves, multipliers, H);
  return H;
}

Eigen::VectorXd TaskProgram::start(int index) {
  Eigen::VectorXd v(n_variables());
  const Eigen::VectorXd spread = halton(index, static_cast<int>(n_x_));
  v.head(n_x_) = lower_.head(n_x_) + spread.cwiseProduct(upper_.head(n_x_) - lower_.head(n_x_));
  const Arm arm{chain_, v.head(n_x_)};
  IkOptions options = problem_.spec().ik;
  options.starts = std::min(options.starts, 4);
  options.family_points = 16;
  const bool linked =
      std::any_of(wanted_.begin(), wanted_.end(), [](const Wanted& wanted) { return wanted.way.has_value(); });
  options.all = compares_bodies_ || !limited_joints_.empty() || linked;
  int goal = 0;
  Eigen::VectorXd last;
  for (const Wanted& wanted : wanted_) {
    // The knots of a trajectory stay on the branch of its first one.
    const IkSolution ik =
        wanted.way ? nearby_posture(arm, wanted.region, last) : inverse_kinematics(arm, wanted.region, options);
    const std::size_t pick = static_cast<std::size_t>(index) % ik.postures.size();
    last = ik.postures[pick].cwiseMax(lower_.segment(q_at(goal), n_q_)).cwiseMin(upper_.segment(q_at(goal), n_q_));
    v.segment(q_at(goal), n_q_) = last;
    ++goal;
  }
  return v;
}

Design TaskProgram::design(const Eigen::VectorXd& v) const {
  const Eigen::VectorXd x = v.head(n_x_).cwiseMax(lower_.head(n_x_)).cwiseMin(upper_.head(n_x_));
  return make_design(problem_.library(), types_, x);
}

}  // namespace modsearch
