#include <gtest/gtest.h>

#include <cmath>
#include <modsearch/kinematics/statics.hpp>
#include <numbers>
#include <random>

namespace modsearch {
namespace {

Eigen::Isometry3d at(double x, double y, double z) { return Eigen::Isometry3d{Eigen::Translation3d{x, y, z}}; }

// A horizontal rod of length x0, mass x0 per metre times 2, that turns about the world's -y axis at the origin: q lifts
// it.
Chain rod() {
  ChainBuilder builder{1};
  const auto length = AffineScalar::of_parameter(0);
  Eigen::Isometry3d lift = Eigen::Isometry3d::Identity();  // z of the joint along -y
  lift.linear() << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  builder.move(lift).joint({.name = "lift", .lower = -3.0, .upper = 3.0, .peak_torque = 10.0});
  builder.body("rod", 0, AffineScalar::of_parameter(0, 2.0), {},
               {.X_FB = {}, .r_com = AffineVector{AffineScalar::of_parameter(0, 0.5), 0.0, 0.0}});
  builder.move(AffinePose{Eigen::Matrix3d::Identity(), AffineVector{length, 0.0, 0.0}});
  return builder.build();
}

// Lever 0.5 L cos q times weight 2 L g, and L cos q times the payload's: tau = g cos q (L^2 + 3 L).
TEST(StaticTorques, HoldARodAndItsPayloadAsTheLeverSays) {
  const Chain chain = rod();
  const Arm arm = chain.at(Eigen::VectorXd::Constant(1, 1.2));
  for (const double q : {0.0, 0.4, -1.1}) {
    const Posture posture = arm.forward(Eigen::VectorXd::Constant(1, q));
    const Eigen::VectorXd torque = static_torques(arm, posture, {.payload = 3.0});
    const double expected = 9.81 * std::cos(q) * (1.2 * 1.2 + 3.0 * 1.2);
    EXPECT_NEAR(torque[0], expected, 1e-12);
    EXPECT_NEAR(torque_share(chain, torque), std::abs(expected) / 10.0, 1e-12);
  }
}

TEST(StaticTorques, AnswerAForceAndATorqueOnTheTip) {
  const Chain chain = rod();
  const Arm arm = chain.at(Eigen::VectorXd::Constant(1, 1.0));
  const Posture posture = arm.forward(Eigen::VectorXd::Zero(1));
  // 5 N downwards at 1 m, 2 N m about the joint's axis -y: both pull the rod down or lift it.
  const StaticLoad load{.gravity = Eigen::Vector3d::Zero(), .wrench = {{0.0, 0.0, -5.0}, {0.0, -2.0, 0.0}}};
  EXPECT_NEAR(static_torques(arm, posture, load)[0], 5.0 - 2.0, 1e-12);
}

// Revolute, sliding and twisted joints, bodies off their axes; parameters that are lengths, masses and an angle.
Chain crane() {
  ChainBuilder builder{4};
  const auto length = [](int p) {
    return AffinePose{Eigen::Matrix3d::Identity(), AffineVector{0.0, 0.0, AffineScalar::of_parameter(p)}};
  };
  const auto body = [&](const char* name, int p) {
    builder.body(name, p, AffineScalar::of_parameter(p, 2.0, 0.3), {},
                 {.X_FB = at(0.02, 0.0, 0.01), .r_com = AffineVector{0.03, -0.05, AffineScalar::of_parameter(p, 0.4)}});
  };
  builder.joint({.name = "turn", .lower = -3.0, .upper = 3.0});
  body("mast", 0);
  builder.move(length(0)).move(ParametricPose::turn(AffineScalar::of_parameter(3)));
  builder.move(Eigen::Isometry3d{Eigen::AngleAxisd{0.7, Eigen::Vector3d::UnitX()}});
  builder.joint({.name = "tilt", .lower = -3.0, .upper = 3.0});
  body("jib", 1);
  builder.move(length(1)).move(Eigen::Isometry3d{Eigen::AngleAxisd{-1.2, Eigen::Vector3d::UnitY()}});
  builder.joint({.name = "slide", .type = JointType::kPrismatic, .lower = 0.0, .upper = 1.0});
  builder.joint({.name = "roll", .lower = -3.0, .upper = 3.0});
  builder.move(Eigen::Isometry3d{Eigen::AngleAxisd{0.9, Eigen::Vector3d::UnitX()}});
  body("hook", 2);
  builder.move(length(2));
  return builder.build();
}

// Potential energy of all masses, straight from forward kinematics.
double energy(const Chain& chain, const Eigen::VectorXd& x, const Eigen::VectorXd& q, const StaticLoad& load) {
  const Arm arm = chain.at(x);
  const Posture posture = arm.forward(q);
  double sum = -load.payload * load.gravity.dot(posture.tip.translation());
  for (const Body& body : chain.bodies()) {
    const Eigen::Vector3d p_B = body.spread.r_com.at(x);
    const Eigen::Vector3d p_W = posture.frames[static_cast<std::size_t>(body.frame)] * (body.spread.X_FB.at(x) * p_B);
    sum -= body.mass.at(x) * load.gravity.dot(p_W);
  }
  return sum;
}

TEST(StaticTorques, AreTheSlopeOfThePotentialEnergyAndHaveTheDerivativesTheyClaim) {
  const Chain chain = crane();
  std::mt19937 random{7};
  std::uniform_real_distribution<double> uniform{-1.0, 1.0};
  for (int trial = 0; trial < 20; ++trial) {
    Eigen::VectorXd x(4), q(4);
    for (int i = 0; i < 4; ++i) {
      x[i] = 1.0 + 0.5 * uniform(random);
      q[i] = 1.5 * uniform(random);
    }
    StaticLoad load{.gravity = {0.5, -1.0, -9.0}, .payload = 1.7};
    const auto torques = [&](const Eigen::VectorXd& x_at, const Eigen::VectorXd& q_at) {
      const Arm arm = chain.at(x_at);
      return static_torques(arm, arm.forward(q_at), load);
    };
    constexpr double kStep = 1e-6;
    for (int j = 0; j < 4; ++j) {
      const Eigen::VectorXd e = kStep * Eigen::VectorXd::Unit(4, j);
      const double slope = (energy(chain, x, q + e, load) - energy(chain, x, q - e, load)) / (2.0 * kStep);
      EXPECT_NEAR(torques(x, q)[j], slope, 1e-6);
    }
    load.wrench = {{3.0, -4.0, 5.0}, {1.0, 2.0, -3.0}};
    const Arm arm = chain.at(x);
    const Eigen::MatrixXd J = static_torque_jacobian(arm, arm.forward(q), load);
    for (int i = 0; i < 4; ++i) {
      const Eigen::VectorXd e = kStep * Eigen::VectorXd::Unit(4, i);
      EXPECT_LT((J.col(i) - (torques(x + e, q) - torques(x - e, q)) / (2.0 * kStep)).cwiseAbs().maxCoeff(), 1e-6);
      EXPECT_LT((J.col(4 + i) - (torques(x, q + e) - torques(x, q - e)) / (2.0 * kStep)).cwiseAbs().maxCoeff(), 1e-6);
    }
  }
}

}  // namespace
}  // namespace modsearch
