#pragma once

#include <filesystem>
#include <modsearch/solvers/search.hpp>
#include <string>

namespace modsearch {

/// Where a search is kept while it runs.
struct Checkpointing {
  std::filesystem::path file;
  double period =
      10.0;  ///< least time between two checkpoints [s]; 0: after every step. Arbitrary: what a crash may cost
  bool resume = false;     ///< begin where `file` ends, if it exists
  std::string identity{};  ///< what else has to be the same for the search to go on: options, seed; in words
};

/// Solves like `solver.solve(problem, meter, rng)` and writes a checkpoint at the beginning, now and then, and where
/// the meter ends the search before it is over (that of half a second earlier, more where states are large), whole or
/// not at all. Killed at any moment and resumed with the same arguments, or with a larger budget, it ends with the same
/// solution as an uninterrupted search (but for what a budget of seconds cuts off). A search that is over leaves its
/// last checkpoint. Throws FileError for a checkpoint that cannot be read or written, that another search is
/// kept in, or that belongs to another solver, problem or identity.
[[nodiscard]] Solution solve(const SteppedSolver& solver, const DesignProblem& problem, Meter& meter, Rng rng,
                             const Checkpointing& checkpointing);

}  // namespace modsearch
