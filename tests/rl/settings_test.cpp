#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <modsearch/rl/settings.hpp>

namespace modsearch {
namespace {

TEST(Settings, AreReadBackAsTheyAreWritten) {
  LearnerSettings from = settings_of(AgentKind::kMpdqn, Preset::kBest, {.sampled = true, .obstacles = true});
  from.agent.passthrough_bias = {-0.8, 0.25};
  from.agent.actor_hidden = {};
  from.agent.weighting = ActorWeighting::kRandom;
  from.agent.gamma = 0.1 + 0.2;  // every digit counts
  LearnerSettings to;
  for (const Setting& setting : setting_table()) setting.set(to, setting.get(from));
  for (const Setting& setting : setting_table()) EXPECT_EQ(setting.get(to), setting.get(from)) << setting.key;
  EXPECT_EQ(to.agent.gamma, from.agent.gamma);
}

TEST(Settings, AreRefusedByNameAndByValue) {
  LearnerSettings settings;
  const auto complaint = [&](const char* key, const char* value) -> std::string {
    try {
      apply_setting(settings, key, value);
    } catch (const std::invalid_argument& e) {
      return e.what();
    }
    return "accepted";
  };
  EXPECT_THAT(complaint("gama", "0.9"), ::testing::HasSubstr("no option 'gama'"));
  EXPECT_THAT(complaint("gamma", "abc"), ::testing::HasSubstr("option gamma=abc: not a number"));
  EXPECT_THAT(complaint("gamma", "nan"), ::testing::HasSubstr("not a number"));
  EXPECT_THAT(complaint("gamma", ""), ::testing::HasSubstr("not a number"));
  EXPECT_THAT(complaint("batch", "12.5"), ::testing::HasSubstr("not an integer"));
  EXPECT_THAT(complaint("twin", "yes"), ::testing::HasSubstr("not true or false"));
  EXPECT_THAT(complaint("noise", "white"), ::testing::HasSubstr("not one of none|gaussian|ou"));
  EXPECT_THAT(complaint("value_hidden", "128x"), ::testing::HasSubstr("widths such as"));
  EXPECT_THAT(complaint("value_hidden", "128x0"), ::testing::HasSubstr("widths of at least 1"));
}

TEST(Presets, HoldTheReportsNumbers) {
  const LearnerSettings text = settings_of(AgentKind::kPdqn, Preset::kReport);
  EXPECT_EQ(text.training.replay, 300'000);
  EXPECT_EQ(text.training.batch, 128);
  EXPECT_EQ(text.training.evaluate_every, 30);
  EXPECT_EQ(text.training.evaluation_episodes, 10);
  EXPECT_EQ(text.training.patience, 300);
  EXPECT_EQ(text.training.final_episodes, 1000);
  EXPECT_EQ(text.training.exploration.epsilon_episodes, 47'000);
  EXPECT_EQ(text.training.exploration.last_epsilon, 0.01);
  EXPECT_EQ(text.agent.actor_hidden, (std::vector<int>{128, 64}));
  EXPECT_EQ(text.agent.value_hidden, (std::vector<int>{128}));
  EXPECT_EQ(text.environment.encoder.kind, EncoderKind::kSeed36);
  EXPECT_FALSE(settings_of(AgentKind::kPaddpg, Preset::kReport).training.returns.legacy_terminals);

  const LearnerSettings code = settings_of(AgentKind::kPdqn, Preset::kReportCode);
  EXPECT_EQ(code.training.batch, 256);
  EXPECT_EQ(code.training.replay, 100'000);
  EXPECT_EQ(code.agent.gamma, 0.99);
  EXPECT_FALSE(code.agent.clip_parameters);
  EXPECT_TRUE(settings_of(AgentKind::kPaddpg, Preset::kReportCode).training.returns.legacy_terminals);
}

TEST(Presets, AreFoundByName) {
  for (const Preset preset : {Preset::kReport, Preset::kReportCode, Preset::kBest}) {
    EXPECT_EQ(preset_from_name(name(preset)), preset);
  }
  EXPECT_EQ(preset_from_name("mine"), std::nullopt);
}

}  // namespace
}  // namespace modsearch
