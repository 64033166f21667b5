#pragma once

#include <modsearch/kinematics/chain.hpp>

namespace modsearch {

/// Where to plan: finite, holds start and goal, lies within the limits.
struct JointBox {
  Eigen::VectorXd lower;
  Eigen::VectorXd upper;
};

/// The limits, and where these are wider, two turns either side of 0 or as far as start and goal; a metre beyond start
/// and goal for a joint that slides without limits.
[[nodiscard]] JointBox planning_box(const Chain& chain, const Eigen::VectorXd& q_start, const Eigen::VectorXd& q_goal);

}  // namespace modsearch
