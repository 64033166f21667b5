#include "app/checker_process.hpp"

#include <gmock/gmock.h>
#include <sys/stat.h>

#include <fstream>

#include "app/command.hpp"

namespace modsearch::testing {
namespace {

using ::testing::HasSubstr;

// The test stands elsewhere than the programs: the one that is run is that of the build.
TEST(CheckerProcess, StandsBesideTheProgramThatRunsIt) {
  EXPECT_EQ(app::checker_program().filename(), "modsearch-check");
  EXPECT_EQ(app::checker_program().parent_path(), std::filesystem::read_symlink("/proc/self/exe").parent_path());
}

TEST(CheckerProcess, RefusesWhatIsNoCertificateWithTheCheckersWords) {
  if (!std::filesystem::exists(app::checker_program())) GTEST_SKIP() << "modsearch-check is not beside the tests";
  const TemporaryFolder folder;
  const std::string file = folder / "certificate.json";
  std::ofstream{file} << "{}";
  const app::CheckerVerdict verdict = app::run_checker(file, 60.0, {});
  EXPECT_EQ(verdict.kind, app::CheckerVerdict::Kind::kRefused);
  EXPECT_THAT(verdict.reason, HasSubstr("modsearch"));
}

TEST(CheckerProcess, IsStoppedWhereSomebodyAsks) {
  if (!std::filesystem::exists(app::checker_program())) GTEST_SKIP() << "modsearch-check is not beside the tests";
  const TemporaryFolder folder;
  const std::string pipe = folder / "never_written";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);  // the checker waits for somebody to write
  std::stop_source stop;
  stop.request_stop();
  EXPECT_EQ(app::run_checker(pipe, 60.0, stop.get_token()).kind, app::CheckerVerdict::Kind::kNotDone);
}

}  // namespace
}  // namespace modsearch::testing
