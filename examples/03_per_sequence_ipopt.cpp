// Step 3: optimise the lengths of each type sequence with Ipopt, then prove by planning that the arm gets there.
#include <iostream>
#include <modsearch/modsearch.hpp>

int main() {
  using namespace modsearch;
  const auto problem = load_problem("seed/random_obstacles", {.seed = 0, .index = 3});

  // 1. Type sequences in order of an optimistic bound, each solved as a smooth program from a few starts.
  Meter meter;
  const Solution best = PerSequence{{.inner = Inner::kIpopt, .starts = 4}}.solve(*problem, meter, Rng{0});
  std::cout << to_string(problem->library(), best.design) << " scores " << best.evaluation.score << '\n'
            << best.reason << '\n';

  // 2. From scratch: score, collision, and a path from home to the goal, looked at ten times finer than it was planned.
  const Verification verification = verify(*problem, best.design, {.score = best.evaluation.score});
  for (const std::string& finding : verification.findings) std::cout << "finding: " << finding << '\n';
  std::cout << (verification.verified ? "verified by a path" : "not verified") << '\n';
}
