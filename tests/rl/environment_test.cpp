#include <gtest/gtest.h>

#include <modsearch/rl/design_environment.hpp>

#include "contracts/environment_contract.hpp"

namespace modsearch {
namespace {

TEST(EnvironmentContract, IsKeptByEverySeedScenarioWithTheScaledObservation) {
  for (const char* id : {"seed/fixed", "seed/random_narrow", "seed/random_wide"}) {
    testing::expect_environment_contract(DesignEnvironment{load_problem_file(id)});
  }
}

TEST(EnvironmentContract, IsKeptAmongObstacles) {
  testing::expect_environment_contract(
      DesignEnvironment{load_problem_file("seed/random_obstacles"), {.end_on = EndOn::kAchieved}}, {.episodes = 4});
}

TEST(EnvironmentContract, IsKeptWithTheReportsObservationInMetres) {
  testing::expect_environment_contract(
      DesignEnvironment{load_problem_file("seed/random_wide"), {.encoder = {.kind = EncoderKind::kSeed36}}},
      {.episodes = 10});
}

TEST(EnvironmentContract, IsKeptWithDifferencesOfScores) {
  testing::expect_environment_contract(
      DesignEnvironment{load_problem_file("seed/random_narrow"), {.reward = RewardKind::kDifference}},
      {.episodes = 10});
}

}  // namespace
}  // namespace modsearch
