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

/// Something that a search has counted.
struct Tally {
  std::string what;
  double count = 0.0;  ///< whole; exact up to 2^53
};

/// Why a search ended, and what there is to say about it.
struct SearchEnd {
  StopReason stop = StopReason::kExhausted;
  std::string reason;  ///< in words, where there is something to say: what is proved, what was not found
  std::optional<Bound> bound{};
  std::vector<Tally> tallies{};  ///< what the search counted, in its own order; most count nothing
};

/// What a solver gives back.
struct Solution {
  Design design;          ///< the best in full fidelity (standing, then score); empty if nothing was evaluated
  Evaluation evaluation;  ///< of `design`; score -inf if nothing was evaluated
  /// Where `design` is not achieved: the one that came nearest (Meter::nearest), for people; nearest_miss says by what
  /// it misses.
  std::optional<Incumbent> nearest;
  Progress spent;
  StopReason stop = StopReason::kExhausted;
  std::string reason;  ///< see SearchEnd
  std::optional<Bound> bound;
  std::vector<Tally> tallies;
};

/// Finds good designs for a problem. Stateless: options are given at construction, randomness comes from `rng`, what is
/// spent goes through the meter.
///
/// To write one, derive and implement `do_solve`: evaluate designs through the meter until it returns nothing, or until
/// there is nothing left to try, and say which it was. The meter remembers the best.
class Solver {
 public:
  virtual ~Solver() = default;
  /// As on the command line: "random", "per-sequence", ..
  [[nodiscard]] virtual std::string name() const = 0;
  /// Searches until the meter says stop or the solver has nothing left to try. Where the problem knows that no design
  /// is achieved (DesignProblem::infeasible), nothing is searched and that is the answer, whatever the solver. Equal
  /// arguments give equal solutions (unless a budget of seconds cuts in). The best design evaluated through the meter
  /// is the answer. Where the meter said stop, its reason is the solution's, except that a proof (optimal, unreachable)
  /// stands, unless an achieved design scores more than a bound of the problem or the solver: then that bound is wrong,
  /// which the reason says. Throws what the problem throws.
  [[nodiscard]] Solution solve(const DesignProblem& problem, Meter& meter, Rng rng) const;

 private:
  [[nodiscard]] virtual SearchEnd do_solve(const DesignProblem& problem, Meter& meter, Rng rng) const = 0;
};

}  // namespace modsearch
