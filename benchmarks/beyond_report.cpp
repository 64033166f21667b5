// What agents of preset `best` and its raw variants learn on the built-in problems, beside the control: random
// parameters of the type that solves these problems, refined in the same way and in the same number of proposals.
// Prints a table in Markdown.
//
//   beyond_report [--row NAME] [--seeds N] [--held-out N] [key=value ..]
//
// Held-out targets are instances 0 .. N - 1 of seed 1; trainings draw theirs from all 64-bit numbers. Settings given
// as key=value replace those of every row.
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <limits>
#include <memory>
#include <modsearch/baselines/per_sequence.hpp>
#include <modsearch/rl/learner.hpp>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace modsearch {
namespace {

using Changes = std::vector<std::pair<std::string, std::string>>;

/// What a design that misses its task counts at most: what two modules score at their best, rounded down.
constexpr double kMissed = 180.0;
constexpr std::uint64_t kHeldOutSeed = 1;
/// Draws of the control where there is only one target.
constexpr int kControlDraws = 1000;

struct Row {
  std::string name;
  std::string problem;
  std::string what;
  AgentKind kind = AgentKind::kMpdqn;
  Changes changes;  ///< of preset `best`
};

// The policy's own proposal is the design, so it has to be right to the millimetre. Whitened inputs and a passthrough
// that learns make what is linear in the observation exact: the distance from the axis at 0.5 m, where the hinge sits
// when the first length rests at its bound. Past the bound (`bounds=zero`) that length may bend without showing it.
Changes exact() {
  return {
      {"polish", "0"},         {"model_joints", "2"},         {"bounds", "zero"},        {"bound", "1.3"},
      {"whiten", "1000"},      {"axis_heights", "0.5/1/1.5"}, {"leak", "0.1"},           {"passthrough_rate", "0.01"},
      {"actor_rate", "0.003"}, {"actor_hidden", "64x32"},     {"value_hidden", "64"},    {"smoothing", "0.01"},
      {"decay_from", "0.2"},   {"decay_to", "0.001"},         {"updates_per_step", "4"}, {"epsilon_episodes", "500"}};
}

Changes with(Changes changes, const Changes& more) {
  changes.insert(changes.end(), more.begin(), more.end());
  return changes;
}

// The actor follows the polish of its own proposals, the critic only chooses the type.
Changes raw(const std::string& episodes, const std::string& actor_hidden) {
  return with(exact(), {{"critic", "0"},
                        {"model_gradient", "0"},
                        {"model_mass", "0"},
                        {"model_pull", "10"},
                        {"model_taken", "true"},
                        {"hindsight", "1"},
                        {"episodes", episodes},
                        {"actor_hidden", actor_hidden}});
}

// The polish knows nothing of obstacles: it only holds the proposal on the curve of designs that reach, along which the
// critic moves it.
Changes raw_among_obstacles() {
  return with(exact(), {{"critic", "0.3"},
                        {"model_gradient", "0"},
                        {"model_mass", "0"},
                        {"model_pull", "300"},
                        {"pull_width", "0.003"},
                        {"pull_mass", "false"},
                        {"model_taken", "true"},
                        {"bound", "1.05"},
                        {"axis_heights", "0.5/0.75/1/1.25/1.5"},
                        {"noise", "none"},
                        {"epsilon_last", "0.2"},
                        {"value_hidden", "128"},
                        {"actor_hidden", "64x64"},
                        {"episodes", "22000"},
                        {"updates_per_step", "3"},
                        {"decay_to", "0.002"}});
}

// No derivative of the model anywhere: relabelled placements show the critic where the goal is reached.
Changes without_derivatives() {
  return with(exact(), {{"critic", "1"},
                        {"model_gradient", "0"},
                        {"model_mass", "0"},
                        {"hindsight", "4"},
                        {"episodes", "8000"},
                        {"value_hidden", "256x256"},
                        {"updates_per_step", "2"},
                        {"epsilon_episodes", "1000"},
                        {"decay_from", "0.3"},
                        {"decay_to", "0.003"}});
}

std::vector<Row> rows() {
  return {
      {.name = "fixed-raw",
       .problem = "seed/fixed",
       .what = "raw, model gradient",
       .changes = {{"polish", "0"},
                   {"model_gradient", "50"},
                   {"model_mass", "5"},
                   {"critic", "0"},
                   {"bound", "2"},
                   {"updates_per_step", "8"},
                   {"actor_rate", "0.0003"},
                   {"epsilon_episodes", "60"},
                   {"epsilon_last", "0.1"},
                   {"decay_from", "0.05"},
                   {"decay_to", "0.003"}}},
      {.name = "fixed", .problem = "seed/fixed", .what = "polished", .changes = {}},
      {.name = "narrow-no-derivatives",
       .problem = "seed/random_narrow",
       .what = "raw, no model derivative",
       .changes = without_derivatives()},
      {.name = "narrow-raw",
       .problem = "seed/random_narrow",
       .what = "raw, model pull",
       .changes = raw("12000", "64x32")},
      {.name = "narrow", .problem = "seed/random_narrow", .what = "one polished proposal", .changes = {}},
      {.name = "wide-raw", .problem = "seed/random_wide", .what = "raw, model pull", .changes = raw("12000", "64x64")},
      {.name = "wide", .problem = "seed/random_wide", .what = "one polished proposal", .changes = {}},
      {.name = "obstacles-raw",
       .problem = "seed/random_obstacles",
       .what = "raw, model pull and critic",
       .changes = raw_among_obstacles()},
      {.name = "obstacles", .problem = "seed/random_obstacles", .what = "one polished proposal", .changes = {}},
  };
}

/// Designs for a set of tasks, in numbers.
struct Quality {
  double one = 0.0;           ///< share of tasks achieved with one module, clear of obstacles
  double achieved = 0.0;      ///< with any number
  double score = 0.0;         ///< mean
  double regret = 0.0;        ///< best score less the design's, one that misses its task counted with kMissed at most
  double score_regret = 0.0;  ///< the same with every design's own score
};

class Tally {
 public:
  void add(double best, double score, bool achieved, int n_modules) {
    ++n_;
    sum_.one += achieved && n_modules == 1;
    sum_.achieved += achieved;
    sum_.score += score;
    sum_.regret += best - (achieved ? score : std::min(score, kMissed));
    sum_.score_regret += best - score;
  }
  [[nodiscard]] Quality mean() const {
    const double n = std::max(n_, 1);
    return {sum_.one / n, sum_.achieved / n, sum_.score / n, sum_.regret / n, sum_.score_regret / n};
  }

 private:
  int n_ = 0;
  Quality sum_;
};

/// The tasks nobody was trained on, with the best score that is known for each.
struct HeldOut {
  std::vector<std::shared_ptr<const RobotProblem>> problems;
  std::vector<double> best;
};

HeldOut held_out(const ProblemFile& file, int n) {
  HeldOut result;
  for (int i = 0; i < (file.sampling ? n : 1); ++i) {
    result.problems.push_back(file.instance({kHeldOutSeed, static_cast<std::uint64_t>(i)}));
    Meter meter;
    result.best.push_back(PerSequence{}.solve(*result.problems.back(), meter, Rng{0}).evaluation.score);
  }
  return result;
}

/// One training and what came of it.
struct Outcome {
  Quality quality;
  std::int64_t stabilised = -1;  ///< episodes until the first of ten evaluations that are all one-step; -1: never
  double training_seconds = 0.0;
  double microseconds = 0.0;  ///< per task, solved by the policy
};

Outcome train(const ProblemFile& file, const LearnerSettings& settings, const HeldOut& tasks, std::uint64_t seed) {
  Meter training_meter{{.evaluations = std::numeric_limits<std::int64_t>::max()}};
  const Training training = AgentLearner{settings}.train(problem_source(file), training_meter, Rng{seed});
  Outcome outcome;
  outcome.stabilised = stabilised_after(training.history).value_or(-1);
  outcome.training_seconds = training.history.back().seconds;
  Tally tally;
  double seconds = 0.0;
  for (std::size_t i = 0; i < tasks.problems.size(); ++i) {
    Meter meter;
    const Solution solution = training.policy->solve(*tasks.problems[i], meter, Rng{i});
    seconds += meter.progress().seconds;
    tally.add(tasks.best[i], solution.evaluation.score, solution.evaluation.attempt.achieved,
              static_cast<int>(solution.design.modules.size()));
  }
  outcome.quality = tally.mean();
  outcome.microseconds = 1e6 * seconds / static_cast<double>(tasks.problems.size());
  return outcome;
}

/// Uniform parameters of a hinge, refined as the policy's are; the best of as many proposals by its true reward.
Quality control(const LearnerSettings& settings, const HeldOut& tasks) {
  const int draws = tasks.problems.size() == 1 ? kControlDraws : static_cast<int>(tasks.problems.size());
  ActingOptions acting = settings.training.acting;
  const int proposals = acting.proposals;
  acting.proposals = 1;
  Tally tally;
  for (int draw = 0; draw < draws; ++draw) {
    const std::size_t task = static_cast<std::size_t>(draw) % tasks.problems.size();
    const auto& problem = tasks.problems[task];
    DesignEnvironment environment{[&problem](Rng) { return problem; }, settings.environment};
    environment.reset(Rng{0});
    Rng rng = Rng{5}.fork(static_cast<std::uint64_t>(draw));
    HybridAction best;
    double best_reward = -std::numeric_limits<double>::infinity();
    for (int i = 0; i < proposals; ++i) {
      HybridAction action;
      action.k = problem->library().find("hinge").value();
      action.x.resize(environment.space().n_parameters());
      for (float& value : action.x) value = static_cast<float>(rng.uniform(-1.0, 1.0));
      Work work;
      action = refined(action, environment, acting, rng, work);
      const auto x_k = action.x.segment(environment.space().offset(action.k), environment.space().count(action.k));
      const double reward =
          environment.preview(action.k, {x_k.data(), static_cast<std::size_t>(x_k.size())}).value_or(best_reward);
      if (i > 0 && reward <= best_reward) continue;
      best = action;
      best_reward = reward;
    }
    static_cast<void>(environment.step(best));
    const Evaluation& evaluation = environment.evaluation().value();
    tally.add(tasks.best[task], evaluation.score, evaluation.attempt.achieved, 1);
  }
  return tally.mean();
}

/// Mean over the seeds and, in brackets, least and greatest.
template <typename Number>
std::string spread(const std::vector<Outcome>& outcomes, int digits, Number number) {
  double sum = 0.0;
  double least = number(outcomes.front());
  double greatest = least;
  for (const Outcome& outcome : outcomes) {
    sum += number(outcome);
    least = std::min(least, number(outcome));
    greatest = std::max(greatest, number(outcome));
  }
  return fmt::format("{:.{}f} [{:.{}f}, {:.{}f}]", sum / static_cast<double>(outcomes.size()), digits, least, digits,
                     greatest, digits);
}

void print_row(const Row& row, const std::vector<Outcome>& outcomes, const Quality& beside) {
  const bool one_target = row.problem == "seed/fixed";
  std::string stabilised = "-";
  if (one_target) {
    std::vector<std::int64_t> episodes;
    for (const Outcome& o : outcomes) {
      if (o.stabilised >= 0) episodes.push_back(o.stabilised);
    }
    stabilised = fmt::format("{} of {}", episodes.size(), outcomes.size());
    if (!episodes.empty()) stabilised += fmt::format(", <= {}", *std::max_element(episodes.begin(), episodes.end()));
  }
  fmt::print("| {} | {} | {} | {} | {} | {} | {} | {} | {} / {} |\n", row.name, row.what,
             spread(outcomes, 4, [](const Outcome& o) { return o.quality.one; }),
             spread(outcomes, 3, [](const Outcome& o) { return o.quality.score; }),
             spread(outcomes, 3, [](const Outcome& o) { return o.quality.regret; }),
             spread(outcomes, 3, [](const Outcome& o) { return o.quality.score_regret; }), stabilised,
             spread(outcomes, 1, [](const Outcome& o) { return o.training_seconds; }),
             fmt::format("{:.4f}", beside.one), fmt::format("{:.3f}", beside.regret));
  std::fflush(stdout);
}

struct Arguments {
  std::string row;
  int seeds = 5;
  int held_out = 1000;
  Changes changes;
};

int count_of(std::string_view option, std::string_view text) {
  int value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || value < 1) {
    throw std::invalid_argument(fmt::format("{} {}: not a number of at least 1", option, text));
  }
  return value;
}

Arguments parsed(const std::vector<std::string>& words) {
  Arguments arguments;
  for (std::size_t i = 0; i < words.size(); ++i) {
    const std::string& word = words[i];
    if (const std::size_t equals = word.find('='); equals != std::string::npos) {
      arguments.changes.emplace_back(word.substr(0, equals), word.substr(equals + 1));
      continue;
    }
    if (word != "--row" && word != "--seeds" && word != "--held-out") {
      throw std::invalid_argument(fmt::format("{}: only --row, --seeds, --held-out and key=value are known", word));
    }
    if (++i == words.size()) throw std::invalid_argument(fmt::format("{}: a value is missing", word));
    if (word == "--row") arguments.row = words[i];
    if (word == "--seeds") arguments.seeds = count_of(word, words[i]);
    if (word == "--held-out") arguments.held_out = count_of(word, words[i]);
  }
  return arguments;
}

void run(const Row& row, const Arguments& arguments) {
  const ProblemFile file = load_problem_file(row.problem);
  LearnerSettings settings = settings_of(row.kind, Preset::kBest, traits_of(file));
  settings.environment.hindsight_region = file.sampling;
  settings.training.final_episodes = 1;  // the held-out tasks say more
  for (const auto& [key, value] : row.changes) apply_setting(settings, key, value);
  for (const auto& [key, value] : arguments.changes) apply_setting(settings, key, value);

  const HeldOut tasks = held_out(file, arguments.held_out);
  std::vector<Outcome> outcomes;
  for (int seed = 0; seed < arguments.seeds; ++seed) {
    outcomes.push_back(train(file, settings, tasks, static_cast<std::uint64_t>(seed)));
    const Outcome& o = outcomes.back();
    fmt::print(stderr,
               "{} seed {}: one {:.4f} achieved {:.4f} score {:.4f} regret {:.4f} ({:.4f} by score) stabilised {} "
               "training {:.1f} s, {:.1f} us per task\n",
               row.name, seed, o.quality.one, o.quality.achieved, o.quality.score, o.quality.regret,
               o.quality.score_regret, o.stabilised, o.training_seconds, o.microseconds);
  }
  print_row(row, outcomes, control(settings, tasks));
}

void run_all(const Arguments& arguments) {
  const std::vector<Row> all = rows();
  const auto wanted = [&](const Row& row) { return arguments.row.empty() || row.name == arguments.row; };
  if (std::none_of(all.begin(), all.end(), wanted)) {
    std::string names;
    for (const Row& row : all) names += ' ' + row.name;
    throw std::invalid_argument(fmt::format("--row {}: there are only{}", arguments.row, names));
  }
  fmt::print(
      "| row | acting | one module | score | regret | regret by score | one-step, episodes | training [s] | control: "
      "one "
      "module / regret |\n|---|---|---|---|---|---|---|---|---|\n");
  for (const Row& row : all) {
    if (wanted(row)) run(row, arguments);
  }
}

}  // namespace
}  // namespace modsearch

int main(int argc, char** argv) {
  try {
    modsearch::run_all(modsearch::parsed({argv + 1, argv + argc}));
  } catch (const std::exception& e) {
    fmt::print(stderr, "beyond_report: {}\n", e.what());
    return 1;
  }
  return 0;
}
