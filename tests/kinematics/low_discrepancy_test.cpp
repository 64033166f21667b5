#include <gmock/gmock.h>

#include <modsearch/kinematics/low_discrepancy.hpp>
#include <thread>
#include <vector>

namespace modsearch {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

TEST(Halton, BeginsAtTheCentre) {
  EXPECT_EQ(halton(0, 7), Eigen::VectorXd::Constant(7, 0.5));
  EXPECT_EQ(halton(0, 0).size(), 0);
}

TEST(Halton, FollowsTheRadicalInversesOfItsBasesShiftedByAHalf) {
  // Base 2: 1/2, 1/4, 3/4; base 3: 1/3, 2/3, 1/9; each plus 1/2, modulo 1.
  EXPECT_LE((halton(1, 2) - Eigen::Vector2d(0.0, 1.0 / 3 + 0.5)).norm(), 1e-15);
  EXPECT_LE((halton(2, 2) - Eigen::Vector2d(0.75, 2.0 / 3 - 0.5)).norm(), 1e-15);
  EXPECT_LE((halton(3, 2) - Eigen::Vector2d(0.25, 1.0 / 9 + 0.5)).norm(), 1e-15);
}

TEST(Halton, MeetsEveryCellOnceInAFullPeriod) {
  // 2^3 * 3^2 consecutive points: one in each of the 8 x 9 cells. The shift by a half moves cells of base 3 by half a
  // cell, so they are counted from 1/18 on.
  std::vector<int> count(72, 0);
  for (int i = 0; i < 72; ++i) {
    const Eigen::VectorXd u = halton(i, 2);
    const double v = u[1] + 0.5 - std::floor(u[1] + 0.5);
    ++count[static_cast<std::size_t>(static_cast<int>(u[0] * 8.0) * 9 + static_cast<int>(v * 9.0 + 1e-9))];
  }
  EXPECT_THAT(count, testing::Each(1));
}

TEST(Halton, StaysInTheUnitCube) {
  for (int i = 0; i < 2000; ++i) {
    const Eigen::VectorXd u = halton(i, 20);
    ASSERT_TRUE((u.array() >= 0.0).all() && (u.array() < 1.0).all());
  }
}

TEST(Halton, IsTheSameFromTwoThreads) {
  Eigen::VectorXd a, b;
  std::thread first{[&] { a = halton(12345, 30); }};
  std::thread second{[&] { b = halton(12345, 30); }};
  first.join();
  second.join();
  EXPECT_EQ(a, b);
}

TEST(Halton, RefusesWhatHasNoPoint) {
  EXPECT_THAT([] { (void)halton(-1, 2); }, ThrowsMessage<std::invalid_argument>(HasSubstr("-1")));
  EXPECT_THAT([] { (void)halton(0, 257); }, ThrowsMessage<std::invalid_argument>(HasSubstr("257")));
}

}  // namespace
}  // namespace modsearch
