#include <algorithm>
#include <cmath>
#include <modsearch/kinematics/low_discrepancy.hpp>
#include <modsearch/kinematics/pose_following.hpp>
#include <modsearch/kinematics/statics.hpp>
#include <modsearch/problem/task_program.hpp>
#include <numbers>

namespace modsearch {
namespace {

// Continuous joints get two turns either way: more than any optimum needs, and finite for methods that want boxes.
constexpr double kContinuousLimit = 2.0 * std::numbers::pi;
// Pairs whose bounding balls are farther apart than this [m] count by these balls: their row is far from active.
constexpr double kFar = 0.25;

// A pair of shapes as its clearance row sees it.
struct RowSeparation {
  Separation separation;
  bool by_balls = false;  // distance of fixed balls about the shapes' origins, a lower bound of the distance
};

RowSeparation row_separation(const Shape& a, double ball_a, const Eigen::Isometry3d& X_WA, const Shape& b,
                             double ball_b, const Eigen::Isometry3d& X_WB) {
  const Eigen::Vector3d between = X_WA.translation() - X_WB.translation();
  const double gap = between.norm() - ball_a - ball_b;
  if (gap < kFar) return {separation(a, X_WA, b, X_WB), false};
  return {{.distance = gap, .p_WA = X_WA.translation(), .p_WB = X_WB.translation(), .normal_W = between.normalized()},
          true};
}

// How rows of one tolerance (or of the tolerances of one goal) are formed.
enum class Form { kPositionBall, kAxisBall, kRotationBall, kInterval };

// Rotation vector of R (axis times angle), by way of the quaternion: accurate at all angles.
Eigen::Vector3d rotation_vector(const Eigen::Matrix3d& R) {
  Eigen::Quaterniond quaternion{R};
  if (quaternion.w() < 0.0) quaternion.coeffs() *= -1.0;
  const double sine = quaternion.vec().norm();
  if (sine < 1e-12) return 2.0 * quaternion.vec();
  return 2.0 * std::atan2(sine, quaternion.w()) / sine * quaternion.vec();
}

Eigen::Matrix3d skew(const Eigen::Vector3d& v) {
  return (Eigen::Matrix3d{} << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0).finished();
}

// d rotation_vector(exp(w) R) / d w at w = 0: the inverse left Jacobian of SO(3).
Eigen::Matrix3d inverse_left_jacobian(const Eigen::Vector3d& r) {
  const double angle = r.norm();
  const Eigen::Matrix3d S = skew(r);
  const double a = angle < 1e-4 ? 1.0 / 12.0 + angle * angle / 720.0
                                : 1.0 / (angle * angle) - (1.0 + std::cos(angle)) / (2.0 * angle * std::sin(angle));
  return Eigen::Matrix3d::Identity() - 0.5 * S + a * S * S;
}

// Shrinks an interval by `margin` on both sides, by at most a quarter of its width.
std::pair<double, double> shrunk(double lower, double upper, double margin) {
  const double by = std::min(margin, 0.25 * (upper - lower));
  return {std::isfinite(lower) ? lower + by : lower, std::isfinite(upper) ? upper - by : upper};
}

// d (support of the shape in direction u of its own frame) / d (sizes): how fast its surface grows towards u.
Eigen::Vector3d support_growth(const AffineShape& shape, const Eigen::Vector3d& u_G) {
  switch (shape.kind) {
    case AffineShape::Kind::kSphere:
      return {1.0, 0.0, 0.0};
    case AffineShape::Kind::kBox:
      return 0.5 * u_G.cwiseAbs();
    case AffineShape::Kind::kCylinder:
      return {std::hypot(u_G.x(), u_G.y()), 0.5 * std::abs(u_G.z()), 0.0};
    case AffineShape::Kind::kCapsule:
      return {1.0, 0.5 * std::abs(u_G.z()), 0.0};
    case AffineShape::Kind::kMesh:
      return Eigen::Vector3d::Zero();
  }
  return Eigen::Vector3d::Zero();
}

}  // namespace

// The rows of one tolerance of one goal.
struct TaskProgram::GoalRows {
  int goal = 0;
  Eigen::Index first = 0;
  Form form = Form::kInterval;
  Eigen::Matrix3d R_TW = Eigen::Matrix3d::Identity();  // world axes to those of the tolerance
  PoseRegion region;                                   // kInterval: this tolerance alone
};

class TaskProgram::Sink final : public RowSink {
 public:
  explicit Sink(TaskProgram& program) : program_{program} {}
  void add(double lower, double upper, Row row) override {
    program_.add_row(lower, upper);
    program_.task_rows_.push_back({std::move(row)});
  }
  [[nodiscard]] int parameter(int i) const override { return i; }
  [[nodiscard]] int joint(int g, int j) const override { return static_cast<int>(program_.q_at(g)) + j; }

 private:
  TaskProgram& program_;
};

TaskProgram::~TaskProgram() = default;

TaskProgram::TaskProgram(const RobotProblem& problem, std::span<const int> types, const Relaxation& relaxation)
    : problem_{problem},
      types_{types.begin(), types.end()},
      kept_{problem.chain(types)},
      chain_{*kept_},
      arm_{chain_, parameter_box(problem.library(), types).lower} {
  const ParameterBox box = parameter_box(problem.library(), types);
  const Arm longest = chain_.at(box.upper);
  for (const ArmGeometry& geometry : longest.geometries()) greatest_radius_.push_back(geometry.bounding_radius);
  const auto n_goals = static_cast<Eigen::Index>(problem.task().goals().size());
  n_x_ = box.lower.size();
  n_q_ = chain_.n_joints();
  mass_gradient_ = chain_.mass().gradient(static_cast<int>(n_x_));

  lower_.resize(n_x_ + n_goals * n_q_);
  upper_.resize(lower_.size());
  lower_.head(n_x_) = box.lower;
  upper_.head(n_x_) = box.upper;
  for (Eigen::Index goal = 0; goal < n_goals; ++goal) {
    lower_.segment(n_x_ + goal * n_q_, n_q_) = chain_.lower_limits().cwiseMax(-kContinuousLimit);
    upper_.segment(n_x_ + goal * n_q_, n_q_) = chain_.upper_limits().cwiseMin(kContinuousLimit);
  }

  for (int goal = 0; goal < static_cast<int>(n_goals); ++goal) {
    add_goal(goal, problem.task().goals()[static_cast<std::size_t>(goal)], relaxation.tolerance_margin);
  }
  first_clearance_row_ = n_rows();
  add_clearances(relaxation);
  clearance_rows_per_goal_ = (n_rows() - first_clearance_row_) / n_goals;
  first_torque_row_ = n_rows();
  add_torques(relaxation);
  first_link_row_ = n_rows();
  add_trajectories();
  first_task_row_ = n_rows();
  Sink sink{*this};
  problem.task().add_rows(sink, chain_);
}

void TaskProgram::add_row(double lower, double upper) {
  const Eigen::Index n = row_lower_.size();
  row_lower_.conservativeResize(n + 1);
  row_upper_.conservativeResize(n + 1);
  row_lower_[n] = lower;
  row_upper_[n] = upper;
}

void TaskProgram::add_ball(int count, double radius) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  balls_.push_back({n_rows(), count, radius});
  for (int i = 0; i < count; ++i) add_row(-kInfinity, kInfinity);
}

void TaskProgram::add_goal(int index, const Goal& goal, double margin) {
  const Eigen::Isometry3d& X_WN = goal.region.nominal();
  for (const Tolerance& tolerance : goal.region.tolerances()) {
    GoalRows rows{.goal = index, .first = n_rows(), .form = Form::kInterval, .R_TW = {}, .region = {X_WN, {tolerance}}};
    rows.R_TW = tolerance.R_TN * X_WN.linear().transpose();
    const double radius = tolerance.upper - std::min(margin, 0.25 * tolerance.upper);
    const bool from_zero = tolerance.lower <= 0.0;
    if (from_zero && tolerance.projection == Projection::kRSph) {
      rows.form = Form::kPositionBall;
      add_ball(3, radius);
    } else if (from_zero && tolerance.projection == Projection::kRCyl) {
      rows.form = Form::kAxisBall;
      add_ball(2, radius);
    } else if (from_zero && tolerance.projection == Projection::kThetaR) {
      rows.form = Form::kRotationBall;
      add_ball(3, radius);
    } else {
      const auto [lower, upper] = shrunk(tolerance.lower, tolerance.upper, margin);
      add_row(lower, upper);
    }
    goal_rows_.push_back(std::move(rows));
  }
}

void TaskProgram::add_clearances(const Relaxation& relaxation) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const Level level = problem_.spec().level;
  obstacle_rows_ = level != Level::kNone && problem_.scene().any_rests();
  self_rows_ = level == Level::kPostureSelf || level == Level::kPath;
  if (self_rows_) {
    for (const auto& [a, b] : chain_.self_pairs()) {
      for (int g = 0; g < static_cast<int>(arm_.geometries().size()); ++g) {
        for (int h = 0; h < static_cast<int>(arm_.geometries().size()); ++h) {
          if (arm_.geometries()[static_cast<std::size_t>(g)].body == a &&
              arm_.geometries()[static_cast<std::size_t>(h)].body == b) {
            self_geometries_.emplace_back(g, h);
          }
        }
      }
    }
  }
  std::size_t pairs = self_geometries_.size();
  if (obstacle_rows_) {
    for (const Obstacle& obstacle : problem_.scene().obstacles()) {
      if (!obstacle.moves()) pairs += obstacle.shapes.size() * arm_.geometries().size();
    }
  }
  for (std::size_t row = 0; row < pairs * problem_.task().goals().size(); ++row) {
    add_row(relaxation.clearance_margin, kInfinity);
  }
}

void TaskProgram::add_torques(const Relaxation& relaxation) {
  if (!problem_.task().statics().limited) return;
  for (int j = 0; j < static_cast<int>(n_q_); ++j) {
    if (std::isfinite(chain_.joints()[static_cast<std::size_t>(j)].peak_torque)) limited_joints_.push_back(j);
  }
  for (std::size_t goal = 0; goal < problem_.task().goals().size(); ++goal) {
    for (const int j : limited_joints_) {
      const double peak =
          chain_.joints()[static_cast<std::size_t>(j)].peak_torque * (1.0 - relaxation.tolerance_margin);
      add_row(-peak, peak);
    }
  }
}

void TaskProgram::add_trajectories() {
  for (const TaskStep& step : problem_.task().steps()) {
    if (step.kind != TaskStep::Kind::kFollow) continue;
    for (int k = 0; k + 1 < step.n_goals; ++k) {
      links_.push_back(step.goal + k);
      const int from = step.knots[static_cast<std::size_t>(k)];
      const int to = step.knots[static_cast<std::size_t>(k) + 1];
      const std::vector<double>& times = step.trajectory->times;
      for (const Joint& joint : chain_.joints()) {
        double way = FollowOptions{}.largest_step * (to - from);
        if (!times.empty()) {
          way = std::min(
              way, joint.velocity * (times[static_cast<std::size_t>(to)] - times[static_cast<std::size_t>(from)]));
        }
        add_row(-way, way);
      }
    }
  }
}

void TaskProgram::do_evaluate(const Eigen::VectorXd& v, Values& values) {
  const Eigen::Index n = n_variables();
  values.rows.resize(n_rows());
  values.gradient.setZero(n);
  values.jacobian.setZero(n_rows(), n);

  arm_.set_parameters(v.head(n_x_));
  values.objective = arm_.mass();
  values.gradient.head(n_x_) = mass_gradient_;

  for (int goal = 0; goal < static_cast<int>(problem_.task().goals().size()); ++goal) {
    arm_.forward(v.data() + q_at(goal), posture_);
    goal_values(goal, values);
    if (clearance_rows_per_goal_ > 0) clearance_values(goal, values);
    if (!limited_joints_.empty()) torque_values(goal, values);
  }
  trajectory_values(v, values);
  for (std::size_t i = 0; i < task_rows_.size(); ++i) {
    Eigen::RowVectorXd gradient = Eigen::RowVectorXd::Zero(n);
    const Eigen::Index row = first_task_row_ + static_cast<Eigen::Index>(i);
    values.rows[row] = task_rows_[i].row(v, gradient);
    values.jacobian.row(row) = gradient;
  }
}

void TaskProgram::goal_values(int goal, Values& values) const {
  const Eigen::Matrix<double, 6, Eigen::Dynamic> J_q = arm_.tip_jacobian_q(posture_);
  const Eigen::Matrix<double, 6, Eigen::Dynamic> J_x = arm_.tip_jacobian_x(posture_);
  for (const GoalRows& rows : goal_rows_) {
    if (rows.goal != goal) continue;
    const Eigen::Isometry3d& X_WN = rows.region.nominal();
    const Eigen::Vector3d offset = posture_.tip.translation() - X_WN.translation();
    switch (rows.form) {
      case Form::kPositionBall:
        values.rows.segment<3>(rows.first) = offset;
        values.jacobian.block(rows.first, 0, 3, n_x_) = J_x.topRows<3>();
        values.jacobian.block(rows.first, q_at(goal), 3, n_q_) = J_q.topRows<3>();
        break;
      case Form::kAxisBall:
        values.rows.segment<2>(rows.first) = rows.R_TW.topRows<2>() * offset;
        values.jacobian.block(rows.first, 0, 2, n_x_) = rows.R_TW.topRows<2>() * J_x.topRows<3>();
        values.jacobian.block(rows.first, q_at(goal), 2, n_q_) = rows.R_TW.topRows<2>() * J_q.topRows<3>();
        break;
      case Form::kRotationBall: {
        // World axes: R_WE = exp(r) R_WN.
        const Eigen::Vector3d r = rotation_vector(posture_.tip.linear() * X_WN.linear().transpose());
        values.rows.segment<3>(rows.first) = r;
        const Eigen::Matrix3d dr = inverse_left_jacobian(r);
        values.jacobian.block(rows.first, 0, 3, n_x_) = dr * J_x.bottomRows<3>();
        values.jacobian.block(rows.first, q_at(goal), 3, n_q_) = dr * J_q.bottomRows<3>();
        break;
      }
      case Form::kInterval: {
        const Eigen::Matrix<double, 1, 6> J = rows.region.jacobian(posture_.tip);
        values.rows[rows.first] = rows.region.values(posture_.tip)[0];
        values.jacobian.block(rows.first, 0, 1, n_x_) = J * J_x;
        values.jacobian.block(rows.first, q_at(goal), 1, n_q_) = J * J_q;
        break;
      }
    }
  }
}

void TaskProgram::add_clearance_gradient(Eigen::Index row, int goal, int geometry, const Eigen::Vector3d& p_W,
                                         const Eigen::Vector3d& n_W, bool shape_counts, Values& values) const {
  // The distance grows with the witness point moving along the normal and shrinks with the shape growing against it.
  const ArmGeometry& shape = arm_.geometries()[static_cast<std::size_t>(geometry)];
  const Eigen::Isometry3d& X_WF = posture_.frames[static_cast<std::size_t>(shape.frame)];
  const Body& body = chain_.bodies()[static_cast<std::size_t>(shape.body)];
  const BodyGeometry* affine = body.geometries.data();
  for (int g = geometry; g > 0 && arm_.geometries()[static_cast<std::size_t>(g) - 1].body == shape.body; --g) ++affine;

  auto gradient = values.jacobian.row(row);
  gradient.segment(q_at(goal), n_q_) += n_W.transpose() * arm_.point_jacobian_q(posture_, shape.frame, p_W);
  gradient.head(n_x_) += n_W.transpose() * arm_.point_jacobian_x(posture_, shape.frame, p_W);
  affine->X_FG.for_each_move(arm_.parameters(), [&](const ParameterMove& move) {
    gradient[move.parameter] += n_W.dot(move.velocity(X_WF, p_W));
  });
  if (!shape_counts) return;
  const Eigen::Vector3d u_G = (X_WF.linear() * shape.X_FG.linear()).transpose() * -n_W;
  const Eigen::Vector3d growth = support_growth(affine->shape, u_G);
  for (std::size_t s = 0; s < affine->shape.size.size(); ++s) {
    for (const AffineScalar::Term& term : affine->shape.size[s].terms) {
      gradient[term.parameter] -= growth[static_cast<Eigen::Index>(s)] * term.scale;
    }
  }
}

void TaskProgram::clearance_values(int goal, Values& values) const {
  const std::vector<ArmGeometry>& geometries = arm_.geometries();
  const auto pose = [&](const ArmGeometry& g) {
    return Eigen::Isometry3d{posture_.frames[static_cast<std::size_t>(g.frame)] * g.X_FG};
  };
  Eigen::Index row = first_clearance_row_ + goal * clearance_rows_per_goal_;
  const auto ball = [&](int g) { return greatest_radius_[static_cast<std::size_t>(g)]; };
  if (obstacle_rows_) {
    for (int g = 0; g < static_cast<int>(geometries.size()); ++g) {
      const ArmGeometry& geometry = geometries[static_cast<std::size_t>(g)];
      const Eigen::Isometry3d X_WG = pose(geometry);
      for (const Obstacle& obstacle : problem_.scene().obstacles()) {
        if (obstacle.moves()) continue;
        for (const PlacedShape& placed : obstacle.shapes) {
          const auto [s, by_balls] =
              row_separation(geometry.shape, ball(g), X_WG, placed.shape, bounding_radius(placed.shape), placed.X_FG);
          values.rows[row] = s.distance;
          add_clearance_gradient(row, goal, g, s.p_WA, s.normal_W, !by_balls, values);
          ++row;
        }
      }
    }
  }
  for (const auto& [g, h] : self_geometries_) {
    const ArmGeometry& a = geometries[static_cast<std::size_t>(g)];
    const ArmGeometry& b = geometries[static_cast<std::size_t>(h)];
    const auto [s, by_balls] = row_separation(a.shape, ball(g), pose(a), b.shape, ball(h), pose(b));
    values.rows[row] = s.distance;
    add_clearance_gradient(row, goal, g, s.p_WA, s.normal_W, !by_balls, values);
    add_clearance_gradient(row, goal, h, s.p_WB, -s.normal_W, !by_balls, values);
    ++row;
  }
}

void TaskProgram::torque_values(int goal, Values& values) const {
  const StaticLoad load = load_at(problem_.task(), goal);
  const Eigen::VectorXd torques = static_torques(arm_, posture_, load);
  const Eigen::MatrixXd J = static_torque_jacobian(arm_, posture_, load);
  Eigen::Index row = first_torque_row_ + goal * static_cast<Eigen::Index>(limited_joints_.size());
  for (const int j : limited_joints_) {
    values.rows[row] = torques[j];
    values.jacobian.row(row).head(n_x_) = J.row(j).head(n_x_);
    values.jacobian.row(row).segment(q_at(goal), n_q_) = J.row(j).tail(n_q_);
    ++row;
  }
}

void TaskProgram::trajectory_values(const Eigen::VectorXd& v, Values& values) const {
  Eigen::Index row = first_link_row_;
  for (const int knot : links_) {
    for (Eigen::Index j = 0; j < n_q_; ++j, ++row) {
      values.rows[row] = v[q_at(knot + 1) + j] - v[q_at(knot) + j];
      values.jacobian(row, q_at(knot + 1) + j) = 1.0;
      values.jacobian(row, q_at(knot) + j) = -1.0;
    }
  }
}

Eigen::MatrixXd TaskProgram::do_hessian(const Eigen::VectorXd& v, double /*objective_factor*/,
                                        const Eigen::VectorXd& multipliers) {
  // Mass is linear: the objective contributes nothing.
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(n_variables(), n_variables());
  arm_.set_parameters(v.head(n_x_));
  for (int goal = 0; goal < static_cast<int>(problem_.task().goals().size()); ++goal) {
    // Rows linear in the tip's position add up to one direction y.
    Eigen::Vector3d y = Eigen::Vector3d::Zero();
    bool curved = false;
    for (const GoalRows& rows : goal_rows_) {
      if (rows.goal != goal) continue;
      const Projection projection = rows.region.tolerances().front().projection;
      if (rows.form == Form::kPositionBall) {
        y += multipliers.segment<3>(rows.first);
      } else if (rows.form == Form::kAxisBall) {
        y += rows.R_TW.topRows<2>().transpose() * multipliers.segment<2>(rows.first);
      } else if (rows.form == Form::kInterval && projection <= Projection::kZ) {
        y += multipliers[rows.first] * rows.R_TW.row(static_cast<int>(projection)).transpose();
      } else {
        curved = true;
      }
    }
    arm_.forward(v.data() + q_at(goal), posture_);
    const Eigen::MatrixXd tip = arm_.tip_hessian(posture_, y);
    H.topLeftCorner(n_x_, n_x_) += tip.topLeftCorner(n_x_, n_x_);
    H.block(0, q_at(goal), n_x_, n_q_) += tip.topRightCorner(n_x_, n_q_);
    H.block(q_at(goal), 0, n_q_, n_x_) += tip.bottomLeftCorner(n_q_, n_x_);
    H.block(q_at(goal), q_at(goal), n_q_, n_q_) += tip.bottomRightCorner(n_q_, n_q_);
    if (!curved) continue;

    // Orientation and polar rows: central differences of their exact gradient, good to about 1e-9.
    constexpr double kStep = 1e-5;
    Values values;
    values.rows.resize(n_rows());
    const auto gradient_at = [&](const Eigen::VectorXd& point) {
      values.jacobian.setZero(n_rows(), n_variables());
      arm_.set_parameters(point.head(n_x_));
      arm_.forward(point.data() + q_at(goal), posture_);
      goal_values(goal, values);
      Eigen::VectorXd sum = Eigen::VectorXd::Zero(n_variables());
      for (const GoalRows& rows : goal_rows_) {
        const Projection projection = rows.region.tolerances().front().projection;
        if (rows.goal != goal) continue;
        if (rows.form == Form::kRotationBall) {
          sum += values.jacobian.middleRows(rows.first, 3).transpose() * multipliers.segment<3>(rows.first);
        } else if (rows.form == Form::kInterval && projection > Projection::kZ) {
          sum += multipliers[rows.first] * values.jacobian.row(rows.first).transpose();
        }
      }
      return sum;
    };
    Eigen::MatrixXd curvature = Eigen::MatrixXd::Zero(n_variables(), n_variables());
    for (Eigen::Index i = 0; i < n_variables(); ++i) {
      const bool used = i < n_x_ || (i >= q_at(goal) && i < q_at(goal) + n_q_);
      if (!used) continue;
      Eigen::VectorXd point = v;
      point[i] = v[i] + kStep;
      const Eigen::VectorXd ahead = gradient_at(point);
      point[i] = v[i] - kStep;
      curvature.col(i) = (ahead - gradient_at(point)) / (2.0 * kStep);
    }
    H += 0.5 * (curvature + curvature.transpose());
    arm_.set_parameters(v.head(n_x_));
  }
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
  options.all = obstacle_rows_ || self_rows_ || !limited_joints_.empty() || !links_.empty();
  int goal = 0;
  Eigen::VectorXd last;
  for (const Goal& wanted : problem_.task().goals()) {
    // The knots of a trajectory stay on the branch of its first one.
    const bool linked = std::find(links_.begin(), links_.end(), goal - 1) != links_.end();
    const IkSolution ik =
        linked ? nearby_posture(arm, wanted.region, last) : inverse_kinematics(arm, wanted.region, options);
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
