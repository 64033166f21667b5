#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <modsearch/baselines/random_search.hpp>
#include <modsearch/study/study_file.hpp>
#include <set>
#include <stdexcept>

#include "problem/temporary_folder.hpp"

namespace modsearch {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// Every solver is random search, but for one that is not known.
StudyNames names() {
  return {.solver = [](const std::string& text) -> StudyNames::NamedSolver {
            if (text == "nobody") throw std::invalid_argument("solver 'nobody' is not one of random");
            return {"canonical " + text, std::make_shared<RandomSearch>()};
          },
          .agent = [](const std::string& text, const ProblemFile& problem) -> StudyNames::NamedAgent {
            return {text, "best", settings_of(AgentKind::kPdqn, Preset::kBest, traits_of(problem))};
          }};
}

constexpr const char* kStudy = R"({
  "modsearch": 1, "name": "test",
  "problems": [{"problem": "seed/fixed"},
               {"problem": "seed/random_wide", "instances": {"seed": 3, "first": 5, "count": 2}}],
  "solvers": [{"solver": "random", "label": "bar"},
              {"solver": "policy", "train": {"agent": "pdqn:preset=best", "episodes": 50, "seeds": [4, 5], "on": "seed/fixed"}}],
  "seeds": {"first": 8, "count": 3},
  "budget": {"evaluations": 100, "seconds": 2.5},
  "targets": {"mass": [1, 10]},
  "certify": {"gap": 0.01, "seconds": 4}
})";

class StudyFile : public ::testing::Test {
 protected:
  [[nodiscard]] Study load(const std::string& text) const {
    return load_study(folder_.write("s.json", text).string(), names());
  }
  /// What is said where `from` stands instead of `what` in the study above.
  [[nodiscard]] std::string refusal(const std::string& what, const std::string& instead) const {
    std::string text = kStudy;
    const std::size_t at = text.find(what);
    if (at == std::string::npos) return "the study has no " + what;
    try {
      static_cast<void>(load(text.replace(at, what.size(), instead)));
    } catch (const FileError& error) {
      return error.what();
    }
    return "none";
  }

  test::TemporaryFolder folder_;
};

TEST_F(StudyFile, SaysWhatIsComparedAndHow) {
  const Study study = load(kStudy);
  EXPECT_EQ(study.name, "test");
  ASSERT_EQ(study.problems.size(), 2U);
  EXPECT_FALSE(study.problems[0].instances.has_value());
  EXPECT_EQ(study.problems[1].instances->seed, 3U);
  EXPECT_EQ(study.problems[1].instances->first, 5U);
  EXPECT_EQ(study.problems[1].instances->count, 2);
  EXPECT_EQ(study.problems[1].make({3, 5})->name(), "seed/random_wide");
  ASSERT_EQ(study.solvers.size(), 2U);
  EXPECT_EQ(study.solvers[0].label, "bar");
  EXPECT_EQ(study.solvers[0].text, "canonical random");
  EXPECT_EQ(study.solvers[1].label, "pdqn:preset=best");
  EXPECT_EQ(study.solvers[1].trainings.at(0).settings.training.episodes, 50);
  EXPECT_EQ(study.solvers[1].trainings.at(0).seeds, (std::vector<std::uint64_t>{4, 5}));
  EXPECT_EQ(study.seeds, (std::vector<std::uint64_t>{8, 9, 10}));
  EXPECT_EQ(study.budget.evaluations, 100);
  EXPECT_EQ(study.budget.seconds, 2.5);
  EXPECT_THAT(study.mass_targets, ElementsAre(10.0, 1.0));
  EXPECT_EQ(study.certification->text, "canonical branch-and-bound:gap=0.01");
  EXPECT_EQ(study.certification->budget.seconds, 4.0);
}

TEST_F(StudyFile, MakesOneCellPerTrainingBoundAndRun) {
  // 2 trainings, 1 + 2 instances, 3 instances x 2 solvers x 3 seeds.
  EXPECT_EQ(cells_of(load(kStudy)).size(), 2U + 3U + 18U);
}

TEST_F(StudyFile, TrainsOnEachProblemWhereItDoesNotSayOnWhich) {
  std::string text = kStudy;
  text.replace(text.find(", \"on\": \"seed/fixed\""), 20, "");
  const std::vector<PlannedCell> cells = cells_of(load(text));
  ASSERT_EQ(cells.size(), 4U + 3U + 18U);  // 2 problems x 2 training seeds
  for (const PlannedCell& cell : cells) {
    if (!cell.needs) continue;
    EXPECT_EQ(cells.at(*cell.needs).record.key.problem, cell.record.key.problem);
  }
}

TEST_F(StudyFile, LetsTwoSolversShareATraining) {
  std::string text = kStudy;
  const std::string policy =
      R"({"solver": "policy", "train": {"agent": "pdqn:preset=best", "episodes": 50, "seeds": [4, 5], "on": "seed/fixed"}})";
  const std::size_t at = text.find(policy);
  ASSERT_NE(at, std::string::npos);
  text.insert(at, policy.substr(0, policy.size() - 1) + ", \"refine\": true}, ");
  const Study study = load(text);
  EXPECT_TRUE(study.solvers.at(1).refine);
  EXPECT_EQ(study.solvers.at(1).label, "pdqn:preset=best, refined");
  const std::vector<PlannedCell> cells = cells_of(study);
  ASSERT_EQ(cells.size(), 2U + 3U + 27U);  // trainings, bounds, runs
  std::set<std::string> runs;
  for (const PlannedCell& cell : cells) {
    if (!cell.needs) continue;
    EXPECT_LT(*cell.needs, 2U);
    runs.insert(cell.record.key.solver);
  }
  EXPECT_EQ(runs.size(), 2U);
}

TEST_F(StudyFile, GivesAnotherNumberOfEpisodesAnotherCell) {
  std::string text = kStudy;
  const std::string before = cells_of(load(text)).at(0).record.id;
  text.replace(text.find("\"episodes\": 50"), 14, "\"episodes\": 51");
  EXPECT_NE(cells_of(load(text)).at(0).record.id, before);
}

TEST_F(StudyFile, NamesProblemFilesRelativeToItself) {
  folder_.write("deep/p.json", R"({"modsearch": 1, "task": "../t.json", "library": "seed", "maxModules": 4,
    "collision": "none", "scoring": {"type": "algorithm1"}})");
  const std::string missing = refusal("seed/fixed", "deep/p.json");
  EXPECT_THAT(missing, HasSubstr("t.json"));  // it got as far as the task, which is not there
  EXPECT_THAT(missing, HasSubstr("s.json: at /problems/0/problem"));
}

TEST_F(StudyFile, NamesTheCulprit) {
  EXPECT_THAT(refusal("\"seeds\": {\"first\"", "\"seed\": {\"first\""), HasSubstr("seed"));
  EXPECT_THAT(refusal("\"count\": 3", "\"count\": 0"), HasSubstr("s.json: at /seeds/count: 0 is not"));
  EXPECT_THAT(refusal("\"solver\": \"random\"", "\"solver\": \"nobody\""),
              HasSubstr("s.json: at /solvers/0/solver: solver 'nobody' is not one of random"));
  EXPECT_THAT(refusal("\"solver\": \"policy\"", "\"solver\": \"random\""),
              HasSubstr("/solvers/1/solver: \"random\" is not \"policy\", which is what is trained"));
  EXPECT_THAT(refusal("seed/fixed", "seed/fixd"), HasSubstr("at /problems/0/problem"));
  EXPECT_THAT(refusal("{\"problem\": \"seed/fixed\"}",
                      "{\"problem\": \"seed/fixed\", \"instances\": {\"seed\": 1, \"count\": 2}}"),
              HasSubstr("is not sampled: it has no instances"));
  EXPECT_THAT(refusal("{\"evaluations\": 100, \"seconds\": 2.5}", "{}"), HasSubstr("a run would never end"));
  EXPECT_THAT(refusal("\"seconds\": 2.5", "\"seconds\": 0"), HasSubstr("at /budget/seconds: 0 is not above 0"));
  EXPECT_THAT(refusal("[1, 10]", "[1, -10]"), HasSubstr("/targets/mass/1"));
  EXPECT_THAT(refusal("\"label\": \"bar\"", "\"label\": \"pdqn:preset=best\""), HasSubstr("occurs twice"));
}

TEST_F(StudyFile, RefusesSeedsAndInstancesBeyondTheLargestNumber) {
  EXPECT_THAT(
      refusal("\"seeds\": {\"first\": 8, \"count\": 3}", "\"seeds\": {\"first\": 18446744073709551615, \"count\": 2}"),
      HasSubstr(
          "s.json: at /seeds: 2 numbers from 18446744073709551615 on end above the largest, 18446744073709551615"));
  EXPECT_THAT(refusal("\"instances\": {\"seed\": 3, \"first\": 5, \"count\": 2}",
                      "\"instances\": {\"seed\": 1, \"first\": 18446744073709551614, \"count\": 3}"),
              HasSubstr("/instances: 3 numbers from 18446744073709551614 on"));
}

TEST_F(StudyFile, TakesTheLargestSeed) {
  std::string text = kStudy;
  const std::string seeds = "\"seeds\": {\"first\": 8, \"count\": 3}";
  const std::size_t at = text.find(seeds);
  ASSERT_NE(at, std::string::npos);
  text.replace(at, seeds.size(), "\"seeds\": {\"first\": 18446744073709551614, \"count\": 2}");
  EXPECT_EQ(load(text).seeds.back(), 18446744073709551615U);
}

TEST(BuiltinStudies, AreStudies) {
  const std::vector<std::string> ids = builtin_studies();
  EXPECT_THAT(ids, ::testing::Contains("quick"));
  for (const std::string& id : ids) EXPECT_FALSE(cells_of(load_study(id, names())).empty()) << id;
  EXPECT_THROW(static_cast<void>(load_study("quik", names())), FileError);
}

}  // namespace
}  // namespace modsearch
