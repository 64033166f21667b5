#include <gmock/gmock.h>

#include <modsearch/kinematics/affine.hpp>
#include <random>

namespace modsearch {
namespace {

using testing::SizeIs;

Eigen::VectorXd random_vector(Eigen::Index size, std::mt19937& generator) {
  Eigen::VectorXd result(size);
  for (double& entry : result) entry = std::uniform_real_distribution<double>{-1, 1}(generator);
  return result;
}

AffinePose random_pose(std::mt19937& generator) {
  AffineVector p{Eigen::Vector3d{random_vector(3, generator)}};
  p.terms.push_back({static_cast<int>(generator() % 3), random_vector(3, generator)});
  return {Eigen::Quaterniond{Eigen::Vector4d{random_vector(4, generator)}.normalized()}.toRotationMatrix(), p};
}

TEST(AffineScalar, IsItsOffsetPlusScaledParameters) {
  const AffineScalar a = AffineScalar::of_parameter(1, 2.0, 0.5) + AffineScalar::of_parameter(0, -3.0) + 1.0;
  const Eigen::Vector2d x{10.0, 100.0};
  EXPECT_DOUBLE_EQ(a.at(x), 1.5 - 30.0 + 200.0);
  EXPECT_EQ(a.gradient(2), Eigen::Vector2d(-3.0, 2.0));
}

TEST(AffineScalar, SumsKeepOneTermPerParameter) {
  const AffineScalar a = AffineScalar::of_parameter(0, 2.0) + AffineScalar::of_parameter(0, 3.0);
  EXPECT_THAT(a.terms, SizeIs(1));
  EXPECT_DOUBLE_EQ(a.at(Eigen::VectorXd::Ones(1)), 5.0);
}

TEST(AffineScalar, ExtremesOverABoxAreAtItsCorners) {
  const AffineScalar a = AffineScalar::of_parameter(0, 2.0) + AffineScalar::of_parameter(1, -1.0, 0.5);
  const Eigen::Vector2d lower{1, 3}, upper{2, 7};
  EXPECT_DOUBLE_EQ(a.least(lower, upper), 2.0 - 7.0 + 0.5);
  EXPECT_DOUBLE_EQ(a.greatest(lower, upper), 4.0 - 3.0 + 0.5);
}

TEST(AffineScalar, ShiftingRenumbersTheParameters) {
  EXPECT_DOUBLE_EQ(AffineScalar::of_parameter(0, 2.0).shifted(2).at(Eigen::Vector3d{0, 0, 4}), 8.0);
}

TEST(AffineVector, IsBuiltFromItsEntries) {
  const AffineVector v{AffineScalar::of_parameter(0), 2.0, AffineScalar::of_parameter(0, 0.5, 1.0)};
  EXPECT_EQ(v.at(Eigen::VectorXd::Constant(1, 4.0)), Eigen::Vector3d(4.0, 2.0, 3.0));
  EXPECT_THAT(v.terms, SizeIs(1));  // one per parameter
}

TEST(AffinePose, ProductInverseAndShiftAgreeWithIsometries) {
  std::mt19937 generator{1};
  for (int i = 0; i < 200; ++i) {
    const AffinePose A = random_pose(generator);
    const AffinePose B = random_pose(generator);
    const Eigen::VectorXd x = random_vector(4, generator);
    const Eigen::Isometry3d expected = A.at(x) * B.at(x);
    ASSERT_LE(((A * B).at(x).matrix() - expected.matrix()).cwiseAbs().maxCoeff(), 1e-15 * 8);
    ASSERT_LE((A.inverse().at(x).matrix() - A.at(x).inverse().matrix()).cwiseAbs().maxCoeff(), 1e-15 * 8);
    ASSERT_EQ(A.shifted(1).at(x).matrix(), A.at(x.tail(3)).matrix());
  }
}

TEST(AffineShape, TakesItsSizesFromTheParameters) {
  const Eigen::Vector2d x{0.3, 2.0};
  const AffineScalar r = AffineScalar::of_parameter(0);
  const AffineScalar l = AffineScalar::of_parameter(1, 0.5);
  using Kind = AffineShape::Kind;
  EXPECT_EQ(std::get<Sphere>(AffineShape{Kind::kSphere, {r}, nullptr}.at(x)).radius, 0.3);
  EXPECT_EQ(std::get<Box>(AffineShape{Kind::kBox, {r, l, 4.0}, nullptr}.at(x)).size, Eigen::Vector3d(0.3, 1.0, 4.0));
  EXPECT_EQ(std::get<Cylinder>(AffineShape{Kind::kCylinder, {r, l}, nullptr}.at(x)).length, 1.0);
  EXPECT_EQ(std::get<Capsule>(AffineShape{Kind::kCapsule, {r, l}, nullptr}.at(x)).radius, 0.3);
  const auto mesh = std::make_shared<const TriangleMesh>();
  EXPECT_EQ(std::get<Mesh>(AffineShape{Kind::kMesh, {}, mesh}.at(x)).triangles, mesh);
  EXPECT_EQ(std::get<Sphere>(AffineShape{Kind::kSphere, {r}, nullptr}.shifted(1).at(x)).radius, 2.0);
}

}  // namespace
}  // namespace modsearch
