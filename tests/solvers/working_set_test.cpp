// Programs of random type sequences with a row for every pair of bodies, and with those that are near: the answers have
// to be as good, and are judged by all rows.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <modsearch/problem/files.hpp>
#include <modsearch/problem/task_program.hpp>
#include <modsearch/solvers/inner_solver.hpp>

namespace modsearch {
namespace {

/// min |A mu - g| over mu >= 0 (Lawson and Hanson 1974, Solving Least Squares Problems, chapter 23).
Eigen::VectorXd nonnegative_least_squares(const Eigen::MatrixXd& A, const Eigen::VectorXd& g) {
  Eigen::VectorXd mu = Eigen::VectorXd::Zero(A.cols());
  std::vector<Eigen::Index> passive;
  for (Eigen::Index round = 0; round < 10 * (A.cols() + 1); ++round) {
    const Eigen::VectorXd slope = A.transpose() * (g - A * mu);
    Eigen::Index next = -1;
    for (Eigen::Index i = 0; i < A.cols(); ++i) {
      const bool is_passive = std::find(passive.begin(), passive.end(), i) != passive.end();
      if (!is_passive && slope[i] > 1e-12 * (1.0 + g.norm()) && (next < 0 || slope[i] > slope[next])) next = i;
    }
    if (next < 0) return mu;
    passive.push_back(next);
    while (!passive.empty()) {
      const Eigen::VectorXd trial = A(Eigen::all, passive).completeOrthogonalDecomposition().solve(g);
      double step = 1.0;
      for (std::size_t k = 0; k < passive.size(); ++k) {
        const double t = trial[static_cast<Eigen::Index>(k)], old = mu[passive[k]];
        if (t <= 0.0) step = std::min(step, old / (old - t));
      }
      for (std::size_t k = 0; k < passive.size(); ++k) {
        mu[passive[k]] += step * (trial[static_cast<Eigen::Index>(k)] - mu[passive[k]]);
      }
      if (step == 1.0) break;
      std::erase_if(passive, [&](Eigen::Index i) { return mu[i] <= 1e-14; });
      for (Eigen::Index i = 0; i < mu.size(); ++i) {
        if (std::find(passive.begin(), passive.end(), i) == passive.end()) mu[i] = 0.0;
      }
    }
  }
  return mu;
}

/// How far the point is from a stationary one: |df/dv - sum mu_i n_i| with the best mu_i >= 0, n_i the inward normals
/// of whatever holds with equality, relative to 1 + max mu_i.
double stationarity(SmoothProgram& program, const Eigen::VectorXd& v) {
  constexpr double kActive = 1e-7;  // solvers leave 1e-9 open
  SmoothProgram::Values at;
  program.evaluate(v, at);
  std::vector<Eigen::VectorXd> normals;
  for (Eigen::Index i = 0; i < v.size(); ++i) {
    if (v[i] - program.lower()[i] <= kActive) normals.emplace_back(Eigen::VectorXd::Unit(v.size(), i));
    if (program.upper()[i] - v[i] <= kActive) normals.emplace_back(-Eigen::VectorXd::Unit(v.size(), i));
  }
  for (Eigen::Index i = 0; i < at.rows.size(); ++i) {
    if (at.rows[i] - program.row_lower()[i] <= kActive) normals.emplace_back(at.jacobian.row(i).transpose());
    if (program.row_upper()[i] - at.rows[i] <= kActive) normals.emplace_back(-at.jacobian.row(i).transpose());
  }
  for (const BallRows& ball : program.balls()) {
    const Eigen::VectorXd c = at.rows.segment(ball.first, ball.count);
    if (ball.radius - c.norm() > kActive) continue;
    normals.emplace_back(-at.jacobian.middleRows(ball.first, ball.count).transpose() * c.normalized());
  }
  Eigen::MatrixXd A(v.size(), static_cast<Eigen::Index>(normals.size()));
  for (std::size_t k = 0; k < normals.size(); ++k) A.col(static_cast<Eigen::Index>(k)) = normals[k];
  const Eigen::VectorXd mu = nonnegative_least_squares(A, at.gradient);
  const double largest = mu.size() > 0 ? mu.maxCoeff() : 0.0;
  return (at.gradient - A * mu).lpNorm<Eigen::Infinity>() / (1.0 + largest);
}

// Of the point (2/3, 2/3) of x + 2 y <= 2 and 2 x + y <= 2, the gradient (-1, -1) is a third of the sum of the inward
// normals (-1, -2) and (-2, -1).
TEST(Stationarity, IsThatOfNonnegativeMultipliers) {
  const Eigen::Matrix2d normals = (Eigen::Matrix2d{} << -1.0, -2.0, -2.0, -1.0).finished();
  const Eigen::VectorXd mu = nonnegative_least_squares(normals, Eigen::Vector2d{-1.0, -1.0});
  EXPECT_NEAR((mu - Eigen::Vector2d::Constant(1.0 / 3.0)).norm(), 0.0, 1e-12);
  // (1, 0) = -1/3 and 2/3 of them has a negative part: the best is to take none of the first.
  EXPECT_EQ(nonnegative_least_squares(-normals, Eigen::Vector2d{-1.0, -1.0}), Eigen::Vector2d::Zero());
}

/// The seed library with a bar across the end of its link that is turned about the link's axis by a parameter.
std::shared_ptr<const ModuleLibrary> twisted_library() {
  std::vector<ModuleType> modules;
  const std::shared_ptr<const ModuleLibrary> seed = load_library("seed");
  modules.push_back(seed->base());
  for (int k = 0; k < seed->n_types(); ++k) modules.push_back(seed->type(k));
  ModuleType& link = modules[1];
  link.parameters.push_back({"twist", "rad", -1.0, 1.0});
  ModuleBody far = link.bodies[0];
  far.id = "far";
  far.collision = {{AffineShape{AffineShape::Kind::kBox, {0.1, 0.4, 0.1}, nullptr},
                    AffinePose{Eigen::Isometry3d{Eigen::Translation3d{0.3, 0.0, 0.2}}}}};
  far.connectors.erase(far.connectors.begin());
  link.bodies[0].connectors.pop_back();
  link.bodies.push_back(far);
  ModuleJoint twist;
  twist.joint.name = "twist";
  twist.fixed = true;
  twist.angle = AffineScalar::of_parameter(1);
  twist.child = 1;
  link.joints = {twist};
  return std::make_shared<const ModuleLibrary>("twisted", std::move(modules));
}

struct Family {
  const char* scenario;
  int most_modules;
  std::shared_ptr<const ModuleLibrary> library;  // null: the scenario's own
};

std::vector<Family> families() {
  return {{"seed/random_obstacles", 4, nullptr},
          {"breakeven/clutter", 5, load_library("seed/short")},
          {"workshop/reach", 7, nullptr},
          {"seed/random_obstacles", 4, twisted_library()}};
}

RobotProblem instance(const Family& family, std::uint64_t index) {
  RobotProblemSpec spec = load_problem_file(family.scenario).instance({11, index})->spec();
  spec.level = Level::kPostureSelf;
  if (family.library) spec.library = family.library;
  spec.chains = nullptr;
  return RobotProblem{spec};
}

std::vector<int> random_sequence(const RobotProblem& problem, int most_modules, Rng& rng) {
  std::vector<int> types;
  for (int k = 0; k < most_modules; ++k) {
    const std::vector<int> next = problem.successors(types);
    if (next.empty()) break;
    types.push_back(next[static_cast<std::size_t>(rng.index(static_cast<int>(next.size())))]);
  }
  return types;
}

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
  return values[values.size() / 2];
}

// The answer is the lightest point within the tolerance of 1e-9: its objective is that close to the optimum. Along a
// ball of radius R = 1 mm the objective rises by s^2 / 2 R per multiplier, so the point may be s = sqrt(2 R 1e-9)
// = 1.4e-6 m from the optimum, where the ball's normal is turned by s / R.
constexpr double kStationary = 1.4e-3;

// `n` sequences, a start each: the answers with rows left out are feasible by all rows and stationary, as many as
// without leaving out, and as light.
void expect_answers_of_the_whole_program(int n) {
  int feasible_all = 0, feasible_some = 0, converged = 0;
  std::vector<double> objectives_all, objectives_some;
  Rng rng{21};
  const std::vector<Family> of = families();
  for (int i = 0; i < n; ++i) {
    const Family& family = of[static_cast<std::size_t>(i) % of.size()];
    const RobotProblem problem = instance(family, static_cast<std::uint64_t>(i));
    const std::vector<int> types = random_sequence(problem, family.most_modules, rng);
    TaskProgram all{problem, types, {.all_rows = true}};
    TaskProgram some{problem, types, {}};
    if (all.n_variables() == 0) continue;
    const Eigen::VectorXd start = all.start(0);
    InnerOptions options;
    if (i % 2 == 0) options.first_penalty = 1e3;
    Meter meter;
    const InnerResult with_all = minimise(Inner::kOwn, all, start, options, meter);
    const InnerResult with_some = minimise(Inner::kOwn, some, start, options, meter);
    if (with_all.violation <= options.tolerance) {
      ++feasible_all;
      objectives_all.push_back(with_all.objective);
    }
    if (with_some.violation > options.tolerance) continue;
    ++feasible_some;
    objectives_some.push_back(with_some.objective);
    SmoothProgram::Values values;
    all.evaluate(with_some.v, values);
    EXPECT_LE(all.violation(with_some.v, values.rows), 1.01 * options.tolerance) << "sequence " << i;
    if (with_some.status != InnerStatus::kConverged) continue;
    ++converged;
    EXPECT_LE(stationarity(all, with_some.v), kStationary) << "sequence " << i;
  }
  testing::Test::RecordProperty("feasible", feasible_some);
  testing::Test::RecordProperty("feasible_all_rows", feasible_all);
  EXPECT_GE(feasible_some, feasible_all);
  EXPECT_GE(converged, n / 5);  // the claims above are about something
  EXPECT_LE(median(objectives_some), median(objectives_all) * (1.0 + 1e-6));
}

TEST(WorkingSet, GivesAnswersOfTheWholeProgram) { expect_answers_of_the_whole_program(60); }

TEST(SlowWorkingSet, GivesAnswersOfTheWholeProgramOnAThousandSequences) { expect_answers_of_the_whole_program(1000); }

}  // namespace
}  // namespace modsearch
