#include <algorithm>
#include <cmath>
#include <modsearch/problem/sure_overlap_internal.hpp>
#include <variant>
#include <vector>

namespace modsearch::detail {
namespace {

using Kind = AffineShape::Kind;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr int kMostCells = 8;     // of a box of parameters, some ten microseconds each
constexpr int kMostCorners = 16;  // of such a box: where one is free, cutting it up is in vain
constexpr int kMostParameters = 3 * ModuleLibrary::kMaxParameters;  // of an end of three modules
using Slides = Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::ColMajor, 3, kMostParameters>;
using Effects = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, kMostParameters, 1>;

// A box of parameters.
struct Cell {
  Eigen::VectorXd middle;
  Eigen::VectorXd half;
};

// Where a point of a part is in R, for all parameters of a cell: q + sum_i s_i slides_i + a ball, |s_i| <= 1.
struct Reached {
  Eigen::Vector3d q = Eigen::Vector3d::Zero();
  Slides slides{};    // [3 x n_parameters]
  double ball = 0.0;  // what turns of parameters add
  Effects effect{};   // how far each parameter carries the point [n_parameters]
};

Eigen::Vector3d half_sizes(const AffineShape& shape, const Eigen::VectorXd& x) {
  switch (shape.kind) {
    case Kind::kSphere:
      return Eigen::Vector3d::Constant(shape.size[0].at(x));
    case Kind::kBox:
      return 0.5 * Eigen::Vector3d{shape.size[0].at(x), shape.size[1].at(x), shape.size[2].at(x)};
    case Kind::kCylinder:
    case Kind::kCapsule:  // the cylinder in it
      return {shape.size[0].at(x), shape.size[0].at(x), 0.5 * shape.size[1].at(x)};
    case Kind::kMesh:
      break;
  }
  return Eigen::Vector3d::Zero();
}

// Adds what the half sizes of the shape gain per unit of each parameter, times `u`.
void add_size_slides(const AffineShape& shape, const Eigen::Vector3d& u, Slides& slides) {
  const auto add = [&](const AffineScalar& size, const Eigen::Vector3d& direction) {
    for (const AffineScalar::Term& term : size.terms) slides.col(term.parameter) += term.scale * direction;
  };
  switch (shape.kind) {
    case Kind::kSphere:
      add(shape.size[0], u);
      break;
    case Kind::kBox:
      for (int axis = 0; axis < 3; ++axis) {
        add(shape.size[static_cast<std::size_t>(axis)], 0.5 * u[axis] * Eigen::Vector3d::Unit(axis));
      }
      break;
    case Kind::kCylinder:
    case Kind::kCapsule:
      add(shape.size[0], {u.x(), u.y(), 0.0});
      add(shape.size[1], {0.0, 0.0, 0.5 * u.z()});
      break;
    case Kind::kMesh:
      break;
  }
}

// `u` moved to where it is a share of the half sizes that lies in the shape.
Eigen::Vector3d within(Kind kind, Eigen::Vector3d u) {
  switch (kind) {
    case Kind::kSphere:
      return u / std::max(1.0, u.norm());
    case Kind::kBox:
      return u.cwiseMax(-1.0).cwiseMin(1.0);
    case Kind::kCylinder:
    case Kind::kCapsule:
      u.head<2>() /= std::max(1.0, u.head<2>().norm());
      u.z() = std::clamp(u.z(), -1.0, 1.0);
      return u;
    case Kind::kMesh:
      break;
  }
  return u;
}

// The point at the share `u` of the half sizes.
class MovingPoint {
 public:
  MovingPoint(const RigidPart& part, const Cell& cell)
      : part_{part},
        cell_{cell},
        half_sizes_{half_sizes(part.shape, cell.middle)},
        X_RG_{part.X_RG.at(cell.middle)},
        fixed_{cell.half.isZero(0.0)} {
    if (fixed_) return;
    const std::vector<ParametricPose::Turn>& turns = part.X_RG.turns;
    for (std::size_t k = turns.size(); k-- > 0;) {
      Step step{.pose = &turns[k].after, .middle = turns[k].after.at(cell.middle)};
      step.turn = Eigen::AngleAxisd{turns[k].angle.at(cell.middle), Eigen::Vector3d::UnitZ()}.toRotationMatrix();
      double most = 0.0;
      for (const AffineScalar::Term& term : turns[k].angle.terms) {
        const double by = std::abs(term.scale) * cell.half[term.parameter];
        step.by_parameter.push_back({term.parameter, chord(by)});
        most += by;
      }
      step.by = chord(most);
      steps_.push_back(std::move(step));
    }
    steps_.push_back({.pose = &part.X_RG.head, .middle = part.X_RG.head.at(cell.middle)});
  }

  [[nodiscard]] Reached at(const Eigen::Vector3d& u) const {
    if (fixed_) return {.q = X_RG_ * half_sizes_.cwiseProduct(u)};
    const Eigen::Index n = cell_.half.size();
    Reached point{.q = half_sizes_.cwiseProduct(u), .slides = Slides::Zero(3, n), .effect = Effects::Zero(n)};
    add_size_slides(part_.shape, u, point.slides);
    for (const Step& step : steps_) take(step, point);
    for (Eigen::Index i = 0; i < n; ++i) {
      point.slides.col(i) *= cell_.half[i];
      point.effect[i] += point.slides.col(i).norm();
    }
    return point;
  }

 private:
  // An affine pose, and a turn of what follows it.
  struct Step {
    const AffinePose* pose = nullptr;
    Eigen::Isometry3d middle = Eigen::Isometry3d::Identity();  // of the pose, in the middle of the cell
    Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();        // likewise
    double by = 0.0;                                           // chord of what the turn may be off that
    std::vector<std::pair<int, double>> by_parameter{};        // the same for each parameter of it alone
  };

  // Slides are per unit of their parameters until the end.
  void take(const Step& step, Reached& point) const {
    point.q = step.middle * point.q;
    point.slides = step.middle.linear() * point.slides;
    for (const AffineVector::Term& term : step.pose->translation.terms) {
      point.slides.col(term.parameter) += term.direction;
    }
    if (step.by_parameter.empty()) return;
    double reach = point.q.head<2>().norm() + point.ball;
    for (Eigen::Index i = 0; i < point.slides.cols(); ++i) {
      reach += cell_.half[i] * point.slides.col(i).head<2>().norm();
    }
    for (const auto& [parameter, chord_of_it] : step.by_parameter) point.effect[parameter] += chord_of_it * reach;
    point.q = step.turn * point.q;
    point.slides = step.turn * point.slides;
    point.ball += step.by * reach;
  }

  const RigidPart& part_;
  const Cell& cell_;
  Eigen::Vector3d half_sizes_;
  Eigen::Isometry3d X_RG_;
  bool fixed_;
  std::vector<Step> steps_;  // from the part outwards, where the cell is more than a point
};

// A shape of the obstacle, as the points of R meet it.
class Target {
 public:
  Target(const PlacedShape& placed, const PoseEnclosure& poses)
      : shape_{placed.shape}, poses_{poses}, X_OC_{placed.X_FG.inverse() * poses.X_WC} {
    const Eigen::Matrix3d half_axes_O = placed.X_FG.linear().transpose() * poses.half_axes_W;
    for (int axis = 0; axis < 3; ++axis) {
      by_position_[axis] = std::min(half_axes_O.row(axis).lpNorm<1>(), poses.position_radius);
    }
  }

  /// How far inside the shape the point is at least, however it is carried [m]; negative: perhaps outside.
  [[nodiscard]] double depth(const Reached& point) const {
    double slid = 0.0;
    Eigen::Vector3d along = by_position_;  // how far it can be carried along each axis of the shape
    if (point.slides.cols() > 0) {
      const Slides slides_O = X_OC_.linear() * point.slides;
      along += slides_O.cwiseAbs().rowwise().sum();
      slid = slides_O.colwise().norm().sum();
    }
    const double turned = point.ball + poses_.turned_by(point.q, slid + point.ball);
    along.array() += turned;
    const double most = std::min(along.norm(), poses_.position_radius + slid + turned);
    return inside(X_OC_ * point.q, along, most);
  }
  /// Whether a shape that is at `X_RG` overlaps this one while the reference frame is at the centre of its poses.
  [[nodiscard]] bool overlaps(const Shape& shape, const Eigen::Isometry3d& X_RG) const {
    return modsearch::overlaps(shape, X_OC_ * X_RG, shape_, Eigen::Isometry3d::Identity());
  }

 private:
  [[nodiscard]] double inside(const Eigen::Vector3d& p, const Eigen::Vector3d& along, double most) const {
    if (const auto* sphere = std::get_if<Sphere>(&shape_)) return sphere->radius - p.norm() - most;
    if (const auto* box = std::get_if<Box>(&shape_)) return (0.5 * box->size - p.cwiseAbs() - along).minCoeff();
    const double across = std::min(most, along.head<2>().norm());
    if (const auto* cylinder = std::get_if<Cylinder>(&shape_)) {
      return std::min(0.5 * cylinder->length - std::abs(p.z()) - along.z(),
                      cylinder->radius - p.head<2>().norm() - across);
    }
    if (const auto* capsule = std::get_if<Capsule>(&shape_)) {
      const double end = 0.5 * capsule->length;
      const Eigen::Vector3d from_axis{p.x(), p.y(), p.z() - std::clamp(p.z(), -end, end)};
      return capsule->radius - from_axis.norm() - most;
    }
    return -kInfinity;
  }

  const Shape& shape_;
  const PoseEnclosure& poses_;
  Eigen::Isometry3d X_OC_;
  Eigen::Vector3d by_position_;
};

// The share of the half sizes where the point is deepest, from `best` on: the depth is concave in it, and 26
// directions, in steps that are halved, come close to its top.
Eigen::Vector3d deepest(const MovingPoint& point, Kind kind, const Target& target, Eigen::Vector3d best,
                        double finest) {
  constexpr double kWorthAStep = 1e-7;  // [m]: the search ends
  double depth = target.depth(point.at(best));
  for (double step = 1.0; step >= finest;) {
    const Eigen::Vector3d from = best;
    for (int i = 0; i < 27; ++i) {
      const Eigen::Vector3d way{i % 3 - 1.0, i / 3 % 3 - 1.0, i / 9 - 1.0};
      const Eigen::Vector3d u = within(kind, from + step * way);
      const double here = target.depth(point.at(u));
      if (here > depth + kWorthAStep) {
        depth = here;
        best = u;
      }
    }
    if (best == from) step *= 0.5;
  }
  return best;
}

bool depends_on_parameters(const RigidPart& part) {
  const auto moves = [](const AffinePose& X) { return !X.translation.terms.empty(); };
  return !part.X_RG.turns.empty() || moves(part.X_RG.head) ||
         std::any_of(part.shape.size.begin(), part.shape.size.end(),
                     [](const AffineScalar& size) { return !size.terms.empty(); });
}

// The parts of a module that may be proved to be in an obstacle, and the shapes of that.
class Pairs {
 public:
  Pairs(const RigidModule& module, const PoseEnclosure& poses, const Obstacle& obstacle) : module_{module} {
    const auto near = [](const Eigen::Isometry3d& X) { return X.translation().cwiseAbs().maxCoeff() < kFarthest; };
    for (const PlacedShape& placed : obstacle.shapes) {
      const bool usable = is_rotation(placed.X_FG.linear()) && near(placed.X_FG) && near(poses.X_WC);
      if (usable && !std::holds_alternative<Mesh>(placed.shape)) targets_.emplace_back(placed, poses);
    }
  }

  /// Deepest of the parts that no parameter moves [m]; -inf: none is inside.
  [[nodiscard]] double fixed_depth() const {
    double depth = -kInfinity;
    const Cell none{module_.lower, Effects::Zero(module_.lower.size())};
    for_each_overlap(module_.lower, [&](const RigidPart& part, const Target& target) {
      if (depends_on_parameters(part)) return;
      const MovingPoint point{part, none};
      depth = std::max(depth, target.depth(point.at(deepest(point, part.shape.kind, target, {0, 0, 0}, kFinest))));
    });
    return depth;
  }
  /// Whether anything overlaps at these parameters and the centre of the poses.
  [[nodiscard]] bool overlap(const Eigen::VectorXd& x) const {
    bool any = false;
    for_each_overlap(x, [&](const RigidPart&, const Target&) { any = true; });
    return any;
  }

  /// What a cell comes to: the deepest point for all of it, and which parameter to halve where that is not deep enough.
  struct Verdict {
    double depth = -kInfinity;
    Eigen::Index halve = -1;  // -1: no point is sure to be inside even in the middle of the cell
  };
  [[nodiscard]] Verdict judged(const Cell& cell) const {
    Verdict verdict;
    double in_the_middle = kLeastDepth;
    const Cell middle{cell.middle, Eigen::VectorXd::Zero(cell.half.size())};
    for_each_overlap(cell.middle, [&](const RigidPart& part, const Target& target) {
      const MovingPoint there{part, middle};
      const Eigen::Vector3d u = deepest(there, part.shape.kind, target, {0, 0, 0}, kFinest);
      const double depth = target.depth(there.at(u));
      if (depth <= kLeastDepth) return;
      const MovingPoint point{part, cell};
      const Reached best = point.at(deepest(point, part.shape.kind, target, u, kRough));
      verdict.depth = std::max(verdict.depth, target.depth(best));
      if (depth <= in_the_middle) return;
      in_the_middle = depth;
      best.effect.maxCoeff(&verdict.halve);
    });
    return verdict;
  }

 private:
  static constexpr double kFinest = 1.0 / 64.0;  // of the half sizes
  static constexpr double kRough = 0.25;

  // Pairs that do not overlap in the middle of everything cannot be proved to overlap.
  template <typename Visit>
  void for_each_overlap(const Eigen::VectorXd& x, const Visit& visit) const {
    for (const RigidPart& part : module_.parts) {
      if (part.shape.kind == Kind::kMesh) continue;
      const Shape shape = part.shape.at(x);
      const Eigen::Isometry3d X_RG = part.X_RG.at(x);
      for (const Target& target : targets_) {
        if (target.overlaps(shape, X_RG)) visit(part, target);
      }
    }
  }

  const RigidModule& module_;
  std::vector<Target> targets_;
};

}  // namespace

std::optional<double> sure_overlap(const RigidModule& module, const PoseEnclosure& poses, const Obstacle& obstacle) {
  if (module.parts.empty() || obstacle.moves()) return std::nullopt;
  const Pairs pairs{module, poses, obstacle};
  const double fixed = pairs.fixed_depth();
  if (fixed > kLeastDepth) return fixed;

  const Eigen::Index n = module.lower.size();
  if (n == 0) return std::nullopt;
  for (int corner = 0; corner < std::min(kMostCorners, 1 << std::min<Eigen::Index>(n, 8)); ++corner) {
    Eigen::VectorXd x = module.lower;
    for (Eigen::Index i = 0; i < n; ++i) {
      if ((corner >> std::min<Eigen::Index>(i, 8) & 1) != 0) x[i] = module.upper[i];
    }
    if (!pairs.overlap(x)) return std::nullopt;
  }
  double least = kInfinity;
  std::vector<Cell> cells{{0.5 * (module.lower + module.upper), 0.5 * (module.upper - module.lower)}};
  for (int seen = 0; !cells.empty(); ++seen) {
    const Cell cell = std::move(cells.back());
    cells.pop_back();
    const Pairs::Verdict verdict = pairs.judged(cell);
    if (verdict.depth > kLeastDepth) {
      least = std::min(least, verdict.depth);
      continue;
    }
    if (verdict.halve < 0 || seen + static_cast<int>(cells.size()) >= kMostCells) return std::nullopt;
    Cell half = cell;
    half.half[verdict.halve] *= 0.5;
    for (const double side : {-1.0, 1.0}) {
      half.middle[verdict.halve] = cell.middle[verdict.halve] + side * half.half[verdict.halve];
      cells.push_back(half);
    }
  }
  return least;
}

}  // namespace modsearch::detail
