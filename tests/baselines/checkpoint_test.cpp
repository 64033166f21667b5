#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <modsearch/baselines/random_search.hpp>
#include <modsearch/problem/files.hpp>
#include <modsearch/solvers/checkpoint.hpp>

#include "problem/temporary_folder.hpp"

namespace modsearch {
namespace {

using test::TemporaryFolder;
using ::testing::HasSubstr;

std::string refusal_of(const DesignProblem& problem, const Checkpointing& checkpointing) {
  Meter meter{{.evaluations = 100}};
  try {
    (void)solve(RandomSearch{}, problem, meter, Rng{1}, checkpointing);
  } catch (const FileError& error) {
    return error.what();
  }
  return "nothing was refused";
}

TEST(Checkpoint, RefusesTheSearchOfAnotherProblem) {
  const TemporaryFolder folder;
  Checkpointing checkpointing{.file = folder.path() / "checkpoint", .period = 0.0};
  EXPECT_EQ(refusal_of(*load_problem("seed/fixed"), checkpointing), "nothing was refused");
  checkpointing.resume = true;
  EXPECT_THAT(refusal_of(*load_problem("seed/random_wide"), checkpointing),
              HasSubstr("entry 'problem': is 'seed/fixed', this search is of 'seed/random_wide"));
}

TEST(Checkpoint, RefusesAFileThatIsNone) {
  const TemporaryFolder folder;
  const Checkpointing checkpointing{.file = folder.path() / "checkpoint", .resume = true};
  write_file(checkpointing.file, "something else");
  EXPECT_THAT(refusal_of(*load_problem("seed/fixed"), checkpointing), HasSubstr("checkpoint"));
}

TEST(Checkpoint, BeginsAnewWhereThereIsNoFileYet) {
  const TemporaryFolder folder;
  const Checkpointing checkpointing{.file = folder.path() / "checkpoint", .resume = true};
  EXPECT_EQ(refusal_of(*load_problem("seed/fixed"), checkpointing), "nothing was refused");
}

TEST(Checkpoint, KeepsDesignsAsTheyAre) {
  const std::shared_ptr<const ModuleLibrary> library = load_library("seed");
  Parameters one(1);
  one << 0.75;
  Parameters two(2);
  two << 0.5, 1.25;
  const std::vector<Design> designs{Design{}, Design{{{0, one}, {1, two}}}, Design{{{2, two}}}};
  Archive archive;
  put(archive, "population", designs);
  EXPECT_EQ(restored_designs(archive, "population", *library), designs);
}

}  // namespace
}  // namespace modsearch
