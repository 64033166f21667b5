#pragma once

#include <modsearch/solvers/inner_solver.hpp>
#include <optional>

namespace modsearch {

/// Where local minimisation of a smooth program takes `design`: the memetic step of evolutionary methods. Starts at the
/// design itself and, where the program's variables are (x, q per goal), at its own postures, which one more evaluation
/// looks up. `clearance`: least clearance asked of the program [m]. Nothing: the meter said stop, the problem has no
/// smooth program for these types, or the program or the method failed; what comes back has not been evaluated.
/// `iterations`: at most.
[[nodiscard]] std::optional<Design> polished(const DesignProblem& problem, const Design& design, double clearance,
                                             Inner inner, Meter& meter, int iterations = InnerOptions{}.max_iterations);

}  // namespace modsearch
