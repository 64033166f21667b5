#pragma once

#include <modsearch/baselines/sequence_frontier.hpp>
#include <modsearch/baselines/sequence_optimum.hpp>
#include <modsearch/solvers/search.hpp>
#include <string>

namespace modsearch {

/// Type sequences one after the other, in falling order of their bounds, each optimised on its own, until no other can
/// beat the best. What `per-sequence` and `enumerate` have in common.
class SequenceSearch : public Search {
 public:
  /// `problem` must outlive it.
  SequenceSearch(const DesignProblem& problem, PerSequenceOptions options, Rng rng);

  /// One sequence per step.
  [[nodiscard]] std::optional<SearchEnd> step(Meter& meter) final;
  void save(Archive& archive) const final;
  void restore(const Archive& archive) final;

 protected:
  /// What to do with a sequence that has parameters and no smooth program: nothing by default. False: nothing was done.
  virtual bool optimise_without_program(const SequenceFrontier::Sequence&, Rng, Meter&) { return false; }
  [[nodiscard]] const DesignProblem& problem() const { return problem_; }

 private:
  // Evaluates what is worth evaluating of the sequence. True: nothing better is left of it, which is then proved.
  [[nodiscard]] bool settle(const SequenceFrontier::Sequence& sequence, Rng rng, Meter& meter);
  [[nodiscard]] SearchEnd end(const Meter& meter) const;
  [[nodiscard]] std::string failures() const;
  [[nodiscard]] std::optional<Bound> bound(const Meter& meter) const;

  const DesignProblem& problem_;
  PerSequenceOptions options_;
  Rng rng_;
  SequenceFrontier frontier_;
  bool begun_ = false;
  std::int64_t tried_ = 0;        // sequences
  std::int64_t settled_ = 0;      // of these, those of which nothing better is left
  std::int64_t failed_ = 0;       // of these, those whose program failed
  std::int64_t passed_over_ = 0;  // of these, those without a program, with which nothing was done
  std::string first_failure_;
  double open_bound_;  // greatest bound of the sequences that were tried and not settled
};

}  // namespace modsearch
