#include <gtest/gtest.h>
#include <unistd.h>

#include <modsearch/problem/files.hpp>

#include "problem/temporary_folder.hpp"

namespace modsearch {
namespace {

TEST(WriteFile, IsNotInTheWayOfItselfWhereAProcessOfTheSameNumberWasKilled) {
  const test::TemporaryFolder folder;
  for (int i = 0; i < 50; ++i) {
    folder.write("a.json." + std::to_string(::getpid()) + "-" + std::to_string(i) + ".part", "torn");
  }
  write_file(folder.path() / "a.json", "whole");
  EXPECT_EQ(test::text_of(folder.path() / "a.json"), "whole");
}

}  // namespace
}  // namespace modsearch
