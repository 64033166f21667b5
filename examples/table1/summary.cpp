#include "table1/summary.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace table1 {

using namespace modsearch;

namespace {

double mean(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

// Mean and the percentile bootstrap's 95 % interval of it (Efron 1979): values of a few kinds, far from normal.
std::string with_interval(const std::vector<double>& values, int digits) {
  if (values.size() < 2) return values.empty() ? "-" : fmt::format("{:.{}f}", values.front(), digits);
  constexpr int kResamples = 10'000;
  Rng rng{0};
  std::vector<double> means;
  for (int i = 0; i < kResamples; ++i) {
    double sum = 0.0;
    for (std::size_t j = 0; j < values.size(); ++j) {
      sum += values[static_cast<std::size_t>(rng.index(static_cast<int>(values.size())))];
    }
    means.push_back(sum / static_cast<double>(values.size()));
  }
  std::sort(means.begin(), means.end());
  return fmt::format("{:.{}f} [{:.{}f}, {:.{}f}]", mean(values), digits, means[kResamples / 40], digits,
                     means[kResamples - 1 - kResamples / 40], digits);
}

// k of n and Wilson's 95 % interval of the share (Wilson 1927): sound for few trainings and for shares of 0 and 1.
std::string share_with_interval(int k, int n) {
  constexpr double z = 1.96;
  const double p = static_cast<double>(k) / n;
  const double centre = (p + z * z / (2.0 * n)) / (1.0 + z * z / n);
  const double half = z / (1.0 + z * z / n) * std::sqrt(p * (1.0 - p) / n + z * z / (4.0 * n * n));
  return fmt::format("{} of {} [{:.0f}, {:.0f} %]", k, n, 100.0 * std::max(0.0, centre - half),
                     100.0 * std::min(1.0, centre + half));
}

std::vector<std::string> names_of(const std::vector<CellResult>& cells) {
  std::vector<std::string> names;
  for (const CellResult& cell : cells) {
    if (std::find(names.begin(), names.end(), cell.row) == names.end()) names.push_back(cell.row);
  }
  return names;
}

std::string line(const std::string& row, const std::vector<CellResult>& cells) {
  std::vector<double> final_return;
  std::vector<double> exact_score;
  std::vector<double> stabilised;
  std::vector<double> episodes;
  std::vector<double> seconds;
  int one_module = 0;
  int ever = 0;
  int n = 0;
  for (const CellResult& cell : cells) {
    if (cell.row != row) continue;
    ++n;
    final_return.push_back(cell.final_return);
    exact_score.push_back(cell.exact_score);
    episodes.push_back(static_cast<double>(cell.episodes));
    seconds.push_back(cell.seconds_per_1000);
    one_module += cell.types == "hinge" && cell.final_one_step > 0.5;
    ever += cell.first_one_step.has_value();
    if (cell.stabilised_after) stabilised.push_back(static_cast<double>(*cell.stabilised_after));
  }
  return fmt::format("| {} | {} | {} | {} | {} | {} of {}{} | {:.0f} | {} |\n", row, share_with_interval(one_module, n),
                     with_interval(final_return, 1), with_interval(exact_score, 1), ever, stabilised.size(), n,
                     stabilised.empty() ? "" : ": " + with_interval(stabilised, 0), mean(episodes),
                     with_interval(seconds, 2));
}

Design random_design(const DesignProblem& problem, int n, Rng& rng) {
  Design design;
  for (int i = 0; i < n; ++i) {
    const std::vector<int> allowed = problem.successors(design.types());
    Placement placement{allowed[static_cast<std::size_t>(rng.index(static_cast<int>(allowed.size())))], {}};
    const std::vector<ParameterRange>& ranges = problem.library().type(placement.type).parameters;
    placement.parameters.resize(static_cast<Eigen::Index>(ranges.size()));
    for (std::size_t p = 0; p < ranges.size(); ++p) {
      placement.parameters[static_cast<Eigen::Index>(p)] = rng.uniform(ranges[p].lower, ranges[p].upper);
    }
    design.modules.push_back(std::move(placement));
  }
  return design;
}

}  // namespace

std::string summary_markdown(const std::vector<CellResult>& cells) {
  std::string text =
      "| row | ends with one hinge | final average return | exact score of the final design | one step, ever "
      "| stabilised, after episodes | episodes trained | s per 1000 episodes |\n|---|---|---|---|---|---|---|---|\n";
  for (const std::string& row : names_of(cells)) text += line(row, cells);
  return text + "\nMeans over trainings, [95 % intervals]: percentile bootstrap of the mean, Wilson's for shares.\n";
}

std::string failure_rates_markdown(const CellRequest& request) {
  constexpr int kDesigns = 20'000;
  constexpr int kWanted = 2000;
  CellRequest exact = request;
  exact.ik.reset();
  const auto judged = source_of(request)(Rng{request.seed});
  const auto truth = source_of(exact)(Rng{request.seed});
  std::string text = "| modules | reachable of random designs | of these missed |\n|---|---|---|\n";
  for (int n = 1; n <= 3; ++n) {
    Rng rng = Rng{request.seed}.fork(static_cast<std::uint64_t>(n));
    int reachable = 0;
    int missed = 0;
    int drawn = 0;
    // One module reaches once in 1500 draws: more of them.
    for (; drawn < (n == 1 ? 50 * kDesigns : kDesigns) && reachable < kWanted; ++drawn) {
      const Design design = random_design(*truth, n, rng);
      if (!truth->evaluate(design).attempt.reached) continue;
      ++reachable;
      missed += !judged->evaluate(design).attempt.reached;
    }
    text += fmt::format("| {} | {} of {} | {} |\n", n, reachable, drawn,
                        reachable == 0 ? "-" : share_with_interval(missed, reachable));
  }
  return text;
}

}  // namespace table1
