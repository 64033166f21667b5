#include <gtest/gtest.h>

#include <modsearch/baselines/per_sequence.hpp>
#include <modsearch/problem/convert.hpp>
#include <modsearch/problem/files.hpp>
#include <modsearch/rl/training_csv.hpp>
#include <modsearch/study/run_study.hpp>
#include <modsearch/study/study_csv.hpp>
#include <modsearch/study/summary_markdown.hpp>

#include "german_locale.hpp"
#include "problem/temporary_folder.hpp"

namespace modsearch {
namespace {

/// Without what a clock has said.
StudyRecord timeless(StudyRecord record) {
  for (CellRecord& cell : record.cells) {
    for (Improvement& point : cell.trace) point.seconds = 0.25;
    if (!cell.outcome) continue;
    cell.outcome->spent.seconds = cell.outcome->cpu_seconds = 0.25;
  }
  return record;
}

/// Everything that a program can write, one text after the other.
std::string everything(const std::filesystem::path& folder) {
  const std::shared_ptr<const RobotProblem> problem = load_problem("seed/fixed");
  Study study{.name = "small",
              .problems = {study_problem("seed/fixed")},
              .solvers = {{.label = "own",
                           .text = "per-sequence:starts=1",
                           .solver = std::make_shared<PerSequence>(PerSequenceOptions{.starts = 1})}},
              .budget = {.evaluations = 20}};
  const StudyRecord record = timeless(run(study, {.folder = folder}));
  const DesignRecord& design = record.cells.at(0).outcome->design;

  SolutionRecord solution;
  solution.problem = "seed/fixed";
  solution.design = design_of(problem->library(), design);
  solution.evaluation = problem->evaluate(solution.design);
  solution.seconds = 0.25;
  std::string text = runs_csv(record) + traces_csv(record) + summary_markdown(record);
  text += solution_to_json(*problem, solution) + design_to_json(problem->library(), solution.design);
  write_file(folder / "design.json", design_to_json(problem->library(), solution.design));
  text += convert((folder / "design.json").string(), {.to = FileFormat::kUrdf, .library = "seed", .folder = folder});
  text += convert("seed", {.folder = folder});
  EvaluationPoint point;
  point.epsilon = 0.125;
  TrainingCsv{folder / "training.csv"}.append(point);
  return text + test::text_of(folder / "training.csv");
}

TEST(Locale, ChangesNoByteOfWhatIsWritten) {
  const test::TemporaryFolder folder;
  const std::string plain = everything(folder.path() / "plain");
  const test::GermanLocale german;
  if (!test::GermanLocale::is_set()) GTEST_SKIP() << "no locale with a decimal comma, and none can be made";
  EXPECT_EQ(everything(folder.path() / "german"), plain);
  // What was written is read as it was meant, too.
  EXPECT_EQ(load_training_csv(folder.path() / "german/training.csv").at(0).epsilon, 0.125);
  EXPECT_EQ(runs_csv(timeless(read_journal(folder.path() / "german/events.jsonl"))),
            runs_csv(timeless(read_journal(folder.path() / "plain/events.jsonl"))));
}

}  // namespace
}  // namespace modsearch
