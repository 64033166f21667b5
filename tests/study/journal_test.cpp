#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <limits>
#include <modsearch/study/journal.hpp>
#include <sstream>

#include "problem/temporary_folder.hpp"

namespace modsearch {
namespace {

using ::testing::HasSubstr;

constexpr std::int64_t kNoLimit = std::numeric_limits<std::int64_t>::max();

StudyFacts some_study() {
  return {.name = "three cells",
          .hash = "0123456789abcdef",
          .version = "0.1.0",
          .command = "modsearch compare three.json --out 'a folder'",
          .compiler = "a compiler 1.0",
          .instruction_set = "avx2",
          .n_cells = 3,
          .problems = {{"seed/fixed", "seed/fixed", {}}, {"own", "", {{7, 0}, {7, 1}}}},
          .solvers = {{"random", "random", false}, {"agent", "mpdqn:preset=best", true}},
          .seeds = {3, 4},
          .budget = {.evaluations = 100},
          .mass_targets = {5.0, 0.1}};
}

CellRecord started(const std::string& id, std::int64_t number) {
  CellRecord cell;
  cell.id = id;
  cell.number = number;
  cell.key = {.kind = CellKind::kRun,
              .problem = "own",
              .instance = Instance{7, 18446744073709551615U},
              .label = "random",
              .solver = "random",
              .seed = 3,
              .budget = {.evaluations = 100},
              .training = ""};
  return cell;
}

CellRecord done(const std::string& id, std::int64_t number) {
  CellRecord cell = started(id, number);
  cell.state = CellState::kDone;
  // 0.1 + 0.2 needs all 17 digits.
  cell.trace = {{1, 0.5, -0.25, false, 3, 2.5}, {40, 0.75, 0.1 + 0.2, true, 2, 1.5}};
  CellOutcome outcome;
  outcome.design = {{{"hinge", {{"distal", 1.0 / 3.0}, {"proximal", 0.5}}}, {"link", {{"length", 0.7}}}}};
  outcome.witness.postures = Eigen::Matrix2d{{1.0 / 3.0, -0.5}, {2.0, 0.0}};
  outcome.score = 0.1 + 0.2;
  outcome.achieved = outcome.reached = true;
  outcome.goal_error = 1e-3;
  outcome.modules = 2;
  outcome.mass = 1.5;
  outcome.terms = {{"reached", 350.0}, {"mass", -8.0}};
  outcome.spent = {.evaluations = 100,
                   .failed = 1,
                   .program_evaluations = 12,
                   .work = {.forward = 1, .ik_iterations = 2, .distances = 3, .planner_states = 4},
                   .seconds = 1.25};
  outcome.cpu_seconds = 1.125;
  outcome.stop = "evaluations";
  outcome.reason = "a \"reason\"\nof two lines";
  outcome.bound = Bound{0.5, "by hand"};
  cell.outcome = outcome;
  return cell;
}

void expect_equal(const CellRecord& a, const CellRecord& b) {
  EXPECT_EQ(a.id, b.id);
  EXPECT_EQ(a.number, b.number);
  EXPECT_EQ(a.state, b.state);
  EXPECT_EQ(a.key.problem, b.key.problem);
  EXPECT_EQ(a.key.instance->index, b.key.instance->index);
  EXPECT_EQ(a.key.seed, b.key.seed);
  EXPECT_EQ(a.key.budget.evaluations, b.key.budget.evaluations);
  EXPECT_EQ(a.key.budget.seconds, b.key.budget.seconds);
  EXPECT_EQ(difference(a, b), std::nullopt);
  EXPECT_EQ(a.outcome->design, b.outcome->design);
  EXPECT_EQ(a.outcome->witness.postures, b.outcome->witness.postures);
  EXPECT_EQ(a.outcome->terms, b.outcome->terms);
  EXPECT_EQ(a.outcome->spent.seconds, b.outcome->spent.seconds);
  EXPECT_EQ(a.outcome->cpu_seconds, b.outcome->cpu_seconds);
  EXPECT_EQ(a.outcome->bound->score, b.outcome->bound->score);
}

class JournalTest : public ::testing::Test {
 protected:
  [[nodiscard]] std::string text() const {
    std::ifstream stream{file_};
    std::stringstream all;
    all << stream.rdbuf();
    return all.str();
  }
  void replace_text(const std::string& text) const { std::ofstream{file_} << text; }
  [[nodiscard]] std::string refusal() const {
    try {
      static_cast<void>(read_journal(file_));
    } catch (const FileError& error) {
      return error.what();
    }
    return "none";
  }

  test::TemporaryFolder folder_;
  std::filesystem::path file_ = folder_.path() / "events.jsonl";
};

TEST_F(JournalTest, ReadsBackWhatWasWrittenToTheLastBit) {
  {
    Journal journal = Journal::begin(file_, some_study());
    journal.start(done("a", 0));
    journal.finish(done("a", 0));
  }
  const StudyRecord record = read_journal(file_);
  EXPECT_EQ(record.study.name, "three cells");
  EXPECT_EQ(record.study.command, "modsearch compare three.json --out 'a folder'");
  EXPECT_EQ(record.study.n_cells, 3);
  EXPECT_EQ(record.study.problems.at(1).instances.at(1).index, 1U);
  EXPECT_EQ(record.study.solvers.at(1).label, "agent");
  EXPECT_TRUE(record.study.solvers.at(1).trained);
  EXPECT_EQ(record.study.seeds, (std::vector<std::uint64_t>{3, 4}));
  EXPECT_EQ(record.study.mass_targets, (std::vector<double>{5.0, 0.1}));
  ASSERT_EQ(record.cells.size(), 1U);
  expect_equal(record.cells[0], done("a", 0));
}

TEST_F(JournalTest, KeepsWhatATrainingTells) {
  CellRecord cell = started("t", 0);
  cell.key.kind = CellKind::kTraining;
  cell.key.instance.reset();
  cell.key.budget = {.evaluations = kNoLimit};
  cell.state = CellState::kDone;
  cell.outcome.emplace();
  cell.outcome->training = TrainingFacts{600, 700, 800, 341.5, "policies/t.json", "fedcba9876543210"};
  {
    Journal journal = Journal::begin(file_, some_study());
    journal.start(cell);
    journal.finish(cell);
  }
  const StudyRecord record = read_journal(file_);
  const CellRecord* read = record.find("t");
  ASSERT_NE(read, nullptr);
  EXPECT_EQ(read->key.kind, CellKind::kTraining);
  EXPECT_FALSE(read->key.instance.has_value());
  EXPECT_FALSE(read->key.timed());
  EXPECT_EQ(read->key.budget.evaluations, kNoLimit);
  EXPECT_EQ(read->outcome->training->updates, 800);
  EXPECT_EQ(read->outcome->training->policy, "policies/t.json");
  EXPECT_EQ(read->outcome->training->weights, "fedcba9876543210");
}

TEST_F(JournalTest, KeepsWhyACellFailed) {
  CellRecord cell = started("f", 2);
  cell.state = CellState::kFailed;
  cell.failure = "killed by signal 11 (Segmentation fault)";
  cell.signal = 11;
  {
    Journal journal = Journal::begin(file_, some_study());
    journal.start(cell);
    journal.finish(cell);
  }
  const CellRecord read = read_journal(file_).cells.at(0);
  EXPECT_EQ(read.state, CellState::kFailed);
  EXPECT_EQ(read.signal, 11);
  EXPECT_EQ(read.failure, cell.failure);
}

TEST_F(JournalTest, IsReadInTheOrderOfTheStudyWhateverEndedFirst) {
  {
    Journal journal = Journal::begin(file_, some_study());
    for (const std::int64_t number : {2, 0, 1}) journal.start(started(std::to_string(number), number));
    for (const std::int64_t number : {1, 2}) journal.finish(done(std::to_string(number), number));
  }
  const StudyRecord record = read_journal(file_);
  ASSERT_EQ(record.cells.size(), 3U);
  EXPECT_EQ(record.cells[0].id, "0");
  EXPECT_EQ(record.cells[0].state, CellState::kStarted);
  EXPECT_EQ(record.cells[2].id, "2");
  EXPECT_EQ(record.cells[2].state, CellState::kDone);
}

TEST_F(JournalTest, LosesNothingButTheTornLineWhereverItIsCut) {
  {
    Journal journal = Journal::begin(file_, some_study());
    journal.start(done("a", 0));
    journal.finish(done("a", 0));
  }
  const std::string whole = text();
  const std::size_t header = whole.find('\n') + 1;
  const std::size_t start = whole.find('\n', header) + 1;
  for (std::size_t size = header; size <= whole.size(); ++size) {
    replace_text(whole.substr(0, size));
    const StudyRecord record = read_journal(file_);
    ASSERT_EQ(record.cells.size(), size < start ? 0U : 1U) << size;
    if (record.cells.empty()) continue;
    ASSERT_EQ(record.cells[0].state, size < whole.size() ? CellState::kStarted : CellState::kDone) << size;
  }
}

TEST_F(JournalTest, GoesOnAfterATornLine) {
  {
    Journal journal = Journal::begin(file_, some_study());
    journal.start(done("a", 0));
    journal.finish(done("a", 0));
  }
  std::filesystem::resize_file(file_, std::filesystem::file_size(file_) - 1);  // only the end of the line is missing
  EXPECT_EQ(read_journal(file_).cells.at(0).state, CellState::kStarted);
  {
    Journal journal = Journal::resume(file_);
    journal.start(done("a", 0));
    journal.finish(done("a", 0));
  }
  const StudyRecord record = read_journal(file_);
  ASSERT_EQ(record.cells.size(), 1U);
  expect_equal(record.cells[0], done("a", 0));  // the improvements of the torn computation are not counted twice
}

TEST_F(JournalTest, IsNeverOverwritten) {
  static_cast<void>(Journal::begin(file_, some_study()));
  EXPECT_THROW(static_cast<void>(Journal::begin(file_, some_study())), FileError);
}

TEST_F(JournalTest, RefusesACellThatWasDoneTwiceWithDifferentResults) {
  CellRecord other = done("a", 0);
  other.outcome->score = 0.25;
  {
    Journal journal = Journal::begin(file_, some_study());
    journal.start(done("a", 0));
    journal.finish(done("a", 0));
    journal.start(other);
    journal.finish(other);
  }
  EXPECT_THAT(refusal(), HasSubstr("cell a was done twice with different results: score: 0.30000000000000004 and 0.25"));
}

TEST_F(JournalTest, AcceptsCellsBoundedByTimeThatDiffer) {
  CellRecord first = done("a", 0);
  first.key.budget.seconds = 1.0;
  CellRecord second = first;
  second.outcome->score = 0.25;
  {
    Journal journal = Journal::begin(file_, some_study());
    for (const CellRecord& cell : {first, second}) {
      journal.start(cell);
      journal.finish(cell);
    }
  }
  EXPECT_EQ(read_journal(file_).cells.at(0).outcome->score, first.outcome->score);
}

TEST_F(JournalTest, NamesTheLineThatIsNoneOfAJournals) {
  static_cast<void>(Journal::begin(file_, some_study()));
  const std::string header = text();
  replace_text(header + "{\"cell\": \"a\", \"event\": \"done\"}\n");
  EXPECT_THAT(refusal(), HasSubstr("line 2: at /cell: \"a\" is not a cell that was started"));
  replace_text(header + "{]\n");
  EXPECT_THAT(refusal(), HasSubstr("events.jsonl: line 2"));
  replace_text("");
  EXPECT_THAT(refusal(), HasSubstr("is empty, not the journal of a study"));
}

TEST(Difference, LooksAtResultsAndNotAtTheClock) {
  const CellRecord first = done("a", 0);
  CellRecord second = first;
  second.outcome->spent.seconds = 99.0;
  second.outcome->cpu_seconds = 98.0;
  second.trace[1].seconds = 97.0;
  EXPECT_EQ(difference(first, second), std::nullopt);
  second.trace[1].evaluations = 41;
  EXPECT_THAT(difference(first, second).value_or("none"), HasSubstr("trace"));
}

TEST(DesignRecords, AreTheDesignAgain) {
  const auto library = load_library("seed");
  const Design design{{{*library->find("hinge"), Parameters{{0.5, 1.25}}}, {*library->find("link"), Parameters{{0.75}}}}};
  const DesignRecord record = record_of(*library, design);
  EXPECT_EQ(record.modules.at(0).parameters.at("distal"), 1.25);
  EXPECT_EQ(design_of(*library, record), design);
}

TEST(DesignRecords, NameTheModuleThatALibraryDoesNotHave) {
  const auto library = load_library("seed");
  try {
    static_cast<void>(design_of(*library, {{{"elbow", {}}}}));
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_THAT(error.what(), HasSubstr("has no module 'elbow'"));
  }
}

}  // namespace
}  // namespace modsearch
