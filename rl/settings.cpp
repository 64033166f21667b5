#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <concepts>
#include <modsearch/rl/settings.hpp>
#include <stdexcept>

namespace modsearch {
namespace {

[[noreturn]] void refuse(const std::string& key, const std::string& text, const std::string& wanted) {
  throw std::invalid_argument(fmt::format("option {}={}: not {}", key, text, wanted));
}

template <typename T>
T parsed(const std::string& key, const std::string& text, const std::string& wanted) {
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) refuse(key, text, wanted);
  if constexpr (std::floating_point<T>) {
    if (!std::isfinite(value)) refuse(key, text, wanted);
  }
  return value;
}

// How a value of a type is read and written.
std::string written(double value) { return fmt::format("{}", value); }
std::string written(int value) { return fmt::format("{}", value); }
std::string written(std::int64_t value) { return fmt::format("{}", value); }
std::string written(bool value) { return value ? "true" : "false"; }
std::string written(const std::vector<int>& values) {
  return values.empty() ? "none" : fmt::format("{}", fmt::join(values, "x"));
}
std::string written(const std::vector<double>& values) {
  return values.empty() ? "none" : fmt::format("{}", fmt::join(values, "/"));
}

void read(const std::string& key, const std::string& text, double& value) {
  value = parsed<double>(key, text, "a number");
}
void read(const std::string& key, const std::string& text, int& value) { value = parsed<int>(key, text, "an integer"); }
void read(const std::string& key, const std::string& text, std::int64_t& value) {
  value = parsed<std::int64_t>(key, text, "an integer");
}
void read(const std::string& key, const std::string& text, bool& value) {
  if (text != "true" && text != "false") refuse(key, text, "true or false");
  value = text == "true";
}
template <typename T>
void read_list(const std::string& key, const std::string& text, char separator, const std::string& wanted,
               std::vector<T>& values) {
  values.clear();
  if (text == "none") return;
  for (std::size_t at = 0; at <= text.size();) {
    const std::size_t end = std::min(text.find(separator, at), text.size());
    values.push_back(parsed<T>(key, text.substr(at, end - at), wanted));
    at = end + 1;
  }
}
void read(const std::string& key, const std::string& text, std::vector<int>& values) {
  read_list(key, text, 'x', "widths such as 128x64, or none", values);
  if (std::any_of(values.begin(), values.end(), [](int n) { return n < 1; })) refuse(key, text, "widths of at least 1");
}
void read(const std::string& key, const std::string& text, std::vector<double>& values) {
  read_list(key, text, '/', "numbers such as 0.5/-0.5, or none", values);
}

template <typename Enum>
using Names = std::vector<std::pair<std::string, Enum>>;

// `field`: a generic lambda that gives the field of (const) settings.
template <typename Field>
Setting setting(std::string key, std::string meaning, Field field) {
  return {key, std::move(meaning), [field](const LearnerSettings& s) { return written(field(s)); },
          [field, key](LearnerSettings& s, const std::string& text) { read(key, text, field(s)); }};
}

template <typename Enum, typename Field>
Setting choice(std::string key, const std::string& meaning, const Names<Enum>& names, Field field) {
  std::vector<std::string> known;
  for (const auto& [text, value] : names) known.push_back(text);
  const std::string choices = fmt::format("{}", fmt::join(known, "|"));
  return {key, fmt::format("{} ({})", meaning, choices),
          [field, names](const LearnerSettings& s) {
            return std::find_if(names.begin(), names.end(), [&](const auto& n) { return n.second == field(s); })->first;
          },
          [field, names, key, choices](LearnerSettings& s, const std::string& text) {
            const auto found = std::find_if(names.begin(), names.end(), [&](const auto& n) { return n.first == text; });
            if (found == names.end()) refuse(key, text, "one of " + choices);
            field(s) = found->second;
          }};
}

// A field of settings, const or not.
#define MODSEARCH_FIELD(path) \
  [](auto& s) -> auto& { return s.path; }

std::vector<Setting> make_table() {
  return {
      setting("episodes", "training episodes at most", MODSEARCH_FIELD(training.episodes)),
      setting("batch", "experiences per update", MODSEARCH_FIELD(training.batch)),
      setting("replay", "experiences kept", MODSEARCH_FIELD(training.replay)),
      setting("warm_up", "experiences before the first update", MODSEARCH_FIELD(training.warm_up)),
      setting("updates_per_step", "updates per environment step", MODSEARCH_FIELD(training.updates_per_step)),
      setting("evaluate_every", "training episodes between evaluations", MODSEARCH_FIELD(training.evaluate_every)),
      setting("evaluation_episodes", "greedy episodes per evaluation", MODSEARCH_FIELD(training.evaluation_episodes)),
      setting("patience", "evaluations without a new best before the end; 0: never",
              MODSEARCH_FIELD(training.patience)),
      setting("final_episodes", "greedy episodes at the end", MODSEARCH_FIELD(training.final_episodes)),
      setting("keep_best", "keep the policy of the best evaluation", MODSEARCH_FIELD(training.keep_best)),
      setting("decay_from", "share of the episodes after which learning rates fall",
              MODSEARCH_FIELD(training.decay_from)),
      setting("decay_to", "factor of the learning rates at the end", MODSEARCH_FIELD(training.decay_to)),

      setting("reward_scale", "factor of the rewards in targets", MODSEARCH_FIELD(training.returns.reward_scale)),
      setting("n_steps", "rewards summed before a value takes over", MODSEARCH_FIELD(training.returns.steps)),
      setting("mixed_target", "share of the whole return in targets", MODSEARCH_FIELD(agent.mixed_target)),
      setting("legacy_terminals", "store no ends of episodes, as the published PA-DDPG does",
              MODSEARCH_FIELD(training.returns.legacy_terminals)),
      setting("truncation_ends", "a cut-off counts as an end, as in the published code",
              MODSEARCH_FIELD(training.returns.truncation_ends)),

      setting("epsilon_first", "share of uniform actions at first",
              MODSEARCH_FIELD(training.exploration.first_epsilon)),
      setting("epsilon_last", "share of uniform actions in the end",
              MODSEARCH_FIELD(training.exploration.last_epsilon)),
      setting("epsilon_episodes", "episodes of its fall", MODSEARCH_FIELD(training.exploration.epsilon_episodes)),
      choice<NoiseKind>(
          "noise", "noise on the parameters of greedy actions",
          {{"none", NoiseKind::kNone}, {"gaussian", NoiseKind::kGaussian}, {"ou", NoiseKind::kOrnsteinUhlenbeck}},
          MODSEARCH_FIELD(training.exploration.noise)),
      setting("noise_deviation", "its deviation; the range of a parameter is 2",
              MODSEARCH_FIELD(training.exploration.deviation)),

      setting("elite", "share of a batch drawn from the best episodes", MODSEARCH_FIELD(training.elite_share)),
      setting("elite_episodes", "best episodes kept", MODSEARCH_FIELD(training.elite_episodes)),
      setting("hindsight", "relabelled transitions per step", MODSEARCH_FIELD(training.hindsight)),
      setting("polish", "Gauss-Newton steps on the chosen module at most", MODSEARCH_FIELD(training.acting.polish)),
      setting("polish_mass", "polish goes on to the lightest parameters that reach",
              MODSEARCH_FIELD(training.acting.polishing.descend_mass)),
      setting("proposals", "polished proposals of which the best is taken", MODSEARCH_FIELD(training.acting.proposals)),
      setting("proposal_deviation", "their deviation; the range of a parameter is 2",
              MODSEARCH_FIELD(training.acting.proposal_deviation)),
      setting("all_types", "as many proposals for every type", MODSEARCH_FIELD(training.acting.all_types)),

      setting("gamma", "discount factor", MODSEARCH_FIELD(agent.gamma)),
      setting("value_hidden", "hidden layers of the value network", MODSEARCH_FIELD(agent.value_hidden)),
      setting("actor_hidden", "hidden layers of the actor", MODSEARCH_FIELD(agent.actor_hidden)),
      setting("leak", "slope of the leaky ReLU below zero", MODSEARCH_FIELD(agent.leak)),
      setting("value_rate", "learning rate of the value network", MODSEARCH_FIELD(agent.value_rate)),
      setting("actor_rate", "learning rate of the actor", MODSEARCH_FIELD(agent.actor_rate)),
      setting("value_tau", "soft update of the value target", MODSEARCH_FIELD(agent.value_tau)),
      setting("actor_tau", "soft update of the actor's target", MODSEARCH_FIELD(agent.actor_tau)),
      setting("clip", "largest gradient norm", MODSEARCH_FIELD(agent.clip)),
      setting("value_output_deviation", "of the value network's last weights; -1: uniform by fan-in",
              MODSEARCH_FIELD(agent.value_output_deviation)),
      setting("actor_output_deviation", "of the actor's last weights", MODSEARCH_FIELD(agent.actor_output_deviation)),
      choice<ActorWeighting>("weighting", "of the types in the actor's objective",
                             {{"sum", ActorWeighting::kSum},
                              {"weighted", ActorWeighting::kWeighted},
                              {"average", ActorWeighting::kAverage},
                              {"random", ActorWeighting::kRandom}},
                             MODSEARCH_FIELD(agent.weighting)),
      setting("indexed", "only the replayed action's term of it", MODSEARCH_FIELD(agent.indexed)),
      setting("zero_index_gradients", "keep its gradient in the replayed action's slice only",
              MODSEARCH_FIELD(agent.zero_index_gradients)),
      choice<BoundGradients>(
          "bounds", "the actor's gradients near the bounds of a parameter",
          {{"invert", BoundGradients::kInvert}, {"zero", BoundGradients::kZero}, {"none", BoundGradients::kNone}},
          MODSEARCH_FIELD(agent.bounds)),
      setting("bound", "where that bound lies; the parameters' own is 1", MODSEARCH_FIELD(agent.bound)),
      setting("clip_parameters", "to [-1, 1] before they are judged and stored",
              MODSEARCH_FIELD(agent.clip_parameters)),
      setting("average", "act by the actor's target, a running mean of its weights", MODSEARCH_FIELD(agent.average)),
      setting("passthrough_rate", "learning rate of the linear passthrough; 0: frozen",
              MODSEARCH_FIELD(agent.passthrough_rate)),
      setting("passthrough_deviation", "of its bias", MODSEARCH_FIELD(agent.passthrough_bias_deviation)),
      setting("passthrough_bias", "bias per parameter, instead of a drawn one",
              MODSEARCH_FIELD(agent.passthrough_bias)),
      setting("passthrough_weight_mean", "of its weights", MODSEARCH_FIELD(agent.passthrough_weight_mean)),
      setting("passthrough_weight_deviation", "of its weights", MODSEARCH_FIELD(agent.passthrough_weight_deviation)),
      setting("twin", "two value networks, the smaller in targets (TD3)", MODSEARCH_FIELD(agent.td3.twin)),
      setting("delay", "value updates per actor update (TD3)", MODSEARCH_FIELD(agent.td3.delay)),
      setting("smoothing", "deviation of the noise on target parameters (TD3)", MODSEARCH_FIELD(agent.td3.smoothing)),
      setting("smoothing_clip", "largest such noise", MODSEARCH_FIELD(agent.td3.smoothing_clip)),
      setting("model_gradient", "weight of the exact gradient of the reach error", MODSEARCH_FIELD(agent.model.reach)),
      setting("model_mass", "weight of the exact gradient of the mass", MODSEARCH_FIELD(agent.model.mass)),
      setting("model_width", "error at which its pull fades [m]", MODSEARCH_FIELD(agent.model.width)),
      setting("model_pull", "weight of the pull towards the polished parameters", MODSEARCH_FIELD(agent.model.pull)),
      setting("pull_width", "distance at which it fades; the range of a parameter is 2",
              MODSEARCH_FIELD(agent.model.pull_width)),
      setting("pull_steps", "steps of its polish", MODSEARCH_FIELD(agent.model.pull_steps)),
      setting("pull_aim", "share of the tolerance to which it goes", MODSEARCH_FIELD(agent.model.pull_aim)),
      setting("pull_mass", "its polish goes on to the lightest parameters that reach",
              MODSEARCH_FIELD(agent.model.pull_mass)),
      setting("model_taken", "all three only in the replayed action's parameters", MODSEARCH_FIELD(agent.model.taken)),
      setting("critic", "weight of the critic's gradient beside it", MODSEARCH_FIELD(agent.model.critic)),
      choice<EncoderKind>("observation", "what the agent sees",
                          {{"scaled", EncoderKind::kScaled}, {"seed36", EncoderKind::kSeed36}},
                          MODSEARCH_FIELD(environment.encoder.kind)),
      setting("cylindrical", "distances of the goal from axis and base beside it",
              MODSEARCH_FIELD(environment.encoder.cylindrical)),
      setting("goal_box", "lower/upper corner of where goals lie, whose place in it is then shown too [m]",
              MODSEARCH_FIELD(environment.encoder.goal_box)),
      setting("axis_heights", "heights on the base's axis whose distance from the goal is shown too [m]",
              MODSEARCH_FIELD(environment.encoder.axis_heights)),
      setting("whiten", "instances by whose mean and covariance the observation's are whitened; 0: they are not",
              MODSEARCH_FIELD(environment.whiten)),
      setting("whitening", "their mean, then the matrix by rows; none: found in training",
              MODSEARCH_FIELD(environment.encoder.whitening)),
      choice<RewardKind>("reward", "what a placement pays",
                         {{"score", RewardKind::kScore}, {"difference", RewardKind::kDifference}},
                         MODSEARCH_FIELD(environment.reward)),
      choice<EndOn>("end_on", "what ends an episode", {{"reached", EndOn::kReached}, {"achieved", EndOn::kAchieved}},
                    MODSEARCH_FIELD(environment.end_on)),
      setting("model_joints", "most joints of a chain with models", MODSEARCH_FIELD(environment.model_joints)),
      setting("bins", "dqn: values per parameter", MODSEARCH_FIELD(agent.bins)),
  };
}

#undef MODSEARCH_FIELD

}  // namespace

const std::vector<Setting>& setting_table() {
  static const std::vector<Setting> table = make_table();
  return table;
}

void apply_setting(LearnerSettings& settings, const std::string& key, const std::string& value) {
  const std::vector<Setting>& table = setting_table();
  const auto found = std::find_if(table.begin(), table.end(), [&](const Setting& s) { return s.key == key; });
  if (found == table.end()) {
    std::vector<std::string> keys;
    for (const Setting& s : table) keys.push_back(s.key);
    throw std::invalid_argument(fmt::format("there is no option '{}', only {}", key, fmt::join(keys, ", ")));
  }
  found->set(settings, value);
}

}  // namespace modsearch
