#include <gtest/gtest.h>

#include <cmath>
#include <modsearch/problem/files.hpp>
#include <modsearch/rl/design_model.hpp>
#include <modsearch/rl/observation_encoder.hpp>
#include <thread>

namespace modsearch {
namespace {

using Look = ActionModel::Look;

std::vector<float> random_parameters(const ModuleLibrary& library, int k, Rng& rng) {
  std::vector<float> x(static_cast<std::size_t>(library.type(k).n_parameters()));
  for (float& value : x) value = static_cast<float>(rng.uniform(-0.95, 0.95));
  return x;
}

Placement placement(const ModuleLibrary& library, int k, const std::vector<float>& x) {
  Placement result{k, Parameters(static_cast<Eigen::Index>(x.size()))};
  for (std::size_t p = 0; p < x.size(); ++p) {
    result.parameters[static_cast<Eigen::Index>(p)] = from_unit(library.type(k).parameters[p], x[p]);
  }
  return result;
}

Design random_prefix(const ModuleLibrary& library, int n, Rng& rng) {
  Design design;
  for (int i = 0; i < n; ++i) {
    const int k = rng.index(library.n_types());
    design.modules.push_back(placement(library, k, random_parameters(library, k, rng)));
  }
  return design;
}

// Error and mass are those of the evaluation of prefix + module.
TEST(DesignModel, SeesWhatAnEvaluationWouldSay) {
  const ProblemFile file = load_problem_file("seed/random_wide");
  Rng rng{1};
  Work work;
  int answers = 0;
  for (std::uint64_t i = 0; i < 400; ++i) {
    const auto problem = file.instance({1, i});
    const Design prefix = random_prefix(problem->library(), static_cast<int>(i % 4), rng);
    const auto model = DesignModel::of(problem, prefix, 3);
    const int k = rng.index(3);
    const std::vector<float> x = random_parameters(problem->library(), k, rng);
    const std::optional<Look> look = model->look(k, x, work);
    Design design = prefix;
    design.modules.push_back(placement(problem->library(), k, x));
    ASSERT_EQ(look.has_value(), problem->chain(design.types())->n_joints() <= 3);
    if (!look) continue;
    ++answers;
    const Evaluation evaluation = problem->evaluate(design);
    EXPECT_EQ(look->error, evaluation.attempt.goal_error);
    EXPECT_EQ(look->error <= look->tolerance, evaluation.attempt.reached);
    EXPECT_NEAR(look->mass, design.parameters().sum(), 1e-12);  // one kilogram per metre
  }
  EXPECT_GT(answers, 200);
  EXPECT_GT(work.forward, 0);
}

// Against central differences of the least distance itself, where it is differentiable: the posture follows along.
TEST(DesignModel, SlopesAreThoseOfTheLeastDistance) {
  const ProblemFile file = load_problem_file("seed/random_wide");
  Rng rng{2};
  Work work;
  int compared = 0;
  for (std::uint64_t i = 0; i < 600; ++i) {
    const auto problem = file.instance({2, i});
    const auto model = DesignModel::of(problem, random_prefix(problem->library(), static_cast<int>(i % 3), rng), 3);
    const int k = rng.index(3);
    const std::vector<float> x = random_parameters(problem->library(), k, rng);
    const std::optional<Look> look = model->look(k, x, work);
    if (!look || look->error < 0.01) continue;
    for (std::size_t p = 0; p < x.size(); ++p) {
      constexpr float kStep = 0x1p-11F;
      std::vector<float> above = x;
      std::vector<float> below = x;
      above[p] += kStep;
      below[p] -= kStep;
      const double width = static_cast<double>(above[p]) - static_cast<double>(below[p]);
      const Look up = model->look(k, above, work).value();
      const Look down = model->look(k, below, work).value();
      const auto at = static_cast<Eigen::Index>(p);
      // The distance bends by at most about 1 / error per metre and step (0.5 m per unit).
      EXPECT_NEAR(look->error_slope[at], (up.error - down.error) / width, 2e-3) << i;
      EXPECT_NEAR(look->mass_slope[at], (up.mass - down.mass) / width, 1e-9) << i;
      ++compared;
    }
  }
  EXPECT_GT(compared, 500);
}

// hinge (p, d) to (1, 0, 1): error |hypot(1, 1 - p) - d|, half a metre per unit.
TEST(DesignModel, KnowsTheHingeInClosedForm) {
  const auto problem = load_problem("seed/fixed");
  const auto model = DesignModel::of(problem, {}, 3);
  Work work;
  const int hinge = problem->library().find("hinge").value();
  const Look look = model->look(hinge, std::vector<float>{-0.5F, 0.5F}, work).value();  // 0.75 m, 1.25 m
  const double h = std::hypot(1.0, 0.25);
  EXPECT_NEAR(look.error, 1.25 - h, 1e-12);
  EXPECT_EQ(look.tolerance, 1e-3);
  EXPECT_NEAR(look.error_slope[0], 0.5 * 0.25 / h, 1e-12);  // raising the hinge brings it nearer: h shrinks
  EXPECT_NEAR(look.error_slope[1], 0.5, 1e-12);
  EXPECT_NEAR(look.mass, 2.0, 1e-12);
  EXPECT_NEAR(look.mass_slope[0], 0.5, 1e-15);
  EXPECT_NEAR(look.mass_slope[1], 0.5, 1e-15);
}

TEST(DesignModel, SpeaksOfTheGoalThatIsMissedByMost) {
  RobotProblemSpec spec = load_problem_file("seed/fixed").spec;
  spec.task = std::make_shared<GoalTask>(
      "two", std::vector<Goal>{{"1", GoalType::kReach, PoseRegion::ball({1.0, 0.0, 1.0}, 1e-3)},
                               {"2", GoalType::kReach, PoseRegion::ball({0.0, 2.0, 0.5}, 1e-2)}});
  const auto problem = std::make_shared<const RobotProblem>(spec);
  Work work;
  const int hinge = problem->library().find("hinge").value();
  const auto model = DesignModel::of(problem, {}, 3);
  // p = 0.5, d = 1: 0.118 m off the first target, 1 m off the second.
  const Look look = model->look(hinge, std::vector<float>{-1.0F, 0.0F}, work).value();
  EXPECT_NEAR(look.error, 1.0, 1e-9);
  EXPECT_EQ(look.tolerance, 1e-2);
  EXPECT_NEAR(look.error_slope[1], -0.5, 1e-9);
}

TEST(DesignModel, HasNoAnswerForGoalsThatAreNoBallsOrForLongChains) {
  RobotProblemSpec spec = load_problem_file("seed/fixed").spec;
  const auto ball = std::make_shared<const RobotProblem>(spec);
  Rng rng{3};
  const Design prefix = random_prefix(ball->library(), 1, rng);
  const int hinge = ball->library().find("hinge").value();
  Work work;
  EXPECT_FALSE(DesignModel::of(ball, prefix, 1)->look(hinge, std::vector<float>{0.0F, 0.0F}, work));
  spec.task = std::make_shared<GoalTask>(
      "pose",
      std::vector<Goal>{{"1", GoalType::kReach, PoseRegion::with_default_tolerances(Eigen::Isometry3d::Identity())}});
  EXPECT_EQ(DesignModel::of(std::make_shared<const RobotProblem>(spec), {}, 3), nullptr);
}

// The types of the seed library, but nothing takes the rotary's connectors.
std::shared_ptr<const ModuleLibrary> library_with_a_misfit() {
  const auto seed = load_library("seed");
  std::vector<ModuleType> modules{seed->base()};
  for (int k = 0; k < seed->n_types(); ++k) modules.push_back(seed->type(k));
  for (ModuleBody& body : modules[1 + static_cast<std::size_t>(seed->find("rotary").value())].bodies) {
    for (Connector& connector : body.connectors) connector.type = "other";
  }
  return std::make_shared<const ModuleLibrary>("misfit", std::move(modules), seed->neighbour_rule());
}

TEST(DesignModel, HasNoAnswerForAModuleThatDoesNotFit) {
  RobotProblemSpec spec = load_problem_file("seed/fixed").spec;
  spec.library = library_with_a_misfit();
  const auto problem = std::make_shared<const RobotProblem>(spec);
  const auto model = DesignModel::of(problem, {}, 3);
  Work work;
  const std::vector<float> x{0.0F, 0.0F};
  EXPECT_TRUE(model->look(problem->library().find("hinge").value(), x, work));
  EXPECT_FALSE(model->look(problem->library().find("rotary").value(), x, work));
}

// A policy borrows the problem that it solves. Looks know chains they have met by their addresses, so these must not
// become free when the problem goes.
TEST(DesignModel, KeepsTheChainsItHasLookedAt) {
  RobotProblemSpec spec = load_problem_file("seed/fixed").spec;
  spec.chains = nullptr;
  auto problem = std::make_unique<const RobotProblem>(std::move(spec));
  const std::weak_ptr<const Chain> chain = problem->chain(std::vector{0});
  const std::shared_ptr<const RobotProblem> borrowed{std::shared_ptr<const RobotProblem>{}, problem.get()};
  Work work;
  EXPECT_TRUE(DesignModel::of(borrowed, {}, 3)->look(0, std::vector<float>(1), work));
  problem.reset();
  EXPECT_FALSE(chain.expired());
}

TEST(DesignModel, IsRestoredFromItsKey) {
  const auto problem = load_problem("seed/random_wide", {1, 5});
  Rng rng{4};
  const auto model = DesignModel::of(problem, random_prefix(problem->library(), 2, rng), 3);
  const std::vector<double> key = model->key();
  EXPECT_EQ(DesignModel::restore(problem, key, 3)->key(), key);
  for (std::size_t n = 0; n < key.size(); ++n) {
    EXPECT_THROW((void)DesignModel::restore(problem, std::span{key}.first(n), 3), std::invalid_argument) << n;
  }
  for (const double nonsense : {-1.0, 0.5, 1e12, std::nan("")}) {
    std::vector<double> broken = key;
    broken[0] = nonsense;
    EXPECT_THROW((void)DesignModel::restore(problem, broken, 3), std::invalid_argument) << nonsense;
  }
  std::vector<double> longer = key;
  longer.push_back(0.0);
  EXPECT_THROW((void)DesignModel::restore(problem, longer, 3), std::invalid_argument);
}

TEST(DesignModel, RefusesAnotherNumberOfParameters) {
  const auto model = DesignModel::of(load_problem("seed/fixed"), {}, 3);
  Work work;
  EXPECT_THROW((void)model->look(0, std::vector<float>(5), work), std::invalid_argument);
}

TEST(DesignModel, AnswersAlikeFromTwoThreadsAndAcrossProblems) {
  const ProblemFile narrow = load_problem_file("seed/random_narrow");
  const ProblemFile wide = load_problem_file("seed/random_wide");
  std::vector<std::shared_ptr<const DesignModel>> models;
  for (std::uint64_t i = 0; i < 40; ++i) {
    models.push_back(DesignModel::of((i % 2 == 0 ? narrow : wide).instance({1, i}), {}, 3));
  }
  const std::vector<float> x{0.25F, -0.5F};
  const auto errors = [&](bool backwards) {
    std::vector<double> result(models.size());
    for (std::size_t i = 0; i < models.size(); ++i) {
      const std::size_t at = backwards ? models.size() - 1 - i : i;
      const ModuleLibrary& library = *narrow.spec.library;
      Work work;
      for (int k = 0; k < library.n_types(); ++k) {
        const auto n = static_cast<std::size_t>(library.type(k).n_parameters());
        result[at] += models[at]->look(k, std::span{x}.first(n), work).value().error;
      }
    }
    return result;
  };
  std::vector<double> first, second;
  std::thread one{[&] { first = errors(false); }};
  std::thread two{[&] { second = errors(true); }};
  one.join();
  two.join();
  EXPECT_EQ(first, second);
}

}  // namespace
}  // namespace modsearch
