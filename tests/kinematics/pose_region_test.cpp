#include <gmock/gmock.h>

#include <array>
#include <cmath>
#include <limits>
#include <modsearch/kinematics/pose_region.hpp>
#include <numbers>
#include <random>

namespace modsearch {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

constexpr double kPi = std::numbers::pi;
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr std::array kProjections{Projection::kX,      Projection::kY,    Projection::kZ,     Projection::kRCyl,
                                  Projection::kPhiCyl, Projection::kRSph, Projection::kTheta, Projection::kPhiSph,
                                  Projection::kNx,     Projection::kNy,   Projection::kNz,    Projection::kThetaR};

double uniform(std::mt19937& generator, double lower, double upper) {
  return std::uniform_real_distribution<double>{lower, upper}(generator);
}

Eigen::Vector3d random_vector(std::mt19937& generator) {
  return {uniform(generator, -1, 1), uniform(generator, -1, 1), uniform(generator, -1, 1)};
}

Eigen::Isometry3d random_pose(std::mt19937& generator) {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.linear() = Eigen::Quaterniond{uniform(generator, -1, 1), uniform(generator, -1, 1), uniform(generator, -1, 1),
                                  uniform(generator, -1, 1)}
                   .normalized()
                   .toRotationMatrix();
  X.translation() = random_vector(generator);
  return X;
}

Eigen::Isometry3d pose(const Eigen::Vector3d& p, double angle = 0.0,
                       const Eigen::Vector3d& axis = Eigen::Vector3d::UnitZ()) {
  Eigen::Isometry3d X{Eigen::AngleAxisd{angle, axis.normalized()}};
  X.translation() = p;
  return X;
}

double value(Projection projection, const Eigen::Isometry3d& X_WE,
             const Eigen::Isometry3d& X_WN = Eigen::Isometry3d::Identity(),
             const Eigen::Matrix3d& R_TN = Eigen::Matrix3d::Identity()) {
  return PoseRegion{X_WN, {{.projection = projection, .lower = 0.0, .upper = 0.0, .R_TN = R_TN}}}.values(X_WE)[0];
}

TEST(PoseRegion, ProjectionsOfTheTranslation) {
  const Eigen::Isometry3d X = pose({3.0, 4.0, -12.0});
  EXPECT_DOUBLE_EQ(value(Projection::kX, X), 3.0);
  EXPECT_DOUBLE_EQ(value(Projection::kY, X), 4.0);
  EXPECT_DOUBLE_EQ(value(Projection::kZ, X), -12.0);
  EXPECT_DOUBLE_EQ(value(Projection::kRCyl, X), 5.0);
  EXPECT_DOUBLE_EQ(value(Projection::kPhiCyl, X), std::atan2(4.0, 3.0));
  EXPECT_DOUBLE_EQ(value(Projection::kRSph, X), 13.0);
  EXPECT_DOUBLE_EQ(value(Projection::kTheta, X), std::acos(-12.0 / 13.0));
  EXPECT_DOUBLE_EQ(value(Projection::kPhiSph, X), std::atan2(4.0, 3.0));
}

TEST(PoseRegion, ProjectionsOfTheRotationAreItsRotationVector) {
  const Eigen::Isometry3d X = pose({0, 0, 0}, 0.3, {0.6, 0.0, 0.8});
  EXPECT_NEAR(value(Projection::kNx, X), 0.18, 1e-15);
  EXPECT_NEAR(value(Projection::kNy, X), 0.0, 1e-15);
  EXPECT_NEAR(value(Projection::kNz, X), 0.24, 1e-15);
  EXPECT_NEAR(value(Projection::kThetaR, X), 0.3, 1e-15);
}

TEST(PoseRegion, MeasuresTheDeviationInTheNominalFrame) {
  // The nominal frame is turned by a right angle about z: what is +x in the world is -y in it.
  const Eigen::Isometry3d X_WN = pose({1.0, 2.0, 3.0}, kPi / 2);
  const Eigen::Isometry3d X_WE = pose({1.5, 2.0, 3.0}, kPi / 2 + 0.2);
  EXPECT_NEAR(value(Projection::kX, X_WE, X_WN), 0.0, 1e-15);
  EXPECT_NEAR(value(Projection::kY, X_WE, X_WN), -0.5, 1e-15);
  EXPECT_NEAR(value(Projection::kNz, X_WE, X_WN), 0.2, 1e-15);
}

TEST(PoseRegion, TurnsTheDeviationIntoTheFrameOfTheTolerance) {
  // With the nominal's own rotation as the tolerance's frame, the axes are those of the world.
  const Eigen::Isometry3d X_WN = pose({1.0, 2.0, 3.0}, kPi / 2);
  const Eigen::Isometry3d X_WE = pose({1.5, 2.0, 3.0}, kPi / 2) * pose({0, 0, 0}, 0.2, {0, -1, 0});
  EXPECT_NEAR(value(Projection::kX, X_WE, X_WN, X_WN.linear()), 0.5, 1e-15);
  EXPECT_NEAR(value(Projection::kNx, X_WE, X_WN, X_WN.linear()), 0.2, 1e-15);  // -y of the nominal is +x of the world
  EXPECT_NEAR(value(Projection::kThetaR, X_WE, X_WN, X_WN.linear()), 0.2, 1e-15);
}

TEST(PoseRegion, RotationVectorIsExactFromNoTurnToHalfATurn) {
  std::mt19937 generator{1};
  for (const double angle : {0.0, 1e-300, 1e-15, 1e-9, 1e-4, 1.0, kPi - 1e-4, kPi - 1e-9}) {
    const Eigen::Vector3d axis = random_vector(generator).normalized();
    const Eigen::Isometry3d X = pose({0, 0, 0}, angle, axis);
    // A rotation matrix keeps the angle to rounding, absolutely.
    EXPECT_NEAR(value(Projection::kNx, X), angle * axis.x(), 1e-14);
    EXPECT_NEAR(value(Projection::kThetaR, X), angle, 1e-14);
  }
  EXPECT_NEAR(value(Projection::kThetaR, pose({0, 0, 0}, kPi, {1, 1, 1})), kPi, 1e-14);
  EXPECT_NEAR(std::abs(value(Projection::kNx, pose({0, 0, 0}, kPi, {1, 0, 0}))), kPi, 1e-14);  // either sign is right
}

TEST(PoseRegion, JacobianOfEveryProjectionAgreesWithCentralDifferences) {
  std::mt19937 generator{2};
  constexpr double kStep = 1e-6;
  for (const Projection projection : kProjections) {
    for (int i = 0; i < 200; ++i) {
      const Eigen::Isometry3d X_WN = random_pose(generator);
      Eigen::Isometry3d X_WE = random_pose(generator);
      // Every fourth deviation small, where series take over.
      if (i % 4 == 0) X_WE = X_WN * pose(0.1 * random_vector(generator), 1e-2 * (i + 1), random_vector(generator));
      const PoseRegion region{
          X_WN, {{.projection = projection, .lower = 0, .upper = 0, .R_TN = random_pose(generator).linear()}}};
      // At half a turn the rotation vector jumps to its opposite.
      if ((X_WN.linear().transpose() * X_WE.linear()).trace() < -0.9999) continue;
      const auto J = region.jacobian(X_WE);
      for (int k = 0; k < 6; ++k) {
        const auto moved = [&](double step) {
          Eigen::Isometry3d X = X_WE;
          if (k < 3) {
            X.translation()[k] += step;
          } else {
            X.linear() = Eigen::AngleAxisd{step, Eigen::Vector3d::Unit(k - 3)} * X_WE.linear();
          }
          return region.values(X)[0];
        };
        double change = moved(kStep) - moved(-kStep);
        if (projection == Projection::kPhiCyl || projection == Projection::kPhiSph) {
          change = std::remainder(change, 2.0 * kPi);
        }
        // Curvatures grow like the inverse square of the distance from the origin; theirs is the error.
        const double p = (X_WE.translation() - X_WN.translation()).norm();
        ASSERT_NEAR(J(0, k), change / (2.0 * kStep), 1e-7 * (1.0 + J.norm() * J.norm() + 1.0 / p))
            << name(projection) << ' ' << i << ' ' << k;
      }
    }
  }
}

TEST(PoseRegion, JacobianIsFiniteEverywhere) {
  std::vector<Tolerance> all;
  for (const Projection projection : kProjections) all.push_back({.projection = projection, .lower = 0, .upper = 0});
  const PoseRegion region{Eigen::Isometry3d::Identity(), all};
  for (const Eigen::Vector3d& p :
       {Eigen::Vector3d{0, 0, 0}, Eigen::Vector3d{0, 0, 1}, Eigen::Vector3d{0, 0, -1}, Eigen::Vector3d{1e-200, 0, 0},
        Eigen::Vector3d{1e-13, 1e-13, 1}, Eigen::Vector3d{1e6, 1, 1}}) {
    for (const double angle : {0.0, 1e-200, 1e-9, kPi / 2, kPi - 1e-12, kPi}) {
      for (const Eigen::Vector3d& axis :
           {Eigen::Vector3d{1, 0, 0}, Eigen::Vector3d{0, 0, 1}, Eigen::Vector3d{1, -1, 1}}) {
        EXPECT_TRUE(region.jacobian(pose(p, angle, axis)).allFinite()) << p.transpose() << ' ' << angle;
        EXPECT_TRUE(region.values(pose(p, angle, axis)).allFinite());
      }
    }
  }
}

TEST(PoseRegion, DirectionsThatDoNotExistAreReplacedByAFixedOne) {
  const auto row = [](Projection projection, const Eigen::Isometry3d& X) {
    const PoseRegion region{Eigen::Isometry3d::Identity(), {{.projection = projection, .lower = 0, .upper = 0}}};
    return Eigen::Matrix<double, 6, 1>{region.jacobian(X).transpose()};
  };
  using Vector6 = Eigen::Matrix<double, 6, 1>;
  EXPECT_EQ(row(Projection::kRSph, pose({0, 0, 0})), Vector6(Vector6::Unit(0)));
  EXPECT_EQ(row(Projection::kRCyl, pose({0, 0, 2})), Vector6(Vector6::Unit(0)));
  EXPECT_EQ(row(Projection::kThetaR, pose({0, 0, 0})), Vector6(Vector6::Unit(3)));
  EXPECT_EQ(row(Projection::kTheta, pose({0, 0, 2})), Vector6(0.5 * Vector6::Unit(0)));  // tilting by dx / 2 m
  EXPECT_EQ(row(Projection::kPhiCyl, pose({0, 0, 2})), Vector6(Vector6::Zero()));
}

TEST(PoseRegion, IntervalsAreClosed) {
  const PoseRegion region{Eigen::Isometry3d::Identity(),
                          {{.projection = Projection::kX, .lower = -0.25, .upper = 0.5}}};
  EXPECT_TRUE(region.contains(pose({-0.25, 9, 9})));
  EXPECT_TRUE(region.contains(pose({0.5, 9, 9}, 2.0)));
  EXPECT_TRUE(region.contains(pose({0.5 + 0.9e-12, 0, 0})));
  EXPECT_FALSE(region.contains(pose({0.5 + 1e-11, 0, 0})));
  EXPECT_FALSE(region.contains(pose({-0.26, 0, 0})));
  EXPECT_FALSE(region.contains(pose({std::nan(""), 0, 0})));
}

TEST(PoseRegion, ViolationsTellHowFarOutsideAndOnWhichSide) {
  const PoseRegion region{Eigen::Isometry3d::Identity(),
                          {{.projection = Projection::kX, .lower = -0.25, .upper = 0.5},
                           {.projection = Projection::kY, .lower = -0.25, .upper = 0.5},
                           {.projection = Projection::kThetaR, .lower = 0.0, .upper = 0.1}}};
  EXPECT_EQ(region.violations(pose({0.75, -0.5, 0})), Eigen::Vector3d(0.25, -0.25, 0.0));
  EXPECT_EQ(region.violations(pose({0, 0, 0})), Eigen::Vector3d::Zero());
  EXPECT_NEAR(region.violations(pose({0, 0, 0}, 0.4))[2], 0.3, 1e-15);
  EXPECT_FALSE(region.contains(pose({0, 0, 0}, 0.4)));
}

TEST(PoseRegion, AzimuthsCountModuloAWholeTurn) {
  const PoseRegion behind{Eigen::Isometry3d::Identity(),
                          {{.projection = Projection::kPhiCyl, .lower = 0.75 * kPi, .upper = 1.25 * kPi}}};
  EXPECT_TRUE(behind.contains(pose({-1, 0.1, 0})));
  EXPECT_TRUE(behind.contains(pose({-1, -0.1, 0})));  // atan2 is below 0 here
  EXPECT_FALSE(behind.contains(pose({0, -1, 0})));
  EXPECT_NEAR(behind.violations(pose({0, -1, 0}))[0], 0.25 * kPi, 1e-15);  // the shorter way: from 1.25 pi up to 1.5 pi
  const PoseRegion anywhere{Eigen::Isometry3d::Identity(),
                            {{.projection = Projection::kPhiSph, .lower = -kInfinity, .upper = kInfinity}}};
  EXPECT_TRUE(anywhere.contains(pose({-1, -1, 0})));
}

TEST(PoseRegion, WithoutTolerancesHoldsEveryPose) {
  const PoseRegion region{pose({1, 2, 3}), {}};
  EXPECT_TRUE(region.contains(pose({-5, 0, 0}, 3.0)));
  EXPECT_EQ(region.values(pose({0, 0, 0})).size(), 0);
  EXPECT_FALSE(region.is_ball());
}

TEST(PoseRegion, KnowsABallAndWhatSpeaksOfOrientation) {
  const PoseRegion ball = PoseRegion::ball({1, 2, 3}, 0.5);
  EXPECT_TRUE(ball.is_ball());
  EXPECT_FALSE(ball.constrains_orientation());
  EXPECT_TRUE(ball.contains(pose({1, 2, 3.5}, 1.0)));
  EXPECT_FALSE(ball.contains(pose({1, 2, 3.6})));
  const PoseRegion shell{pose({0, 0, 0}), {{.projection = Projection::kRSph, .lower = 0.1, .upper = 0.2}}};
  EXPECT_FALSE(shell.is_ball());
  const PoseRegion full = PoseRegion::with_default_tolerances(pose({1, 2, 3}, 0.7));
  EXPECT_TRUE(full.constrains_orientation());
  EXPECT_FALSE(full.is_ball());
}

TEST(PoseRegion, DefaultTolerancesAreAMillimetreAndHalfADegree) {
  const Eigen::Isometry3d X_WN = pose({1, 2, 3}, 0.7, {1, 2, 2});
  const PoseRegion region = PoseRegion::with_default_tolerances(X_WN);
  EXPECT_TRUE(region.contains(X_WN * pose({9e-4, -9e-4, 9e-4}, 0.49 * kPi / 180.0, {1, 1, 0})));
  EXPECT_FALSE(region.contains(X_WN * pose({1.1e-3, 0, 0})));
  EXPECT_FALSE(region.contains(X_WN * pose({0, 0, 0}, 0.51 * kPi / 180.0)));
}

TEST(PoseRegion, RefusesIntervalsAndPosesThatAreNone) {
  EXPECT_THAT(
      [] {
        (PoseRegion{pose({0, 0, 0}), {{.projection = Projection::kNx, .lower = 1.0, .upper = -1.0}}});
      },
      ThrowsMessage<std::invalid_argument>(HasSubstr("N_x: [1, -1]")));
  EXPECT_THAT(
      [] {
        (PoseRegion{pose({0, 0, 0}), {{.projection = Projection::kX, .lower = std::nan(""), .upper = 0.0}}});
      },
      ThrowsMessage<std::invalid_argument>(HasSubstr("nan")));
  EXPECT_THAT(
      [] {
        (void)PoseRegion::ball({0, 0, 0}, -1.0);
      },
      ThrowsMessage<std::invalid_argument>(HasSubstr("r_sph")));
  EXPECT_THAT(
      [] {
        (void)PoseRegion::ball({0, kInfinity, 0}, 1.0);
      },
      ThrowsMessage<std::invalid_argument>(HasSubstr("not finite")));
}

TEST(Projection, HasTheNameItHasInFiles) {
  EXPECT_EQ(name(Projection::kRSph), "r_sph");
  EXPECT_EQ(name(Projection::kThetaR), "Theta_R");
  EXPECT_EQ(name(Projection::kNx), "N_x");
  EXPECT_EQ(name(Projection::kPhiCyl), "phi_cyl");
}

}  // namespace
}  // namespace modsearch
