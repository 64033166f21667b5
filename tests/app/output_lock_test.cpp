#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <modsearch/problem/output_lock.hpp>

#include "app/command.hpp"

namespace modsearch::testing {
namespace {

using ::testing::HasSubstr;

constexpr const char* kStudy = R"({
  "modsearch": 1, "name": "tiny", "problems": [{"problem": "seed/fixed"}], "solvers": [{"solver": "random"}],
  "seeds": {"first": 0, "count": 1}, "budget": {"evaluations": 5}
})";

// This process writes the output; each command that would do so, too, has to find out.
class OutputInUse : public ::testing::Test {
 protected:
  OutputInUse() {
    std::ofstream{folder_ / "study.json"} << kStudy;
    std::filesystem::create_directory(out_);
  }
  void expect_refusal(const std::vector<std::string>& words) const {
    const Outcome refused = modsearch(words, folder_);
    EXPECT_EQ(refused.status, 2) << words[0];
    EXPECT_THAT(refused.err, HasSubstr("is being written by process " + std::to_string(getpid()) + " on ")) << words[0];
    EXPECT_EQ(std::count(refused.err.begin(), refused.err.end(), '\n'), 1) << refused.err;
    EXPECT_EQ(refused.out, "") << words[0];
  }
  [[nodiscard]] std::vector<std::string> files_in_out() const {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator{out_}) names.push_back(entry.path().filename());
    return names;
  }

  TemporaryFolder folder_;
  std::string out_ = folder_ / "out";
};

TEST_F(OutputInUse, IsRefusedByEveryCommandThatWritesAFolder) {
  ASSERT_EQ(modsearch({"solve", "seed/fixed", "--out", folder_ / "solved"}, folder_).status, 0);
  const std::string solution = folder_ / "solved/solution.json";
  const OutputLock lock = OutputLock::of_folder(out_);
  expect_refusal({"solve", "seed/fixed", "--out", out_});
  expect_refusal({"train", "seed/fixed", "--out", out_});
  expect_refusal({"compare", folder_ / "study.json", "--out", out_});
  expect_refusal({"compare", folder_ / "study.json", "--resume", "--out", out_});
  expect_refusal({"generate", "whitman", "--count", "1", "--out", out_});
  expect_refusal({"render", solution, "--out", out_});
  expect_refusal({"best-known", solution, "--tables", out_});
  EXPECT_THAT(files_in_out(), ::testing::ElementsAre(".modsearch.lock"));
}

TEST_F(OutputInUse, IsRefusedForAFileThatTakesLong) {
  const OutputLock certificate = OutputLock::of_file(folder_ / "c.json");
  expect_refusal({"certify", "seed/fixed", "--out", folder_ / "c.json"});
  const OutputLock checkpoint = OutputLock::of_file(folder_ / "search.bin");
  expect_refusal({"solve", "seed/fixed", "--solver", "random", "--checkpoint", folder_ / "search.bin"});
  EXPECT_FALSE(std::filesystem::exists(folder_ / "search.bin"));
  // Others in the same folder are free.
  EXPECT_EQ(modsearch({"certify", "seed/fixed", "--gap", "1e-2", "--out", folder_ / "d.json"}, folder_).status, 0);
}

TEST_F(OutputInUse, IsFreeAsSoonAsItsWriterHasEnded) {
  ASSERT_EQ(modsearch({"solve", "seed/fixed", "--out", out_}, folder_).status, 0);
  EXPECT_THAT(files_in_out(), ::testing::UnorderedElementsAre("solution.json", "trace.csv", "view.html"));
  EXPECT_EQ(modsearch({"solve", "seed/fixed", "--out", out_}, folder_).status, 0);
}

}  // namespace
}  // namespace modsearch::testing
