// Step 2: let a solver look for designs, with a budget and a trace of its improvements.
#include <iostream>
#include <modsearch/modsearch.hpp>

int main() {
  using namespace modsearch;
  const auto problem = load_problem("seed/fixed");

  // 1. The meter counts, keeps the best and says when it is time to stop: every solver is charged alike.
  Meter meter{{.evaluations = 20'000}};

  // 2. Any solver: here the bar that every method has to clear. The seed makes it repeatable.
  const Solution solution = RandomSearch{}.solve(*problem, meter, Rng{0});

  // 3. How it went, and what came of it.
  for (const TracePoint& point : meter.trace()) {
    std::cout << point.evaluations << " evaluations: " << point.score << (point.achieved ? "" : " (not achieved)") << '\n';
  }
  std::cout << "random search: " << to_string(problem->library(), solution.design) << " scores "
            << solution.evaluation.score << " after " << solution.spent.evaluations << " evaluations\n";
}
