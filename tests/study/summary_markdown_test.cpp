#include <gmock/gmock.h>

#include <algorithm>
#include <limits>
#include <modsearch/study/duration_text.hpp>
#include <modsearch/study/summary_markdown.hpp>
#include <sstream>

#include "study/synthetic_study.hpp"

namespace modsearch {
namespace {

using ::testing::HasSubstr;

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream{text};
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

TEST(SummaryMarkdown, HasATablePerProblemWithARowPerSolver) {
  const std::vector<std::string> lines = lines_of(summary_markdown(testing::synthetic_study()));
  int tables = 0;
  std::ptrdiff_t bars = 0;
  int rows = 0;
  int breaks = 0;
  for (const std::string& line : lines) {
    if (line.starts_with("### ")) ++tables;
    if (!line.starts_with("|")) continue;
    const std::ptrdiff_t own = std::count(line.begin(), line.end(), '|');
    if (line.starts_with("| solver") || line.starts_with("| trained")) bars = own;
    breaks += line.starts_with("| trained");
    EXPECT_EQ(own, bars) << line;
    rows += line.starts_with("| steady") + line.starts_with("| slow") + line.starts_with("| agent | 0 %") +
            line.starts_with("| agent | 100 %");
  }
  EXPECT_EQ(tables, 2);
  EXPECT_EQ(rows, 6);
  EXPECT_EQ(breaks, 2);
}

TEST(SummaryMarkdown, TellsTheTargetsAndWhatRegretIsMeasuredFrom) {
  const std::string text = summary_markdown(testing::synthetic_study());
  EXPECT_THAT(text, HasSubstr("mass within 10 %: runs"));
  EXPECT_THAT(text, HasSubstr("mass within 1 %: runs"));
  EXPECT_THAT(text, ::testing::Not(HasSubstr("mass within 5 %")));
  // The agent is 3 % too heavy: it meets 10 % in 2 evaluations and 1 % never.
  EXPECT_THAT(text, ::testing::ContainsRegex("\\| agent .*\\| 100 % \\| 2 \\| 400 us \\|.*∞"));
  EXPECT_THAT(text, HasSubstr("15 instances: 0 with a certified optimum, 15 with a certified bound"));
  EXPECT_THAT(text, HasSubstr("15 instances: 0 with a certified optimum, 0 with a certified bound"));
}

TEST(SummaryMarkdown, SaysFromHowManyTasksOnTrainingPays) {
  // The agent's training takes 20 000 evaluations, a use 2. It is 3 % too heavy, so at 1 % it never pays.
  const std::string text = summary_markdown(testing::synthetic_study());
  EXPECT_THAT(text, HasSubstr("| agent | fewest modules | 100 % | 2 |"));
  EXPECT_THAT(text, ::testing::ContainsRegex("\\| agent \\| mass within 10 % \\| 100 % \\| 2 \\| [0-9]+ tasks, against "
                                             "steady \\([0-9.]+\\) \\| [0-9]+ tasks, against steady"));
  EXPECT_THAT(text, HasSubstr("Met in less than half of the runs, and not compared from there on: agent (mass within 1 %, 0 %)."));
  EXPECT_THAT(text, ::testing::Not(HasSubstr("| agent | mass within 1 %")));
}

TEST(DurationText, TakesTheUnitThatFits) {
  EXPECT_EQ(duration_text(1.234e-5), "12.3 us");
  EXPECT_EQ(duration_text(0.99949e-3), "999 us");
  EXPECT_EQ(duration_text(0.99951e-3), "1 ms");
  EXPECT_EQ(duration_text(12.34), "12.3 s");
  EXPECT_EQ(duration_text(std::numeric_limits<double>::infinity()), "∞");
}

TEST(SummaryMarkdown, ShowsAllTargetsOfMassWhereTheStudyHasNeitherTenNorOne) {
  StudyRecord record = testing::synthetic_study();
  record.study.mass_targets = {20, 5};
  EXPECT_THAT(summary_markdown(record), HasSubstr("mass within 5 %: runs"));
}

}  // namespace
}  // namespace modsearch
