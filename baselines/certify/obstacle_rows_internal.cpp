#include <algorithm>
#include <array>
#include <cmath>
#include <modsearch/baselines/certify/obstacle_rows_internal.hpp>

namespace modsearch::certify {
namespace {

// Rounding may not push a ball out of its obstacle.
constexpr double kInside = 1e-9;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

// Keeps the better of two rows about one body point.
void improve(RowCandidate& best, const Row& row, double cut, double blunt, bool inside) {
  if (best.inside || (!inside && cut <= best.cut)) return;
  best.row = row;
  best.cut = cut;
  best.blunt = blunt;
  best.inside = inside;
}

// About the ball of `radius` at `centre`: |x - centre| >= R for all x within D of `x`.
void try_ball(RowCandidate& best, Row row, const NodeBound::BodyPoint& point, double body_radius,
              const Eigen::Vector3d& centre, double radius) {
  const double R = radius + body_radius - kSlack;
  const double D = point.reach;
  const double d = (point.x - centre).norm();
  row.ball = true;
  row.centre = centre;
  row.radius = radius;
  const double twice = 2.0 * std::max(d, 1e-3);
  improve(best, row, (R * R - D * D - d * d) / twice, D * D / twice, d + D < R - 1e-9);
}

// Balls of some sizes inside a box or a cylinder, each as near to the point as it can be, and the faces of a box.
void try_box(RowCandidate& best, Row row, const NodeBound::BodyPoint& point, double body_radius,
             const Eigen::Isometry3d& X_WG, const Eigen::Vector3d& size) {
  const Eigen::Vector3d local = X_WG.linear().transpose() * (point.x - X_WG.translation());
  const Eigen::Vector3d half = 0.5 * size;
  for (const double share : {0.0, 0.5, 1.0}) {
    const double radius = std::max(share * half.minCoeff() - kInside, 0.0);
    const Eigen::Vector3d room = (half.array() - radius - kInside).max(0.0).matrix();
    const Eigen::Vector3d centre = local.cwiseMin(room).cwiseMax(-room);
    try_ball(best, row, point, body_radius, X_WG * centre, radius);
  }
  for (int face = 0; face < 6; ++face) {
    const int axis = face / 2;
    const double sign = face % 2 == 0 ? 1.0 : -1.0;
    bool beside = false;
    for (int k = 0; k < 3; ++k) {
      beside = beside || (k != axis && std::abs(local[k]) + point.reach > half[k] - 1e-10);
    }
    const double out = half[axis] + body_radius - kSlack;
    if (beside || sign * local[axis] - point.reach <= -out + 1e-10) continue;
    row.ball = false;
    row.face = face;
    const double cut = out - sign * local[axis];
    // Faces lose nothing, but the farther the points move, the more may another row cut: as if a ball were there.
    const double blunt = point.reach * point.reach / (2.0 * std::max(body_radius, 1e-3));
    improve(best, row, cut, blunt, cut > point.reach + 1e-9);
    row.ball = true;
  }
}

void try_cylinder(RowCandidate& best, const Row& row, const NodeBound::BodyPoint& point, double body_radius,
                  const Eigen::Isometry3d& X_WG, const Cylinder& cylinder) {
  const Eigen::Vector3d local = X_WG.linear().transpose() * (point.x - X_WG.translation());
  const double half = 0.5 * cylinder.length;
  for (const double share : {0.0, 0.5, 1.0}) {
    const double radius = std::max(share * std::min(cylinder.radius, half) - kInside, 0.0);
    const double across = std::max(cylinder.radius - radius - kInside, 0.0);
    const double along = std::max(half - radius - kInside, 0.0);
    const double off = std::hypot(local.x(), local.y());
    const double scale = off > across ? across / off : 1.0;
    const Eigen::Vector3d centre{scale * local.x(), scale * local.y(), std::clamp(local.z(), -along, along)};
    try_ball(best, row, point, body_radius, X_WG * centre, radius);
  }
}

RowCandidate best_at(const NodeBound& bound, const SequenceModel& model, const Scenery& scenery, Row row) {
  RowCandidate best{row, -1e9, 0.0, false};
  const NodeBound::BodyPoint point = bound.body_point(row.goal, row.run, row.tau);
  const PlacedShape& obstacle = scenery.obstacles[at(row.shape)];
  const double r = model.runs[at(row.run)].radius;
  if (const auto* sphere = std::get_if<Sphere>(&obstacle.shape)) {
    try_ball(best, row, point, r, obstacle.X_FG.translation(), std::max(sphere->radius - 1e-11, 0.0));
  } else if (const auto* box = std::get_if<modsearch::Box>(&obstacle.shape)) {
    try_box(best, row, point, r, obstacle.X_FG, box->size);
  } else if (const auto* cylinder = std::get_if<Cylinder>(&obstacle.shape)) {
    try_cylinder(best, row, point, r, obstacle.X_FG, *cylinder);
  }
  return best;
}

// How far `local`, in the obstacle's frame, is outside the obstacle; where it is inside, how deep, negative. Convex.
double outside(const PlacedShape& obstacle, const Eigen::Vector3d& local) {
  const auto beyond = [](const Eigen::Vector3d& excess) {
    return excess.cwiseMax(0.0).norm() + std::min(excess.maxCoeff(), 0.0);
  };
  if (const auto* box = std::get_if<modsearch::Box>(&obstacle.shape)) return beyond(local.cwiseAbs() - 0.5 * box->size);
  if (const auto* cylinder = std::get_if<Cylinder>(&obstacle.shape)) {
    const double across = std::hypot(local.x(), local.y()) - cylinder->radius;
    const double along = std::abs(local.z()) - 0.5 * cylinder->length;
    return std::hypot(std::max(across, 0.0), std::max(along, 0.0)) + std::min(std::max(across, along), 0.0);
  }
  if (const auto* sphere = std::get_if<Sphere>(&obstacle.shape)) return local.norm() - sphere->radius;
  return 0.0;
}

// Place of the segment from `a` to `b` that is nearest to the obstacle, or deepest in it.
double nearest_on_segment(const PlacedShape& obstacle, const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  const Eigen::Isometry3d X_GW = obstacle.X_FG.inverse();
  const Eigen::Vector3d from = X_GW * a;
  const Eigen::Vector3d way = X_GW.linear() * (b - a);
  const double square = way.squaredNorm();
  if (!(square > 0.0)) return 0.0;
  if (std::holds_alternative<Sphere>(obstacle.shape)) return std::clamp(-from.dot(way) / square, 0.0, 1.0);
  constexpr int kSteps = 16;  // of three, to a 650th of the body
  double lower = 0.0;
  double upper = 1.0;
  for (int step = 0; step < kSteps; ++step) {
    const double third = (upper - lower) / 3.0;
    const bool before =
        outside(obstacle, from + (lower + third) * way) < outside(obstacle, from + (upper - third) * way);
    (before ? upper : lower) = before ? upper - third : lower + third;
  }
  return 0.5 * (lower + upper);
}

// Around the best place that was tried: where a body leans over an edge, the row that cuts most is beside the place
// that is nearest to the obstacle.
void refine(RowCandidate& best, const NodeBound& bound, const SequenceModel& model, const Scenery& scenery) {
  constexpr double kBetween = 0.25;  // places that were tried
  constexpr int kSteps = 9;          // to a 300th of it
  double lower = std::max(0.0, best.row.tau - kBetween);
  double upper = std::min(1.0, best.row.tau + kBetween);
  Row row = best.row;
  for (int step = 0; step < kSteps; ++step) {
    const double third = (upper - lower) / 3.0;
    row.tau = lower + third;
    const RowCandidate nearer = best_at(bound, model, scenery, row);
    row.tau = upper - third;
    const RowCandidate farther = best_at(bound, model, scenery, row);
    (nearer.cut > farther.cut ? upper : lower) = nearer.cut > farther.cut ? farther.row.tau : nearer.row.tau;
    for (const RowCandidate* candidate : {&nearer, &farther}) {
      if (candidate->inside ? !best.inside || candidate->cut > best.cut : !best.inside && candidate->cut > best.cut) {
        best = *candidate;
      }
    }
  }
}

}  // namespace

void find_rows(const NodeBound& bound, const SequenceModel& model, const Scenery& scenery,
               const std::vector<Row>& before, std::vector<RowCandidate>& result) {
  result.clear();
  if (scenery.obstacles.empty()) return;
  for (int g = 0; g < static_cast<int>(scenery.targets.size()); ++g) {
    for (int i = 0; i < static_cast<int>(model.runs.size()); ++i) {
      const StraightRun& run = model.runs[at(i)];
      if (!run.usable || bound.too_short(i)) continue;
      const NodeBound::BodyPoint first = bound.body_point(g, i, 0.0);
      const NodeBound::BodyPoint last = bound.body_point(g, i, 1.0);
      const double reach = std::max(first.reach, last.reach);
      for (int s = 0; s < static_cast<int>(scenery.obstacles.size()); ++s) {
        const PlacedShape& obstacle = scenery.obstacles[at(s)];
        if (std::holds_alternative<Mesh>(obstacle.shape) || std::holds_alternative<Capsule>(obstacle.shape)) continue;
        const double nearest = nearest_on_segment(obstacle, first.x, last.x);
        const Eigen::Vector3d there = first.x + nearest * (last.x - first.x);
        if (outside(obstacle, obstacle.X_FG.inverse() * there) > run.radius + reach) continue;
        RowCandidate best{{}, -1e9, 0.0, false};
        for (const double tau : {nearest, 0.0, 0.25, 0.5, 0.75, 1.0}) {
          const RowCandidate candidate = best_at(bound, model, scenery, {.goal = g, .run = i, .tau = tau, .shape = s});
          if (candidate.inside && !best.inside) best = candidate;
          if (!best.inside && candidate.cut > best.cut) best = candidate;
        }
        if (!std::holds_alternative<Sphere>(obstacle.shape) && best.cut > -reach) refine(best, bound, model, scenery);
        for (const Row& row : before) {
          if (row.goal != g || row.run != i || row.shape != s || !(row.multiplier > 0.0)) continue;
          if (std::abs(row.tau - best.row.tau) < 0.15) {
            best.row.multiplier += row.multiplier;
            continue;
          }
          RowCandidate kept = best_at(bound, model, scenery, {.goal = g, .run = i, .tau = row.tau, .shape = s});
          kept.row.multiplier = row.multiplier;
          result.push_back(kept);
        }
        // One that leaves the middle of the box alone by more than the box is wide cuts nothing off.
        if (best.inside || best.cut > -reach || best.row.multiplier > 0.0) result.push_back(best);
      }
    }
  }
  std::stable_sort(result.begin(), result.end(), [](const RowCandidate& a, const RowCandidate& b) {
    if (a.inside != b.inside) return a.inside;
    return a.cut > b.cut;
  });
}

}  // namespace modsearch::certify
