// Inverse kinematics beyond the exact case: full poses, tolerance regions, more joints, and what may not go wrong.

#include <gmock/gmock.h>

#include <cmath>
#include <kinematics/sample_arms.hpp>
#include <limits>
#include <modsearch/kinematics/inverse_kinematics.hpp>
#include <thread>

namespace modsearch {
namespace {

using sample::kPi;
using sample::seed_chain;
using testing::HasSubstr;
using testing::SizeIs;
using testing::ThrowsMessage;

constexpr double kTolerance = 1e-3;  // [m]
constexpr double kInfinity = std::numeric_limits<double>::infinity();

double uniform(std::mt19937& generator, double lower, double upper) {
  return std::uniform_real_distribution<double>{lower, upper}(generator);
}

bool within_limits(const Chain& chain, const Eigen::VectorXd& q) {
  return q.size() == chain.n_joints() && (q.array() >= chain.lower_limits().array()).all() &&
         (q.array() <= chain.upper_limits().array()).all();
}

// Revolute joints whose axes alternate by right angles, random lengths and limits of at least half a turn.
Chain alternating_arm(int n_joints, std::mt19937& generator) {
  ChainBuilder builder{0};
  for (int j = 0; j < n_joints; ++j) {
    const double middle = uniform(generator, -1, 1);
    const double half = uniform(generator, 0.5 * kPi, kPi);
    builder.joint({.name = "j", .lower = middle - half, .upper = middle + half});
    Eigen::Isometry3d X{Eigen::AngleAxisd{(j % 2 == 0 ? 0.5 : -0.5) * kPi, Eigen::Vector3d::UnitX()}};
    X.translation() << uniform(generator, -0.1, 0.1), uniform(generator, 0.1, 0.5), uniform(generator, 0.05, 0.4);
    builder.move(X);
  }
  return builder.build();
}

TEST(InverseKinematics, FindsPosesThatRandomSixJointArmsAreKnownToReach) {
  std::mt19937 generator{1};
  constexpr int kPoses = 1000;
  int found = 0;
  for (int i = 0; i < kPoses; ++i) {
    const Chain chain = alternating_arm(6, generator);
    const Arm arm = chain.at(Eigen::VectorXd{0});
    const Eigen::Isometry3d X_WE = arm.forward(sample::random_joints(chain, generator)).tip;
    const PoseRegion region = PoseRegion::with_default_tolerances(X_WE);
    const IkSolution solution = inverse_kinematics(arm, region, {.all = false});
    ASSERT_TRUE(within_limits(chain, solution.postures.front()));
    ASSERT_EQ(solution.reached, region.contains(arm.forward(solution.postures.front()).tip));
    ASSERT_EQ(solution.violation == 0.0, solution.reached);
    ASSERT_FALSE(solution.exact);
    if (solution.reached) ++found;
  }
  EXPECT_GE(found, 990);
}

TEST(InverseKinematics, FindsPositionsThatArmsOfFourToEightJointsAreKnownToReach) {
  std::mt19937 generator{2};
  for (int i = 0; i < 300; ++i) {
    const Chain chain = alternating_arm(4 + i % 5, generator);
    const Arm arm = chain.at(Eigen::VectorXd{0});
    const Eigen::Vector3d t = arm.forward(sample::random_joints(chain, generator)).tip.translation();
    const IkSolution solution = inverse_kinematics(arm, PoseRegion::ball(t, kTolerance), {.all = false});
    ASSERT_TRUE(solution.reached) << i;
    ASSERT_TRUE(within_limits(chain, solution.postures.front()));
    EXPECT_LE(solution.position_error, 1e-9);  // as close as possible, not merely within the tolerance
  }
}

TEST(InverseKinematics, StretchesALongArmTowardsATargetOutOfReach) {
  // Three hinges: the tip comes as near as the straight arm, whose length is the sum of all beyond the first hinge.
  const Chain chain = seed_chain("hhh");
  const Arm arm = chain.at((Eigen::VectorXd{6} << 0.5, 0.6, 0.7, 0.8, 0.9, 1.0).finished());
  const Eigen::Vector3d t{3.0, 4.0, 0.5};  // 5 m from the first hinge at (0, 0, 0.5)
  const IkSolution solution = inverse_kinematics(arm, PoseRegion::ball(t, kTolerance));
  EXPECT_FALSE(solution.reached);
  EXPECT_NEAR(solution.position_error, 5.0 - (0.6 + 0.7 + 0.8 + 0.9 + 1.0), 1e-9);
}

// Arms of one to three joints whose limits are a turn or less, and a pose they reach.
TEST(InverseKinematics, FindsEveryPoseThatArmsOfOneToThreeJointsAreKnownToReach) {
  std::mt19937 generator{3};
  for (int i = 0; i < 300; ++i) {
    const Chain chain = alternating_arm(1 + i % 3, generator);
    const Arm arm = chain.at(Eigen::VectorXd{0});
    const Eigen::Isometry3d X_WE = arm.forward(sample::random_joints(chain, generator)).tip;
    const IkSolution solution = inverse_kinematics(arm, PoseRegion::with_default_tolerances(X_WE), {.all = false});
    ASSERT_TRUE(solution.reached) << i;
  }
}

TEST(InverseKinematics, SatisfiesEveryProjection) {
  std::mt19937 generator{4};
  for (const Projection projection : {Projection::kX, Projection::kY, Projection::kZ, Projection::kRCyl,
                                      Projection::kPhiCyl, Projection::kRSph, Projection::kTheta, Projection::kPhiSph,
                                      Projection::kNx, Projection::kNy, Projection::kNz, Projection::kThetaR}) {
    for (const int n_joints : {2, 3, 5}) {
      for (int i = 0; i < 20; ++i) {
        const Chain chain = alternating_arm(n_joints, generator);
        const Arm arm = chain.at(Eigen::VectorXd{0});
        Eigen::Isometry3d X_WN{Eigen::Quaterniond{uniform(generator, -1, 1), uniform(generator, -1, 1),
                                                  uniform(generator, -1, 1), uniform(generator, -1, 1)}
                                   .normalized()};
        X_WN.translation() << uniform(generator, -1, 1), uniform(generator, -1, 1), uniform(generator, -1, 1);
        Tolerance tolerance{.projection = projection, .R_TN = X_WN.linear()};
        // An interval about the value at a posture: it can be met.
        const Eigen::Isometry3d X_WE = arm.forward(sample::random_joints(chain, generator)).tip;
        const double value =
            PoseRegion{X_WN, {{.projection = projection, .lower = 0.0, .upper = 0.0, .R_TN = X_WN.linear()}}}.values(
                X_WE)[0];
        tolerance.lower = value - 0.01;
        tolerance.upper = value + 0.002;
        const PoseRegion region{X_WN, {tolerance}};
        const IkSolution solution = inverse_kinematics(arm, region, {.all = false});
        ASSERT_TRUE(solution.reached) << name(projection) << ", " << n_joints << " joints, arm " << i;
        ASSERT_TRUE(region.contains(arm.forward(solution.postures.front()).tip));
        ASSERT_TRUE(within_limits(chain, solution.postures.front()));
      }
    }
  }
}

TEST(InverseKinematics, GivesDistinctPosturesThatAllLieInTheRegion) {
  std::mt19937 generator{5};
  const Chain chain = alternating_arm(6, generator);
  const Arm arm = chain.at(Eigen::VectorXd{0});
  const PoseRegion region =
      PoseRegion::with_default_tolerances(arm.forward(sample::random_joints(chain, generator)).tip);
  const IkSolution solution = inverse_kinematics(arm, region);
  ASSERT_TRUE(solution.reached);
  for (std::size_t i = 0; i < solution.postures.size(); ++i) {
    EXPECT_TRUE(region.contains(arm.forward(solution.postures[i]).tip));
    for (std::size_t k = 0; k < i; ++k) {
      EXPECT_GT((solution.postures[i] - solution.postures[k]).cwiseAbs().maxCoeff(), 1e-6);
    }
  }
}

TEST(InverseKinematics, EqualInputsGiveEqualBitsFromTwoThreadsToo) {
  std::mt19937 generator{6};
  for (const int n_joints : {2, 3, 6}) {
    const Chain chain = alternating_arm(n_joints, generator);
    const Arm arm = chain.at(Eigen::VectorXd{0});
    const Eigen::Isometry3d X_WE = arm.forward(sample::random_joints(chain, generator)).tip;
    for (const PoseRegion& region :
         {PoseRegion::with_default_tolerances(X_WE), PoseRegion::ball(X_WE.translation(), kTolerance)}) {
      IkSolution here, there;
      std::thread first{[&] { here = inverse_kinematics(arm, region); }};
      std::thread second{[&] { there = inverse_kinematics(arm, region); }};
      first.join();
      second.join();
      IkSolution again = inverse_kinematics(arm, region);
      for (const IkSolution* other : {&there, &again}) {
        EXPECT_EQ(here.position_error, other->position_error);
        EXPECT_EQ(here.forward, other->forward);
        EXPECT_EQ(here.postures, other->postures);
      }
    }
  }
}

TEST(InverseKinematics, AnArmWithoutJointsIsWhereItIs) {
  ChainBuilder builder{1};
  builder.move(AffinePose{Eigen::Matrix3d::Identity(), AffineVector{0.0, 0.0, AffineScalar::of_parameter(0)}});
  const Chain chain = builder.build();
  const Arm arm = chain.at(Eigen::VectorXd::Constant(1, 0.8));
  const IkSolution near = inverse_kinematics(arm, PoseRegion::ball({0, 0, 0.8005}, kTolerance));
  EXPECT_TRUE(near.reached && near.exact);
  EXPECT_THAT(near.postures, SizeIs(1));
  const IkSolution far = inverse_kinematics(arm, PoseRegion::ball({0, 0, 0.9}, kTolerance));
  EXPECT_FALSE(far.reached);
  EXPECT_NEAR(far.position_error, 0.1, 1e-15);
}

TEST(InverseKinematics, SurvivesDegenerateArmsAndTargets) {
  // Zero lengths, targets on the base, on axes and far away: the answer is finite, within limits and true.
  for (const char* types : {"l", "h", "r", "hh", "hr", "rh", "rr", "lhr", "hhh", "rrrr"}) {
    const Chain chain = seed_chain(types);
    for (const double length : {0.0, 0.055, 1.0}) {
      const Arm arm = chain.at(Eigen::VectorXd::Constant(chain.n_parameters(), length));
      for (const Eigen::Vector3d& t :
           {Eigen::Vector3d{0, 0, 0}, Eigen::Vector3d{0, 0, 1}, Eigen::Vector3d{1e6, 0, 0}, Eigen::Vector3d{1, 2, -1e6},
            Eigen::Vector3d{1e-9, 0, 0.5}, Eigen::Vector3d{0, 0, 2.0 * length}}) {
        for (const bool all : {false, true}) {
          const IkSolution solution = inverse_kinematics(arm, PoseRegion::ball(t, kTolerance), {.all = all});
          ASSERT_FALSE(solution.postures.empty());
          ASSERT_LE(solution.postures.size(), 2000u) << types << ' ' << length << ' ' << t.transpose();
          ASSERT_TRUE(std::isfinite(solution.position_error));
          for (const Eigen::VectorXd& q : solution.postures) {
            ASSERT_TRUE(within_limits(chain, q)) << types << ' ' << q.transpose();
            ASSERT_NEAR((arm.forward(q).tip.translation() - t).norm(), solution.position_error,
                        1.1e-9 + 1e-12 * t.norm());
          }
        }
      }
    }
  }
}

TEST(InverseKinematics, JointsWithoutRoomStayWhereTheyAre) {
  ChainBuilder builder{0};
  for (int j = 0; j < 3; ++j) {
    Eigen::Isometry3d X{Eigen::AngleAxisd{0.5 * kPi, Eigen::Vector3d::UnitX()}};
    X.translation() << 0.3, 0.1, 0.2;
    builder.joint({.name = "j", .lower = 0.2 * j, .upper = 0.2 * j}).move(X);
  }
  const Chain chain = builder.build();
  const IkSolution solution = inverse_kinematics(chain.at(Eigen::VectorXd{0}), PoseRegion::ball({1, 1, 1}, kTolerance));
  ASSERT_THAT(solution.postures, SizeIs(1));
  EXPECT_EQ(solution.postures.front(), Eigen::Vector3d(0.0, 0.2, 0.4));
}

TEST(InverseKinematics, UsesSlidesWithoutLimits) {
  ChainBuilder builder{0};
  const Joint slide{.name = "slide", .type = JointType::kPrismatic, .lower = -kInfinity, .upper = kInfinity};
  const Eigen::Isometry3d tilt{Eigen::AngleAxisd{0.5 * kPi, Eigen::Vector3d::UnitX()}};
  builder.joint(slide).move(tilt).joint(slide).move(tilt.inverse());
  const Chain chain = builder.build();  // slides along z, then along -y
  const IkSolution solution =
      inverse_kinematics(chain.at(Eigen::VectorXd{0}), PoseRegion::ball({0.5, 30.0, -40.0}, 1.0));
  EXPECT_TRUE(solution.reached);
  EXPECT_NEAR(solution.position_error, 0.5, 1e-12);
  EXPECT_NEAR(solution.postures.front()[0], -40.0, 1e-6);
  EXPECT_NEAR(solution.postures.front()[1], -30.0, 1e-6);
}

TEST(InverseKinematics, RefusesOptionsThatMakeNoSense) {
  const Chain chain = seed_chain("h");
  const Arm arm = chain.at(Eigen::Vector2d{1, 1});
  const PoseRegion region = PoseRegion::ball({1, 0, 1}, kTolerance);
  EXPECT_THAT([&] { (void)inverse_kinematics(arm, region, {.starts = 0}); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("starts 0")));
  EXPECT_THAT([&] { (void)inverse_kinematics(arm, region, {.tie = -1.0}); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("tie -1")));
}

}  // namespace
}  // namespace modsearch
