#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <modsearch/baselines/lexicographic.hpp>
#include <modsearch/baselines/sequence_search_internal.hpp>
#include <modsearch/baselines/staged.hpp>
#include <utility>

namespace modsearch {
namespace {

constexpr double kImpossible = -std::numeric_limits<double>::infinity();
// Scores are sums of a few numbers up to some hundreds.
constexpr double kRounding = 1e-9;

std::string plural(std::int64_t n, const std::string& what) {
  return fmt::format("{} {}{}", n, what, n == 1 ? "" : "s");
}

}  // namespace

SequenceSearch::SequenceSearch(const DesignProblem& problem, PerSequenceOptions options, Rng rng)
    : problem_{problem}, options_{std::move(options)}, rng_{rng}, frontier_{problem}, open_bound_{kImpossible} {}

std::optional<SearchEnd> SequenceSearch::step(Meter& meter) {
  if (!begun_) {
    // The empty design is allowed and often scores more than one that misses: it stands until something better is
    // found.
    if (!meter.evaluate(problem_, Design{})) return end(meter);
    begun_ = true;
  }
  if (meter.stopped()) return end(meter);
  const std::optional<SequenceFrontier::Sequence> sequence = frontier_.next(meter);
  if (!sequence) return frontier_.exhausted() ? std::optional{end(meter)} : std::nullopt;
  const double open_bound = open_bound_;
  open_bound_ = std::max(open_bound_, sequence->bound);  // until it is settled
  const bool settled = settle(*sequence, rng_.fork(static_cast<std::uint64_t>(tried_)), meter);
  ++tried_;
  if (settled) {
    ++settled_;
    open_bound_ = open_bound;
  }
  if (meter.stopped()) return end(meter);  // perhaps in the middle of the sequence
  return std::nullopt;
}

bool SequenceSearch::settle(const SequenceFrontier::Sequence& sequence, Rng rng, Meter& meter) {
  if (parameter_box(problem_.library(), sequence.types).lower.size() == 0) {
    const std::optional<Evaluation> evaluation =
        evaluate_staged(meter, problem_, make_design(problem_.library(), sequence.types, Eigen::VectorXd{}));
    return evaluation && is_settled(*evaluation);
  }
  const SequenceOutcome outcome = optimise_sequence(problem_, sequence.types, sequence.bound, options_, meter, rng);
  if (!outcome.failure.empty() && failed_++ == 0) first_failure_ = outcome.failure;
  if (!outcome.has_program && !optimise_without_program(sequence, rng, meter)) ++passed_over_;
  return false;
}

std::string SequenceSearch::failures() const {
  return failed_ == 0 ? "" : fmt::format("; {} of them failed: {}", failed_, first_failure_);
}

std::optional<Bound> SequenceSearch::bound(const Meter& meter) const {
  const double upper = std::max({score_to_beat(meter), open_bound_, frontier_.bound()});
  if (upper == std::numeric_limits<double>::infinity()) return std::nullopt;
  return Bound{upper,
               settled_ == tried_ ? "every design that could score more was evaluated" : "modules, mass by reach"};
}

SearchEnd SequenceSearch::end(const Meter& meter) const {
  const bool cut_off = !begun_ || !frontier_.exhausted() || (meter.stopped() && settled_ < tried_);
  if (cut_off) return {StopReason::kExhausted, "", bound(meter)};  // the meter says why
  if (tried_ > 0 && passed_over_ == tried_) {
    return {StopReason::kExhausted,
            fmt::format("none of {} has a smooth program, so that nothing was optimised: `ga` does without",
                        plural(tried_, "type sequence")),
            bound(meter)};
  }
  const double best = score_to_beat(meter);
  const bool discrete = problem_.library().max_parameters() == 0;
  if (best > kImpossible) {
    const bool proved = open_bound_ <= best + kRounding;
    // Starts prove nothing: whatever they found, a sequence may hold more.
    const std::string others =
        proved ? "no other can beat the best by its bound"
               : fmt::format("none beyond these can beat the best by its bound, and these may score up to {}",
                             rounded_up(open_bound_));
    const bool evaluated = discrete || settled_ == tried_;
    const std::string what =
        fmt::format("{} {}; {}{}{}", plural(tried_, "type sequence"), evaluated ? "evaluated" : "optimised", others,
                    discrete && !proved ? ": " + nothing_proved(meter) : "", failures());
    return {proved ? StopReason::kOptimal : StopReason::kExhausted, what, bound(meter)};
  }
  if (tried_ == 0) {
    const std::string& why = frontier_.impossible();
    return {StopReason::kUnreachable, why.empty() ? "no module may be attached" : why, Bound{kImpossible, "reach"}};
  }
  if (settled_ == tried_) {
    return {
        StopReason::kUnreachable,
        fmt::format("{} could reach by their bounds; all were evaluated, none is achieved", plural(tried_, "design")),
        Bound{kImpossible, "every design was evaluated"}};
  }
  if (discrete) {
    return {StopReason::kExhausted,
            fmt::format("{} could reach by their bounds; none was found to be achieved: {}", plural(tried_, "design"),
                        nothing_proved(meter)),
            bound(meter)};
  }
  return {StopReason::kExhausted,
          fmt::format("no achieved design was found in {} from {} each{}", plural(tried_, "type sequence"),
                      plural(options_.starts, "start"), failures()),
          bound(meter)};
}

void SequenceSearch::save(Archive& archive) const {
  frontier_.save(archive);
  archive.put("sequences/counts", std::array<std::int64_t, 5>{begun_ ? 1 : 0, tried_, settled_, failed_, passed_over_});
  archive.put_text("sequences/failure", first_failure_);
  archive.put_number("sequences/open bound", open_bound_);
}

void SequenceSearch::restore(const Archive& archive) {
  frontier_.restore(archive);
  const std::vector<std::int64_t> counts = archive.integers("sequences/counts");
  // A checkpoint of an earlier version holds no number of sequences that were passed over.
  if (counts.size() != 4 && counts.size() != 5) archive.fail("sequences/counts", "does not hold 5 numbers");
  begun_ = counts[0] != 0;
  tried_ = counts[1];
  settled_ = counts[2];
  failed_ = counts[3];
  passed_over_ = counts.size() == 5 ? counts[4] : 0;
  first_failure_ = archive.text("sequences/failure");
  open_bound_ = archive.number("sequences/open bound");
}

}  // namespace modsearch
