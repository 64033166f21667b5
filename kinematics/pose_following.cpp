#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <modsearch/kinematics/local_ik_internal.hpp>
#include <modsearch/kinematics/pose_following.hpp>
#include <numbers>
#include <stdexcept>

namespace modsearch {
namespace {

// Angles of a joint that turns all round count up to whole turns: the one nearest to `before` within the limits.
void unwind(const Chain& chain, const Eigen::VectorXd& before, Eigen::VectorXd& q) {
  constexpr double kTurn = 2.0 * std::numbers::pi;
  for (int j = 0; j < chain.n_joints(); ++j) {
    const Joint& joint = chain.joints()[static_cast<std::size_t>(j)];
    if (!joint.full_circle()) continue;
    const double nearest = q[j] + kTurn * std::round((before[j] - q[j]) / kTurn);
    if (nearest >= joint.lower && nearest <= joint.upper) q[j] = nearest;
  }
}

}  // namespace

double travel_time(const Chain& chain, const Eigen::VectorXd& from, const Eigen::VectorXd& to) {
  double seconds = 0.0;
  for (int j = 0; j < chain.n_joints(); ++j) {
    const double limit = chain.joints()[static_cast<std::size_t>(j)].velocity;
    seconds = std::max(seconds, std::abs(to[j] - from[j]) / (std::isfinite(limit) ? limit : 1.0));
  }
  return seconds;
}

IkSolution nearby_posture(const Arm& arm, const PoseRegion& region, const Eigen::VectorXd& q, int iterations) {
  if (q.size() != arm.n_joints()) {
    throw std::invalid_argument(
        fmt::format("nearby_posture: {} joint values given, the arm has {}", q.size(), arm.n_joints()));
  }
  internal::Verdict verdict = internal::judge(arm, region, q);
  IkSolution result;
  result.forward = 1;
  if (!verdict.reached && arm.n_joints() > 0) {
    internal::LocalIk search{arm, region, iterations};
    verdict = search.refine(q);
    unwind(arm.chain(), q, verdict.q);
    result.iterations = search.iterations();
    result.forward += search.forward();
  }
  result.reached = verdict.reached;
  result.violation = verdict.violation;
  result.position_error = verdict.position_error;
  result.postures = {verdict.q};
  return result;
}

Following follow_poses(const Arm& arm, std::span<const PoseRegion> poses, std::span<const double> times,
                       const Eigen::VectorXd& q, const FollowOptions& options) {
  constexpr double kRounding = 1e-9;  // of a limit
  Following result;
  result.postures.resize(static_cast<Eigen::Index>(poses.size()), arm.n_joints());
  Eigen::VectorXd last = q;
  for (std::size_t k = 0; k < poses.size(); ++k) {
    if (result.end == FollowEnd::kDone) {
      const IkSolution next = nearby_posture(arm, poses[k], last, options.iterations);
      result.iterations += next.iterations;
      result.forward += next.forward;
      result.position_error = std::max(result.position_error, next.position_error);
      const Eigen::VectorXd& q_next = next.postures.front();
      if (!next.reached) {
        result.end = FollowEnd::kUnreachable;
      } else if (k > 0 && arm.n_joints() > 0 && (q_next - last).cwiseAbs().maxCoeff() > options.largest_step) {
        result.end = FollowEnd::kJump;
      } else {
        for (int j = 0; k > 0 && !times.empty() && j < arm.n_joints(); ++j) {
          const double limit = arm.chain().joints()[static_cast<std::size_t>(j)].velocity * (times[k] - times[k - 1]);
          if (std::abs(q_next[j] - last[j]) > limit * (1.0 + kRounding)) result.end = FollowEnd::kTooFast;
        }
      }
      if (result.end == FollowEnd::kDone) {
        last = q_next;
        ++result.n_followed;
      }
    }
    result.postures.row(static_cast<Eigen::Index>(k)) = last.transpose();
  }
  return result;
}

}  // namespace modsearch
