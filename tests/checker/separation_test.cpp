#include <gmock/gmock.h>

#include <cfenv>
#include <checker/separation.hpp>
#include <cmath>
#include <modsearch/kinematics/separation.hpp>
#include <random>

namespace modsearch_check {
namespace {

/// Pairs of shapes, as the checker and as the toolkit sees them.
class Separations : public testing::Test {
 protected:
  double uniform(double lower, double upper) {
    return lower + (upper - lower) * static_cast<double>(bits_() >> 11) * 0x1p-53;
  }

  struct Both {
    Solid solid;
    modsearch::Shape shape;
    Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  };

  Both draw(Kind kind) {
    Both both;
    both.solid.kind = kind;
    const double a = uniform(0.05, 0.3);
    const double b = uniform(0.1, 1.0);
    const double c = uniform(0.1, 0.5);
    both.solid.size = {a, b, c};
    switch (kind) {
      case Kind::kBox:
        both.shape = modsearch::Box{{a, b, c}};
        break;
      case Kind::kCylinder:
        both.shape = modsearch::Cylinder{a, b};
        break;
      default:
        both.shape = modsearch::Sphere{a};
    }
    const Rounding nearest{FE_TONEAREST};
    const Eigen::Quaterniond turn{uniform(-1.0, 1.0), uniform(-1.0, 1.0), uniform(-1.0, 1.0), uniform(-1.0, 1.0)};
    both.X.linear() = turn.normalized().toRotationMatrix();
    for (int i = 0; i < 3; ++i) {
      const auto k = static_cast<std::size_t>(i);
      both.X.translation()[i] = uniform(-0.4, 0.4);
      both.solid.centre[k] = both.X.translation()[i];
      for (int j = 0; j < 3; ++j) both.solid.turn[k][static_cast<std::size_t>(j)] = both.X(i, j);
    }
    return both;
  }

  std::mt19937_64 bits_{3};

 private:
  Rounding up_{FE_UPWARD};
};

TEST_F(Separations, AreFoundWhereTheToolkitMeasuresAGapAndNowhereElse) {
  int apart = 0;
  int overlapping = 0;
  for (int i = 0; i < 6'000; ++i) {
    const Both a = draw(i % 3 == 0 ? Kind::kBox : i % 3 == 1 ? Kind::kCylinder : Kind::kSphere);
    const Both b = draw(i / 3 % 3 == 0 ? Kind::kBox : i / 3 % 3 == 1 ? Kind::kCylinder : Kind::kSphere);
    const double distance = [&] {
      const Rounding nearest{FE_TONEAREST};
      return modsearch::signed_distance(a.shape, a.X, b.shape, b.X);
    }();
    const bool found = are_apart(a.solid, b.solid, {});
    if (distance > 1e-4) {
      ++apart;
      EXPECT_TRUE(found) << distance << " " << i;
    } else if (distance < -1e-4) {
      ++overlapping;
      EXPECT_FALSE(found) << distance << " " << i;
    }
  }
  EXPECT_GT(apart, 1'000);
  EXPECT_GT(overlapping, 1'000);
}

TEST_F(Separations, TakeANormalThatIsGiven) {
  Both a = draw(Kind::kSphere);
  Both b = draw(Kind::kSphere);
  a.solid.centre = {0.0, 0.0, 0.0};
  b.solid.centre = {0.0, 0.0, -(a.solid.size[0].upper() + b.solid.size[0].upper()) - 1e-6};
  EXPECT_TRUE(are_apart(a.solid, b.solid, {Numbers{0.0, 0.0, 1.0}}));
  b.solid.centre[2] += 2e-6;
  EXPECT_FALSE(are_apart(a.solid, b.solid, {Numbers{0.0, 0.0, 1.0}, {0.0, 0.0, 0.0}}));
}

}  // namespace
}  // namespace modsearch_check
