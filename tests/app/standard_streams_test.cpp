#include "app/standard_streams.hpp"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <functional>
#include <nlohmann/json.hpp>
#include <set>

#include "app/command.hpp"
#include "app/progress_line.hpp"

namespace modsearch::app {
namespace {

using ::testing::HasSubstr;
using testing::modsearch;
using testing::read_text;
using testing::shell;
using testing::TemporaryFolder;

constexpr const char* kStudy = R"({
  "modsearch": 1, "name": "tiny", "problems": [{"problem": "seed/fixed"}],
  "solvers": [{"solver": "random"}, {"solver": "policy", "train": {"agent": "mpdqn:preset=best", "episodes": 30}}],
  "seeds": {"first": 0, "count": 2}, "budget": {"evaluations": 30}
})";

/// What `body` makes of its own standard streams, in a process of its own: its exit status.
int alone(const std::function<int()>& body) {
  const pid_t child = fork();
  if (child == 0) {
    alarm(60);  // what waits for ever shall not
    _exit(body());
  }
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
}

TEST(StandardStreams, KeepFilesFromGettingTheNumbersOfClosedOnes) {
  for (const std::vector<int>& closed : {std::vector{0, 1, 2}, {0}, {1}, {2}, {0, 2}}) {
    EXPECT_EQ(alone([&] {
                for (const int descriptor : closed) close(descriptor);
                secure_standard_streams();
                return open("/dev/null", O_RDWR) > STDERR_FILENO ? 0 : 1;
              }),
              0);
  }
}

TEST(StandardStreams, DoNotCallItSuccessToWriteToAClosedOutput) {
  EXPECT_EQ(alone([] {
              close(STDOUT_FILENO);
              secure_standard_streams();
              return write(STDOUT_FILENO, "x", 1) == 1 ? 1 : 0;
            }),
            0);
}

TEST(StandardStreams, TellWhatTheyCanAndNeverThrowOrWait) {
  const auto progress = [] {
    ProgressLine line{false};
    line.show(0.5, "half");
    line.say("a line");
    tell_at_last("the end\n");
    return 0;
  };
  EXPECT_EQ(alone([&] {
              dup2(open("/dev/full", O_WRONLY), STDERR_FILENO);
              return progress();
            }),
            0);
  EXPECT_EQ(alone([&] {
              close(STDERR_FILENO);
              return progress();
            }),
            0);
  EXPECT_EQ(alone([&] {  // nobody reads any more
              secure_standard_streams();
              std::array<int, 2> ends{};
              if (pipe(ends.data()) != 0) return 1;
              close(ends[0]);
              dup2(ends[1], STDERR_FILENO);
              return progress();
            }),
            0);
  EXPECT_EQ(alone([&] {  // somebody might, but does not
              std::array<int, 2> ends{};
              if (pipe(ends.data()) != 0) return 1;
              dup2(ends[1], STDERR_FILENO);
              const std::string page(1000, 'x');
              for (int i = 0; i < 1000; ++i) tell(page);
              return 0;
            }),
            0);
}

class BrokenStreams : public ::testing::Test {
 protected:
  BrokenStreams() { std::ofstream{folder_ / "study.json"} << kStudy; }
  void SetUp() override {
    if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "no /dev/full";
  }
  TemporaryFolder folder_;
};

TEST_F(BrokenStreams, OfAnErrorGiveTheStatusOfTheError) {
  for (const char* broken : {"2>&-", "2>/dev/full", ">&- 2>&-", "<&- >&- 2>&-", "2>&1 | true"}) {
    const std::string line = std::string{"$M solve nosuch "} + broken;
    EXPECT_EQ(shell(line, folder_), line.ends_with("true") ? 0 : 2) << line;
  }
  EXPECT_EQ(shell("${M}-check nosuch 2>&-", folder_), 2);
  EXPECT_EQ(shell("${M}-check nosuch 2>/dev/full", folder_), 2);
}

TEST_F(BrokenStreams, LeaveAStudyWithNothingButItsCellsInTheJournal) {
  ASSERT_EQ(shell("$M compare study.json --out whole >/dev/null 2>&1", folder_), 0);
  int number = 0;
  for (const char* broken : {">/dev/null 2>&-", ">/dev/null 2>/dev/full", "<&- >&- 2>&-", ">/dev/full 2>&-"}) {
    const std::string out = "out" + std::to_string(++number);
    const int status = shell("$M compare study.json --out " + out + ' ' + broken, folder_);
    EXPECT_EQ(status, std::string{broken}.starts_with(">/dev/null") ? 0 : 2) << broken;
    std::ifstream journal{folder_ / (out + "/events.jsonl")};
    int done = 0;
    for (std::string line; std::getline(journal, line);) {
      const nlohmann::json event = nlohmann::json::parse(line, nullptr, false);
      ASSERT_TRUE(event.is_object()) << broken << ": " << line;
      done += event.value("event", "") == "done";
    }
    EXPECT_EQ(done, 1 + 2 * 2) << broken;  // a training, two solvers with two seeds each
    EXPECT_TRUE(std::filesystem::exists(folder_ / (out + "/report.html")));
    EXPECT_EQ(shell("$M compare study.json --resume --out " + out + " >/dev/null", folder_), 0) << broken;
  }
}

TEST_F(BrokenStreams, KeepAPolicyThatWasTrained) {
  const std::string train = "$M train seed/fixed --agent mpdqn:preset=best,episodes=60,final_episodes=1 --out ";
  int number = 0;
  for (const char* broken : {"2>/dev/full", "2>&-", ">/dev/full 2>/dev/full", ">&- 2>&-"}) {
    const std::string out = "out" + std::to_string(++number);
    const int status = shell(train + out + ' ' + broken + (broken[0] == '2' ? " >/dev/null" : ""), folder_);
    EXPECT_EQ(status, broken[0] == '2' ? 0 : 2) << broken;
    EXPECT_TRUE(std::filesystem::exists(folder_ / (out + "/policy.json"))) << broken;
  }
}

TEST_F(BrokenStreams, LeaveTheFilesOfASolutionWhole) {
  EXPECT_EQ(shell("$M solve seed/fixed --out out >/dev/full 2>&-", folder_), 2);
  EXPECT_EQ(modsearch({"verify", folder_ / "out/solution.json"}, folder_).status, 0);
}

TEST_F(BrokenStreams, MakeAnAnswerThatIsLostNoSuccess) {
  ASSERT_EQ(modsearch({"solve", "seed/fixed", "--out", folder_ / "out"}, folder_).status, 0);
  ASSERT_EQ(modsearch({"certify", "seed/fixed", "--gap", "1e-2", "--out", folder_ / "c.json"}, folder_).status, 0);
  for (const char* answer :
       {"$M --help", "$M --version", "$M solve --help", "$M list solvers", "$M list agents --json",
        "$M evaluate seed/fixed out/solution.json", "$M verify out/solution.json", "$M render out/solution.json",
        "$M render out/solution.json --out page", "$M convert out/solution.json a.urdf",
        "$M generate whitman --count 1 --out tasks", "$M certify seed/fixed --gap 1e-2 --out d.json",
        "$M check-certificate c.json", "${M}-check c.json", "${M}-check --json c.json", "${M}-check --help"}) {
    for (const char* lost : {">/dev/full", ">&-"}) {
      const std::string line = std::string{answer} + ' ' + lost + " 2>complaint.txt";
      EXPECT_EQ(shell(line, folder_), 2) << line;
      const std::string complaint = read_text(folder_ / "complaint.txt");
      EXPECT_THAT(complaint, HasSubstr("written")) << line;
      EXPECT_EQ(std::count(complaint.begin(), complaint.end(), '\n'), 1) << complaint;
    }
  }
}

TEST_F(BrokenStreams, ReportAFileThatMayNotGrowInsteadOfDying) {
  // ulimit -f counts blocks of 512 bytes; the page is larger than 100 of them.
  EXPECT_EQ(shell("(ulimit -f 100; $M solve seed/fixed --out out >answer.txt 2>complaint.txt)", folder_), 2);
  EXPECT_THAT(read_text(folder_ / "complaint.txt"), HasSubstr("view.html: cannot be written: File too large"));
  EXPECT_THAT(read_text(folder_ / "answer.txt"), HasSubstr("verified     path"));
}

TEST_F(BrokenStreams, LetARejectionBeAsLoudAsItsReader) {
  std::ofstream{folder_ / "c.json"} << "{}";
  EXPECT_EQ(shell("${M}-check c.json >/dev/full 2>/dev/null", folder_), 2);
}

}  // namespace
}  // namespace modsearch::app
