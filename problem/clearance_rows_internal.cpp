#include <algorithm>
#include <cmath>
#include <modsearch/kinematics/self_pairs_internal.hpp>
#include <modsearch/problem/clearance_rows_internal.hpp>

namespace modsearch::detail {
namespace {

// Pairs whose bounding balls are farther apart than this [m] count by these balls: their row is far from active.
constexpr double kFar = 0.25;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

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

// Of a shape about its origin in direction u of its own frame: no point of it is farther that way.
double support(const Shape& shape, const Eigen::Vector3d& u_G) {
  if (const auto* const sphere = std::get_if<Sphere>(&shape)) return sphere->radius;
  if (const auto* const box = std::get_if<Box>(&shape)) return 0.5 * box->size.dot(u_G.cwiseAbs());
  if (const auto* const cylinder = std::get_if<Cylinder>(&shape)) {
    return cylinder->radius * std::sqrt(u_G.x() * u_G.x() + u_G.y() * u_G.y()) +
           0.5 * cylinder->length * std::abs(u_G.z());
  }
  if (const auto* const capsule = std::get_if<Capsule>(&shape)) {
    return capsule->radius + 0.5 * capsule->length * std::abs(u_G.z());
  }
  return kInfinity;
}

const ArmGeometry& shape_of(const Arm& arm, int index) { return arm.geometries()[static_cast<std::size_t>(index)]; }

Eigen::Isometry3d placed(const ArmGeometry& shape, const Posture& posture) {
  return Eigen::Isometry3d{posture.frames[static_cast<std::size_t>(shape.frame)] * shape.X_FG};
}

}  // namespace

void ClearanceRows::Balls::resize(std::size_t n) {
  for (std::vector<double>* numbers : {&x, &y, &z, &radius}) numbers->resize(n);
}

void ClearanceRows::Balls::set(std::size_t i, const BoundingCapsule& capsule) {
  x[i] = capsule.centre_W.x();
  y[i] = capsule.centre_W.y();
  z[i] = capsule.centre_W.z();
  radius[i] = capsule.half_length + capsule.radius;
}

ClearanceRows::ClearanceRows(const Chain& chain, const Scene& scene, bool obstacles, bool self, const Arm& longest) {
  if (!obstacles && !self) return;
  for (const Body& body : chain.bodies()) {
    for (const BodyGeometry& geometry : body.geometries) {
      arm_shapes_.push_back({&geometry, longest.geometries()[arm_shapes_.size()].bounding_radius});
    }
  }
  capsules_.resize(arm_shapes_.size());
  balls_.resize(arm_shapes_.size());
  room_.resize(arm_shapes_.size());
  if (obstacles) {
    for (const Obstacle& obstacle : scene.obstacles()) {
      if (obstacle.moves()) continue;
      for (const PlacedShape& shape : obstacle.shapes) {
        const double radius = bounding_radius(shape.shape);
        scene_shapes_.push_back({&shape, radius, bounding_capsule(shape.shape, radius, shape.X_FG)});
      }
    }
  }
  for (int b = 0; b < static_cast<int>(scene_shapes_.size()); ++b) {
    for (int a = 0; a < static_cast<int>(arm_shapes_.size()); ++a) pairs_.push_back({a, b, false});
  }
  self_pairs_of_.assign(arm_shapes_.size() + 1, pairs_.size());
  if (!self) return;
  any_self_pair(longest, [&](std::size_t a, std::size_t b) {
    pairs_.push_back({static_cast<int>(a), static_cast<int>(b), true});
    return false;
  });
  const auto first = pairs_.begin() + static_cast<std::ptrdiff_t>(self_pairs_of_.front());
  std::stable_sort(first, pairs_.end(), [](const Pair& p, const Pair& q) { return p.a < q.a; });
  for (std::size_t a = 0; a < self_pairs_of_.size(); ++a) {
    const auto begin = std::partition_point(first, pairs_.end(),
                                            [&](const Pair& pair) { return static_cast<std::size_t>(pair.a) < a; });
    self_pairs_of_[a] = static_cast<std::size_t>(begin - pairs_.begin());
  }
}

void ClearanceRows::set_parameters(const Arm& arm) {
  for (std::size_t i = 0; i < arm_shapes_.size(); ++i) {
    const ArmGeometry& shape = arm.geometries()[i];
    arm_shapes_[i].capsule_F = bounding_capsule(shape.shape, shape.bounding_radius, shape.X_FG);
  }
}

void ClearanceRows::place_capsules(const Arm& arm, const Posture& posture) {
  for (std::size_t i = 0; i < capsules_.size(); ++i) {
    const Eigen::Isometry3d& X_WF = posture.frames[static_cast<std::size_t>(arm.geometries()[i].frame)];
    const BoundingCapsule& capsule_F = arm_shapes_[i].capsule_F;
    capsules_[i] = {X_WF * capsule_F.centre_W, X_WF.linear() * capsule_F.half_axis_W, capsule_F.half_length,
                    capsule_F.radius};
    balls_.set(i, capsules_[i]);
  }
}

bool ClearanceRows::measured_apart(const Arm& arm, const Posture& posture, std::size_t a, const Shape& other,
                                   const Eigen::Isometry3d& X_WO, double distance, Known& known) const {
  constexpr double kRounding = 1e-9;
  const ArmGeometry& shape = arm.geometries()[a];
  const Eigen::Isometry3d X_WA = placed(shape, posture);
  if (known.was_apart) {
    const Eigen::Vector3d axis_W = X_WA.linear() * known.axis_A;
    const double gap = axis_W.dot(X_WA.translation() - X_WO.translation()) - support(shape.shape, known.axis_A) -
                       support(other, X_WO.linear().transpose() * axis_W);
    if (gap >= distance + kRounding) return true;
  }
  const Separation s = separation(shape.shape, X_WA, other, X_WO);
  known.axis_A = X_WA.linear().transpose() * s.normal_W;
  known.was_apart = s.distance >= distance;  // not a number: near
  return known.was_apart;
}

void ClearanceRows::compare(const BoundingCapsule& other, std::size_t from, double distance) {
  constexpr double kRounding = 2e-9;
  const double x = other.centre_W.x(), y = other.centre_W.y(), z = other.centre_W.z();
  const double radius = other.half_length + other.radius + distance + kRounding;
  for (std::size_t i = from; i < room_.size(); ++i) {
    const double dx = balls_.x[i] - x, dy = balls_.y[i] - y, dz = balls_.z[i] - z;
    const double reach = balls_.radius[i] + radius;
    room_[i] = reach * reach - (dx * dx + dy * dy + dz * dz);
  }
}

void ClearanceRows::add(const Arm& arm, const Posture& posture, int goal, double distance) {
  if (pairs_.empty()) return;
  if (known_.size() <= static_cast<std::size_t>(goal)) known_.resize(static_cast<std::size_t>(goal) + 1);
  std::vector<Known>& known = known_[static_cast<std::size_t>(goal)];
  known.resize(pairs_.size());
  const auto take = [&](std::size_t pair) {
    known[pair].is_row = true;
    rows_.push_back({goal, static_cast<int>(pair)});
  };
  if (std::isinf(distance)) {
    for (std::size_t pair = 0; pair < pairs_.size(); ++pair) {
      if (!known[pair].is_row) take(pair);
    }
    return;
  }
  place_capsules(arm, posture);
  std::size_t pair = 0;
  for (const SceneShape& other : scene_shapes_) {
    compare(other.capsule, 0, distance);
    for (std::size_t a = 0; a < capsules_.size(); ++a, ++pair) {
      if (room_[a] < 0.0 || known[pair].is_row || apart(capsules_[a], other.capsule, distance)) continue;
      const PlacedShape& obstacle = *other.placed;
      if (!measured_apart(arm, posture, a, obstacle.shape, obstacle.X_FG, distance, known[pair])) take(pair);
    }
  }
  for (std::size_t a = 0; a < capsules_.size(); ++a) {
    if (pair == self_pairs_of_[a + 1]) continue;
    compare(capsules_[a], a + 1, distance);
    for (; pair < self_pairs_of_[a + 1]; ++pair) {
      const auto b = static_cast<std::size_t>(pairs_[pair].b);
      if (room_[b] < 0.0 || known[pair].is_row || apart(capsules_[a], capsules_[b], distance)) continue;
      const ArmGeometry& other = arm.geometries()[b];
      if (!measured_apart(arm, posture, a, other.shape, placed(other, posture), distance, known[pair])) take(pair);
    }
  }
}

void ClearanceRows::clear() {
  for (std::vector<Known>& known : known_) std::fill(known.begin(), known.end(), Known{});
  rows_.clear();
}

void ClearanceRows::add_gradient(const Arm& arm, const Posture& posture, const ArmMoves& order,
                                 std::span<const Move> moves, GoalColumns columns, int shape,
                                 const Eigen::Vector3d& p_W, const Eigen::Vector3d& n_W, bool shape_counts,
                                 Eigen::Index row, Eigen::MatrixXd& jacobian) const {
  // The distance grows with the witness point moving along the normal and shrinks with the shape growing against it.
  const ArmGeometry& geometry = shape_of(arm, shape);
  const BodyGeometry& affine = *arm_shapes_[static_cast<std::size_t>(shape)].affine;
  for (const Move& move : moves.first(order.count(geometry.frame))) {
    jacobian(row, columns.of(move.variable)) += n_W.dot(move.velocity(p_W));
  }
  const Eigen::Isometry3d& X_WF = posture.frames[static_cast<std::size_t>(geometry.frame)];
  affine.X_FG.for_each_move(arm.parameters(), [&](const ParameterMove& move) {
    jacobian(row, move.parameter) += n_W.dot(move.velocity(X_WF, p_W));
  });
  if (!shape_counts) return;
  const Eigen::Vector3d u_G = (X_WF.linear() * geometry.X_FG.linear()).transpose() * -n_W;
  const Eigen::Vector3d growth = support_growth(affine.shape, u_G);
  for (std::size_t s = 0; s < affine.shape.size.size(); ++s) {
    for (const AffineScalar::Term& term : affine.shape.size[s].terms) {
      jacobian(row, term.parameter) -= growth[static_cast<Eigen::Index>(s)] * term.scale;
    }
  }
}

void ClearanceRows::evaluate(const Arm& arm, const Posture& posture, const ArmMoves& order, std::span<const Move> moves,
                             int goal, GoalColumns columns, Eigen::Index first_row, SmoothProgram::Values& values) {
  const auto ball = [&](int shape) { return arm_shapes_[static_cast<std::size_t>(shape)].greatest_radius; };
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    if (rows_[i].goal != goal) continue;
    const Pair& pair = pairs_[static_cast<std::size_t>(rows_[i].pair)];
    const Eigen::Index row = first_row + static_cast<Eigen::Index>(i);
    const auto slope = [&](int shape, const Eigen::Vector3d& p_W, const Eigen::Vector3d& n_W, bool shape_counts) {
      add_gradient(arm, posture, order, moves, columns, shape, p_W, n_W, shape_counts, row, values.jacobian);
    };
    const ArmGeometry& a = shape_of(arm, pair.a);
    const Eigen::Isometry3d X_WA = placed(a, posture);
    if (pair.self) {
      const ArmGeometry& b = shape_of(arm, pair.b);
      const auto [s, by_balls] = row_separation(a.shape, ball(pair.a), X_WA, b.shape, ball(pair.b), placed(b, posture));
      values.rows[row] = s.distance;
      slope(pair.a, s.p_WA, s.normal_W, !by_balls);
      slope(pair.b, s.p_WB, -s.normal_W, !by_balls);
    } else {
      const SceneShape& other = scene_shapes_[static_cast<std::size_t>(pair.b)];
      const auto [s, by_balls] =
          row_separation(a.shape, ball(pair.a), X_WA, other.placed->shape, other.radius, other.placed->X_FG);
      values.rows[row] = s.distance;
      slope(pair.a, s.p_WA, s.normal_W, !by_balls);
    }
  }
}

}  // namespace modsearch::detail
