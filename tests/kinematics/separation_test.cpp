#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <modsearch/kinematics/separation.hpp>
#include <string>
#include <thread>
#include <tuple>
#include <vector>

#include "kinematics/separation_checks.hpp"

namespace modsearch {
namespace {

using namespace separation_checks;

using KindPair = std::tuple<Kind, Kind>;

std::string pair_name(const testing::TestParamInfo<KindPair>& info) {
  return name(std::get<0>(info.param)) + "And" + name(std::get<1>(info.param));
}

unsigned seed_of(const KindPair& kinds) {
  return 1000U + 10U * static_cast<unsigned>(std::get<0>(kinds)) + static_cast<unsigned>(std::get<1>(kinds));
}

const auto kUnorderedPairs =
    testing::Values(KindPair{Kind::kSphere, Kind::kSphere}, KindPair{Kind::kSphere, Kind::kCapsule},
                    KindPair{Kind::kSphere, Kind::kCylinder}, KindPair{Kind::kSphere, Kind::kBox},
                    KindPair{Kind::kCapsule, Kind::kCapsule}, KindPair{Kind::kCapsule, Kind::kCylinder},
                    KindPair{Kind::kCapsule, Kind::kBox}, KindPair{Kind::kCylinder, Kind::kCylinder},
                    KindPair{Kind::kCylinder, Kind::kBox}, KindPair{Kind::kBox, Kind::kBox});

const auto kAllKinds = testing::Values(Kind::kSphere, Kind::kCapsule, Kind::kCylinder, Kind::kBox);

void expect_agreement_with_fcl(const KindPair& kinds, int n_pairs) {
  Draw draw(seed_of(kinds));
  int booleans_differ = 0;
  int distances_differ = 0;
  double worst = 0.0;
  for (int i = 0; i < n_pairs; ++i) {
    const Pair pair{draw.shape(std::get<0>(kinds)), draw.pose(0.7), draw.shape(std::get<1>(kinds)), draw.pose(0.7)};
    const Separation s = separation(pair);
    ASSERT_NO_FATAL_FAILURE(expect_certified(pair, s, 1e-9)) << "pair " << i;
    ASSERT_NEAR(signed_distance(pair), s.distance, 1e-14) << "pair " << i;
    if (std::abs(s.distance) < 1e-6) continue;  // FCL's own tolerance
    ASSERT_EQ(overlaps(pair), s.distance < 0.0) << "pair " << i;
    if (fcl_overlaps(pair.a, pair.X_WA, pair.b, pair.X_WB) != (s.distance < 0.0)) ++booleans_differ;
    if (s.distance <= 0.0) continue;
    const double difference = std::abs(fcl_distance(pair.a, pair.X_WA, pair.b, pair.X_WB) - s.distance);
    worst = std::max(worst, difference);
    if (difference > 1e-4) ++distances_differ;
    if (testing::Test::HasFailure()) return;
  }
  // Ours is proven above, so what is counted here are errors of FCL; docs/clearance.md lists them.
  EXPECT_EQ(booleans_differ, 0);
  EXPECT_LE(distances_differ, n_pairs / 400);
  testing::Test::RecordProperty("distances_beyond_1e-4", distances_differ);
  testing::Test::RecordProperty("worst_difference", std::to_string(worst));
  std::printf("%d pairs: %d booleans, %d distances differ from FCL's, at most by %.1e m\n", n_pairs, booleans_differ,
              distances_differ, worst);
}

class SeparationOfPair : public testing::TestWithParam<KindPair> {};
INSTANTIATE_TEST_SUITE_P(Kinds, SeparationOfPair, kUnorderedPairs, pair_name);

TEST_P(SeparationOfPair, IsProvenAndAgreesWithFclOn100000RandomPairs) { expect_agreement_with_fcl(GetParam(), 100000); }

class SeparationOfOrderedPair : public testing::TestWithParam<KindPair> {};
INSTANTIATE_TEST_SUITE_P(Kinds, SeparationOfOrderedPair, testing::Combine(kAllKinds, kAllKinds), pair_name);

TEST_P(SeparationOfOrderedPair, IsProvenWhereFacesEdgesAndAxesCoincide) {
  Draw draw(seed_of(GetParam()));
  for (int i = 0; i < 3000; ++i) {
    const Pair pair{draw.round_shape(std::get<0>(GetParam())), draw.aligned_pose(0.8),
                    draw.round_shape(std::get<1>(GetParam())), draw.aligned_pose(0.8)};
    const Separation s = separation(pair);
    expect_certified(pair, s, 1e-9);
    expect_aligned(s, 1e-7);
    if (std::abs(s.distance) > 1e-9) {
      EXPECT_EQ(overlaps(pair), s.distance < 0.0);
    }
    ASSERT_FALSE(HasFailure()) << "pair " << i;
  }
}

TEST_P(SeparationOfOrderedPair, IsProvenWhereAxesAreAlmostParallel) {
  Draw draw(seed_of(GetParam()));
  for (int i = 0; i < 3000; ++i) {
    const auto tilted = [&](const Isometry3d& X) {
      return turned(X, std::pow(10.0, draw.uniform(-12, -2)), draw.direction());
    };
    const Pair pair{draw.shape(std::get<0>(GetParam())), tilted(draw.aligned_pose(0.8)),
                    draw.shape(std::get<1>(GetParam())), tilted(draw.aligned_pose(0.8))};
    const Separation s = separation(pair);
    // Beside the axis of a disk the witness of a depth moves by metres per radian of the normal.
    expect_certified(pair, s, 1e-8, 1e-4);
    expect_aligned(s, s.distance > 0.0 ? 1e-5 : 1e-4);
    if (std::abs(s.distance) > 1e-7) {
      EXPECT_EQ(overlaps(pair), s.distance < 0.0);
    }
    ASSERT_FALSE(HasFailure()) << "pair " << i;
  }
}

TEST_P(SeparationOfOrderedPair, IsMirroredWhenTheArgumentsAreSwapped) {
  Draw draw(seed_of(GetParam()));
  for (int i = 0; i < 2000; ++i) {
    const Pair pair{draw.shape(std::get<0>(GetParam())), draw.pose(0.7), draw.shape(std::get<1>(GetParam())),
                    draw.pose(0.7)};
    const Separation s = separation(pair);
    const Separation m = separation(pair.b, pair.X_WB, pair.a, pair.X_WA);
    EXPECT_NEAR(m.distance, s.distance, 1e-9);
    EXPECT_NEAR(signed_distance(pair.b, pair.X_WB, pair.a, pair.X_WA), s.distance, 1e-9);
    EXPECT_EQ(overlaps(pair.b, pair.X_WB, pair.a, pair.X_WA), overlaps(pair));
    if (s.distance > 1e-3) {  // inside, two directions may be equally short
      EXPECT_LE((m.normal_W + s.normal_W).norm(), 1e-6);
      EXPECT_LE((m.p_WA - s.p_WB).norm() + (m.p_WB - s.p_WA).norm(), 1e-5);
    }
    ASSERT_FALSE(HasFailure()) << "pair " << i;
  }
}

/// Central difference of the distance along a translation of A and along a rotation of A about the world's origin.
TEST_P(SeparationOfOrderedPair, HasTheGradientThatTheWitnessesSay) {
  Draw draw(seed_of(GetParam()));
  int compared = 0;
  for (int i = 0; i < 1500; ++i) {
    const Pair pair{draw.shape(std::get<0>(GetParam())), draw.pose(0.6), draw.shape(std::get<1>(GetParam())),
                    draw.pose(0.6)};
    const Separation s = separation(pair);
    if (s.distance < 1e-3) continue;
    const double h = 1e-6;
    const Vector3d along = draw.direction();
    const auto moved = [&](double step) {
      Isometry3d X = pair.X_WA;
      X.translation() += step * along;
      return signed_distance(pair.a, X, pair.b, pair.X_WB);
    };
    EXPECT_NEAR((moved(h) - moved(-h)) / (2 * h), s.normal_W.dot(along), 1e-4);
    const auto rotated = [&](double step) {
      return signed_distance(pair.a, Isometry3d(AngleAxisd(step, along)) * pair.X_WA, pair.b, pair.X_WB);
    };
    const double forward = (rotated(h) - s.distance) / h;
    const double backward = (s.distance - rotated(-h)) / h;
    if (std::abs(forward - backward) < 1e-3) {  // away from kinks, where the witness jumps along a face
      EXPECT_NEAR(0.5 * (forward + backward), s.normal_W.dot(along.cross(s.p_WA)), 1e-3);
      ++compared;
    }
    ASSERT_FALSE(HasFailure()) << "pair " << i;
  }
  EXPECT_GT(compared, 800);
}

TEST_P(SeparationOfOrderedPair, IsContinuousThroughTouching) {
  Draw draw(seed_of(GetParam()));
  for (int i = 0; i < 60; ++i) {
    Pair pair{draw.shape(std::get<0>(GetParam())), draw.pose(0.5), draw.shape(std::get<1>(GetParam())), draw.pose(0.5)};
    const Vector3d n = separation(pair).normal_W;
    // Moved by a step, the distance changes by at most the step, from deep inside to well apart.
    pair.X_WA.translation() -= 0.3 * n;
    double before = signed_distance(pair);
    for (int k = 0; k < 600; ++k) {
      pair.X_WA.translation() += 1e-3 * n;
      const double now = signed_distance(pair);
      EXPECT_LE(std::abs(now - before), 1e-3 + 1e-9);
      before = now;
    }
    ASSERT_FALSE(HasFailure()) << "pair " << i;
  }
}

/// A depth is the least over all directions: a search that knows nothing of faces and edges must find none shorter.
TEST_P(SeparationOfOrderedPair, IsTheLeastDepthOfAllDirections) {
  Draw draw(seed_of(GetParam()));
  int inside = 0;
  while (inside < 150) {
    const Pair pair{draw.shape(std::get<0>(GetParam())), draw.pose(0.3), draw.shape(std::get<1>(GetParam())),
                    draw.pose(0.3)};
    const double distance = signed_distance(pair);
    if (distance >= 0.0) continue;
    ++inside;
    const auto gap = [&](const Vector3d& n) { return plane_gap(pair.a, pair.X_WA, pair.b, pair.X_WB, n); };
    std::vector<std::pair<double, Vector3d>> start;
    for (int k = 0; k < 500; ++k) {
      const Vector3d n = draw.direction();
      start.emplace_back(gap(n), n);
    }
    std::partial_sort(start.begin(), start.begin() + 5, start.end(),
                      [](const auto& one, const auto& other) { return one.first > other.first; });
    for (int k = 0; k < 5; ++k) {
      auto [value, n] = start[static_cast<std::size_t>(k)];
      for (double step = 0.1; step > 1e-6;) {
        bool better = false;
        for (int attempt = 0; attempt < 10 && !better; ++attempt) {
          const Vector3d next = (n + step * draw.in_cube(1.0)).normalized();
          if (gap(next) <= value) continue;
          value = gap(next);
          n = next;
          better = true;
        }
        if (!better) step *= 0.6;
      }
      EXPECT_LE(value, distance + 1e-9);
    }
    ASSERT_FALSE(HasFailure()) << "pair " << inside;
  }
}

// ---- known values ----

TEST(Separation, OfTwoUnitBoxesFourMetresApartIsThree) {
  const Box unit{Vector3d::Ones()};
  EXPECT_DOUBLE_EQ(signed_distance(unit, at(4, 0, 0), unit, at(0, 0, 0)), 3.0);  // 4 - 1/2 - 1/2
  const Separation s = separation(unit, at(4, 0, 0), unit, at(0, 0, 0));
  EXPECT_DOUBLE_EQ(s.distance, 3.0);
  EXPECT_EQ(s.normal_W, Vector3d::UnitX());
  EXPECT_DOUBLE_EQ(s.p_WA.x(), 3.5);
  EXPECT_DOUBLE_EQ(s.p_WB.x(), 0.5);
}

TEST(Separation, OfSpheresIsTheDistanceOfCentresLessTheRadii) {
  EXPECT_DOUBLE_EQ(signed_distance(Sphere{1}, at(3, 4, 0), Sphere{2}, at(0, 0, 0)), 2.0);   // 5 - 3
  EXPECT_DOUBLE_EQ(signed_distance(Sphere{1}, at(2, 0, 0), Sphere{2}, at(0, 0, 0)), -1.0);  // 2 - 3
}

TEST(Separation, OfASphereAndABoxInsideAndOutside) {
  const Box box{Vector3d(2, 4, 6)};
  EXPECT_DOUBLE_EQ(signed_distance(Sphere{0.5}, at(4, 6, 3), box, at(0, 0, 0)), 4.5);       // edge: hypot(3, 4) - 0.5
  EXPECT_DOUBLE_EQ(signed_distance(Sphere{0.5}, at(0.25, 0, 0), box, at(0, 0, 0)), -1.25);  // face x: 0.75 + 0.5
}

TEST(Separation, OfASphereAndACylinderBesideAboveBeyondTheRimAndInside) {
  const Cylinder cylinder{1.0, 4.0};
  EXPECT_DOUBLE_EQ(signed_distance(Sphere{0.5}, at(3, 0, 1), cylinder, at(0, 0, 0)), 1.5);    // side: 3 - 1 - 0.5
  EXPECT_DOUBLE_EQ(signed_distance(Sphere{0.5}, at(0.5, 0, 4), cylinder, at(0, 0, 0)), 1.5);  // end: 4 - 2 - 0.5
  EXPECT_DOUBLE_EQ(signed_distance(Sphere{0.5}, at(4, 0, 6), cylinder, at(0, 0, 0)), 4.5);    // rim: hypot(3, 4) - 0.5
  EXPECT_DOUBLE_EQ(signed_distance(Sphere{0.5}, at(0.25, 0, 0), cylinder, at(0, 0, 0)), -1.25);  // side: 0.75 + 0.5
}

TEST(Separation, OfACylinderAndABoxThroughSideEndAndRim) {
  const Cylinder cylinder{0.5, 2.0};
  const Box box{Vector3d(2, 2, 2)};
  EXPECT_DOUBLE_EQ(signed_distance(cylinder, at(3, 0, 0), box, at(0, 0, 0)), 1.5);  // side: 3 - 1 - 0.5
  EXPECT_DOUBLE_EQ(signed_distance(cylinder, at(0, 0, 5), box, at(0, 0, 0)), 3.0);  // end: 5 - 1 - 1
  // Rim at x = 4 - 0.5, z = 5 - 1 against the edge x = 1, z = 1: hypot(2.5, 3).
  EXPECT_NEAR(signed_distance(cylinder, at(4, 0, 5), box, at(0, 0, 0)), std::hypot(2.5, 3.0), 1e-12);
  // Turned by 45 deg about y, the lowest rim point is (1 + 0.5) / sqrt(2) below the centre.
  const Isometry3d tilted = turned(at(0, 0, 4), kPi / 4, Vector3d::UnitY());
  EXPECT_NEAR(signed_distance(cylinder, tilted, box, at(0, 0, 0)), 3.0 - 1.5 / std::sqrt(2.0), 1e-12);
  // 0.2 deep in the face x = 1, everything else deeper.
  EXPECT_NEAR(signed_distance(cylinder, at(1.3, 0, 0), box, at(0, 0, 0)), -0.2, 1e-12);
}

TEST(Separation, OfCrossedCylindersIsTheDistanceOfAxesLessTheRadii) {
  const Isometry3d lying = turned(at(0, 2, 0), kPi / 2, Vector3d::UnitY());
  EXPECT_NEAR(signed_distance(Cylinder{0.5, 4}, lying, Cylinder{0.25, 4}, at(0, 0, 0)), 1.25, 1e-15);
}

TEST(Separation, OfCapsulesEndToEndAndCrossing) {
  EXPECT_DOUBLE_EQ(signed_distance(Capsule{0.5, 2}, at(0, 0, 5), Capsule{0.25, 2}, at(0, 0, 0)), 2.25);  // 5 - 2 - 0.75
  const Isometry3d lying = turned(at(0, 0, 0), kPi / 2, Vector3d::UnitY());
  EXPECT_NEAR(signed_distance(Capsule{0.5, 2}, lying, Capsule{0.25, 2}, at(0, 0, 0)), -0.75, 1e-15);
}

TEST(Separation, OfACapsuleThroughABoxIsTheShortestWayOut) {
  // Along z through the middle: 1 sideways to the face x = 1 and the radius on top.
  EXPECT_DOUBLE_EQ(signed_distance(Capsule{0.25, 10}, at(0, 0.5, 0), Box{Vector3d(2, 4, 6)}, at(0, 0, 0)), -1.25);
}

// ---- degenerate inputs ----

TEST(Separation, HasAUnitNormalForConcentricShapesOfEveryKind) {
  const std::vector<Shape> shapes{Sphere{0.3}, Capsule{0.1, 0.5}, Cylinder{0.2, 0.6}, Box{Vector3d(0.2, 0.4, 0.6)}};
  for (const Shape& a : shapes) {
    for (const Shape& b : shapes) {
      const Pair pair{a, at(1, 2, 3), b, at(1, 2, 3)};
      const Separation s = separation(pair);
      EXPECT_LT(s.distance, 0.0);
      expect_certified(pair, s, 1e-12);
      EXPECT_TRUE(overlaps(pair));
    }
  }
}

TEST(Separation, TakesShapesWithoutSizeForPointsSegmentsAndSheets) {
  const std::vector<Shape> shapes{Sphere{0.0},
                                  Capsule{0.0, 0.0},
                                  Capsule{0.0, 1.0},
                                  Cylinder{0.0, 0.0},
                                  Cylinder{0.0, 1.0},
                                  Cylinder{0.5, 0.0},
                                  Box{},
                                  Box{Vector3d(1.0, 0, 0)},
                                  Box{Vector3d(1.0, 1.0, 0)}};
  Draw draw(77);
  for (const Shape& a : shapes) {
    for (const Shape& b : shapes) {
      for (int i = 0; i < 40; ++i) {
        const Pair pair{a, draw.pose(1.0), b, draw.pose(1.0)};
        const Separation s = separation(pair);
        expect_certified(pair, s, 1e-9);
        ASSERT_FALSE(HasFailure()) << "shapes " << a.index() << " " << b.index() << " draw " << i;
      }
      const Pair same{a, at(1, 2, 3), b, at(1, 2, 3)};
      const Separation s = separation(same);
      expect_certified(same, s, 1e-12);
      EXPECT_LE(s.distance, 0.0);
    }
  }
}

TEST(Separation, IsZeroWhereShapesJustTouch) {
  const Box box{Vector3d(1, 1, 1)};
  EXPECT_DOUBLE_EQ(signed_distance(box, at(1, 0, 0), box, at(0, 0, 0)), 0.0);
  EXPECT_FALSE(overlaps(box, at(1, 0, 0), box, at(0, 0, 0)));
  EXPECT_DOUBLE_EQ(signed_distance(Sphere{0.5}, at(1, 0, 0), box, at(0, 0, 0)), 0.0);
  EXPECT_NEAR(signed_distance(Cylinder{0.5, 1}, at(0, 0, 1), box, at(0, 0, 0)), 0.0, 1e-15);
  EXPECT_NEAR(signed_distance(Cylinder{0.5, 1}, at(1, 0, 0), Cylinder{0.5, 1}, at(0, 0, 0)), 0.0, 1e-15);
}

TEST(Separation, StaysAccurateAHundredMetresFromTheOrigin) {
  Draw draw(5);
  for (int i = 0; i < 500; ++i) {
    Pair pair{draw.shape(Kind::kCylinder), draw.pose(0.7), draw.shape(Kind::kBox), draw.pose(0.7)};
    const double here = signed_distance(pair);
    pair.X_WA.translation() += Vector3d(100, -50, 80);
    pair.X_WB.translation() += Vector3d(100, -50, 80);
    EXPECT_NEAR(signed_distance(pair), here, 1e-10);  // positions of 100 m are rounded to 1e-14 m
  }
}

TEST(Separation, GivesTheSameBitsFromSeveralThreads) {
  Draw draw(11);
  std::vector<Pair> pairs;
  for (int i = 0; i < 2000; ++i) {
    pairs.push_back({draw.shape(static_cast<Kind>(draw.below(4))), draw.pose(0.6),
                     draw.shape(static_cast<Kind>(draw.below(4))), draw.pose(0.6)});
  }
  const auto run = [&] {
    std::vector<std::uint64_t> bits;
    for (const Pair& pair : pairs) bits.push_back(std::bit_cast<std::uint64_t>(separation(pair).distance));
    return bits;
  };
  const std::vector<std::uint64_t> alone = run();
  std::array<std::vector<std::uint64_t>, 3> together;
  {
    std::vector<std::jthread> threads;
    for (auto& result : together) threads.emplace_back([&result, &run] { result = run(); });
  }
  for (const auto& result : together) EXPECT_EQ(result, alone);
}

}  // namespace
}  // namespace modsearch
