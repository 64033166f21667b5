#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <modsearch/kinematics/shape.hpp>
#include <stdexcept>

namespace modsearch {
namespace {

using Eigen::Vector3d;
using testing::AllOf;
using testing::HasSubstr;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Right triangle in the plane z = 0 with legs 3 m and 4 m.
TriangleMesh right_triangle() {
  return {{Vector3d(0, 0, 0), Vector3d(3, 0, 0), Vector3d(0, 4, 0)}, {Eigen::Vector3i(0, 1, 2)}, "triangle.stl"};
}

Mesh mesh(const TriangleMesh& triangles) { return {std::make_shared<const TriangleMesh>(triangles)}; }

std::string complaint(const Shape& shape) {
  try {
    check(shape);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

TEST(BoundingRadius, ReachesTheFarthestPointOfEachShape) {
  EXPECT_DOUBLE_EQ(bounding_radius(Sphere{0.3}), 0.3);
  EXPECT_DOUBLE_EQ(bounding_radius(Box{Vector3d(2, 4, 4)}), 3.0);  // half diagonal: sqrt(1 + 4 + 4)
  EXPECT_DOUBLE_EQ(bounding_radius(Cylinder{3.0, 8.0}), 5.0);      // rim: sqrt(3^2 + 4^2)
  EXPECT_DOUBLE_EQ(bounding_radius(Capsule{0.25, 1.0}), 0.75);     // tip of a cap: 1 / 2 + 0.25
  EXPECT_DOUBLE_EQ(bounding_radius(mesh(right_triangle())), 4.0);  // vertex (0, 4, 0)
}

TEST(BoundingRadius, OfNothingIsZero) {
  EXPECT_EQ(bounding_radius(Sphere{}), 0.0);
  EXPECT_EQ(bounding_radius(Box{}), 0.0);
  EXPECT_EQ(bounding_radius(Cylinder{}), 0.0);
  EXPECT_EQ(bounding_radius(Capsule{}), 0.0);
}

TEST(BoundingRadius, RefusesAMeshWithoutTriangles) {
  EXPECT_THROW(static_cast<void>(bounding_radius(Mesh{})), std::invalid_argument);
}

TEST(Check, AcceptsEveryShapeOfFiniteSize) {
  EXPECT_EQ(complaint(Sphere{0.3}), "");
  EXPECT_EQ(complaint(Sphere{0.0}), "");
  EXPECT_EQ(complaint(Box{Vector3d(1, 0, 2)}), "");
  EXPECT_EQ(complaint(Cylinder{0.1, 0.0}), "");
  EXPECT_EQ(complaint(Capsule{0.0, 1.0}), "");
  EXPECT_EQ(complaint(mesh(right_triangle())), "");
}

TEST(Check, NamesTheNegativeSize) {
  EXPECT_THAT(complaint(Sphere{-0.1}), AllOf(HasSubstr("sphere"), HasSubstr("radius"), HasSubstr("-0.1")));
  EXPECT_THAT(complaint(Box{Vector3d(1, -2, 1)}), AllOf(HasSubstr("box"), HasSubstr("size y"), HasSubstr("-2")));
  EXPECT_THAT(complaint(Cylinder{-1, 1}), AllOf(HasSubstr("cylinder"), HasSubstr("radius")));
  EXPECT_THAT(complaint(Cylinder{1, -1}), AllOf(HasSubstr("cylinder"), HasSubstr("length")));
  EXPECT_THAT(complaint(Capsule{-1, 1}), AllOf(HasSubstr("capsule"), HasSubstr("radius")));
  EXPECT_THAT(complaint(Capsule{1, -1}), AllOf(HasSubstr("capsule"), HasSubstr("length")));
}

TEST(Check, RefusesSizesThatAreNoNumbers) {
  EXPECT_THAT(complaint(Sphere{kNan}), HasSubstr("nan"));
  EXPECT_THAT(complaint(Capsule{1, kInfinity}), HasSubstr("inf"));
  EXPECT_NE(complaint(Box{Vector3d(1, 1, kNan)}), "");
}

TEST(Check, RefusesAMeshWithoutTriangles) {
  EXPECT_THAT(complaint(Mesh{}), HasSubstr("null"));
  TriangleMesh points = right_triangle();
  points.triangles.clear();
  EXPECT_THAT(complaint(mesh(points)), AllOf(HasSubstr("triangle.stl"), HasSubstr("no triangle")));
}

TEST(Check, NamesTheTriangleWithAVertexThatDoesNotExist) {
  TriangleMesh wrong = right_triangle();
  wrong.triangles.emplace_back(0, 1, 3);
  EXPECT_THAT(complaint(mesh(wrong)), AllOf(HasSubstr("triangle 1"), HasSubstr("vertex 3"), HasSubstr("of 3")));
}

TEST(Check, NamesTheVertexThatIsNotFinite) {
  TriangleMesh wrong = right_triangle();
  wrong.vertices[2].x() = kNan;
  EXPECT_THAT(complaint(mesh(wrong)), AllOf(HasSubstr("triangle.stl"), HasSubstr("vertex 2")));
}

}  // namespace
}  // namespace modsearch
