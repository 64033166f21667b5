#include <gtest/gtest.h>

#include <cmath>
#include <modsearch/baselines/lexicographic.hpp>
#include <modsearch/problem/files.hpp>

namespace modsearch {
namespace {

Evaluation evaluation(Failure why, double score) {
  Evaluation result;
  result.score = score;
  result.attempt.why = why;
  result.attempt.achieved = why == Failure::kNone;
  return result;
}

TEST(Rank, RisesFromCheapToDearWhateverTheScore) {
  const Failure rising[] = {Failure::kThrew,    Failure::kIncomplete, Failure::kUnreachable,
                            Failure::kObstacle, Failure::kNoPath,     Failure::kNone};
  double score = 100.0;
  Rank last{};  // hopeless
  for (const Failure why : rising) {
    const Rank next = rank(evaluation(why, score));
    EXPECT_GT(next, last) << name(why);
    last = next;
    score -= 10.0;
  }
}

TEST(Rank, PrefersTheNearerMissToTheBetterScore) {
  Evaluation far_and_light = evaluation(Failure::kUnreachable, -3.5);
  far_and_light.attempt.relative_error = 0.5;
  Evaluation near_and_heavy = evaluation(Failure::kUnreachable, -9.0);
  near_and_heavy.attempt.relative_error = 0.01;
  EXPECT_GT(rank(near_and_heavy), rank(far_and_light));
}

TEST(Rank, PrefersTheShallowerCollision) {
  Evaluation deep = evaluation(Failure::kObstacle, 300.0);
  deep.attempt.clearance = -0.2;
  Evaluation shallow = evaluation(Failure::kSelfCollision, 290.0);
  shallow.attempt.clearance = -0.1;
  EXPECT_GT(rank(shallow), rank(deep));
}

TEST(Rank, DecidesByScoreAmongTheAchieved) {
  EXPECT_GT(rank(evaluation(Failure::kNone, 341.0)), rank(evaluation(Failure::kNone, 340.0)));
}

TEST(Rank, TakesAnErrorThatIsNotANumberForTheWorst) {
  Evaluation broken = evaluation(Failure::kUnreachable, 0.0);
  broken.attempt.relative_error = std::numeric_limits<double>::quiet_NaN();
  EXPECT_LT(rank(broken), rank(evaluation(Failure::kUnreachable, -100.0)));
}

// seed/fixed: a hinge of 0.5 and 1.117 m reaches and scores 350 - 5 * 1.617; two modules score at most 193.
TEST(Rank, SpendsNothingOnTypesThatCannotBeatTheBest) {
  const auto problem = load_problem("seed/fixed");
  const int hinge = problem->library().find("hinge").value();
  Parameters lengths(2);
  lengths << 0.5, std::sqrt(1.25) - 0.0005;
  Meter meter;
  const std::optional<Rank> best = evaluate_rank(meter, *problem, {{{hinge, lengths}}});
  EXPECT_EQ(best->level, Rank::Level::kAchieved);
  const std::optional<Rank> longer = evaluate_rank(meter, *problem, {{{hinge, lengths}, {hinge, lengths}}});
  EXPECT_EQ(longer->level, Rank::Level::kHopeless);
  EXPECT_EQ(meter.progress().evaluations, 1);
}

// Every design but the empty one is achieved and scores 1, and that is known beforehand.
class Flat final : public DesignProblem {
 public:
  explicit Flat(double bound) : library_{load_library("seed")}, bound_{bound} {}
  [[nodiscard]] std::string name() const override { return "flat"; }
  [[nodiscard]] const ModuleLibrary& library() const override { return *library_; }
  [[nodiscard]] int max_modules() const override { return 3; }
  [[nodiscard]] Eigen::VectorXd context() const override { return Eigen::VectorXd::Zero(1); }
  [[nodiscard]] Optimism optimism_of_length(int) const override { return {bound_, "flat"}; }

 private:
  [[nodiscard]] Evaluation do_evaluate(const Design& design, Fidelity) const override {
    return evaluation(design.modules.empty() ? Failure::kUnreachable : Failure::kNone, 1.0);
  }
  std::shared_ptr<const ModuleLibrary> library_;
  double bound_;
};

Design one_link() {
  Parameters length(1);
  length << 1.0;
  return {{{0, length}}};
}

TEST(Pointless, SaysOptimalOnceTheBestMeetsTheBound) {
  const Flat problem{1.0};
  Meter meter;
  EXPECT_FALSE(pointless(meter, problem).has_value());
  ASSERT_TRUE(meter.evaluate(problem, one_link()).has_value());
  const std::optional<SearchEnd> end = pointless(meter, problem);
  ASSERT_TRUE(end.has_value());
  EXPECT_EQ(end->stop, StopReason::kOptimal);
  EXPECT_EQ(end->bound->score, 1.0);
}

TEST(Pointless, SeesAPointWhereTheBoundIsHigher) {
  const Flat problem{1.1};
  Meter meter;
  ASSERT_TRUE(meter.evaluate(problem, one_link()).has_value());
  EXPECT_FALSE(pointless(meter, problem).has_value());
}

TEST(RoundedUp, IsNeverLessThanTheBound) {
  EXPECT_EQ(rounded_up(338.43909250), "338.44");
  EXPECT_EQ(rounded_up(-12.34567891), "-12.3456");
  EXPECT_EQ(rounded_up(100.0), "100");
  EXPECT_EQ(rounded_up(0.0), "0");
  EXPECT_EQ(rounded_up(std::numeric_limits<double>::infinity()), "inf");
}

}  // namespace
}  // namespace modsearch
