#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <modsearch/problem/files.hpp>
#include <modsearch/rl/state_archive.hpp>

namespace modsearch {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

template <typename Action>
std::string refusal(const Action& action) {
  try {
    action();
  } catch (const FileError& error) {
    return error.what();
  }
  return "nothing was refused";
}

TEST(StateArchive, RestoresEveryPart) {
  std::vector<std::byte> weights(5, std::byte{3});
  std::vector<std::byte> steps(8, std::byte{4});
  const std::vector<StatePart> parts = {{"weights", weights, true}, {"steps", steps, false}, {"nothing", {}, false}};
  Archive archive;
  put(archive, "agent", parts);
  EXPECT_THAT(archive.names(), ElementsAre("agent/nothing", "agent/steps", "agent/weights"));
  const std::vector<std::byte> kept = weights;
  std::fill(weights.begin(), weights.end(), std::byte{0});
  std::fill(steps.begin(), steps.end(), std::byte{0});
  restore(archive, "agent", parts);
  EXPECT_EQ(weights, kept);
  EXPECT_EQ(steps, std::vector<std::byte>(8, std::byte{4}));
}

TEST(StateArchive, ChangesNothingWhereAPartDoesNotFit) {
  std::vector<std::byte> weights(5, std::byte{3});
  std::vector<std::byte> steps(8, std::byte{4});
  Archive archive;
  put(archive, "agent", std::vector<StatePart>{{"weights", weights, true}, {"steps", steps, false}});
  std::vector<std::byte> others(5, std::byte{9});
  std::vector<std::byte> fewer(4, std::byte{9});
  EXPECT_THAT(refusal([&] {
                restore(archive, "agent", std::vector<StatePart>{{"weights", others, true}, {"steps", fewer, false}});
              }),
              HasSubstr("entry 'agent/steps': has 8 bytes (limit 4)"));
  EXPECT_EQ(others, std::vector<std::byte>(5, std::byte{9}));
  EXPECT_THAT(refusal([&] {
                restore(archive, "agent", std::vector<StatePart>{{"bias", others, true}});
              }),
              HasSubstr("entry 'agent/bias': is missing"));
}

}  // namespace
}  // namespace modsearch
