#pragma once

#include <modsearch/problem/rng.hpp>
#include <modsearch/solvers/inner_solver.hpp>
#include <string>

namespace modsearch {

struct PerSequenceOptions {
  Inner inner = Inner::kOwn;  ///< method for the smooth program of each sequence: the fastest
  /// Low-discrepancy starts per sequence. Eight: local methods solve 60-95 % of single starts on chains of up to five
  /// joints, so eight miss a sequence in less than one case in a thousand.
  int starts = 8;
  InnerOptions inner_options{};
};

/// What came of a sequence besides the designs that were evaluated.
struct SequenceOutcome {
  bool has_program = false;  ///< the problem has a smooth program for it
  std::string failure;       ///< what the program threw, or that it was nowhere a number; empty: it did not fail
};

/// Solves the smooth program of one type sequence from several starts and evaluates every optimum for real. The program
/// is a relaxation (it ignores which posture the score looks at): where its optimum is in collision after all, it is
/// solved again with a larger clearance. Where it is feasible and the poses are missed after all, because a trajectory
/// leaves its tolerance between the knots of the program, it is solved again with more knots and some room. A program
/// that throws or is not a number fails alone; the meter's stop is heard at once. `bound`: no design of the sequence
/// scores more, so a design that does ends the work.
SequenceOutcome optimise_sequence(const DesignProblem& problem, std::span<const int> types, double bound,
                                  const PerSequenceOptions& options, Meter& meter, Rng rng);

}  // namespace modsearch
