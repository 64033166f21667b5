#pragma once

#include <modsearch/problem/rng.hpp>
#include <modsearch/solvers/meter.hpp>
#include <string>

namespace modsearch {

/// An upper bound on the score of every achieved design, and how it is known.
struct Bound {
  double score = std::numeric_limits<double>::infinity();
  std::string reason;
};

/// What a solver gives back.
struct Solution {
  Design design;
  Evaluation evaluation;
  Progress spent;
  StopReason stop = StopReason::kExhausted;
  std::string reason;         ///< in words, where there is something to say: what is proved, what was not found
  std::optional<Bound> bound;
};

/// Finds good designs for a problem. Stateless: options are given at construction, randomness comes from `rng`, what is
/// spent goes through the meter.
class Solver {
 public:
  virtual ~Solver() = default;
  [[nodiscard]] virtual std::string name() const = 0;
  /// Searches until the meter says stop or the solver has nothing left to try. Equal arguments give equal solutions
  /// (unless a budget of seconds cuts in). The best design evaluated through the meter is the answer; without any, the
  /// empty design.
  [[nodiscard]] Solution solve(const DesignProblem& problem, Meter& meter, Rng rng) const;

 private:
  /// Why the search ended, and what to say about it.
  struct End {
    StopReason stop = StopReason::kExhausted;
    std::string reason;
    std::optional<Bound> bound;
  };
  friend class Search;
  [[nodiscard]] virtual End do_solve(const DesignProblem& problem, Meter& meter, Rng rng) const = 0;

 protected:
  using SearchEnd = End;
};

}  // namespace modsearch
