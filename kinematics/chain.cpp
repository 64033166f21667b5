#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <modsearch/kinematics/arm.hpp>
#include <numbers>
#include <stdexcept>

namespace modsearch {

bool Joint::full_circle() const { return rotates() && upper - lower >= 2.0 * std::numbers::pi * (1.0 - 1e-12); }

Eigen::VectorXd Chain::lower_limits() const {
  Eigen::VectorXd result(n_joints());
  for (int j = 0; j < n_joints(); ++j) result[j] = joints_[static_cast<std::size_t>(j)].lower;
  return result;
}

Eigen::VectorXd Chain::upper_limits() const {
  Eigen::VectorXd result(n_joints());
  for (int j = 0; j < n_joints(); ++j) result[j] = joints_[static_cast<std::size_t>(j)].upper;
  return result;
}

Eigen::VectorXd Chain::clamped(const Eigen::VectorXd& q) const {
  Eigen::VectorXd result = q;
  for (int j = 0; j < n_joints(); ++j) {
    const Joint& joint = joints_[static_cast<std::size_t>(j)];
    if (joint.full_circle() && (q[j] < joint.lower || q[j] > joint.upper)) {
      constexpr double kTurn = 2.0 * std::numbers::pi;
      result[j] = std::isfinite(joint.lower) ? q[j] - kTurn * std::floor((q[j] - joint.lower) / kTurn)
                                             : q[j] - kTurn * std::ceil((q[j] - joint.upper) / kTurn);
    }
    result[j] = std::clamp(result[j], joint.lower, joint.upper);
  }
  return result;
}

Arm Chain::at(const Eigen::VectorXd& x) const { return {*this, x}; }

ChainBuilder::ChainBuilder(int n_parameters) {
  if (n_parameters < 0) throw std::invalid_argument(fmt::format("ChainBuilder: {} parameters", n_parameters));
  chain_.n_parameters_ = n_parameters;
}

ChainBuilder& ChainBuilder::move(const ParametricPose& X) {
  X_FC_ = X_FC_ * X;
  return *this;
}

ChainBuilder& ChainBuilder::joint(Joint joint, int parent, int child) {
  if (!(joint.lower <= joint.upper)) {
    throw std::invalid_argument(
        fmt::format("joint '{}': limits [{}, {}] are not an interval", joint.name, joint.lower, joint.upper));
  }
  chain_.segments_.push_back(X_FC_);
  chain_.joints_.push_back(std::move(joint));
  X_FC_ = ParametricPose{};
  joined_.emplace_back(parent, child);
  return *this;
}

int ChainBuilder::body(std::string name, int module, AffineScalar mass, std::vector<BodyGeometry> geometries,
                       MassSpread spread) {
  for (BodyGeometry& geometry : geometries) geometry.X_FG = X_FC_ * geometry.X_FG;
  spread.X_FB = X_FC_ * spread.X_FB;
  chain_.mass_ = chain_.mass_ + mass;
  chain_.bodies_.push_back({std::move(name), module, chain_.n_joints(), std::move(mass), std::move(geometries),
                            std::move(spread)});
  return static_cast<int>(chain_.bodies_.size()) - 1;
}

Chain ChainBuilder::build(NeighbourRule rule) const {
  Chain chain = chain_;
  chain.segments_.push_back(X_FC_);

  const auto neighbours = [&](int a, int b) {
    const int joints_between = std::abs(chain.bodies_[static_cast<std::size_t>(a)].frame -
                                        chain.bodies_[static_cast<std::size_t>(b)].frame);
    if (joints_between == 0) return true;
    if (rule == NeighbourRule::kRigid || joints_between > 1) return false;
    if (rule == NeighbourRule::kRigidViaJoint) return true;
    return std::any_of(joined_.begin(), joined_.end(), [&](const auto& pair) {
      return (pair.first == a && pair.second == b) || (pair.first == b && pair.second == a);
    });
  };
  const int n_bodies = static_cast<int>(chain.bodies_.size());
  for (int a = 0; a < n_bodies; ++a) {
    for (int b = a + 1; b < n_bodies; ++b) {
      if (!neighbours(a, b)) chain.self_pairs_.emplace_back(a, b);
    }
  }
  return chain;
}

}  // namespace modsearch
