#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <modsearch/kinematics/arm.hpp>
#include <numbers>

namespace modsearch {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Pair;
using testing::ThrowsMessage;

constexpr double kPi = std::numbers::pi;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

Joint joint(double lower, double upper, JointType type = JointType::kRevolute) {
  return {.name = "elbow", .type = type, .lower = lower, .upper = upper};
}

Chain chain_of(const std::vector<Joint>& joints) {
  ChainBuilder builder{0};
  for (const Joint& j : joints) builder.joint(j);
  return builder.build();
}

TEST(Chain, KeepsWhatTheBuilderWasGivenInOrder) {
  ChainBuilder builder{2};
  const Eigen::Isometry3d up{Eigen::Translation3d{0, 0, 0.3}};
  builder.move(up)
      .move(up)
      .joint(joint(-1, 2))
      .move(AffinePose{Eigen::Matrix3d::Identity(), {0.0, AffineScalar::of_parameter(1), 0.0}});
  const Chain chain = builder.build();
  EXPECT_EQ(chain.n_joints(), 1);
  EXPECT_EQ(chain.n_parameters(), 2);
  const Eigen::Vector2d x{5.0, 7.0};
  EXPECT_LE((chain.segment(0).at(x).translation() - Eigen::Vector3d(0, 0, 0.6)).norm(), 1e-15);  // both moves in one
  EXPECT_EQ(chain.segment(1).at(x).translation(), Eigen::Vector3d(0, 7, 0));
  EXPECT_EQ(chain.lower_limits(), Eigen::VectorXd::Constant(1, -1.0));
  EXPECT_EQ(chain.upper_limits(), Eigen::VectorXd::Constant(1, 2.0));
}

TEST(Chain, MassIsTheSumOverBodiesAndAffine) {
  ChainBuilder builder{2};
  builder.body("a", 0, AffineScalar::of_parameter(0, 2.0, 0.1), {});
  builder.body("b", 1, AffineScalar::of_parameter(1, 3.0), {});
  builder.body("c", 1, AffineScalar::of_parameter(0, 1.0), {});
  const Chain chain = builder.build();
  EXPECT_DOUBLE_EQ(chain.mass(Eigen::Vector2d{0.5, 0.7}), 0.1 + 3.0 * 0.5 + 3.0 * 0.7);
  EXPECT_EQ(chain.mass().gradient(2), Eigen::Vector2d(3.0, 3.0));
}

TEST(Chain, ClampsLimitedJointsAndTakesTurnsOffFullCircles) {
  const Chain chain = chain_of({joint(-1, 1), joint(-kPi, kPi), joint(-kInfinity, kInfinity, JointType::kContinuous),
                                joint(0.0, 0.5, JointType::kPrismatic)});
  const Eigen::Vector4d q{4.0, 4.0, 40.0, -3.0};
  const Eigen::VectorXd clamped = chain.clamped(q);
  EXPECT_EQ(clamped[0], 1.0);
  EXPECT_NEAR(clamped[1], 4.0 - 2.0 * kPi, 1e-15);
  EXPECT_EQ(clamped[2], 40.0);  // a continuous joint has no limits to move into
  EXPECT_EQ(clamped[3], 0.0);
}

TEST(Chain, LeavesWhatIsWithinTheLimitsAlone) {
  const Chain chain = chain_of({joint(-kPi, kPi), joint(-2.0 * kPi, 2.0 * kPi)});
  const Eigen::Vector2d q{kPi, -6.0};
  EXPECT_EQ(chain.clamped(q), q);
}

TEST(Chain, ClampsAFullCircleWithOneLimit) {
  const Chain chain = chain_of({joint(-kInfinity, 1.0), joint(-1.0, kInfinity)});
  const Eigen::VectorXd clamped = chain.clamped(Eigen::Vector2d{2.0, -2.0});
  EXPECT_NEAR(clamped[0], 2.0 - 2.0 * kPi, 1e-15);
  EXPECT_NEAR(clamped[1], -2.0 + 2.0 * kPi, 1e-15);
}

TEST(Joint, IsAFullCircleWhenEveryAngleIsWithinTheLimits) {
  EXPECT_TRUE(joint(-kPi, kPi).full_circle());
  EXPECT_TRUE(joint(-kInfinity, kInfinity, JointType::kContinuous).full_circle());
  EXPECT_FALSE(joint(-3.1, kPi).full_circle());
  EXPECT_FALSE(joint(-10, 10, JointType::kPrismatic).full_circle());
}

// Five bodies: two before a joint, two between the joints, one after; the joints connect 1-2 and 3-4.
Chain five_bodies(NeighbourRule rule) {
  ChainBuilder builder{0};
  builder.body("0", 0, 1.0, {});
  builder.body("1", 0, 1.0, {});
  builder.joint(joint(-1, 1), 1, 2);
  builder.body("2", 1, 1.0, {});
  builder.body("3", 1, 1.0, {});
  builder.joint(joint(-1, 1), 3, 4);
  builder.body("4", 2, 1.0, {});
  return builder.build(rule);
}

TEST(Chain, RigidRuleComparesAllBodiesWithAJointBetweenThem) {
  EXPECT_THAT(
      five_bodies(NeighbourRule::kRigid).self_pairs(),
      ElementsAre(Pair(0, 2), Pair(0, 3), Pair(0, 4), Pair(1, 2), Pair(1, 3), Pair(1, 4), Pair(2, 4), Pair(3, 4)));
}

TEST(Chain, ViaJointRuleSparesTheTwoBodiesThatAJointConnects) {
  EXPECT_THAT(five_bodies(NeighbourRule::kViaJoint).self_pairs(),
              ElementsAre(Pair(0, 2), Pair(0, 3), Pair(0, 4), Pair(1, 3), Pair(1, 4), Pair(2, 4)));
}

TEST(Chain, RigidViaJointRuleSparesWholeGroupsOneJointApart) {
  EXPECT_THAT(five_bodies(NeighbourRule::kRigidViaJoint).self_pairs(), ElementsAre(Pair(0, 4), Pair(1, 4)));
}

TEST(Chain, OneRigidPieceHasNothingToCompare) {
  ChainBuilder builder{0};
  builder.body("0", 0, 1.0, {});
  builder.body("1", 0, 1.0, {});
  EXPECT_THAT(builder.build(NeighbourRule::kRigid).self_pairs(), IsEmpty());
}

TEST(ChainBuilder, RefusesLimitsThatAreNoInterval) {
  ChainBuilder builder{0};
  EXPECT_THAT([&] { builder.joint(joint(1.0, -1.0)); }, ThrowsMessage<std::invalid_argument>(HasSubstr("'elbow'")));
  EXPECT_THAT([&] { builder.joint(joint(std::nan(""), 1.0)); }, ThrowsMessage<std::invalid_argument>(HasSubstr("nan")));
  EXPECT_THAT([] { ChainBuilder{-1}; }, ThrowsMessage<std::invalid_argument>(HasSubstr("-1")));
}

}  // namespace
}  // namespace modsearch
