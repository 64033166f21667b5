#include "app/progress.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <modsearch/problem/files.hpp>

namespace modsearch::app {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

// seed/fixed: the target is (1, 0, 1). A link stands upright on its base; a hinge of 1 m and 1 m gets there.
class Fixed {
 public:
  [[nodiscard]] Design link() const { return {{{type("link"), Parameters{{1.0}}}}}; }
  [[nodiscard]] Design hinge() const { return {{{type("hinge"), Parameters{{1.0, 1.0}}}}}; }
  [[nodiscard]] const RobotProblem& problem() const { return *problem_; }

 private:
  [[nodiscard]] int type(const char* id) const { return problem_->library().find(id).value(); }
  std::shared_ptr<const RobotProblem> problem_ = load_problem("seed/fixed");
};

TEST(ProgressText, SaysTheBestTheStageAndWhyTheRestFailed) {
  const Fixed fixed;
  Meter meter;
  EXPECT_THAT(progress_text("random", meter), StartsWith("random: no design yet; 0 evaluations"));
  for (int i = 0; i < 3; ++i) (void)meter.evaluate(fixed.problem(), fixed.link());
  (void)meter.evaluate(fixed.problem(), Design{});
  meter.say("poses: 12 sequences, 1 meets them");
  const std::string failed = progress_text("random", meter);
  EXPECT_THAT(failed, HasSubstr("(not achieved); poses: 12 sequences, 1 meets them; 4 evaluations"));
  EXPECT_THAT(failed, HasSubstr("; failed: 4 proved infeasible"));  // 1 m of arm for a target 1.4 m away
  (void)meter.evaluate(fixed.problem(), fixed.hinge());
  EXPECT_THAT(progress_text("random", meter), Not(HasSubstr("not achieved")));
}

TEST(ProgressDisplay, TellsTheFirstAchievedDesignOnceAndAtOnce) {
  const Fixed fixed;
  ::testing::internal::CaptureStderr();
  {
    ProgressDisplay display{"random", false, &fixed.problem().library()};
    Meter meter{{}, [&](const Meter& m) { display.update(m); }};
    (void)meter.evaluate(fixed.problem(), fixed.link());
    (void)meter.evaluate(fixed.problem(), fixed.hinge());
    (void)meter.evaluate(fixed.problem(), fixed.hinge());
  }
  const std::string told = ::testing::internal::GetCapturedStderr();
  EXPECT_THAT(told, StartsWith("random: first achieved design after "));
  EXPECT_THAT(told, HasSubstr("and 2 evaluations, score 340.0000: hinge(1, 1)"));  // 350 - 5 x 2 kg
  EXPECT_EQ(std::count(told.begin(), told.end(), '\n'), 1);
}

TEST(ProgressDisplay, SaysNothingWhereItIsToBeQuiet) {
  const Fixed fixed;
  ::testing::internal::CaptureStderr();
  {
    ProgressDisplay display{"random", true, &fixed.problem().library()};
    Meter meter{{}, [&](const Meter& m) { display.update(m); }};
    for (int i = 0; i < 40; ++i) (void)meter.evaluate(fixed.problem(), fixed.hinge());
  }
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
}

}  // namespace
}  // namespace modsearch::app
