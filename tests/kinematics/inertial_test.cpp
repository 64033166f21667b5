#include <gtest/gtest.h>

#include <cmath>
#include <modsearch/kinematics/inertial.hpp>
#include <numbers>

// Expected numbers: closed forms from any table of solids, sums of parts, and integration by slices.

namespace modsearch {
namespace {

Eigen::Isometry3d at(double x, double y, double z) {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.translation() = Eigen::Vector3d{x, y, z};
  return X;
}

Eigen::Isometry3d turned(const Eigen::Isometry3d& X, double angle, const Eigen::Vector3d& axis) {
  return X * Eigen::Isometry3d{Eigen::AngleAxisd{angle, axis.normalized()}};
}

Inertial even(double mass, std::vector<PlacedShape> shapes) { return evenly_spread(mass, shapes).value(); }

void expect_equal(const Inertial& a, const Inertial& b, double tolerance = 1e-12) {
  EXPECT_NEAR(a.mass, b.mass, tolerance);
  EXPECT_LE((a.p_FC - b.p_FC).norm(), tolerance);
  EXPECT_LE((a.inertia - b.inertia).cwiseAbs().maxCoeff(), tolerance);
}

TEST(Inertial, OfABoxOfTwoKilogramsIsThatOfTheTable) {
  const Inertial box = even(2.0, {{Box{{0.1, 0.2, 0.3}}, at(1.0, 0.0, -1.0)}});
  EXPECT_LE((box.p_FC - Eigen::Vector3d{1.0, 0.0, -1.0}).norm(), 1e-15);
  const Eigen::Vector3d expected = 2.0 / 12.0 * Eigen::Vector3d{0.04 + 0.09, 0.01 + 0.09, 0.01 + 0.04};
  EXPECT_LE((box.inertia - Eigen::Matrix3d{expected.asDiagonal()}).cwiseAbs().maxCoeff(), 1e-15);
}

TEST(Inertial, OfACylinderAcrossIsThatOfTheTableTurned) {
  // Length 0.4 m along x: m r^2 / 2 about x, m (3 r^2 + h^2) / 12 about y and z.
  const Inertial cylinder =
      even(3.0, {{Cylinder{0.05, 0.4}, turned(at(0, 0, 0), std::numbers::pi / 2.0, Eigen::Vector3d::UnitY())}});
  const double across = 3.0 * (3.0 * 0.0025 + 0.16) / 12.0;
  EXPECT_NEAR(cylinder.inertia(0, 0), 3.0 * 0.0025 / 2.0, 1e-15);
  EXPECT_NEAR(cylinder.inertia(1, 1), across, 1e-15);
  EXPECT_NEAR(cylinder.inertia(2, 2), across, 1e-15);
}

TEST(Inertial, OfACapsuleIsTheSumOfItsSlices) {
  // Slices of thickness dz at height z: discs of radius r(z), m R^2 / 2 about z and m R^2 / 4 + m z^2 about x.
  const double r = 0.07;
  const double h = 0.3;
  const int n = 200'000;
  const double dz = (h + 2.0 * r) / n;
  double volume = 0.0;
  double about_z = 0.0;
  double about_x = 0.0;
  for (int i = 0; i < n; ++i) {
    const double z = -0.5 * h - r + (i + 0.5) * dz;
    const double beyond = std::max(0.0, std::abs(z) - 0.5 * h);
    const double squared = r * r - beyond * beyond;
    const double slice = std::numbers::pi * squared * dz;
    volume += slice;
    about_z += slice * squared / 2.0;
    about_x += slice * (squared / 4.0 + z * z);
  }
  const Inertial capsule = even(volume, {{Capsule{r, h}, at(0, 0, 0)}});  // density 1
  EXPECT_NEAR(capsule.inertia(2, 2) / about_z, 1.0, 1e-8);
  EXPECT_NEAR(capsule.inertia(0, 0) / about_x, 1.0, 1e-8);
}

TEST(Inertial, OfTwoHalvesOfABoxIsThatOfTheBox) {
  const Inertial lower = even(1.0, {{Box{{0.1, 0.2, 0.15}}, at(0, 0, -0.075)}});
  const Inertial upper = even(1.0, {{Box{{0.1, 0.2, 0.15}}, at(0, 0, 0.075)}});
  const Inertial whole = even(2.0, {{Box{{0.1, 0.2, 0.3}}, at(0, 0, 0)}});
  expect_equal(lower + upper, whole);
  expect_equal(even(2.0, {{Box{{0.1, 0.2, 0.15}}, at(0, 0, -0.075)}, {Box{{0.1, 0.2, 0.15}}, at(0, 0, 0.075)}}), whole);
}

TEST(Inertial, SeenFromElsewhereIsTheSameBody) {
  const Eigen::Isometry3d X = turned(at(0.3, -0.2, 0.5), 0.7, {1.0, 2.0, 3.0});
  const Shape shape = Cylinder{0.05, 0.3};
  expect_equal(X * even(2.0, {{shape, at(0.1, 0.2, 0.3)}}), even(2.0, {{shape, X * at(0.1, 0.2, 0.3)}}));
}

TriangleMesh box_mesh(const Eigen::Vector3d& size, const Eigen::Vector3d& centre, bool inside_out) {
  TriangleMesh mesh;
  for (int i = 0; i < 8; ++i) {
    const Eigen::Vector3d corner{(i & 1) != 0 ? 0.5 : -0.5, (i & 2) != 0 ? 0.5 : -0.5, (i & 4) != 0 ? 0.5 : -0.5};
    mesh.vertices.emplace_back(centre + corner.cwiseProduct(size));
  }
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  if (inside_out) {
    for (Eigen::Vector3i& triangle : mesh.triangles) std::swap(triangle[0], triangle[1]);
  }
  return mesh;
}

Inertial of_mesh(TriangleMesh mesh) {
  return even(2.0, {{Mesh{std::make_shared<const TriangleMesh>(std::move(mesh))}, at(0, 0, 0)}});
}

TEST(Inertial, OfAClosedMeshIsThatOfWhatItEncloses) {
  const Eigen::Vector3d size{0.1, 0.2, 0.3};
  const Inertial box = even(2.0, {{Box{size}, at(0.4, 0.0, 0.1)}});
  expect_equal(of_mesh(box_mesh(size, {0.4, 0.0, 0.1}, false)), box);
  expect_equal(of_mesh(box_mesh(size, {0.4, 0.0, 0.1}, true)), box);
}

TEST(Inertial, OfAnOpenMeshIsThatOfItsBoundingBox) {
  const Eigen::Vector3d size{0.1, 0.2, 0.3};
  TriangleMesh sheet = box_mesh(size, {0.0, 0.0, 0.0}, false);
  sheet.triangles.resize(1);  // one triangle encloses nothing
  expect_equal(of_mesh(sheet), even(2.0, {{Box{size}, at(0, 0, 0)}}));
}

TEST(Inertial, OfWhatHasNoVolumeIsNone) {
  EXPECT_FALSE(evenly_spread(1.0, {}).has_value());
  const std::vector<PlacedShape> flat{{Box{{0.1, 0.1, 0.0}}, at(0, 0, 0)}};
  EXPECT_FALSE(evenly_spread(1.0, flat).has_value());
}

TEST(Inertial, IsPhysicalWhereARigidBodyCanBeLikeThat) {
  const auto body = [](double mass, const Eigen::Vector3d& moments) {
    return Inertial{mass, Eigen::Vector3d::Zero(), moments.asDiagonal()};
  };
  EXPECT_TRUE(physical(body(1.0, {1.0, 1.0, 1.9})));
  EXPECT_TRUE(physical(body(1.0, {1.0, 1.0, 2.0})));   // a thin plate
  EXPECT_FALSE(physical(body(1.0, {1.0, 1.0, 2.1})));  // no mass lies like that
  EXPECT_FALSE(physical(body(1.0, {1.0, 1.0, 0.0})));
  EXPECT_FALSE(physical(body(0.0, {1.0, 1.0, 1.0})));
  Inertial skew = body(1.0, {1.0, 1.0, 1.0});
  skew.inertia(0, 1) = 0.1;
  EXPECT_FALSE(physical(skew));
}

TEST(Inertial, OfABodyFollowsItsLengthAndItsTwist) {
  // A tube along z as long as parameter 0, of 2 kg/m, its frame twisted by parameter 1, centre of mass at its middle.
  ChainBuilder builder{2};
  builder.move(at(0.0, 0.0, 1.0)).move(ParametricPose::turn(AffineScalar::of_parameter(1)));
  const AffineVector middle{0.3, 0.0, AffineScalar::of_parameter(0, 0.5)};
  const BodyGeometry tube{{AffineShape::Kind::kCylinder, {0.05, AffineScalar::of_parameter(0)}, nullptr},
                          AffinePose{Eigen::Matrix3d::Identity(), middle}};
  builder.body("tube", 0, AffineScalar::of_parameter(0, 2.0), {tube}, {ParametricPose{}, middle});
  const Chain chain = builder.build();
  const Inertial body = inertial(chain.bodies()[0], Eigen::Vector2d{0.8, 0.5});
  EXPECT_NEAR(body.mass, 1.6, 1e-15);
  EXPECT_LE((body.p_FC - Eigen::Vector3d{0.3 * std::cos(0.5), 0.3 * std::sin(0.5), 1.4}).norm(), 1e-12);
  EXPECT_NEAR(body.inertia(0, 0), 1.6 * (3.0 * 0.0025 + 0.64) / 12.0, 1e-12);
}

TEST(Inertial, GivenInTheBodysFrameTurnsWithIt) {
  ChainBuilder builder{0};
  builder.move(turned(at(0, 0, 0), std::numbers::pi / 2.0, Eigen::Vector3d::UnitZ()));
  MassSpread spread{ParametricPose{}, AffineVector{}, false};
  spread.inertia = Eigen::Vector3d{1.0, 2.0, 2.5}.asDiagonal();
  builder.body("block", 0, 3.0, {}, spread);
  const Chain chain = builder.build();
  const Inertial body = inertial(chain.bodies()[0], Eigen::VectorXd(0));
  EXPECT_LE((body.inertia.diagonal() - Eigen::Vector3d{2.0, 1.0, 2.5}).norm(), 1e-12);
}

TEST(Inertial, IsMadePhysicalFromShapesOrFromABallOfSteel) {
  const Eigen::VectorXd none(0);
  const MassSpread nothing{ParametricPose{}, AffineVector{}, false};  // a mass whose inertia the library leaves out
  ChainBuilder builder{0};
  builder.body("box", 0, 2.0, {{{AffineShape::Kind::kBox, {0.1, 0.2, 0.3}, nullptr}, AffinePose{}}}, nothing);
  builder.body("point", 0, 2.0, {}, nothing);
  builder.body("air", 0, 0.0, {}, nothing);
  const Chain chain = builder.build();
  expect_equal(physical_inertial(chain.bodies()[0], none), even(2.0, {{Box{{0.1, 0.2, 0.3}}, at(0, 0, 0)}}));
  EXPECT_FALSE(physical(inertial(chain.bodies()[1], none)));
  EXPECT_TRUE(physical(physical_inertial(chain.bodies()[1], none)));
  EXPECT_EQ(physical_inertial(chain.bodies()[2], none).mass, 0.0);
}

}  // namespace
}  // namespace modsearch
