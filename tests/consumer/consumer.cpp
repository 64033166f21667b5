// A program outside the source tree: solves the built-in reference problem with nothing but the installed package.
#include <cstdio>
#include <modsearch/modsearch.hpp>

int main() {
  const auto problem = modsearch::load_problem("seed/fixed");
  modsearch::Meter meter{modsearch::Budget{.evaluations = 20'000, .seconds = 60.0}};
  const modsearch::Solution best = modsearch::AutoSolver{}.solve(*problem, meter, modsearch::Rng{0});
  std::printf("score %.4f with %zu modules, %s\n", best.evaluation.score, best.design.modules.size(),
              best.evaluation.attempt.achieved ? "achieved" : "not achieved");
  // The optimum of this problem is 341.915.
  return best.evaluation.attempt.achieved && best.evaluation.score > 341.9 ? 0 : 1;
}
