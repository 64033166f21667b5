// How many generated tasks are proved infeasible, what that takes and what bound is left: the table of
// docs/infeasible.md.

#include <fmt/format.h>

#include <algorithm>
#include <ctime>
#include <limits>
#include <modsearch/problem/files.hpp>
#include <vector>

namespace {

using namespace modsearch;

double processor_milliseconds() { return 1e3 * static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

double best_bound(const RobotProblem& problem) {
  double best = -std::numeric_limits<double>::infinity();
  for (int n = 1; n < problem.max_modules(); ++n) best = std::max(best, problem.optimism_of_length(n).score);
  return best;
}

void table_row(const char* family) {
  constexpr std::uint64_t kInstances = 100;
  const ProblemFile file = load_problem_file(family);
  static_cast<void>(file.instance({.seed = 1})->infeasible());  // what belongs to the library is known from then on
  std::vector<double> times;
  std::vector<double> bounds;
  std::string which;
  int proved = 0;
  for (std::uint64_t i = 0; i < kInstances; ++i) {
    const auto problem = file.instance({.seed = 0, .index = i});
    const double begun = processor_milliseconds();
    const bool infeasible = problem->infeasible().has_value();
    times.push_back(processor_milliseconds() - begun);
    if (!infeasible) bounds.push_back(best_bound(*problem));
    if (infeasible) which += fmt::format(" {}", i);
    proved += infeasible ? 1 : 0;
  }
  std::sort(times.begin(), times.end());
  std::sort(bounds.begin(), bounds.end());
  fmt::print("| `{}` | {} of {} |{} | {:.2f}, {:.2f}, {:.2f} ms | {:.2f} |\n", family, proved, kInstances, which,
             times[times.size() / 2], times[times.size() * 9 / 10], times.back(), bounds[bounds.size() / 2]);
}

}  // namespace

int main() {
  fmt::print("| family | proved infeasible | which | time: median, 90 %, worst | bound of the others: median |\n");
  fmt::print("|---|---|---|---|---|\n");
  for (const char* family : {"whitman/3g_3o", "whitman/3g_3o_free", "whitman/5g_5o", "whitman/5g_5o_free"}) {
    table_row(family);
  }
}
