// Trains an agent on Platform with the settings of its published evaluation, once per seed, and prints what its greedy
// policy gains: to be held against published numbers.
#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <iostream>
#include <modsearch/rl/agents.hpp>
#include <modsearch/rl/training.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <system_error>
#include <vector>

#include "platform/platform_environment.hpp"
#include "platform/platform_settings.hpp"

namespace {

using namespace modsearch;

constexpr const char* kUsage = R"(usage: platform_training pdqn|mpdqn|spdqn|paddpg|dqn [KEY=VALUE ..]
  episodes=20000      of training; the published number
  seeds=1             trainings, one per seed
  first_seed=0
  prior=true          frozen first guess of the parameters: run 3, hop 10, leap 400; as published
  legacy_terminals=false   ends of episodes are not stored, as in the published code of PA-DDPG
  final_episodes=1000 greedy episodes at the end
example: platform_training mpdqn episodes=2000 seeds=3
)";

struct Request {
  AgentKind kind = AgentKind::kMpdqn;
  std::int64_t episodes = 20'000;
  int seeds = 1;
  std::uint64_t first_seed = 0;
  bool prior = true;
  bool legacy_terminals = false;
  int final_episodes = 1000;
};

// 1. One training, and its greedy policy on episodes that it has never seen.
struct Result {
  std::vector<EvaluationPoint> history;
  EvaluationSummary greedy;
  std::int64_t steps = 0;
  double seconds = 0.0;
};

Result train(const Request& request, std::uint64_t seed) {
  const PlatformEnvironment environment;
  const std::unique_ptr<Agent> agent =
      make_agent(request.kind, environment.space(), environment.observation_size(),
                 platform_agent_options(request.kind, request.prior), Rng{seed}.fork("agent"));
  TrainingOptions options = platform_training_options(request.kind, request.episodes);
  options.returns.legacy_terminals = request.legacy_terminals;
  Trainer trainer{*agent, environment, options, Rng{seed}.fork("training")};
  trainer.run();
  return {.history = trainer.history(),
          .greedy = trainer.evaluate("final", 0, request.final_episodes),
          .steps = trainer.steps(),
          .seconds = trainer.seconds()};
}

// 2. The table: a row per seed, then mean and deviation over the seeds.
void print_row(std::uint64_t seed, const Result& result) {
  std::cout << fmt::format("{:>6}", seed);
  for (const EvaluationPoint& point : result.history) std::cout << fmt::format("  {:.3f}", point.training_return);
  std::cout << fmt::format("  | {:.3f}   {:.3f}  {:>8}  {:>7.1f}\n", result.greedy.mean_return,
                           result.greedy.success_share, result.steps, result.seconds)
            << std::flush;
}

void print_summary(const std::vector<double>& returns) {
  double mean = 0.0;
  for (const double value : returns) mean += value / static_cast<double>(returns.size());
  double squares = 0.0;
  for (const double value : returns) squares += (value - mean) * (value - mean);
  const double deviation = returns.size() > 1 ? std::sqrt(squares / static_cast<double>(returns.size() - 1)) : 0.0;
  std::cout << fmt::format("mean greedy return: {:.3f} +- {:.3f} ({} trainings)\n", mean, deviation, returns.size());
}

bool flag(const std::string& key, const std::string& value) {
  if (value != "true" && value != "false") throw std::invalid_argument(key + "=" + value + ": neither true nor false");
  return value == "true";
}

int whole(const std::string& key, const std::string& value, int least) {
  int number = 0;
  const char* const end = value.data() + value.size();
  const auto [rest, error] = std::from_chars(value.data(), end, number);
  if (error != std::errc{} || rest != end || number < least) {
    throw std::invalid_argument(fmt::format("{}={}: not a whole number of at least {}", key, value, least));
  }
  return number;
}

Request parse(const std::vector<std::string>& arguments) {
  Request request;
  const std::optional<AgentKind> kind = arguments.empty() ? std::nullopt : agent_kind_from_name(arguments[0]);
  if (!kind) throw std::invalid_argument("an agent comes first");
  request.kind = *kind;
  for (std::size_t i = 1; i < arguments.size(); ++i) {
    const std::size_t equals = arguments[i].find('=');
    const std::string key = arguments[i].substr(0, equals);
    const std::string value = equals == std::string::npos ? "" : arguments[i].substr(equals + 1);
    if (key == "episodes") {
      request.episodes = whole(key, value, 1);
    } else if (key == "seeds") {
      request.seeds = whole(key, value, 1);
    } else if (key == "first_seed") {
      request.first_seed = static_cast<std::uint64_t>(whole(key, value, 0));
    } else if (key == "final_episodes") {
      request.final_episodes = whole(key, value, 1);
    } else if (key == "prior") {
      request.prior = flag(key, value);
    } else if (key == "legacy_terminals") {
      request.legacy_terminals = flag(key, value);
    } else {
      throw std::invalid_argument("there is no key " + key);
    }
  }
  return request;
}

}  // namespace

int main(int argc, char** argv) {
  Request request;
  try {
    request = parse({argv + 1, argv + argc});
  } catch (const std::invalid_argument& error) {
    std::cerr << "platform_training: " << error.what() << '\n' << kUsage;
    return 2;
  }
  std::cout << fmt::format("{} on platform, {} episodes, {} first guess{}\n", name(request.kind), request.episodes,
                           request.prior ? "with" : "without",
                           request.legacy_terminals ? ", ends of episodes not stored" : "")
            << "  seed  mean training return by quarter  | greedy arrived    steps  seconds\n";
  std::vector<double> returns;
  for (int i = 0; i < request.seeds; ++i) {
    const std::uint64_t seed = request.first_seed + static_cast<std::uint64_t>(i);
    const Result result = train(request, seed);
    print_row(seed, result);
    returns.push_back(result.greedy.mean_return);
  }
  print_summary(returns);
}
