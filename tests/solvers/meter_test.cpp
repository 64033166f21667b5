#include <gtest/gtest.h>

#include <cmath>
#include <deque>
#include <modsearch/kinematics/interruption.hpp>
#include <modsearch/solvers/archive.hpp>
#include <modsearch/solvers/meter.hpp>
#include <modsearch/solvers/solver.hpp>
#include <numeric>
#include <thread>

namespace modsearch::test {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();

/// A problem that scores what it is told, whatever the design.
class Script final : public DesignProblem {
 public:
  struct Line {
    double score = 0.0;
    bool achieved = true;
    Failure why = Failure::kUnreachable;  // where not achieved
    double relative_error = 0.0;
    double clearance = kInf;
    double torque_share = 0.0;
  };
  explicit Script(std::deque<Line> lines) : lines_{std::move(lines)} {}

  [[nodiscard]] std::string name() const override { return "script"; }
  [[nodiscard]] const ModuleLibrary& library() const override {
    static const ModuleLibrary library = make_library();
    return library;
  }
  [[nodiscard]] int max_modules() const override { return 3; }
  [[nodiscard]] Eigen::VectorXd context() const override { return {}; }
  [[nodiscard]] int calls() const { return calls_; }

 private:
  // A base with an output, which is all that the empty design needs.
  static ModuleLibrary make_library() {
    Connector world, out;
    world.id = world.type = "base";
    out.id = out.type = "out";
    ModuleType base;
    base.id = "base";
    base.bodies.resize(1);
    base.bodies[0].connectors = {world, out};
    return ModuleLibrary{"script", {base}};
  }
  [[nodiscard]] Evaluation do_evaluate(const Design&, Fidelity) const override {
    ++calls_;
    const Line line = lines_.empty() ? Line{} : lines_.front();
    if (!lines_.empty()) lines_.pop_front();
    if (line.score == kInf) throw std::runtime_error{"the script says throw"};
    Evaluation evaluation;
    evaluation.score = line.score;
    evaluation.attempt.achieved = evaluation.attempt.reached = line.achieved;
    evaluation.attempt.why = line.achieved ? Failure::kNone : line.why;
    evaluation.attempt.relative_error = line.relative_error;
    evaluation.attempt.clearance = line.clearance;
    evaluation.attempt.torque_share = line.torque_share;
    evaluation.attempt.work = {.forward = 3, .ik_iterations = 5, .distances = 7, .planner_states = 11};
    return evaluation;
  }
  mutable std::deque<Line> lines_;
  mutable int calls_ = 0;
};

const Design kEmpty;

TEST(Meter, RefusesTheEvaluationAfterTheLast) {
  const Script problem{{}};
  Meter meter{{.evaluations = 3}};
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(meter.stopped(), std::nullopt);
    EXPECT_TRUE(meter.evaluate(problem, kEmpty).has_value());
  }
  EXPECT_EQ(meter.stopped(), StopReason::kEvaluations);
  EXPECT_FALSE(meter.evaluate(problem, kEmpty).has_value());
  EXPECT_EQ(problem.calls(), 3);
  EXPECT_EQ(meter.progress().evaluations, 3);
}

TEST(Meter, EvaluatesNothingOnABudgetOfZero) {
  const Script problem{{}};
  for (const Budget& budget : {Budget{.evaluations = 0}, Budget{.seconds = 0.0}}) {
    Meter meter{budget};
    EXPECT_FALSE(meter.evaluate(problem, kEmpty).has_value());
    EXPECT_FALSE(meter.best().has_value());
  }
  EXPECT_EQ(problem.calls(), 0);
}

TEST(Meter, SaysThatTheTimeIsUp) {
  Meter meter{{.seconds = 1e-6}};
  while (meter.progress().seconds < 1e-6) {
  }
  EXPECT_EQ(meter.stopped(), StopReason::kSeconds);
}

TEST(Meter, StopsAtTheTargetScoreOfAnAchievedDesign) {
  const Script problem{{{.score = 9.0, .achieved = false}, {.score = 4.9}, {.score = 5.0}}};
  Meter meter{{.target_score = 5.0}};
  (void)meter.evaluate(problem, kEmpty);
  EXPECT_EQ(meter.stopped(), std::nullopt);  // a score without the deed does not count
  (void)meter.evaluate(problem, kEmpty);
  EXPECT_EQ(meter.stopped(), std::nullopt);
  (void)meter.evaluate(problem, kEmpty);
  EXPECT_EQ(meter.stopped(), StopReason::kTargetScore);
}

TEST(Meter, StopsAtTheFirstAchievedDesignWhateverItsScore) {
  const Script problem{{{.score = 9.0, .achieved = false}, {.score = -1e9}}};
  Meter meter{{.target_score = Budget::kFirstAchieved}};
  (void)meter.evaluate(problem, kEmpty);
  EXPECT_EQ(meter.stopped(), std::nullopt);
  (void)meter.evaluate(problem, kEmpty);
  EXPECT_EQ(meter.stopped(), StopReason::kTargetScore);
}

TEST(Meter, HearsWhoeverAsksToStop) {
  const Script problem{{}};
  std::stop_source source;
  Meter meter{{}, {}, source.get_token()};
  EXPECT_TRUE(meter.evaluate(problem, kEmpty).has_value());
  std::thread{[&] { source.request_stop(); }}.join();
  EXPECT_EQ(meter.stopped(), StopReason::kInterrupted);
  EXPECT_FALSE(meter.evaluate(problem, kEmpty).has_value());
}

TEST(Meter, KeepsTheBestByStandingThenScore) {
  const Script problem{{{.score = 1.0, .achieved = false},
                        {.score = 7.0, .achieved = false},
                        {.score = 6.0, .achieved = false},
                        {.score = -3.0},
                        {.score = 8.0, .achieved = false},
                        {.score = -3.0},
                        {.score = 2.0}}};
  Meter meter;
  while (meter.progress().evaluations < 7) (void)meter.evaluate(problem, kEmpty);
  ASSERT_TRUE(meter.best().has_value());
  EXPECT_EQ(meter.best()->evaluation.score, 2.0);
  EXPECT_TRUE(meter.best()->evaluation.attempt.achieved);
}

TEST(Meter, TracesEveryImprovementAndNothingElse) {
  const Script problem{{{.score = 1.0, .achieved = false},
                        {.score = 0.5, .achieved = false},
                        {.score = 7.0, .achieved = false},
                        {.score = -3.0},
                        {.score = 8.0, .achieved = false},
                        {.score = -3.0},
                        {.score = 2.0}}};
  Meter meter;
  while (meter.progress().evaluations < 7) (void)meter.evaluate(problem, kEmpty);
  std::vector<std::int64_t> evaluations;
  std::vector<double> scores;
  double seconds = 0.0;
  for (const TracePoint& point : meter.trace()) {
    evaluations.push_back(point.evaluations);
    scores.push_back(point.score);
    EXPECT_GE(point.seconds, seconds);
    seconds = point.seconds;
  }
  EXPECT_EQ(evaluations, (std::vector<std::int64_t>{1, 3, 4, 7}));
  EXPECT_EQ(scores, (std::vector<double>{1.0, 7.0, -3.0, 2.0}));
  EXPECT_FALSE(meter.trace()[1].achieved);
  EXPECT_TRUE(meter.trace()[2].achieved);
}

// Each line comes nearer than the one before, the score says the contrary.
TEST(Meter, RemembersTheDesignThatCameNearestWhileNothingIsAchieved) {
  const std::deque<Script::Line> nearer{
      {.score = 9.0, .achieved = false, .why = Failure::kIncomplete},
      {.score = 8.0, .achieved = false, .relative_error = 0.5},
      {.score = 7.0, .achieved = false, .relative_error = 0.1},
      {.score = 6.0, .achieved = false, .why = Failure::kTorque, .torque_share = 1.7},
      {.score = 5.0, .achieved = false, .why = Failure::kTorque, .torque_share = 1.2},
      {.score = 4.0, .achieved = false, .why = Failure::kObstacle, .clearance = -0.02},
      {.score = 3.0, .achieved = false, .why = Failure::kObstacle, .clearance = -0.01},
      {.score = 2.0, .achieved = false, .why = Failure::kSelfCollision, .clearance = 0.01},
      {.score = 1.0, .achieved = false, .why = Failure::kNoPath, .clearance = 0.01}};
  const Script rising{nearer};
  Meter meter;
  for (std::size_t i = 0; i < nearer.size(); ++i) {
    (void)meter.evaluate(rising, kEmpty);
    ASSERT_TRUE(meter.nearest().has_value());
    EXPECT_EQ(meter.nearest()->evaluation.score, nearer[i].score);
  }
  EXPECT_EQ(meter.best()->evaluation.score, 9.0);
  const Script falling{{nearer.rbegin(), nearer.rend()}};
  Meter other;
  for (std::size_t i = 0; i < nearer.size(); ++i) (void)other.evaluate(falling, kEmpty);
  EXPECT_EQ(other.nearest()->evaluation.score, 1.0);
}

TEST(Meter, TakesAScreeningThatFailsForTheNearestAndOneThatPassesForNothing) {
  const Script problem{{{.score = 1.0, .achieved = false, .relative_error = 0.5}, {.score = 2.0}}};
  Meter meter;
  (void)meter.evaluate(problem, kEmpty, Fidelity::kScreen);
  (void)meter.evaluate(problem, kEmpty, Fidelity::kScreen);
  ASSERT_TRUE(meter.nearest().has_value());
  EXPECT_EQ(meter.nearest()->evaluation.score, 1.0);
}

TEST(Meter, LeavesEvaluationsThatFailedAndErrorsThatAreNoNumbersOutOfTheNearest) {
  const Script problem{{{.score = std::nan("")},
                        {.score = kInf},
                        {.score = 1.0, .achieved = false, .relative_error = std::nan("")},
                        {.score = 2.0, .achieved = false, .relative_error = 0.5}}};
  Meter meter;
  for (int i = 0; i < 3; ++i) (void)meter.evaluate(problem, kEmpty);
  EXPECT_FALSE(meter.nearest().has_value());
  (void)meter.evaluate(problem, kEmpty);
  EXPECT_EQ(meter.nearest()->evaluation.score, 2.0);
}

TEST(Meter, ForgetsTheNearestDesignAsSoonAsOneIsAchieved) {
  const Script problem{{{.score = 1.0, .achieved = false}, {.score = 0.0}, {.score = 2.0, .achieved = false}}};
  Meter meter;
  for (int i = 0; i < 3; ++i) (void)meter.evaluate(problem, kEmpty);
  EXPECT_FALSE(meter.nearest().has_value());
}

TEST(Meter, KeepsTheNearestDesignInItsArchive) {
  const Script problem{{{.score = 1.0, .achieved = false, .relative_error = 0.5},
                        {.score = 1.0, .achieved = false, .relative_error = 0.5},
                        {.score = 1.0, .achieved = false, .relative_error = 0.5},
                        {.score = 9.0, .achieved = false, .relative_error = 0.6}}};
  Meter meter;
  (void)meter.evaluate(problem, kEmpty);
  Archive archive;
  meter.save(archive);
  Meter other;
  other.restore(archive, problem);  // evaluates the nearest and the best again
  (void)other.evaluate(problem, kEmpty);
  ASSERT_TRUE(other.nearest().has_value());
  EXPECT_EQ(other.nearest()->evaluation.attempt.relative_error, 0.5);
  EXPECT_EQ(other.best()->evaluation.score, 9.0);
}

TEST(Meter, TakesNotANumberForTheWorstScore) {
  const Script problem{{{.score = std::nan("")}, {.score = -1e9, .achieved = false}}};
  Meter meter;
  const std::optional<Evaluation> evaluation = meter.evaluate(problem, kEmpty);
  ASSERT_TRUE(evaluation.has_value());
  EXPECT_EQ(evaluation->score, -kInf);
  EXPECT_FALSE(evaluation->attempt.achieved);
  EXPECT_EQ(evaluation->attempt.why, Failure::kNotANumber);
  EXPECT_EQ(meter.progress().failed, 1);
  (void)meter.evaluate(problem, kEmpty);
  EXPECT_EQ(meter.best()->evaluation.score, -1e9);
  EXPECT_EQ(meter.progress().failed, 1);
}

TEST(Meter, RecordsAnEvaluationThatThrowsAndGoesOn) {
  const Script problem{{{.score = kInf}, {.score = 1.0}}};
  Meter meter;
  const std::optional<Evaluation> evaluation = meter.evaluate(problem, kEmpty);
  ASSERT_TRUE(evaluation.has_value());
  EXPECT_EQ(evaluation->attempt.why, Failure::kThrew);
  EXPECT_EQ(evaluation->score, -kInf);
  EXPECT_EQ(meter.progress().evaluations, 1);
  EXPECT_EQ(meter.progress().failed, 1);
  EXPECT_EQ(meter.first_failure(), "the script says throw");
  EXPECT_EQ(meter.evaluate(problem, kEmpty)->score, 1.0);
}

TEST(Meter, LetsADesignOutsideTheSpacePassAsTheMisuseItIs) {
  const Script problem{{{.score = 1.0}}};
  Meter meter;
  EXPECT_THROW((void)meter.evaluate(problem, Design{{{99, Parameters{}}}}), std::invalid_argument);
  EXPECT_EQ(meter.progress().evaluations, 1);
}

TEST(Meter, NeverKeepsAScreeningAsTheBest) {
  const Script problem{{{.score = 100.0}, {.score = 1.0}}};
  Meter meter{{.target_score = 50.0}};
  EXPECT_EQ(meter.evaluate(problem, kEmpty, Fidelity::kScreen)->score, 100.0);
  EXPECT_FALSE(meter.best().has_value());
  EXPECT_EQ(meter.stopped(), std::nullopt);
  (void)meter.evaluate(problem, kEmpty);
  EXPECT_EQ(meter.best()->evaluation.score, 1.0);
  EXPECT_EQ(meter.progress().evaluations, 2);
}

TEST(Meter, SumsTheInnerWork) {
  const Script problem{{}};
  Meter meter;
  (void)meter.evaluate(problem, kEmpty);
  (void)meter.evaluate(problem, kEmpty);
  meter.count(Work{.forward = 100});
  meter.count_program(4);
  meter.count_program(5);
  const Progress progress = meter.progress();
  EXPECT_EQ(progress.work.forward, 3 + 3 + 100);
  EXPECT_EQ(progress.work.ik_iterations, 10);
  EXPECT_EQ(progress.work.distances, 14);
  EXPECT_EQ(progress.work.planner_states, 22);
  EXPECT_EQ(progress.program_evaluations, 9);
}

TEST(Meter, CountsWhyEvaluationsFailed) {
  const Script problem{{{1.0, true}, {2.0, false}, {kInf, false}, {3.0, true}}};
  Meter meter;
  for (int i = 0; i < 4; ++i) (void)meter.evaluate(problem, kEmpty);
  const auto outcomes = meter.progress().outcomes;
  const auto count = [&](Failure why) { return outcomes[static_cast<std::size_t>(why)]; };
  EXPECT_EQ(count(Failure::kNone), 2);
  EXPECT_EQ(count(Failure::kUnreachable), 1);
  EXPECT_EQ(count(Failure::kThrew), 1);
  EXPECT_EQ(std::accumulate(outcomes.begin(), outcomes.end(), std::int64_t{0}), meter.progress().evaluations);
}

TEST(Meter, ShowsItselfAfterEveryEvaluationAndNowAndThenInBetween) {
  const Script problem{{}};
  std::vector<std::int64_t> seen;
  Meter meter{{}, [&](const Meter& it) { seen.push_back(it.progress().evaluations); }};
  (void)meter.evaluate(problem, kEmpty);
  (void)meter.evaluate(problem, kEmpty);
  EXPECT_EQ(seen, (std::vector<std::int64_t>{1, 2}));
  for (int i = 0; i < 10'000; ++i) meter.count_program(1);
  EXPECT_EQ(seen.size(), 2U + 2U);  // at 4096 and 8192
}

TEST(Meter, RefusesABudgetThatMakesNoSense) {
  EXPECT_THROW(Meter{Budget{.evaluations = -1}}, std::invalid_argument);
  EXPECT_THROW(Meter{Budget{.seconds = -1.0}}, std::invalid_argument);
  EXPECT_THROW(Meter{Budget{.seconds = std::nan("")}}, std::invalid_argument);
  EXPECT_THROW(Meter{Budget{.target_score = std::nan("")}}, std::invalid_argument);
}

/// Evaluates the empty design so many times, then says what it was told to say.
class Repeater final : public Solver {
 public:
  Repeater(int times, SearchEnd end) : times_{times}, end_{std::move(end)} {}
  [[nodiscard]] std::string name() const override { return "repeater"; }

 private:
  [[nodiscard]] SearchEnd do_solve(const DesignProblem& problem, Meter& meter, Rng) const override {
    for (int i = 0; i < times_; ++i) {
      if (!meter.evaluate(problem, kEmpty)) break;
    }
    return end_;
  }
  int times_;
  SearchEnd end_;
};

TEST(Solver, AnswersWithTheBestOfTheMeter) {
  const Script problem{{{.score = 1.0}, {.score = 3.0}, {.score = 2.0}}};
  Meter meter;
  const Solution solution =
      Repeater{3, {.stop = StopReason::kExhausted, .reason = "three", .bound = Bound{4.0, "by law"}}}.solve(
          problem, meter, Rng{1});
  EXPECT_EQ(solution.evaluation.score, 3.0);
  EXPECT_EQ(solution.spent.evaluations, 3);
  EXPECT_EQ(solution.stop, StopReason::kExhausted);
  EXPECT_EQ(solution.reason, "three");
  ASSERT_TRUE(solution.bound.has_value());
  EXPECT_EQ(solution.bound->score, 4.0);
}

TEST(Solver, NamesTheDesignThatCameNearestBesideTheBestByItsScore) {
  const Script problem{{{.score = 1.0, .achieved = false, .relative_error = 1.0},
                        {.score = -4.0, .achieved = false, .relative_error = 0.1}}};
  Meter meter;
  const Solution solution = Repeater{2, {}}.solve(problem, meter, Rng{1});
  EXPECT_EQ(solution.evaluation.score, 1.0);
  ASSERT_TRUE(solution.nearest.has_value());
  EXPECT_EQ(solution.nearest->evaluation.score, -4.0);
}

TEST(Solver, EndsForTheReasonOfTheMeterUnlessItHasAProof) {
  const Script problem{{}};
  Meter spent{{.evaluations = 2}};
  EXPECT_EQ((Repeater{5, {}}.solve(problem, spent, Rng{1}).stop), StopReason::kEvaluations);
  Meter proved{{.evaluations = 2}};
  EXPECT_EQ((Repeater{2, {.stop = StopReason::kOptimal, .reason = "by law", .bound = {}}}
                 .solve(problem, proved, Rng{1})
                 .stop),
            StopReason::kOptimal);
}

TEST(Solver, AnswersWithTheEmptyDesignIfNothingWasEvaluated) {
  const Script problem{{}};
  Meter meter{{.evaluations = 0}};
  const Solution solution = Repeater{1, {}}.solve(problem, meter, Rng{1});
  EXPECT_EQ(solution.design, Design{});
  EXPECT_EQ(solution.evaluation.score, -kInf);
  EXPECT_FALSE(solution.evaluation.attempt.achieved);
  EXPECT_EQ(solution.stop, StopReason::kEvaluations);
}

/// A problem whose evaluations never end by themselves; somebody asks to stop in the middle of the third.
class Endless final : public DesignProblem {
 public:
  explicit Endless(std::stop_source& stop) : stop_{stop} {}
  [[nodiscard]] std::string name() const override { return "endless"; }
  [[nodiscard]] const ModuleLibrary& library() const override { return sound_.library(); }
  [[nodiscard]] int max_modules() const override { return 3; }
  [[nodiscard]] Eigen::VectorXd context() const override { return {}; }

 private:
  [[nodiscard]] Evaluation do_evaluate(const Design& design, Fidelity fidelity) const override {
    if (++calls_ <= 2) return sound_.evaluate(design, fidelity);
    stop_.request_stop();
    for (;;) interruption_point();
  }

  std::stop_source& stop_;
  Script sound_{{{.score = 1.0}, {.score = 2.0}}};
  mutable int calls_ = 0;
};

TEST(Meter, CountsNothingOfAnEvaluationThatIsCutOff) {
  std::stop_source stop;
  const Endless problem{stop};
  Meter meter{{.evaluations = 100}, {}, stop.get_token()};
  EXPECT_TRUE(meter.evaluate(problem, Design{}));
  EXPECT_TRUE(meter.evaluate(problem, Design{}));
  EXPECT_FALSE(meter.evaluate(problem, Design{}));
  EXPECT_EQ(meter.stopped(), StopReason::kInterrupted);
  const Progress progress = meter.progress();
  EXPECT_EQ(progress.evaluations, 2);
  EXPECT_EQ(progress.failed, 0);
  EXPECT_EQ(std::accumulate(progress.outcomes.begin(), progress.outcomes.end(), std::int64_t{0}), 2);
  EXPECT_EQ(meter.best()->evaluation.score, 2.0);
}

// The budget of evaluations is no reason to stop in the middle of the last.
TEST(Meter, FinishesTheLastEvaluationOfItsBudget) {
  const Script problem{{{.score = 1.0}}};
  Meter meter{{.evaluations = 1}};
  EXPECT_TRUE(meter.evaluate(problem, Design{}));
  EXPECT_EQ(meter.stopped(), StopReason::kEvaluations);
}

}  // namespace
}  // namespace modsearch::test
