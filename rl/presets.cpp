#include <algorithm>
#include <array>
#include <modsearch/rl/settings.hpp>

namespace modsearch {
namespace {

constexpr std::array kPresets{Preset::kReport, Preset::kReportCode, Preset::kBest};

// The report's text; where it is silent, its code. Its environment: 36 unscaled numbers, the score paid at each
// placement.
LearnerSettings report(AgentKind kind) {
  LearnerSettings s;
  s.kind = kind;
  s.environment.encoder.kind = EncoderKind::kSeed36;
  s.agent.passthrough_bias_deviation = 2.0;  // N(1, 1) in metres, mapped from [0.5, 1.5]
  if (kind == AgentKind::kPaddpg) {
    s.agent.gamma = 0.9;
    s.agent.value_rate = 1e-4;
    s.agent.actor_rate = 1e-3;
    s.agent.value_tau = 0.001;
    s.agent.actor_tau = 0.01;
    s.agent.leak = 0.01;
    s.agent.value_output_deviation = 0.01;
    s.agent.actor_output_deviation = 0.01;
    s.agent.passthrough_bias_deviation = 0.0;
  }
  return s;
}

// Its published code, with the faults that bear on learning.
LearnerSettings report_code(AgentKind kind) {
  LearnerSettings s = report(kind);
  s.training.patience = 0;
  s.training.returns.truncation_ends = true;
  s.agent.clip_parameters = false;
  if (kind == AgentKind::kPaddpg) {
    s.training.returns.legacy_terminals = true;
  } else {
    s.agent.actor_hidden = {128};
    s.training.batch = 256;
    s.training.warm_up = 256;
    s.training.replay = 100'000;
  }
  return s;
}

// What came out best in our own trials (docs/agents.md): polish while training and acting, rewards scaled so that the
// mass still shows beside the bonus for reaching, learning rates that fall.
LearnerSettings best(AgentKind kind, const ProblemTraits& traits) {
  LearnerSettings s;
  s.kind = kind;
  s.environment.encoder.goal_box = traits.goal_box;
  s.agent.actor_rate = 1e-3;
  s.agent.bound = 1.1;
  s.training.returns.reward_scale = 0.1;
  s.training.replay = 100'000;
  s.training.patience = 0;
  s.training.acting.polish = 3;
  s.training.decay_from = 0.3;
  s.training.decay_to = 0.01;
  // The lightest design within reach is the best one unless it collides.
  s.training.acting.polishing.descend_mass = !traits.obstacles;
  // Evaluations on one target can be compared; those on a few sampled ones differ by luck more than by the policy.
  s.training.keep_best = !traits.sampled;
  if (!traits.sampled) {
    s.training.episodes = 600;
    s.training.updates_per_step = 4.0;
    s.training.exploration.epsilon_episodes = 200;
    s.training.evaluate_every = 30;
    s.training.evaluation_episodes = 1;
  } else {
    s.training.episodes = traits.obstacles ? 16'000 : 12'000;
    s.training.updates_per_step = 2.0;
    s.training.decay_to = 0.003;  // 0.01 leaves one target in 500 unsolved on seed/random_wide
    s.training.exploration.epsilon_episodes = 1000;
    s.training.evaluate_every = 300;
    s.training.evaluation_episodes = 100;
  }
  if (traits.obstacles) {
    // A design that collides is then worth that of a clean one with more modules, not 30 points less than the best:
    // the cliff along which the best designs lie is deep enough for the critic to keep away from it.
    s.environment.reward = RewardKind::kDifference;
    s.environment.end_on = EndOn::kAchieved;
    s.agent.value_hidden = {256};
    s.training.exploration.last_epsilon = 0.1;
    s.training.exploration.noise = NoiseKind::kGaussian;
    s.training.exploration.deviation = 0.3;
  } else if (traits.sampled) {
    // The model moves the parameters, the critic chooses the type; PA-DDPG's critic has to do both.
    s.agent.model = {.reach = 50.0, .mass = 5.0, .critic = kind == AgentKind::kPaddpg ? 1.0 : 0.0};
  }
  return s;
}

}  // namespace

std::string_view name(Preset preset) {
  switch (preset) {
    case Preset::kReport:
      return "report";
    case Preset::kReportCode:
      return "report-code";
    case Preset::kBest:
      return "best";
  }
  return "";
}

std::optional<Preset> preset_from_name(std::string_view text) {
  const auto found = std::find_if(kPresets.begin(), kPresets.end(), [&](Preset p) { return name(p) == text; });
  return found == kPresets.end() ? std::nullopt : std::optional{*found};
}

ProblemTraits traits_of(const ProblemFile& file) {
  ProblemTraits traits{.sampled = file.sampled(), .obstacles = !file.spec.scene->obstacles().empty()};
  // A box without width along some axis cannot be scaled.
  if (file.sampling && (file.sampling->lower.array() < file.sampling->upper.array()).all()) {
    traits.goal_box.assign(file.sampling->lower.begin(), file.sampling->lower.end());
    traits.goal_box.insert(traits.goal_box.end(), file.sampling->upper.begin(), file.sampling->upper.end());
  }
  return traits;
}

LearnerSettings settings_of(AgentKind kind, Preset preset, const ProblemTraits& traits) {
  switch (preset) {
    case Preset::kReport:
      return report(kind);
    case Preset::kReportCode:
      return report_code(kind);
    case Preset::kBest:
      return best(kind, traits);
  }
  return {};
}

}  // namespace modsearch
