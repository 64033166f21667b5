#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <modsearch/baselines/per_sequence.hpp>
#include <modsearch/baselines/random_search.hpp>
#include <modsearch/rl/saved_policy.hpp>
#include <modsearch/study/compute_cell.hpp>
#include <modsearch/study/run_study.hpp>
#include <modsearch/study/summary.hpp>
#include <sstream>
#include <thread>

#include "places.hpp"
#include "problem/temporary_folder.hpp"

namespace modsearch {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// A solver made of a function.
class Scripted final : public Solver {
 public:
  using Search = std::function<void(const DesignProblem&, Meter&, Rng)>;
  explicit Scripted(Search search) : search_{std::move(search)} {}
  [[nodiscard]] std::string name() const override { return "scripted"; }

 private:
  [[nodiscard]] SearchEnd do_solve(const DesignProblem& problem, Meter& meter, Rng rng) const override {
    search_(problem, meter, rng);
    return {};
  }
  Search search_;
};

StudySolver scripted(const std::string& name, Scripted::Search search) {
  return {.label = name, .text = name, .solver = std::make_shared<Scripted>(std::move(search))};
}

StudySolver random_solver() {
  return {.label = "random", .text = "random", .solver = std::make_shared<RandomSearch>()};
}

/// Two problems, three instances in all, two solvers, two seeds: twelve runs of some milliseconds.
Study small_study() {
  return {.name = "small",
          .problems = {study_problem("seed/fixed"), study_problem("seed/random_narrow", InstanceRange{.count = 2})},
          .solvers = {random_solver(),
                      {.label = "own",
                       .text = "per-sequence:starts=1",
                       .solver = std::make_shared<PerSequence>(PerSequenceOptions{.starts = 1})}},
          .seeds = {0, 1},
          .budget = {.evaluations = 20}};
}

std::string read(const std::filesystem::path& file) {
  std::ifstream stream{file};
  std::stringstream text;
  text << stream.rdbuf();
  return text.str();
}

/// Every ended cell by its ID.
std::map<std::string, CellRecord> by_id(const StudyRecord& record) {
  std::map<std::string, CellRecord> cells;
  for (const CellRecord& cell : record.cells) cells.emplace(cell.id, cell);
  return cells;
}

/// The same cells with the same results, whatever the clock says.
void expect_same_results(const StudyRecord& a, const StudyRecord& b) {
  const auto cells = by_id(a);
  const auto others = by_id(b);
  ASSERT_EQ(cells.size(), others.size());
  for (const auto& [id, cell] : cells) {
    ASSERT_TRUE(others.contains(id)) << id;
    const CellRecord& other = others.at(id);
    ASSERT_EQ(cell.state, other.state) << id;
    ASSERT_EQ(difference(cell, other), std::nullopt) << id;
    ASSERT_EQ(cell.failure, other.failure) << id;
  }
}

class RunStudy : public ::testing::Test {
 protected:
  [[nodiscard]] std::filesystem::path at(const std::string& name) const { return folder_.path() / name; }
  [[nodiscard]] StudyRecord run_in(const std::string& name, const Study& study, int jobs = 1) const {
    return run(study, {.folder = at(name), .jobs = jobs});
  }
  template <typename Error>
  [[nodiscard]] static std::string refusal(const Study& study, const RunOptions& options) {
    try {
      static_cast<void>(run(study, options));
    } catch (const Error& error) {
      return error.what();
    }
    return "none";
  }

  test::TemporaryFolder folder_;
};

// Tasks 5 and 6 of the generated family; the second is proved infeasible, by whatever solver.
TEST_F(RunStudy, CountsInstancesThatAreProvedInfeasibleApart) {
  Study study{.name = "infeasible",
              .problems = {study_problem("whitman/3g_3o", InstanceRange{.seed = 0, .first = 5, .count = 2})},
              .solvers = {random_solver()},
              .seeds = {0},
              .budget = {.evaluations = 2}};
  const StudyRecord record = run_in("study", study);
  const StudyRuns runs = runs_of(record);
  ASSERT_EQ(runs.instances.size(), 2U);
  EXPECT_EQ(runs.instances[1].certainty(), Certainty::kUnreachable);
  EXPECT_EQ(runs.n_runs(0), 1);
  EXPECT_EQ(summarise(record, runs, Rng{0}).unreachable, 1);
}

TEST_F(RunStudy, SolvesEveryInstanceWithEverySolverAndSeed) {
  const StudyRecord record = run_in("a", small_study());
  ASSERT_EQ(record.cells.size(), 12U);  // (1 + 2) instances x 2 solvers x 2 seeds
  for (const CellRecord& cell : record.cells) EXPECT_EQ(cell.state, CellState::kDone) << cell.failure;
  EXPECT_EQ(record.study.n_cells, 12);
  EXPECT_EQ(record.n_ended(), 12);
}

TEST_F(RunStudy, GivesWhatTheSolverGivesByItself) {
  const StudyRecord record = run_in("a", small_study());
  const auto cell = std::find_if(record.cells.begin(), record.cells.end(), [](const CellRecord& c) {
    return c.key.label == "random" && c.key.seed == 1 && c.key.instance && c.key.instance->index == 1;
  });
  ASSERT_NE(cell, record.cells.end());
  const auto problem = load_problem("seed/random_narrow", {.seed = 1, .index = 1});
  Meter meter{{.evaluations = 20}};
  const Solution alone = RandomSearch{}.solve(*problem, meter, Rng{1});
  EXPECT_EQ(cell->outcome->score, alone.evaluation.score);
  EXPECT_EQ(design_of(problem->library(), cell->outcome->design), alone.design);
  ASSERT_EQ(cell->trace.size(), meter.trace().size());
  EXPECT_EQ(cell->trace.back().modules, static_cast<int>(alone.design.modules.size()) + 1);
  EXPECT_EQ(cell->trace.back().mass, problem->chain(alone.design.types())->mass(alone.design.parameters()));
}

TEST_F(RunStudy, CountsAPlacedBaseOnce) {
  Study study = small_study();
  study.problems = {study_problem((test::source_folder() / "examples/tasks/placed_base.json").string())};
  study.solvers = {study.solvers.back()};
  study.seeds = {0};
  const StudyRecord record = run_in("a", study);
  ASSERT_EQ(record.cells.size(), 1U);
  ASSERT_EQ(record.cells.front().state, CellState::kDone);
  const CellOutcome& outcome = record.cells.front().outcome.value();
  ASSERT_FALSE(outcome.design.modules.empty());
  EXPECT_EQ(outcome.design.modules.front().type, "base");
  EXPECT_EQ(outcome.modules, static_cast<int>(outcome.design.modules.size()));
  EXPECT_EQ(record.cells.front().trace.back().modules, outcome.modules);
}

TEST_F(RunStudy, DoesNotDependOnTheNumberOfJobsOrTheOrder) {
  const StudyRecord one = run_in("one", small_study(), 1);
  expect_same_results(one, run_in("two", small_study(), 2));
  Study reversed = small_study();
  std::reverse(reversed.problems.begin(), reversed.problems.end());
  std::reverse(reversed.solvers.begin(), reversed.solvers.end());
  std::reverse(reversed.seeds.begin(), reversed.seeds.end());
  expect_same_results(one, run_in("reversed", reversed, 3));
}

TEST_F(RunStudy, EndsAlikeWhereverItsJournalIsCut) {
  const Study study = small_study();
  const StudyRecord whole = run_in("whole", study);
  const std::string journal = read(at("whole") / "events.jsonl");
  constexpr std::size_t kPoints = 100;
  for (std::size_t i = 0; i < kPoints; ++i) {
    const std::size_t size = i * journal.size() / (kPoints - 1);
    const std::filesystem::path folder = at("cut " + std::to_string(i));
    std::filesystem::create_directories(folder);
    std::ofstream{folder / "events.jsonl"} << journal.substr(0, size);
    const std::string kept = journal.substr(0, journal.substr(0, size).rfind('\n') + 1);

    const StudyRecord resumed = run(study, {.folder = folder, .jobs = 2, .resume = true});
    expect_same_results(whole, resumed);
    const std::string after = read(folder / "events.jsonl");
    ASSERT_TRUE(after.starts_with(kept)) << "a finished line was lost when cut at " << size;
    std::size_t n_done = 0;
    for (std::size_t found = after.find("\"event\":\"done\""); found != std::string::npos;
         found = after.find("\"event\":\"done\"", found + 1)) {
      ++n_done;
    }
    ASSERT_EQ(n_done, 12U) << "a finished cell was computed again when cut at " << size;
  }
}

TEST_F(RunStudy, EndsAlikeAfterItWasKilled) {
  const Study study = small_study();
  const StudyRecord whole = run_in("whole", study);
  const std::filesystem::path file = at("killed") / "events.jsonl";
  // Each time it is killed as soon as it has got further than the last time.
  for (std::uintmax_t size = 0; size < std::filesystem::file_size(at("whole") / "events.jsonl") / 2;) {
    const ::pid_t child = ::fork();
    if (child == 0) {
      static_cast<void>(run(study, {.folder = at("killed"), .jobs = 2, .resume = true}));
      ::_exit(0);
    }
    std::error_code error;
    std::uintmax_t now = 0;
    while (::waitpid(child, nullptr, WNOHANG) == 0) {
      now = std::filesystem::file_size(file, error);
      if (error || now <= size + 1000) continue;
      ::kill(child, SIGKILL);
      ::waitpid(child, nullptr, 0);
      break;
    }
    size = std::filesystem::file_size(file);
  }
  expect_same_results(whole, run(study, {.folder = at("killed"), .resume = true}));
}

TEST_F(RunStudy, RecordsACellThatCrashesAndGoesOn) {
  Study study = small_study();
  study.problems.resize(1);
  study.seeds = {0};
  study.solvers = {scripted("crashes", [](const DesignProblem&, Meter&, Rng) { std::raise(SIGSEGV); }),
                   scripted("throws", [](const DesignProblem&, Meter&, Rng) { throw std::runtime_error("no luck"); }),
                   scripted("leaves", [](const DesignProblem&, Meter&, Rng) { ::_exit(3); }),
                   scripted("eats", [](const DesignProblem&, Meter&, Rng) { throw std::bad_alloc{}; }),
                   random_solver()};
  const StudyRecord record = run_in("a", study, 2);
  ASSERT_EQ(record.cells.size(), 5U);
  EXPECT_EQ(record.cells[0].signal, SIGSEGV);
  EXPECT_THAT(record.cells[0].failure, HasSubstr("killed by signal 11"));
  EXPECT_EQ(record.cells[1].failure, "no luck");
  EXPECT_THAT(record.cells[2].failure, HasSubstr("status 3"));
  EXPECT_EQ(record.cells[3].state, CellState::kFailed);
  EXPECT_EQ(record.cells[4].state, CellState::kDone);
}

TEST_F(RunStudy, TriesFailedCellsAgainWhenItIsResumed) {
  const std::filesystem::path mark = at("mark");
  Study study = small_study();
  study.problems.resize(1);
  study.seeds = {0};
  study.solvers = {scripted("second time lucky", [mark](const DesignProblem& problem, Meter& meter, Rng rng) {
    if (!std::filesystem::exists(mark)) throw std::runtime_error("no luck");
    static_cast<void>(RandomSearch{}.solve(problem, meter, rng));
  })};
  EXPECT_EQ(run_in("a", study).cells.at(0).state, CellState::kFailed);
  std::ofstream{mark} << "there";
  const StudyRecord resumed = run(study, {.folder = at("a"), .resume = true});
  EXPECT_EQ(resumed.cells.at(0).state, CellState::kDone);
  EXPECT_EQ(resumed.cells.at(0).outcome->spent.evaluations, 20);
}

TEST_F(RunStudy, StopsWithAReportWhereACellComesOutDifferently) {
  const std::filesystem::path count = at("count");
  // Evaluates one design more each time it is called.
  const auto nondeterministic = [count](const DesignProblem& problem, Meter& meter, Rng rng) {
    std::ofstream{count, std::ios::app} << 'x';
    const Design design = random_design(problem, rng);
    for (std::uintmax_t i = 0; i < std::filesystem::file_size(count); ++i) {
      static_cast<void>(meter.evaluate(problem, design));
    }
  };
  Study study = small_study();
  study.problems.resize(1);
  study.seeds = {5};
  study.solvers = {scripted("moody", nondeterministic)};
  const std::string complaint = refusal<StudyContradiction>(study, {.folder = at("a"), .recheck = 1});
  EXPECT_THAT(complaint,
              HasSubstr("run of moody on seed/fixed with seed 5) was computed twice with different results"));
  EXPECT_THAT(complaint, HasSubstr(": 1 and 7"));  // a short search is done five times more for its clock
}

TEST_F(RunStudy, ChecksCellsAgainWithoutChangingTheJournal) {
  const Study study = small_study();
  static_cast<void>(run_in("a", study));
  const std::string before = read(at("a") / "events.jsonl");
  static_cast<void>(run(study, {.folder = at("a"), .resume = true, .recheck = 100}));
  EXPECT_EQ(read(at("a") / "events.jsonl"), before);
}

TEST_F(RunStudy, LeavesRunsThatAreBoundedByTimeOutOfTheComparison) {
  Study study = small_study();
  study.problems.resize(1);
  study.seeds = {0};
  study.budget = {.evaluations = 20, .seconds = 60.0};
  const std::filesystem::path count = at("count");
  study.solvers = {scripted("moody", [count](const DesignProblem& problem, Meter& meter, Rng rng) {
    std::ofstream{count, std::ios::app} << 'x';
    static_cast<void>(meter.evaluate(problem, random_design(problem, rng)));
  })};
  const StudyRecord record = run(study, {.folder = at("a"), .recheck = 1});
  EXPECT_TRUE(record.cells.at(0).key.timed());
  EXPECT_EQ(std::filesystem::file_size(count), 1U);  // not computed again
}

TEST_F(RunStudy, RefusesAJournalThatIsThereAlready) {
  static_cast<void>(run_in("a", small_study()));
  EXPECT_THAT(refusal<FileError>(small_study(), {.folder = at("a")}), HasSubstr("is there already"));
}

TEST_F(RunStudy, RefusesToGoOnWithAnotherStudysJournal) {
  static_cast<void>(run_in("a", small_study()));
  Study other = small_study();
  other.budget.evaluations = 21;
  EXPECT_THAT(refusal<FileError>(other, {.folder = at("a"), .resume = true}), HasSubstr("would not belong together"));
}

TEST_F(RunStudy, StopsWhenAskedAndGoesOnLater) {
  std::stop_source source;
  const Study study = small_study();
  const StudyRecord part = run(study, {.folder = at("a"),
                                       .progress =
                                           [&](const StudyProgress& progress) {
                                             if (progress.n_ended == 3) source.request_stop();
                                           },
                                       .stop = source.get_token()});
  EXPECT_EQ(part.n_ended(), 3);
  expect_same_results(run_in("whole", study), run(study, {.folder = at("a"), .resume = true}));
}

TEST_F(RunStudy, TellsHowFarItHasCome) {
  std::vector<std::int64_t> ended;
  std::optional<double> left;
  static_cast<void>(run(small_study(), {.folder = at("a"), .progress = [&](const StudyProgress& progress) {
                                          EXPECT_EQ(progress.n_cells, 12);
                                          if (ended.empty() || ended.back() != progress.n_ended) {
                                            ended.push_back(progress.n_ended);
                                          }
                                          left = progress.left;
                                        }}));
  EXPECT_THAT(ended, ElementsAre(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12));
  EXPECT_EQ(left, 0.0);
}

/// An agent of a few dozen episodes on the fixed problem.
StudySolver small_agent(std::vector<std::uint64_t> seeds) {
  const ProblemFile family = load_problem_file("seed/fixed");
  LearnerSettings settings = settings_of(AgentKind::kMpdqn, Preset::kBest, traits_of(family));
  settings.training.episodes = 60;
  return {.label = "agent",
          .text = "mpdqn:preset=best,episodes=60",
          .trainings = {StudyTraining{.problem = "seed/fixed",
                                      .source = problem_source(family),
                                      .library = family.spec.library,
                                      .settings = settings,
                                      .preset = "best",
                                      .seeds = std::move(seeds)}}};
}

TEST_F(RunStudy, TrainsEachAgentOncePerTrainingSeedAndUsesItsPolicy) {
  Study study = small_study();
  study.problems.resize(1);
  study.solvers = {small_agent({7, 8})};
  study.seeds = {0, 1, 2};
  const StudyRecord record = run_in("a", study, 2);
  ASSERT_EQ(record.cells.size(), 5U);
  for (const CellRecord& cell : record.cells) EXPECT_EQ(cell.state, CellState::kDone) << cell.failure;
  EXPECT_EQ(record.cells[0].key.kind, CellKind::kTraining);
  EXPECT_EQ(record.cells[0].key.seed, 7U);
  EXPECT_EQ(record.cells[0].outcome->training->episodes, 60);
  EXPECT_GT(record.cells[0].outcome->spent.evaluations, 60);
  // Seeds 0, 1, 2 use the policies of 7, 8, 7.
  EXPECT_EQ(record.cells[2].key.training, record.cells[0].id);
  EXPECT_EQ(record.cells[3].key.training, record.cells[1].id);
  EXPECT_EQ(record.cells[4].key.training, record.cells[0].id);
  // A policy that is used by itself does the same.
  const auto problem = load_problem("seed/fixed");
  Meter meter{study.budget};
  const Solution alone =
      load_trained_policy(at("a") / record.cells[1].outcome->training->policy)->solve(*problem, meter, Rng{1});
  EXPECT_EQ(record.cells[3].outcome->score, alone.evaluation.score);
}

TEST_F(RunStudy, TrainsAgainToTheSameWeights) {
  Study study = small_study();
  study.problems.resize(1);
  study.solvers = {small_agent({7})};
  const StudyRecord record = run(study, {.folder = at("a"), .recheck = 1});
  std::filesystem::remove_all(at("a") / "policies");  // somebody tidied up
  expect_same_results(record, run(study, {.folder = at("a"), .resume = true}));
  EXPECT_TRUE(std::filesystem::exists(at("a") / record.cells[0].outcome->training->policy));
}

TEST_F(RunStudy, FailsTheRunsOfAnAgentWhoseTrainingFailed) {
  Study study = small_study();
  study.problems.resize(1);
  study.solvers = {small_agent({7})};
  study.solvers[0].trainings[0].source = [](Rng) -> std::shared_ptr<const DesignProblem> {
    throw std::runtime_error("nothing to learn from");
  };
  const StudyRecord record = run_in("a", study);
  EXPECT_EQ(record.cells.at(0).failure, "nothing to learn from");
  EXPECT_THAT(record.cells.at(1).failure, HasSubstr("its training, cell " + record.cells.at(0).id + ", failed"));
}

/// Says what it knows of any problem: that nothing scores more than 400.
class Boundary final : public Solver {
 public:
  [[nodiscard]] std::string name() const override { return "boundary"; }

 private:
  [[nodiscard]] SearchEnd do_solve(const DesignProblem&, Meter&, Rng) const override {
    return {StopReason::kExhausted, "", Bound{400.0, "by assumption"}};
  }
};

TEST_F(RunStudy, BoundsEachInstanceOnce) {
  Study study = small_study();
  study.certification = StudyCertification{.text = "boundary", .solver = std::make_shared<Boundary>()};
  const StudyRecord record = run_in("a", study);
  const auto n_bounds = std::count_if(record.cells.begin(), record.cells.end(), [](const CellRecord& cell) {
    return cell.key.kind == CellKind::kBound && cell.outcome->bound && cell.outcome->bound->score == 400.0;
  });
  EXPECT_EQ(n_bounds, 3);
}

}  // namespace
}  // namespace modsearch
