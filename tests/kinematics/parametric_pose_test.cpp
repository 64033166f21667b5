#include <gtest/gtest.h>

#include <modsearch/kinematics/parametric_pose.hpp>
#include <random>

namespace modsearch {
namespace {

Eigen::VectorXd random_vector(Eigen::Index size, std::mt19937& generator) {
  Eigen::VectorXd result(size);
  for (double& entry : result) entry = std::uniform_real_distribution<double>{-1, 1}(generator);
  return result;
}

AffinePose random_affine(std::mt19937& generator) {
  AffineVector p{Eigen::Vector3d{random_vector(3, generator)}};
  p.terms.push_back({static_cast<int>(generator() % 3), random_vector(3, generator)});
  return {Eigen::Quaterniond{Eigen::Vector4d{random_vector(4, generator)}.normalized()}.toRotationMatrix(), p};
}

ParametricPose random_pose(std::mt19937& generator) {
  ParametricPose X{random_affine(generator)};
  for (int i = 0; i < static_cast<int>(generator() % 3); ++i) {
    const auto parameter = static_cast<int>(generator() % 3);
    X = X * ParametricPose::turn(AffineScalar::of_parameter(parameter, 1.5, 0.3)) * random_affine(generator);
  }
  return X;
}

TEST(ParametricPose, ProductInverseAndShiftAgreeWithIsometries) {
  std::mt19937 generator{1};
  for (int i = 0; i < 200; ++i) {
    const ParametricPose A = random_pose(generator);
    const ParametricPose B = random_pose(generator);
    const Eigen::VectorXd x = random_vector(4, generator);
    const Eigen::Isometry3d expected = A.at(x) * B.at(x);
    ASSERT_LE(((A * B).at(x).matrix() - expected.matrix()).cwiseAbs().maxCoeff(), 1e-14);
    ASSERT_LE((A.inverse().at(x).matrix() - A.at(x).inverse().matrix()).cwiseAbs().maxCoeff(), 1e-14);
    ASSERT_EQ(A.shifted(1).at(x).matrix(), A.at(x.tail(3)).matrix());
  }
}

TEST(ParametricPose, TurnsAboutItsZAxisByTheParameter) {
  const ParametricPose X = ParametricPose::turn(AffineScalar::of_parameter(0, 2.0, 0.1));
  const Eigen::Isometry3d at = X.at(Eigen::VectorXd::Constant(1, 0.2));
  EXPECT_LE((at.linear() - Eigen::AngleAxisd{0.5, Eigen::Vector3d::UnitZ()}.matrix()).norm(), 1e-15);
  EXPECT_FALSE(X.affine());
}

TEST(ParametricPose, IsAffineWhereTheAngleIsConstant) {
  EXPECT_TRUE(ParametricPose::turn(0.0).affine());
  const ParametricPose quarter = ParametricPose::turn(0.5);
  EXPECT_TRUE(quarter.affine());
  EXPECT_LE((quarter.head.rotation - Eigen::AngleAxisd{0.5, Eigen::Vector3d::UnitZ()}.matrix()).norm(), 1e-15);
}

TEST(ParametricPose, MovesWhatLiesBeyondAsCentralDifferencesSay) {
  std::mt19937 generator{2};
  for (int i = 0; i < 200; ++i) {
    const ParametricPose X = random_pose(generator);
    const Eigen::Isometry3d X_WF = random_pose(generator).at(random_vector(3, generator));
    const Eigen::VectorXd x = random_vector(3, generator);
    const Eigen::Vector3d p = random_vector(3, generator);
    Eigen::Matrix3d J = Eigen::Matrix3d::Zero();
    X.for_each_move(
        x, [&](const ParameterMove& move) { J.col(move.parameter) += move.velocity(X_WF, X_WF * X.at(x) * p); });
    for (int k = 0; k < 3; ++k) {
      constexpr double kStep = 1e-6;
      const Eigen::VectorXd h = kStep * Eigen::VectorXd::Unit(3, k);
      const Eigen::Vector3d expected = X_WF.linear() * (X.at(x + h) * p - X.at(x - h) * p) / (2.0 * kStep);
      ASSERT_LE((J.col(k) - expected).norm(), 1e-8);
    }
  }
}

}  // namespace
}  // namespace modsearch
