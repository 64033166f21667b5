#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <modsearch/baselines/certify/projection_internal.hpp>
#include <modsearch/problem/rng.hpp>
#include <numeric>

namespace modsearch::certify {
namespace {

double dot(const std::vector<double>& a, const std::vector<double>& b) {
  return std::inner_product(a.begin(), a.end(), b.begin(), 0.0);
}

std::vector<double> unit_vector(std::size_t n, Rng& rng) {
  std::vector<double> v(n);
  for (double& entry : v) entry = rng.uniform(-1.0, 1.0);
  const double length = std::sqrt(dot(v, v));
  for (double& entry : v) entry /= length;
  return v;
}

TEST(Projection, OntoTwoHalfSpacesIsTheCornerWhereBothEdgesAreInTheWay) {
  // x >= 1 and (x + y) / sqrt 2 >= sqrt 2, seen from the origin: (1, 1) is nearest.
  const std::vector<HalfSpace> both{{{1.0, 0.0}, 1.0}, {{std::sqrt(0.5), std::sqrt(0.5)}, std::sqrt(2.0)}};
  Projection projection;
  std::vector<double> nearest;
  ASSERT_TRUE(projection.nearest(both, {0.0, 0.0}, nearest));
  EXPECT_NEAR(nearest[0], 1.0, 1e-12);
  EXPECT_NEAR(nearest[1], 1.0, 1e-12);
}

TEST(Projection, FromWithinChangesNothing) {
  const std::vector<HalfSpace> right{{{1.0, 0.0}, -1.0}};
  Projection projection;
  std::vector<double> nearest;
  ASSERT_TRUE(projection.nearest(right, {0.5, 7.0}, nearest));
  EXPECT_EQ(nearest, (std::vector<double>{0.5, 7.0}));
}

TEST(Projection, SaysThatThereIsNoPointWhereHalfSpacesExcludeEachOther) {
  // x >= 1, y >= 1 and x + y <= 1.9.
  const double s = std::sqrt(0.5);
  const std::vector<HalfSpace> apart{{{1.0, 0.0}, 1.0}, {{0.0, 1.0}, 1.0}, {{-s, -s}, -1.9 * s}};
  Projection projection;
  std::vector<double> nearest;
  EXPECT_FALSE(projection.nearest(apart, {0.0, 0.0}, nearest));
}

// A point x is nearest to p if it is in all half-spaces and (x - p) . (z - x) >= 0 for every z in them.
TEST(Projection, IsNearerThanWhateverElseIsInside) {
  Rng rng{3};
  Projection projection;
  std::vector<double> nearest;
  int moved = 0;
  for (int i = 0; i < 2000; ++i) {
    const std::size_t n = 1 + static_cast<std::size_t>(rng.index(9));
    const std::vector<double> inside = unit_vector(n, rng);
    std::vector<HalfSpace> half_spaces;
    for (int c = rng.index(20); c >= 0; --c) {
      std::vector<double> normal = unit_vector(n, rng);
      const double least = dot(normal, inside) - (rng.uniform() < 0.3 ? 0.0 : rng.uniform(0.0, 0.5));
      half_spaces.push_back({std::move(normal), least});
    }
    std::vector<double> from = unit_vector(n, rng);
    for (double& entry : from) entry *= 5.0;
    ASSERT_TRUE(projection.nearest(half_spaces, from, nearest));
    for (const HalfSpace& h : half_spaces) EXPECT_GE(dot(h.normal, nearest), h.least - 1e-8);
    std::vector<double> way = nearest;
    for (std::size_t k = 0; k < n; ++k) way[k] -= from[k];
    moved += dot(way, way) > 0.0 ? 1 : 0;
    EXPECT_GE(dot(way, inside) - dot(way, nearest), -1e-7);
    for (int other = 0; other < 20; ++other) {
      std::vector<double> z = unit_vector(n, rng);
      for (std::size_t k = 0; k < n; ++k) z[k] = inside[k] + 0.3 * z[k];
      const bool in_all = std::all_of(half_spaces.begin(), half_spaces.end(),
                                      [&](const HalfSpace& h) { return dot(h.normal, z) >= h.least; });
      if (in_all) {
        EXPECT_GE(dot(way, z) - dot(way, nearest), -1e-7);
      }
    }
  }
  EXPECT_GT(moved, 1000);
}

}  // namespace
}  // namespace modsearch::certify
