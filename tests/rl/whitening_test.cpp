#include <gtest/gtest.h>

#include <limits>
#include <modsearch/problem/rng.hpp>
#include <modsearch/rl/whitening.hpp>
#include <stdexcept>

namespace modsearch {
namespace {

// x, y uniform, then twice what is nearly their sum, and a constant: three directions, one of them narrow.
Eigen::MatrixXd samples(int m) {
  Eigen::MatrixXd result(m, 4);
  Rng rng{1};
  for (int i = 0; i < m; ++i) {
    const double x = rng.uniform(-1.0, 1.0);
    const double y = rng.uniform(2.0, 3.0);
    result.row(i) << x, y, x + y + 1e-3 * rng.normal(), 7.0;
  }
  return result;
}

TEST(Whitening, GivesItsSamplesMeanZeroAndCovarianceOne) {
  const Eigen::MatrixXd v = samples(500);
  const Whitening whitening = whitening_of(v);
  ASSERT_EQ(whitening.A.rows(), 3);
  Eigen::MatrixXd white(500, 3);
  for (int i = 0; i < 500; ++i) white.row(i) = whitening(v.row(i).transpose()).transpose();
  EXPECT_LT(white.colwise().mean().cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_TRUE((white.transpose() * white / 500.0).isIdentity(1e-6));
}

TEST(Whitening, SortsItsDirectionsFromTheWidestToTheNarrowest) {
  const Whitening whitening = whitening_of(samples(500));
  // A row of A is a unit vector over the deviation along it.
  EXPECT_LT(whitening.A.row(0).norm(), whitening.A.row(1).norm());
  EXPECT_LT(100.0 * whitening.A.row(1).norm(), whitening.A.row(2).norm());
}

TEST(Whitening, OfEqualSamplesShowsNothing) {
  const Whitening whitening = whitening_of(Eigen::MatrixXd::Constant(5, 3, 0.25));
  EXPECT_EQ(whitening.A.rows(), 0);
  EXPECT_EQ(whitening(Eigen::VectorXd::Ones(3)).size(), 0);
}

TEST(Whitening, IsReadBackFromItsNumbers) {
  const Whitening whitening = whitening_of(samples(50));
  const Whitening back = whitening_from(numbers_of(whitening), 4);
  EXPECT_EQ(back.mean, whitening.mean);
  EXPECT_EQ(back.A, whitening.A);
}

TEST(Whitening, RefusesListsOfAnotherLengthAndSamplesThatAreNone) {
  EXPECT_THROW(static_cast<void>(whitening_from({1.0, 2.0, 3.0}, 2)), std::invalid_argument);
  EXPECT_THROW(static_cast<void>(whitening_from({}, 2)), std::invalid_argument);
  EXPECT_THROW(static_cast<void>(whitening_from({1.0, 1.0, 1.0}, 1)), std::invalid_argument);  // two of one direction
  EXPECT_THROW(static_cast<void>(whitening_of(Eigen::MatrixXd(0, 3))), std::invalid_argument);
  EXPECT_THROW(
      static_cast<void>(whitening_of(Eigen::MatrixXd::Constant(2, 2, std::numeric_limits<double>::infinity()))),
      std::invalid_argument);
}

}  // namespace
}  // namespace modsearch
