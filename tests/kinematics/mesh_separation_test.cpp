#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <memory>
#include <modsearch/kinematics/separation.hpp>
#include <thread>
#include <vector>

#include "kinematics/separation_checks.hpp"

namespace modsearch {
namespace {

using namespace separation_checks;

/// A closed bumpy ball of about `radius` from rings of triangles.
Mesh bumpy_ball(int n_rings, double radius) {
  auto mesh = std::make_shared<TriangleMesh>();
  const int n_sides = 2 * n_rings;
  for (int i = 0; i <= n_rings; ++i) {
    for (int j = 0; j < n_sides; ++j) {
      const double polar = kPi * (i + 0.01) / (n_rings + 0.02);
      const double around = kPi * j / n_rings;
      const double r = radius * (1.0 + 0.15 * std::sin(3 * around) * std::sin(4 * polar));
      mesh->vertices.emplace_back(r * std::sin(polar) * std::cos(around), r * std::sin(polar) * std::sin(around),
                                  r * std::cos(polar));
    }
  }
  for (int i = 0; i < n_rings; ++i) {
    for (int j = 0; j < n_sides; ++j) {
      const int a = i * n_sides + j;
      const int b = i * n_sides + (j + 1) % n_sides;
      mesh->triangles.emplace_back(a, b, a + n_sides);
      mesh->triangles.emplace_back(b, b + n_sides, a + n_sides);
    }
  }
  return {mesh};
}

Mesh square(double half) {
  auto mesh = std::make_shared<TriangleMesh>();
  mesh->vertices = {{-half, -half, 0}, {half, -half, 0}, {half, half, 0}, {-half, half, 0}};
  mesh->triangles = {{0, 1, 2}, {0, 2, 3}};
  return {mesh};
}

TEST(MeshSeparation, OfShapesAboveASquareIsTheirLowestPoint) {
  const Mesh floor = square(2.0);
  EXPECT_NEAR(signed_distance(Sphere{0.5}, at(0.3, 0.2, 2), floor, at(0, 0, 0)), 1.5, 1e-12);
  EXPECT_NEAR(signed_distance(Box{Vector3d(1, 1, 1)}, at(0.3, 0.2, 2), floor, at(0, 0, 0)), 1.5, 1e-12);
  EXPECT_NEAR(signed_distance(Cylinder{0.5, 1}, at(0.3, 0.2, 2), floor, at(0, 0, 0)), 1.5, 1e-12);
  EXPECT_NEAR(signed_distance(Capsule{0.5, 1}, at(0.3, 0.2, 2), floor, at(0, 0, 0)), 1.0, 1e-12);
  EXPECT_NEAR(signed_distance(square(1.0), at(0.3, 0.2, 2), floor, at(0, 0, 0)), 2.0, 1e-12);
}

TEST(MeshSeparation, InsideIsTheDepthOfTheDeepestPointOfTheSurface) {
  const Mesh floor = square(2.0);
  EXPECT_NEAR(signed_distance(Sphere{0.5}, at(0, 0.1, 0.4), floor, at(0, 0, 0)), -0.1, 1e-9);
  EXPECT_NEAR(signed_distance(Box{Vector3d(1, 1, 1)}, at(0, 0.1, 0.4), floor, at(0, 0, 0)), -0.1, 1e-8);
  EXPECT_NEAR(signed_distance(Cylinder{0.5, 1}, at(0, 0.1, 0.4), floor, at(0, 0, 0)), -0.1, 1e-8);
  EXPECT_NEAR(signed_distance(Capsule{0.5, 1}, at(0, 0.1, 0.9), floor, at(0, 0, 0)), -0.1, 1e-9);
}

TEST(MeshSeparation, TakesTheMeshForASurface) {
  EXPECT_FALSE(overlaps(Sphere{0.1}, at(0, 0, 0), bumpy_ball(8, 0.5), at(0, 0, 0)));
  EXPECT_GT(signed_distance(Sphere{0.1}, at(0, 0, 0), bumpy_ball(8, 0.5), at(0, 0, 0)), 0.2);
}

TEST(MeshSeparation, AgreesWithEveryTriangleTakenByItself) {
  const Mesh ball = bumpy_ball(6, 0.4);
  std::vector<Mesh> triangles;
  for (const Eigen::Vector3i& t : ball.triangles->triangles) {
    auto one = std::make_shared<TriangleMesh>(*ball.triangles);
    one->triangles = {t};
    triangles.push_back({one});
  }
  Draw draw(21);
  for (int i = 0; i < 120; ++i) {
    const Shape a = draw.shape(static_cast<Kind>(i % 4));
    const Isometry3d X_WA = draw.pose(0.8);
    const Isometry3d X_WB = draw.pose(0.3);
    double least = 1e300;
    for (const Mesh& triangle : triangles) least = std::min(least, signed_distance(a, X_WA, triangle, X_WB));
    EXPECT_NEAR(signed_distance(a, X_WA, ball, X_WB), least, 1e-9);
    EXPECT_EQ(separation(a, X_WA, ball, X_WB).distance, -0.0 + separation(ball, X_WB, a, X_WA).distance);
  }
}

TEST(MeshSeparation, AgreesWithFclOutsideItsTolerance) {
  const Mesh ball = bumpy_ball(8, 0.4);
  Draw draw(22);
  int booleans_differ = 0;
  int distances_differ = 0;
  for (int i = 0; i < 1000; ++i) {
    const Pair pair{draw.shape(static_cast<Kind>(i % 4)), draw.pose(0.8), ball, draw.pose(0.3)};
    const Separation s = separation(pair);
    if (std::abs(s.distance) < 1e-5) continue;
    EXPECT_EQ(overlaps(pair), s.distance < 0.0) << i;
    if (fcl_overlaps(pair.a, pair.X_WA, ball, pair.X_WB) != (s.distance < 0.0)) ++booleans_differ;
    if (s.distance < 0.0) continue;
    const double theirs = fcl_distance(pair.a, pair.X_WA, ball, pair.X_WB);
    if (std::abs(theirs - s.distance) < 1e-5) continue;
    ++distances_differ;
    // Witnesses on both surfaces prove that ours is not too small to be true, being smaller than FCL's that it is
    // better.
    EXPECT_LE(outside(pair.a, pair.X_WA.inverse() * s.p_WA), 1e-9);
    EXPECT_NEAR((s.p_WA - s.p_WB).norm(), s.distance, 1e-9);
    EXPECT_LT(s.distance, theirs) << i;
  }
  EXPECT_EQ(booleans_differ, 0);
  EXPECT_LE(distances_differ, 5);
}

TEST(MeshSeparation, OfTwoMeshesAgreesWithFcl) {
  const Mesh a = bumpy_ball(6, 0.3);
  const Mesh b = bumpy_ball(8, 0.4);
  Draw draw(23);
  for (int i = 0; i < 300; ++i) {
    const Isometry3d X_WA = draw.pose(0.7);
    const Isometry3d X_WB = draw.pose(0.3);
    const Separation s = separation(a, X_WA, b, X_WB);
    EXPECT_EQ(fcl_overlaps(a, X_WA, b, X_WB), s.distance < 0.0);
    EXPECT_EQ(overlaps(a, X_WA, b, X_WB), s.distance < 0.0);
    if (s.distance > 0.0) {
      EXPECT_NEAR(fcl_distance(a, X_WA, b, X_WB), s.distance, 1e-8);
      EXPECT_NEAR((s.p_WA - s.p_WB).norm(), s.distance, 1e-9);
    }
  }
}

TEST(MeshSeparation, GivesTheSameBitsFromSeveralThreadsAndForACopyOfTheMesh) {
  const auto run = [](const Mesh& mesh) {
    Draw draw(31);
    std::vector<std::uint64_t> bits;
    for (int i = 0; i < 200; ++i) {
      const Pair pair{draw.shape(static_cast<Kind>(i % 4)), draw.pose(0.8), mesh, draw.pose(0.3)};
      bits.push_back(std::bit_cast<std::uint64_t>(separation(pair).distance) ^ (overlaps(pair) ? 1U : 0U));
    }
    return bits;
  };
  const Mesh shared = bumpy_ball(8, 0.4);
  const std::vector<std::uint64_t> alone = run(bumpy_ball(8, 0.4));
  std::array<std::vector<std::uint64_t>, 3> together;
  {
    std::vector<std::jthread> threads;
    for (auto& result : together) threads.emplace_back([&] { result = run(shared); });
  }
  for (const auto& result : together) EXPECT_EQ(result, alone);
}

}  // namespace
}  // namespace modsearch
