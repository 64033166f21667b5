#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <modsearch/baselines/cat_cma.hpp>
#include <modsearch/solvers/archive.hpp>
#include <stdexcept>

namespace modsearch {
namespace {

using Function = std::function<double(const MixedPoint&)>;

double sphere(const Eigen::VectorXd& x) { return x.squaredNorm(); }

// Axes of 1 to 1000: the standard ill-conditioned function.
double ellipsoid(const Eigen::VectorXd& x) {
  double sum = 0.0;
  const auto n = static_cast<double>(x.size());
  for (Eigen::Index i = 0; i < x.size(); ++i)
    sum += std::pow(10.0, 6.0 * static_cast<double>(i) / (n - 1.0)) * x[i] * x[i];
  return sum;
}

// How many choices are not category 0 ("one max"), and how many come at or after the first that is not ("leading
// ones"): the categorical halves of SphereCOM and EllipsoidCLO in Hamano et al. 2024.
double missing_ones(const std::vector<int>& c) {
  return static_cast<double>(std::count_if(c.begin(), c.end(), [](int k) { return k != 0; }));
}
double missing_leading_ones(const std::vector<int>& c) {
  return static_cast<double>(c.end() - std::find_if(c.begin(), c.end(), [](int k) { return k != 0; }));
}

// Evaluations until f is below 1e-10, from mean 3 and sigma 1.
int evaluations(const Function& f, int n_x, const std::vector<int>& categories, std::uint64_t seed) {
  CatCma cma{{.mean = Eigen::VectorXd::Constant(n_x, 3.0), .sigma = 1.0, .categories = categories}};
  Rng rng{seed};
  int count = 0;
  while (count < 100'000) {
    std::vector<std::pair<double, MixedPoint>> points;
    for (int i = 0; i < cma.population(); ++i) {
      MixedPoint point = cma.ask(rng);
      const double value = f(point);
      ++count;
      if (value < 1e-10) return count;
      points.emplace_back(value, std::move(point));
    }
    std::stable_sort(points.begin(), points.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    std::vector<MixedPoint> ranked;
    for (auto& [value, point] : points) ranked.push_back(std::move(point));
    cma.tell(ranked);
  }
  return count;
}

int median_evaluations(const Function& f, int n_x, const std::vector<int>& categories) {
  std::vector<int> counts;
  for (std::uint64_t seed = 0; seed < 21; ++seed) counts.push_back(evaluations(f, n_x, categories, seed));
  std::sort(counts.begin(), counts.end());
  return counts[10];
}

// The expected medians are those of an independent implementation by the method's authors, Python package cmaes 0.13.1
// (CatCMAwM, same start, same target, seeds 0 to 20). Medians of 21 runs of such length scatter by some 3 %.
void expect_about(int median, double expected) {
  EXPECT_GT(median, 0.9 * expected);
  EXPECT_LT(median, 1.1 * expected);
}

const std::vector<int> kFiveOfFive(5, 5);

TEST(CatCma, SolvesTheSphereAsFastAsTheReference) {
  expect_about(median_evaluations([](const MixedPoint& p) { return sphere(p.x); }, 10, {}), 1823);
}

TEST(CatCma, SolvesTheEllipsoidAsFastAsTheReference) {
  expect_about(median_evaluations([](const MixedPoint& p) { return ellipsoid(p.x); }, 10, {}), 4610);
}

TEST(CatCma, SolvesSphereComAsFastAsTheReference) {
  const auto f = [](const MixedPoint& p) { return sphere(p.x) + missing_ones(p.categories); };
  expect_about(median_evaluations(f, 5, kFiveOfFive), 1322);
}

TEST(CatCma, SolvesEllipsoidCloAsFastAsTheReference) {
  const auto f = [](const MixedPoint& p) { return ellipsoid(p.x) + missing_leading_ones(p.categories); };
  expect_about(median_evaluations(f, 5, kFiveOfFive), 2214);
}

// One max over 10 choices of 3, nothing else.
TEST(CatCma, SearchesCategoriesAlone) {
  const auto f = [](const MixedPoint& p) { return missing_ones(p.categories); };
  EXPECT_LT(median_evaluations(f, 0, std::vector<int>(10, 3)), 1000);  // 3^10 = 59049 points
}

// f rises with the number of zeros: category 0 must keep its margin (1 - 0.73^(1/4)) / 2 in four choices of three.
TEST(CatCma, KeepsAMarginForEveryCategory) {
  CatCma cma{{.mean = Eigen::VectorXd::Zero(0), .categories = {3, 3, 3, 3}}};
  const double margin = (1.0 - std::pow(0.73, 0.25)) / 2.0;
  Rng rng{1};
  for (int generation = 0; generation < 300; ++generation) {
    std::vector<MixedPoint> points;
    for (int i = 0; i < cma.population(); ++i) points.push_back(cma.ask(rng));
    std::stable_sort(points.begin(), points.end(), [](const auto& a, const auto& b) {
      return missing_ones(a.categories) > missing_ones(b.categories);
    });
    cma.tell(points);
    for (int i = 0; i < 4; ++i) {
      EXPECT_GE(cma.probabilities(i).minCoeff(), margin - 1e-12);
      EXPECT_NEAR(cma.probabilities(i).sum(), 1.0, 1e-12);
    }
  }
  for (int i = 0; i < 4; ++i) EXPECT_LT(cma.probabilities(i)[0], 2.0 * margin);
}

TEST(CatCma, DrawsOnlyWhatTheMaskAllows) {
  const CatCma cma{{.mean = Eigen::VectorXd::Zero(1), .categories = {4, 4, 4}}};
  Rng rng{2};
  for (int i = 0; i < 200; ++i) {
    const MixedPoint point = cma.ask(rng, [](std::span<const int> chosen) {
      return chosen.empty() ? std::vector<int>{1, 3} : std::vector<int>{chosen.back()};
    });
    EXPECT_EQ(point.categories[0] % 2, 1);
    EXPECT_EQ(point.categories, std::vector<int>(3, point.categories[0]));
  }
}

TEST(CatCma, GoesOnFromAnArchiveAsIfNothingHadHappened) {
  const CatCmaStart start{.mean = Eigen::VectorXd::Constant(3, 3.0), .categories = {2, 5}};
  CatCma first{start};
  Rng rng{3};
  const auto generation = [](CatCma& cma, Rng& stream) {
    std::vector<MixedPoint> points;
    for (int i = 0; i < cma.population(); ++i) points.push_back(cma.ask(stream));
    std::stable_sort(points.begin(), points.end(),
                     [](const auto& a, const auto& b) { return sphere(a.x) < sphere(b.x); });
    cma.tell(points);
  };
  for (int i = 0; i < 20; ++i) generation(first, rng);
  Archive archive;
  first.save(archive, "here");
  CatCma second{start};
  second.restore(archive, "here");
  Rng again = rng;
  for (int i = 0; i < 20; ++i) {
    generation(first, rng);
    generation(second, again);
  }
  EXPECT_EQ(first.mean(), second.mean());
  EXPECT_EQ(first.probabilities(1), second.probabilities(1));
  CatCma other{{.mean = Eigen::VectorXd::Zero(2), .categories = {2, 5}}};
  EXPECT_THROW(other.restore(archive, "here"), std::runtime_error);
}

TEST(CatCma, RefusesWhatCannotBeSearched) {
  EXPECT_THROW(CatCma{CatCmaStart{}}, std::invalid_argument);
  EXPECT_THROW((CatCma{{.mean = Eigen::VectorXd::Zero(1), .sigma = 0.0}}), std::invalid_argument);
  EXPECT_THROW((CatCma{{.mean = Eigen::VectorXd::Zero(1), .categories = {0}}}), std::invalid_argument);
  CatCma cma{{.mean = Eigen::VectorXd::Zero(1)}};
  EXPECT_THROW(cma.tell({}), std::invalid_argument);
}

}  // namespace
}  // namespace modsearch
