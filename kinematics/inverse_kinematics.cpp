#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <modsearch/kinematics/exact_reach_internal.hpp>
#include <modsearch/kinematics/inverse_kinematics.hpp>
#include <modsearch/kinematics/local_ik_internal.hpp>
#include <numbers>
#include <stdexcept>

namespace modsearch {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;

// The same posture up to whole turns of full-circle joints, as far as clearance can tell.
bool same_posture(const Chain& chain, const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
  constexpr double kSame = 1e-5;  // [rad] or [m]
  for (int j = 0; j < chain.n_joints(); ++j) {
    const double apart = a[j] - b[j];
    const bool turns = chain.joints()[static_cast<std::size_t>(j)].full_circle();
    if (std::abs(turns ? std::remainder(apart, kTurn) : apart) > kSame) return false;
  }
  return true;
}

Eigen::VectorXd posture_of(const Chain& chain, const internal::ReachJoints& q) {
  Eigen::VectorXd result(chain.n_joints());
  for (int j = 0; j < chain.n_joints(); ++j) {
    const Joint& joint = chain.joints()[static_cast<std::size_t>(j)];
    result[j] = std::clamp(q[j], joint.lower, joint.upper);
  }
  return result;
}

// A ball and at most three joints.
IkSolution exact_solution(const Arm& arm, const PoseRegion& region, const IkOptions& options) {
  internal::ReachWork work;
  const internal::ReachProblem problem = internal::reach_problem(arm, region.nominal().translation());
  IkSolution solution;
  solution.exact = true;
  if (options.all) {
    const internal::FamilyOptions families{options.tie, options.family_points, options.shared_turns};
    for (const internal::Nearest& item : internal::all_nearest(problem, families, work)) {
      solution.postures.push_back(posture_of(arm.chain(), item.q));
    }
  } else {
    solution.postures.push_back(posture_of(arm.chain(), internal::nearest(problem, work).q));
  }
  const internal::Verdict verdict = internal::judge(arm, region, solution.postures.front());
  solution.reached = verdict.reached;
  solution.violation = verdict.violation;
  solution.position_error = verdict.position_error;
  // Where the tolerance ends between the best and an equally close one, only what lies inside may speak for the arm.
  if (verdict.reached && verdict.position_error + 2.0 * options.tie > region.tolerances().front().upper) {
    std::erase_if(solution.postures,
                  [&](const Eigen::VectorXd& q) { return !internal::judge(arm, region, q).reached; });
  }
  solution.iterations = work.iterations;
  solution.forward = work.forward;
  return solution;
}

// Searches from many starts; keeps the best ends.
class BestOf {
 public:
  BestOf(const Arm& arm, const PoseRegion& region, const IkOptions& options)
      : arm_{arm}, ball_{region.is_ball()}, options_{options} {}

  void add(internal::Verdict verdict) {
    if (found_.empty() || better(verdict, found_.front())) {
      // The first stays the best one.
      found_.insert(found_.begin(), std::move(verdict));
    } else {
      found_.push_back(std::move(verdict));
    }
  }
  [[nodiscard]] bool enough() const { return !options_.all && !found_.empty() && found_.front().reached; }

  [[nodiscard]] IkSolution solution() const {
    const internal::Verdict& best = found_.front();
    IkSolution result;
    result.reached = best.reached;
    result.violation = best.violation;
    result.position_error = best.position_error;
    for (const internal::Verdict& verdict : found_) {
      if (!result.postures.empty() && !options_.all) break;
      if (verdict.reached != best.reached || loss(verdict) > loss(best) + options_.tie) continue;
      const bool known = std::any_of(result.postures.begin(), result.postures.end(), [&](const Eigen::VectorXd& q) {
        return same_posture(arm_.chain(), q, verdict.q);
      });
      if (!known) result.postures.push_back(verdict.q);
    }
    return result;
  }

 private:
  [[nodiscard]] double loss(const internal::Verdict& verdict) const {
    return ball_ ? verdict.position_error : verdict.violation;
  }
  [[nodiscard]] bool better(const internal::Verdict& a, const internal::Verdict& b) const {
    if (a.reached != b.reached) return a.reached;
    return loss(a) < loss(b);
  }

  const Arm& arm_;
  bool ball_;
  const IkOptions& options_;
  std::vector<internal::Verdict> found_;
};

IkSolution local_solution(const Arm& arm, const PoseRegion& region, const IkOptions& options) {
  internal::LocalIk search{arm, region, options.iterations};
  BestOf best{arm, region, options};
  for (int i = 0; i < options.starts && !best.enough(); ++i) best.add(search.refine(search.start(i)));
  if (arm.n_joints() <= internal::kMaxReachJoints && !best.enough()) {
    for (const Eigen::VectorXd& q : search.scan()) {
      best.add(search.refine(q));
      if (best.enough()) break;
    }
  }
  IkSolution solution = best.solution();
  solution.iterations = search.iterations();
  solution.forward = search.forward();
  return solution;
}

}  // namespace

IkSolution inverse_kinematics(const Arm& arm, const PoseRegion& region, const IkOptions& options) {
  constexpr double kWidestTie = 1e-8;
  if (options.starts < 1 || options.iterations < 1 || options.family_points < 1) {
    throw std::invalid_argument(
        fmt::format("inverse_kinematics: starts {}, iterations {}, family points {} must be at least 1", options.starts,
                    options.iterations, options.family_points));
  }
  if (!(options.tie >= 0.0 && options.tie <= kWidestTie)) {
    throw std::invalid_argument(fmt::format("inverse_kinematics: tie {} is not in [0, {}]", options.tie, kWidestTie));
  }
  if (arm.n_joints() == 0) {
    const internal::Verdict verdict = internal::judge(arm, region, Eigen::VectorXd{0});
    return {.reached = verdict.reached,
            .exact = true,
            .position_error = verdict.position_error,
            .violation = verdict.violation,
            .postures = {verdict.q},
            .forward = 1};
  }
  if (region.is_ball() && arm.n_joints() <= internal::kMaxReachJoints) return exact_solution(arm, region, options);
  return local_solution(arm, region, options);
}

}  // namespace modsearch
