#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <modsearch/rl/design_environment.hpp>
#include <modsearch/solvers/meter.hpp>

#include "problem/one_module_optimum.hpp"

namespace modsearch {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// The action that places `name` with these lengths in metres.
HybridAction action(const DesignEnvironment& environment, const char* name, std::initializer_list<double> lengths) {
  const ModuleLibrary& library = environment.problem().library();
  HybridAction result{library.find(name).value(), Eigen::VectorXf::Zero(environment.space().n_parameters()), {}};
  int i = environment.space().offset(result.k);
  for (const double length : lengths) {
    result.x[i++] = static_cast<float>(to_unit(library.type(result.k).parameters.front(), length));
  }
  return result;
}

DesignEnvironment environment_of(const char* id, DesignEnvironmentOptions options = {}) {
  return DesignEnvironment{load_problem_file(id), std::move(options)};
}

// A problem of whose designs a test says what they are worth: types without geometry that matters.
class ToldProblem final : public DesignProblem {
 public:
  using Told = std::function<Evaluation(const Design&)>;
  ToldProblem(Told told, int max_modules)
      : library_{load_library("seed")}, told_{std::move(told)}, max_modules_{max_modules} {}
  std::string name() const override { return "told"; }
  const ModuleLibrary& library() const override { return *library_; }
  int max_modules() const override { return max_modules_; }
  Eigen::VectorXd context() const override { return Eigen::VectorXd::Constant(1, 0.25); }

 private:
  std::vector<int> do_successors(std::span<const int> types) const override {
    if (!types.empty() && types.back() == 1) return {};  // nothing fits on type 1
    return library().successors(types);
  }
  Evaluation do_evaluate(const Design& design, Fidelity) const override { return told_(design); }

  std::shared_ptr<const ModuleLibrary> library_;
  Told told_;
  int max_modules_;
};

DesignEnvironment told(ToldProblem::Told worth, DesignEnvironmentOptions options = {}, int max_modules = 10) {
  const auto problem = std::make_shared<const ToldProblem>(std::move(worth), max_modules);
  return DesignEnvironment{[problem](Rng) { return problem; }, std::move(options)};
}

Evaluation worth(double score) {
  Evaluation result;
  result.score = score;
  return result;
}

HybridAction plain(const Environment& environment, int k) {
  return {k, Eigen::VectorXf::Zero(environment.space().n_parameters()), {}};
}

TEST(DesignEnvironment, PaysTheScoreOfEveryPrefix) {
  DesignEnvironment environment = environment_of("seed/fixed");
  const auto problem = load_problem("seed/fixed");
  environment.reset(Rng{1});
  const Step first = environment.step(action(environment, "link", {0.75}));
  EXPECT_EQ(first.reward, problem->evaluate(environment.design()).score);
  // A link of 0.75 m ends at (0, 0, 0.75): -|(1, 0, 0.25)| / |(1, 0, 1)| - 5 * 0.75.
  EXPECT_NEAR(first.reward, -std::hypot(1.0, 0.25) / std::sqrt(2.0) - 3.75, 1e-12);
  EXPECT_FALSE(first.terminated || first.truncated || first.success);
  const Step second = environment.step(action(environment, "hinge", {0.5, 1.25}));
  EXPECT_EQ(second.reward, problem->evaluate(environment.design()).score);
  EXPECT_EQ(environment.design().modules.size(), 2U);
}

TEST(DesignEnvironment, PaysDifferencesThatAddUpToTheScoreLessThatOfNothing) {
  DesignEnvironment environment = environment_of("seed/fixed", {.reward = RewardKind::kDifference});
  const auto problem = load_problem("seed/fixed");
  environment.reset(Rng{1});
  double paid = environment.step(action(environment, "link", {0.75})).reward;
  paid += environment.step(action(environment, "rotary", {0.5, 1.25})).reward;
  EXPECT_NEAR(paid, problem->evaluate(environment.design()).score - problem->evaluate({}).score, 1e-12);
}

TEST(DesignEnvironment, EndsWithSuccessWhenTheTargetIsReached) {
  DesignEnvironment environment = environment_of("seed/fixed");
  environment.reset(Rng{1});
  const Step step = environment.step(action(environment, "hinge", {0.5, std::sqrt(1.25)}));
  EXPECT_TRUE(step.terminated);
  EXPECT_TRUE(step.success);
  EXPECT_FALSE(step.truncated);
  EXPECT_NEAR(step.reward, 350.0 - 5.0 * (0.5 + std::sqrt(1.25)), 1e-6);
  EXPECT_FALSE(environment.running());
}

TEST(DesignEnvironment, IsCutOffWhenTenModulesAreInPlace) {
  DesignEnvironment environment = environment_of("seed/fixed");
  environment.reset(Rng{1});
  Step step;
  int steps = 0;
  while (environment.running()) {
    step = environment.step(action(environment, "link", {1.5}));
    ++steps;
  }
  EXPECT_EQ(steps, 9);  // and the base
  EXPECT_TRUE(step.truncated);
  EXPECT_FALSE(step.terminated || step.success);
}

// The one-module optimum is blocked on three targets in five (PROBLEM 5): there the two ends differ.
TEST(DesignEnvironment, EndsOnReachingOrOnAchievingAsAsked) {
  const ProblemFile file = load_problem_file("seed/random_obstacles");
  int blocked = 0;
  for (std::uint64_t i = 0; i < 30; ++i) {
    const ProblemSource source = problem_source(file, {3, i});
    DesignEnvironment reaching{source};
    DesignEnvironment achieving{source, {.end_on = EndOn::kAchieved}};
    const auto optimum = testing::one_module_optimum(file.instance({3, i})->task().goals()[0].position());
    if (optimum.hinge_proximal != 0.5) continue;  // lengths that leave no room for half a millimetre more
    const HybridAction best = action(reaching, "hinge", {optimum.hinge_proximal, optimum.hinge_distal + 5e-4});
    reaching.reset(Rng{0});
    achieving.reset(Rng{0});
    EXPECT_TRUE(reaching.step(best).success);
    const Step step = achieving.step(best);
    EXPECT_EQ(step.terminated, achieving.evaluation()->attempt.achieved);
    EXPECT_EQ(achieving.running(), achieving.evaluation()->attempt.collides);
    if (achieving.running()) ++blocked;
  }
  EXPECT_GT(blocked, 5);
  EXPECT_LT(blocked, 30);
}

TEST(DesignEnvironment, ReplacesTheCollisionLevel) {
  const DesignEnvironment environment = environment_of("seed/random_obstacles", {.level = Level::kNone});
  EXPECT_EQ(dynamic_cast<const RobotProblem&>(environment.problem()).spec().level, Level::kNone);
}

TEST(DesignEnvironment, DrawsANewInstanceForEveryEpisodeAndTheSameForTheSameStream) {
  DesignEnvironment environment = environment_of("seed/random_wide");
  environment.reset(Rng{1});
  const Eigen::VectorXf first = environment.observation();
  environment.reset(Rng{2});
  EXPECT_NE(environment.observation(), first);
  environment.reset(Rng{1});
  EXPECT_EQ(environment.observation(), first);
}

TEST(DesignEnvironment, WhitensWhatTellsItsInstancesApart) {
  const ProblemFile file = load_problem_file("seed/random_narrow");
  const int plain = DesignEnvironment{file}.observation_size();
  DesignEnvironment environment{file, {.whiten = 2000}};
  // The target's three coordinates, its two cylindrical distances: five directions that differ.
  ASSERT_EQ(environment.observation_size(), plain);
  constexpr int kDraws = 2000;
  Eigen::MatrixXd seen(kDraws, 5);
  for (int i = 0; i < kDraws; ++i) {
    environment.reset(Rng{1}.fork(static_cast<std::uint64_t>(i)));
    seen.row(i) = environment.observation().tail(5).cast<double>().transpose();
  }
  // Other instances than those it was whitened by: deviations of means and covariances of 2000 draws are 0.03.
  EXPECT_LT(seen.colwise().mean().cwiseAbs().maxCoeff(), 0.2);
  EXPECT_TRUE((seen.transpose() * seen / kDraws - Eigen::MatrixXd::Identity(5, 5)).cwiseAbs().maxCoeff() < 0.3);

  // What it has found goes on with its options: a policy meets one problem only.
  const auto problem = file.instance({3, 4});
  DesignEnvironment other{[&problem](Rng) { return problem; }, environment.options()};
  environment.set_source([&problem](Rng) { return problem; });
  environment.reset(Rng{0});
  other.reset(Rng{0});
  EXPECT_EQ(other.observation(), environment.observation());
}

TEST(DesignEnvironment, SolvesTheProblemItIsGiven) {
  const ProblemFile file = load_problem_file("seed/random_wide");
  DesignEnvironment environment{file};
  environment.set_source(problem_source(file, {5, 17}));
  environment.reset(Rng{9});
  const auto& goals = dynamic_cast<const RobotProblem&>(environment.problem()).task().goals();
  EXPECT_EQ(goals[0].position(), file.instance({5, 17})->task().goals()[0].position());
}

TEST(DesignEnvironment, IsCutOffWhenAnEvaluationIsRefused) {
  DesignEnvironment environment = environment_of("seed/fixed");
  Meter meter{{.evaluations = 2}};
  environment.set_evaluate([&](const DesignProblem& problem, const Design& design, Fidelity fidelity) {
    return meter.evaluate(problem, design, fidelity);
  });
  environment.reset(Rng{1});
  EXPECT_TRUE(environment.preview(0, std::vector<float>{0.0F}).has_value());
  EXPECT_FALSE(environment.step(action(environment, "link", {1.0})).truncated);
  EXPECT_FALSE(environment.preview(0, std::vector<float>{0.0F}).has_value());
  const Step step = environment.step(action(environment, "link", {1.0}));
  EXPECT_TRUE(step.truncated);
  EXPECT_TRUE(step.unpaid);
  EXPECT_EQ(step.reward, 0.0);
  EXPECT_FALSE(environment.evaluation().has_value());
  EXPECT_FALSE(environment.running());
  EXPECT_EQ(meter.progress().evaluations, 2);
}

TEST(DesignEnvironment, IsCutOffWhereNothingFitsAnyMore) {
  DesignEnvironment environment = told([](const Design&) { return worth(3.0); });
  environment.reset(Rng{1});
  EXPECT_FALSE(environment.step(plain(environment, 0)).truncated);
  const Step step = environment.step(plain(environment, 1));
  EXPECT_TRUE(step.truncated);
  EXPECT_EQ(step.reward, 3.0);
}

TEST(DesignEnvironment, IsCutOffByAScoreThatIsNoNumber) {
  for (const double score : {std::nan(""), -kInfinity}) {
    DesignEnvironment environment = told([score](const Design&) { return worth(score); });
    environment.reset(Rng{1});
    const Step step = environment.step(plain(environment, 0));
    EXPECT_TRUE(step.truncated);
    EXPECT_EQ(step.reward, 0.0);
  }
}

TEST(DesignEnvironment, GoesOnAfterAProblemHasThrown) {
  int calls = 0;
  DesignEnvironment environment = told([&](const Design& design) {
    if (++calls == 2) throw std::runtime_error("the licence server is away");
    return worth(static_cast<double>(design.modules.size()));
  });
  environment.reset(Rng{1});
  EXPECT_EQ(environment.step(plain(environment, 0)).reward, 1.0);
  EXPECT_THROW((void)environment.step(plain(environment, 0)), std::runtime_error);
  EXPECT_TRUE(environment.running());
  EXPECT_EQ(environment.design().modules.size(), 1U);
  EXPECT_EQ(environment.step(plain(environment, 0)).reward, 2.0);
}

TEST(DesignEnvironment, DoesNotCountADesignWithoutItsEndEffectorAsReached) {
  DesignEnvironment environment = told([](const Design& design) {
    Evaluation evaluation = worth(0.0);
    evaluation.attempt.reached = true;
    evaluation.attempt.why = design.modules.size() < 2 ? Failure::kIncomplete : Failure::kNone;
    return evaluation;
  });
  environment.reset(Rng{1});
  EXPECT_FALSE(environment.step(plain(environment, 0)).terminated);
  EXPECT_TRUE(environment.step(plain(environment, 0)).terminated);
}

TEST(DesignEnvironment, RefusesASourceOfNothingAndAProblemWithoutRoom) {
  EXPECT_THROW(DesignEnvironment{ProblemSource{}}, std::invalid_argument);
  EXPECT_THROW(DesignEnvironment{ProblemSource{[](Rng) { return nullptr; }}}, std::invalid_argument);
  EXPECT_THROW(told([](const Design&) { return worth(0.0); }, {}, 1), std::invalid_argument);
}

TEST(DesignEnvironment, RefusesALevelForAProblemThatHasNone) {
  EXPECT_THROW(told([](const Design&) { return worth(0.0); }, {.level = Level::kNone}), std::invalid_argument);
}

TEST(DesignEnvironment, CountsTheWorkOfItsEvaluations) {
  DesignEnvironment environment = environment_of("seed/random_obstacles");
  environment.reset(Rng{1});
  (void)environment.step(action(environment, "hinge", {0.5, 1.0}));
  EXPECT_EQ(environment.work().forward, environment.evaluation()->attempt.work.forward);
  EXPECT_GT(environment.work().forward, 0);
}

// Relabelled goals are reached by the design, lie in the region targets are drawn from, and pay what their problem
// pays.
TEST(Hindsight, TellsOfTheLastPlacementInTasksThatItSolves) {
  const ProblemFile file = load_problem_file("seed/random_narrow");
  DesignEnvironment environment{file, {.encoder = {.kind = EncoderKind::kSeed36}}};
  Rng rng{7};
  int told = 0;
  for (std::uint64_t i = 0; i < 40; ++i) {
    environment.reset(Rng{i});
    (void)environment.step(action(environment, "hinge", {0.5 + 0.02 * static_cast<double>(i), 1.0}));
    const double mass = environment.design().parameters().sum();
    for (const Transition& transition : environment.hindsight(3, rng)) {
      ++told;
      const Eigen::Vector3d target = transition.s.tail<3>().cast<double>();
      EXPECT_TRUE((target.array() >= file.sampling->lower.array() - 1e-6).all()) << target.transpose();
      EXPECT_TRUE((target.array() <= file.sampling->upper.array() + 1e-6).all()) << target.transpose();
      EXPECT_TRUE(transition.terminated);
      EXPECT_FALSE(transition.truncated);
      EXPECT_NEAR(transition.reward, 350.0 - 5.0 * mass, 1e-4);
      // Nothing but the target differs from the real step: here the design after it.
      EXPECT_EQ(transition.s_next.head(33), environment.observation().head(33));
      EXPECT_EQ(transition.s_next.tail(3), transition.s.tail(3));
      EXPECT_EQ(transition.next_mask, environment.space().all());
      // The model of the state before it sees the placement reach.
      const int k = transition.action.k;
      const Eigen::VectorXf x_k =
          transition.action.x.segment(environment.space().offset(k), environment.space().count(k));
      Work work;
      const auto look = transition.model->look(k, {x_k.data(), static_cast<std::size_t>(x_k.size())}, work);
      EXPECT_LE(look.value().error, 1e-6);
    }
  }
  EXPECT_GT(told, 60);
}

TEST(Hindsight, LeavesOutGoalsThatTheDesignBeforeHadReached) {
  DesignEnvironment environment{problem_source(load_problem_file("seed/fixed"))};  // anywhere: no region
  Rng rng{8};
  environment.reset(Rng{1});
  (void)environment.step(action(environment, "hinge", {0.5, 1.0}));
  (void)environment.step(action(environment, "rotary", {0.5, 0.5}));
  const std::vector<Transition> transitions = environment.hindsight(20, rng);
  EXPECT_EQ(transitions.size(), 20U);
  for (const Transition& transition : transitions) EXPECT_TRUE(transition.terminated);
}

TEST(Hindsight, PaysDifferencesWhereStepsDo) {
  DesignEnvironment environment{load_problem_file("seed/random_wide"), {.reward = RewardKind::kDifference}};
  environment.reset(Rng{1});
  (void)environment.step(action(environment, "hinge", {0.5, 1.0}));
  Rng rng{9};
  const std::vector<Transition> transitions = environment.hindsight(5, rng);
  EXPECT_FALSE(transitions.empty());
  for (const Transition& transition : transitions) {
    EXPECT_NEAR(transition.reward, 350.0 - 5.0 * 1.5 - 1.0, 1e-4);  // nothing placed is worth +1
  }
}

TEST(Hindsight, HasNothingToTellBeforeAStepOrOfProblemsThatAreNoRobots) {
  Rng rng{1};
  DesignEnvironment robot = environment_of("seed/fixed");
  robot.reset(Rng{1});
  EXPECT_TRUE(robot.hindsight(3, rng).empty());
  DesignEnvironment other = told([](const Design&) { return worth(0.0); });
  other.reset(Rng{1});
  (void)other.step(plain(other, 0));
  EXPECT_TRUE(other.hindsight(3, rng).empty());
}

}  // namespace
}  // namespace modsearch
