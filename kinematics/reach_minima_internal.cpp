#include <algorithm>
#include <cmath>
#include <limits>
#include <modsearch/kinematics/reach_minima_internal.hpp>
#include <modsearch/kinematics/reach_quartic_internal.hpp>
#include <modsearch/kinematics/reach_search_internal.hpp>
#include <numbers>

namespace modsearch::internal {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;
// Postures closer than this in every joint are the same [rad] or [m]: below what clearance can tell apart.
constexpr double kSame = 1e-5;
// Flatness below which a minimum may belong to a family: far above rounding. At distance zero the flatness is the
// square of the ratio of the Jacobian's singular values, so this is 1e-4 of singular. A false alarm costs time only.
constexpr double kFlat = 1e-8;
// Flatness below which a second minimum may lie within a step of the grid (a fold of the arm's reach).
constexpr double kFold = 0.1;

bool same(const ReachProblem& problem, const ReachJoints& a, const ReachJoints& b) {
  for (int j = 0; j < problem.n; ++j) {
    const double apart = a[j] - b[j];
    const bool turns = problem.links[static_cast<std::size_t>(j)].full_circle;
    if (std::abs(turns ? std::remainder(apart, kTurn) : apart) > kSame) return false;
  }
  return true;
}

// Half the distance that the tip can travel between neighbouring points of the grid, joint 0 left out: no minimum is
// lower than a grid minimum that leads to it by more than this.
double grid_uncertainty(const ReachProblem& problem) {
  double result = 0.0;
  double lever = 0.0;
  for (int j = problem.n - 1; j >= 1; --j) {
    const ReachLink& link = problem.links[static_cast<std::size_t>(j)];
    lever += link.p.norm();
    result += 0.5 * grid_step(problem, j) * (link.rotates ? lever : 1.0);
    if (!link.rotates) lever += std::max(std::abs(link.lower), std::abs(link.upper));
  }
  return result;
}

class Search {
 public:
  Search(const ReachProblem& problem, bool all, ReachWork& work) : problem_{problem}, all_{all}, work_{work} {}

  std::vector<Minimum> run() {
    if (problem_.n == 3) from_roots();
    // The roots are all postures at distance zero.
    if (!touches()) from_grid();
    if (!touches()) from_limits();
    std::stable_sort(minima_.begin(), minima_.end(),
                     [](const Minimum& a, const Minimum& b) { return a.nearest.distance < b.nearest.distance; });
    return std::move(minima_);
  }

 private:
  static constexpr int kDepth = 3;
  static constexpr double kTied = 1e-8;  // [m]; wider than any tie that is asked for

  [[nodiscard]] bool touches() const { return best_ < 1e-12 * (1.0 + problem_.target.norm()); }
  [[nodiscard]] bool finished() const { return !all_ && touches(); }

  void from_roots() {
    for (const Nearest& start : reaching_postures(problem_)) {
      if (finished()) return;
      descend_from(with_best_first_joint(problem_, start.q), kDepth);
    }
  }

  void from_grid() {
    NearestList starts = problem_.n == 2 ? grid_minima_2(problem_) : grid_minima_3(problem_);
    std::sort(starts.begin(), starts.end(), [](const Nearest& a, const Nearest& b) { return a.distance < b.distance; });
    const double uncertainty = grid_uncertainty(problem_);
    for (const Nearest& start : starts) {
      if (finished() || start.distance > best_ + uncertainty) return;
      descend_from(start.q, 0);
    }
  }

  // Minima on the faces of the box of limits are minima of arms with a joint fewer.
  void from_limits() {
    for (int k = 0; k < problem_.n; ++k) {
      const ReachLink& link = problem_.links[static_cast<std::size_t>(k)];
      if (link.full_circle) continue;
      for (const double value : {link.lower, link.upper}) {
        const ReachProblem face = with_joint_fixed(problem_, k, value);
        const auto try_one = [&](const Nearest& item) {
          if (item.distance <= best_ + kTied) descend_from(with_joint_inserted(item.q, k, value), kDepth);
        };
        if (face.n == 1) {
          for (const Nearest& item : one_joint_minima(face)) try_one(item);
        } else {
          for (const Minimum& minimum : minima(face, all_, work_)) try_one(minimum.nearest);
        }
      }
    }
  }

  void descend_from(const ReachJoints& start, int depth) {
    constexpr std::size_t kEnough = 64;
    const Descent descent = descend(problem_, start, work_);
    const bool known = std::any_of(minima_.begin(), minima_.end(),
                                   [&](const Minimum& m) { return same(problem_, m.nearest.q, descent.end.q); });
    if (known || minima_.size() >= kEnough) return;
    const bool flat = std::abs(descent.flatness) < kFlat;
    minima_.push_back({descent.end, flat, descent.flat_direction});
    best_ = std::min(best_, descent.end.distance);
    if (depth == kDepth || descent.flatness >= kFold || flat) return;
    // Shallow: look on either side.
    for (const double side : {1.0, -1.0}) {
      if (finished()) return;
      descend_from(descent.end.q + side * grid_step(problem_, problem_.n - 1) * descent.flat_direction, depth + 1);
    }
  }

  const ReachProblem& problem_;
  bool all_;
  ReachWork& work_;
  double best_ = std::numeric_limits<double>::infinity();
  std::vector<Minimum> minima_;
};

}  // namespace

NearestList one_joint_minima(const ReachProblem& problem) {
  const ReachLink& link = problem.links[0];
  const Eigen::Vector3d& t = problem.target;
  NearestList result;
  const auto add = [&](double q) {
    const Eigen::Vector3d tip = link.rotates
                                    ? Eigen::Vector3d{std::cos(q) * link.p.x() - std::sin(q) * link.p.y(),
                                                      std::sin(q) * link.p.x() + std::cos(q) * link.p.y(), link.p.z()}
                                    : Eigen::Vector3d{link.p.x(), link.p.y(), link.p.z() + q};
    result.add({{q, 0.0, 0.0}, (tip - t).norm()});
  };
  if (!link.rotates) {
    add(std::clamp(t.z() - link.p.z(), link.lower, link.upper));
    return result;
  }
  double q = std::atan2(t.y() * link.p.x() - t.x() * link.p.y(), t.x() * link.p.x() + t.y() * link.p.y());
  q -= kTurn * std::floor((q - link.lower) / kTurn);
  if (q <= link.upper) {
    add(q);
  } else {
    add(link.lower);
    if (link.upper > link.lower) add(link.upper);
    if (result.size() == 2 && result[1].distance < result[0].distance) std::swap(result[0], result[1]);
  }
  return result;
}

std::vector<Minimum> minima(const ReachProblem& problem, bool all, ReachWork& work) {
  return Search{problem, all, work}.run();
}

}  // namespace modsearch::internal
