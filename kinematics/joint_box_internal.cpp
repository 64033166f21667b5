#include <algorithm>
#include <cmath>
#include <modsearch/kinematics/joint_box_internal.hpp>
#include <numbers>

namespace modsearch {

JointBox planning_box(const Chain& chain, const Eigen::VectorXd& q_start, const Eigen::VectorXd& q_goal) {
  // Two turns show a joint that turns every posture and a way round either side; a joint that slides without limits
  // gets a metre either way.
  constexpr double kTurn = 2.0 * std::numbers::pi;
  constexpr double kSlide = 1.0;
  JointBox box{chain.lower_limits(), chain.upper_limits()};
  for (Eigen::Index j = 0; j < q_start.size(); ++j) {
    const bool rotates = chain.joints()[static_cast<std::size_t>(j)].rotates();
    const double least = std::min(q_start[j], q_goal[j]);
    const double greatest = std::max(q_start[j], q_goal[j]);
    if (rotates) {
      box.lower[j] = std::max(box.lower[j], std::min(-kTurn, least));
      box.upper[j] = std::min(box.upper[j], std::max(kTurn, greatest));
    }
    if (!std::isfinite(box.lower[j])) box.lower[j] = least - kSlide;
    if (!std::isfinite(box.upper[j])) box.upper[j] = greatest + kSlide;
  }
  return box;
}

}  // namespace modsearch
