#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <modsearch/problem/files.hpp>
#include <modsearch/problem/output_lock.hpp>
#include <optional>

#include "problem/temporary_folder.hpp"

namespace modsearch {
namespace {

using ::testing::HasSubstr;
using ::testing::MatchesRegex;

std::string refusal(const std::filesystem::path& folder) {
  try {
    static_cast<void>(OutputLock::of_folder(folder));
  } catch (const FileError& error) {
    return error.what();
  }
  return "none";
}

/// Another process that takes the lock of a folder and keeps it until it is killed.
class Holder {
 public:
  explicit Holder(const std::filesystem::path& folder) {
    std::array<int, 2> ends{};
    if (pipe(ends.data()) != 0) throw std::runtime_error("no pipe");
    process_ = fork();
    if (process_ == 0) {
      close(ends[0]);
      hold(folder, ends[1]);
      _exit(1);
    }
    close(ends[1]);
    char held = 0;
    const bool has_it = read(ends[0], &held, 1) == 1;
    close(ends[0]);
    if (has_it) return;
    end();
    throw std::runtime_error("the other process does not get the lock");
  }
  Holder(const Holder&) = delete;
  Holder& operator=(const Holder&) = delete;
  ~Holder() { end(); }
  void end() {
    if (process_ <= 0) return;
    kill(process_, SIGKILL);
    waitpid(process_, nullptr, 0);
    process_ = -1;
  }
  [[nodiscard]] pid_t process() const { return process_; }

 private:
  static void hold(const std::filesystem::path& folder, int told) {
    try {
      const OutputLock lock = OutputLock::of_folder(folder);
      if (write(told, "x", 1) == 1) pause();
    } catch (const FileError&) {
    }
  }

  pid_t process_ = -1;
};

class OutputLockTest : public ::testing::Test {
 protected:
  test::TemporaryFolder folder_;
};

TEST_F(OutputLockTest, NamesInOneSentenceWhoWritesTheFolder) {
  const Holder holder{folder_.path()};
  const std::string sentence = refusal(folder_.path());
  EXPECT_THAT(sentence, HasSubstr(": is being written by process " + std::to_string(holder.process()) + " on "));
  EXPECT_THAT(sentence, MatchesRegex(".* since 20..-..-.. ..:..:.. UTC: .*modsearch_problem_test.*"));
  EXPECT_EQ(sentence.find('\n'), std::string::npos);
}

TEST_F(OutputLockTest, IsGoneWithItsProcessHoweverThatEnds) {
  Holder holder{folder_.path()};
  holder.end();
  EXPECT_TRUE(std::filesystem::exists(folder_.path() / ".modsearch.lock"));
  EXPECT_EQ(refusal(folder_.path()), "none");
}

TEST_F(OutputLockTest, LeavesNothingBehind) {
  { const OutputLock lock = OutputLock::of_folder(folder_.path()); }
  { const OutputLock lock = OutputLock::of_file(folder_.path() / "a"); }
  EXPECT_TRUE(std::filesystem::is_empty(folder_.path()));
}

TEST_F(OutputLockTest, IsHeldOnceInAProcessToo) {
  std::optional<OutputLock> lock{OutputLock::of_folder(folder_.path())};
  EXPECT_THAT(refusal(folder_.path()), HasSubstr("is being written by process " + std::to_string(getpid())));
  // The refusal has not taken it away from the other processes' sight.
  EXPECT_THROW(Holder{folder_.path()}, std::runtime_error);
  lock.reset();
  EXPECT_EQ(refusal(folder_.path()), "none");
}

TEST_F(OutputLockTest, IsNotInheritedByAProcessThatIsForked) {
  std::optional<OutputLock> lock{OutputLock::of_folder(folder_.path())};
  const pid_t child = fork();
  if (child == 0) {
    pause();
    _exit(0);
  }
  lock.reset();
  EXPECT_EQ(refusal(folder_.path()), "none");
  kill(child, SIGKILL);
  waitpid(child, nullptr, 0);
}

TEST_F(OutputLockTest, IsNotGivenBackByAProcessThatIsForked) {
  std::optional<OutputLock> lock{OutputLock::of_folder(folder_.path())};
  const pid_t child = fork();
  if (child == 0) {
    lock.reset();
    _exit(0);
  }
  waitpid(child, nullptr, 0);
  EXPECT_TRUE(std::filesystem::exists(folder_.path() / ".modsearch.lock"));
  EXPECT_THROW(Holder{folder_.path()}, std::runtime_error);
}

TEST_F(OutputLockTest, KnowsAFolderByWhateverNameItIsGiven) {
  std::filesystem::create_directory(folder_.path() / "real");
  std::filesystem::create_directory_symlink("real", folder_.path() / "link");
  const Holder holder{folder_.path() / "link"};
  EXPECT_THAT(refusal(folder_.path() / "real/../real/."), HasSubstr("is being written by"));
}

TEST_F(OutputLockTest, LetsTwoFilesOfAFolderBeWrittenAtOnce) {
  const OutputLock first = OutputLock::of_file(folder_.path() / "first.json");
  const OutputLock second = OutputLock::of_file(folder_.path() / "second.json");
  EXPECT_THROW(static_cast<void>(OutputLock::of_file(folder_.path() / "first.json")), FileError);
}

TEST_F(OutputLockTest, NeedsNoneForADevice) {
  const OutputLock first = OutputLock::of_file("/dev/null");
  const OutputLock second = OutputLock::of_file("/dev/null");
  EXPECT_FALSE(std::filesystem::exists("/dev/null.lock"));
}

TEST_F(OutputLockTest, SaysWhatCannotBeLocked) {
  EXPECT_THAT(refusal(folder_.path() / "nowhere"), HasSubstr("cannot be locked against other writers: No such file"));
}

}  // namespace
}  // namespace modsearch
