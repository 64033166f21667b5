// What a solver makes of real arms for real tasks in so many seconds of processor time: one line of CSV per instance of
// a family on stdout, a summary on stderr.
//
//   real_arms whitman/3g_3o [--seed 0] [--from 0] [--to 19] [--solver auto] [--seconds 60] [--check] [--tables DIR]
//
// Instances are solved one at a time, and time is that of this process, so that a busy machine is as good as an idle
// one. A solver is stopped at the next evaluation after its time is up; what was achieved later than that does not
// count.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <map>
#include <modsearch/problem/files.hpp>
#include <modsearch/problem/nearest_miss.hpp>
#include <modsearch/solvers/verification.hpp>
#include <modsearch/study/best_known.hpp>
#include <optional>

#include "app/solver_registry.hpp"

namespace modsearch {
namespace {

// Of this process so far, all of its threads [s].
double processor_time() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

struct Arguments {
  std::string family;
  std::string solver = "auto";
  std::uint64_t seed = 0;  // of the family
  std::uint64_t from = 0;
  std::uint64_t to = 19;
  double seconds = 60.0;
  bool check = false;
  std::filesystem::path tables = "data/best_known";
};

// Follows a meter by processor time: when the best achieved design improved, and in which stage the time went.
class Watch {
 public:
  explicit Watch(double seconds) : seconds_{seconds}, start_{processor_time()} {}

  void look(const Meter& meter) {
    const double now = processor_time() - start_;
    stages_[stage_] += now - last_;
    last_ = now;
    // What follows the first colon of a stage are counts.
    stage_ = meter.stage().substr(0, meter.stage().find(':'));
    if (meter.trace().size() > seen_) {
      seen_ = meter.trace().size();
      const Incumbent& best = *meter.best();
      if (best.evaluation.attempt.achieved && now <= seconds_) improvements_.push_back({now, best});
    }
    if (now >= seconds_) stop_.request_stop();
  }

  // The score of the best achieved design `seconds` after the start; nothing: there was none.
  [[nodiscard]] std::optional<double> score_at(double seconds) const {
    std::optional<double> score;
    for (const auto& [time, best] : improvements_) {
      if (time <= seconds) score = best.evaluation.score;
    }
    return score;
  }
  [[nodiscard]] const std::vector<std::pair<double, Incumbent>>& improvements() const { return improvements_; }
  [[nodiscard]] double spent() const { return last_; }
  [[nodiscard]] std::stop_token token() const { return stop_.get_token(); }

  // "poses 61 %; evaluation 39 %", the largest share first.
  [[nodiscard]] std::string stages() const {
    std::vector<std::pair<double, std::string>> shares;
    for (const auto& [stage, time] : stages_) shares.emplace_back(time / std::max(last_, 1e-9), stage);
    std::sort(shares.rbegin(), shares.rend());
    std::vector<std::string> texts;
    for (const auto& [share, stage] : shares) {
      if (share >= 0.005) texts.push_back(fmt::format("{} {:.0f} %", stage.empty() ? "-" : stage, 100.0 * share));
    }
    return fmt::format("{}", fmt::join(texts, "; "));
  }

 private:
  double seconds_;
  double start_;
  double last_ = 0.0;
  std::size_t seen_ = 0;
  std::string stage_;
  std::map<std::string, double> stages_;
  std::vector<std::pair<double, Incumbent>> improvements_;
  std::stop_source stop_;
};

struct Row {
  bool proved_infeasible = false;
  std::optional<double> first;  // processor time to the first achieved design [s]
  std::vector<std::optional<double>> scores;
};

const std::vector<double> kMarks{1.0, 10.0, 60.0};  // [s]

std::string number_or_nothing(const std::optional<double>& value, int digits = 4) {
  return value && std::isfinite(*value) ? fmt::format("{:.{}f}", *value, digits) : std::string{};
}

// A field of CSV, in quotes.
std::string quoted(std::string text) {
  std::replace(text.begin(), text.end(), '"', '\'');
  return '"' + text + '"';
}

bool verifies(const RobotProblem& problem, const Incumbent& found) {
  const Evaluation& evaluation = found.evaluation;
  return verify(problem, found.design,
                {.score = evaluation.score, .achieved = true, .postures = evaluation.attempt.postures})
      .verified;
}

// The first and the last achieved design are what they say: "yes", "no", or empty where nobody asked or none is there.
std::string checked(const Arguments& arguments, const RobotProblem& problem, const Watch& watch) {
  if (!arguments.check || watch.improvements().empty()) return "";
  const bool good =
      verifies(problem, watch.improvements().front().second) && verifies(problem, watch.improvements().back().second);
  return good ? "yes" : "no";
}

std::string missed(const RobotProblem& problem, const Solution& solution) {
  if (!solution.nearest) return "";
  const Design& design = solution.nearest->design;
  return nearest_miss(problem, design, problem.evaluate(design)).words();
}

std::optional<BestKnownTable> known_designs(const Arguments& arguments) {
  const std::filesystem::path file = best_known_file(arguments.tables, arguments.family);
  if (!std::filesystem::exists(file)) return std::nullopt;
  return load_best_known(file);
}

Row run(const Arguments& arguments, const Solver& solver, const std::optional<BestKnownTable>& known,
        std::uint64_t index) {
  const Instance instance{arguments.seed, index};
  const auto problem = load_problem(arguments.family, instance);
  Watch watch{arguments.seconds};
  constexpr std::int64_t kNoLimit = std::numeric_limits<std::int64_t>::max();
  Meter meter{{.evaluations = kNoLimit}, [&](const Meter& m) { watch.look(m); }, watch.token()};
  const Solution solution = solver.solve(*problem, meter, Rng{0});
  watch.look(meter);
  const bool ended_itself = solution.stop != StopReason::kInterrupted;

  Row row{.proved_infeasible = solution.stop == StopReason::kUnreachable, .first = {}, .scores = {}};
  if (!watch.improvements().empty()) row.first = watch.improvements().front().first;
  for (const double mark : kMarks) {
    // Nothing is known of a time that the run did not get to.
    const bool got_there = ended_itself || mark <= arguments.seconds;
    row.scores.push_back(got_there ? watch.score_at(mark) : std::nullopt);
  }
  const std::optional<double> score = watch.score_at(arguments.seconds);
  std::optional<double> gap, regret;
  if (score && solution.bound) gap = solution.bound->score - *score;
  const BestKnown* best = known ? known->find(instance) : nullptr;
  if (score && best != nullptr) regret = best->score - *score;

  std::vector<std::string> fields{std::to_string(index), row.proved_infeasible ? "yes" : "no",
                                  number_or_nothing(row.first)};
  for (const auto& at_mark : row.scores) fields.push_back(number_or_nothing(at_mark));
  fields.push_back(number_or_nothing(score));
  fields.push_back(number_or_nothing(gap));
  fields.push_back(number_or_nothing(regret));
  fields.push_back(checked(arguments, *problem, watch));
  fields.push_back(std::to_string(solution.spent.evaluations));
  fields.push_back(fmt::format("{:.3f}", watch.spent()));
  fields.emplace_back(name(solution.stop));
  fields.push_back(quoted(watch.stages()));
  fields.push_back(quoted(score ? "" : row.proved_infeasible ? solution.reason : missed(*problem, solution)));
  fmt::print("{}\n", fmt::join(fields, ","));
  std::fflush(stdout);
  return row;
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  if (values.size() % 2 == 1) return *middle;
  return 0.5 * (*middle + *std::max_element(values.begin(), middle));
}

void summarise(const Arguments& arguments, const std::vector<Row>& rows) {
  std::vector<double> first;
  std::size_t proved = 0;
  for (const Row& row : rows) {
    if (row.first) first.push_back(*row.first);
    proved += row.proved_infeasible ? 1 : 0;
  }
  fmt::print(stderr, "{} on {}, instances {}:{} to {}:{}, {:g} s of processor time each\n", arguments.solver,
             arguments.family, arguments.seed, arguments.from, arguments.seed, arguments.to, arguments.seconds);
  fmt::print(stderr, "achieved {} of {}; {} proved infeasible, {} left open\n", first.size(), rows.size(), proved,
             rows.size() - first.size() - proved);
  if (!first.empty()) fmt::print(stderr, "first achieved design: median {:.3f} s\n", median(first));
  for (std::size_t m = 0; m < kMarks.size(); ++m) {
    std::vector<double> scores;
    for (const Row& row : rows) {
      if (row.scores[m]) scores.push_back(*row.scores[m]);
    }
    if (scores.empty()) continue;
    fmt::print(stderr, "after {:g} s: {} achieved, their median score {:.3f}\n", kMarks[m], scores.size(),
               median(scores));
  }
}

int main_of(int argc, char** argv) {
  Arguments arguments;
  CLI::App command{"What a solver makes of real arms for real tasks, by processor time"};
  command.add_option("FAMILY", arguments.family, "ID of a built-in problem, or a file")->required();
  command.add_option("--solver", arguments.solver, "as `modsearch solve` takes it")->capture_default_str();
  command.add_option("--seed", arguments.seed, "of the family")->capture_default_str();
  command.add_option("--from", arguments.from, "first instance")->capture_default_str();
  command.add_option("--to", arguments.to, "last instance")->capture_default_str();
  command.add_option("--seconds", arguments.seconds, "of processor time per instance")->capture_default_str();
  command.add_flag("--check", arguments.check, "verify the first and the last achieved design of each instance");
  command.add_option("--tables", arguments.tables, "folder of best known designs, for regret")->capture_default_str();
  CLI11_PARSE(command, argc, argv);
  const app::ChosenSolver chosen = app::choose_solver(arguments.solver);
  const std::optional<BestKnownTable> known = known_designs(arguments);
  fmt::print(
      "instance,proved_infeasible,first_s,score_1s,score_10s,score_60s,score,gap,regret,verified,evaluations,cpu_s,"
      "stop,stages,missed\n");
  std::vector<Row> rows;
  for (std::uint64_t i = arguments.from; i <= arguments.to; ++i) {
    rows.push_back(run(arguments, *chosen.solver, known, i));
  }
  summarise(arguments, rows);
  return 0;
}

}  // namespace
}  // namespace modsearch

int main(int argc, char** argv) {
  try {
    return modsearch::main_of(argc, argv);
  } catch (const std::exception& error) {
    fmt::print(stderr, "real_arms: {}\n", error.what());
    return 2;
  }
}
