// Step 1: score a design by hand. Build and run:
//   find_package(modsearch CONFIG REQUIRED)
//   target_link_libraries(your_program PRIVATE modsearch::baselines)
#include <cmath>
#include <iostream>
#include <modsearch/modsearch.hpp>

int main() {
  using namespace modsearch;

  // 1. A problem: reach (1, 0, 1) within 1 mm, with modules of the built-in library `seed`.
  const auto problem = load_problem("seed/fixed");

  // 2. A design: one hinge, 0.5 m before the joint and just enough behind it. The base is always there.
  const int hinge = problem->library().find("hinge").value();
  Placement placement{hinge, Parameters(2)};
  placement.parameters << 0.5, std::sqrt(1.25);
  const Design design{{placement}};

  // 3. What it is worth, term by term.
  const Evaluation evaluation = problem->evaluate(design);
  std::cout << to_string(problem->library(), design) << " scores " << evaluation.score << '\n';
  for (const Term& term : evaluation.terms.items()) std::cout << "  " << name(term.id) << ' ' << term.value << '\n';

  // 4. Whether it does what was asked, and the joint angles that do it (base first).
  std::cout << (evaluation.attempt.achieved ? "achieved" : "not achieved") << " with q = "
            << evaluation.attempt.postures.row(0) << '\n';
}
