#include <fmt/format.h>

#include <modsearch/baselines/per_sequence.hpp>
#include <modsearch/baselines/sequence_search_internal.hpp>
#include <stdexcept>

namespace modsearch {

PerSequence::PerSequence(PerSequenceOptions options) : options_{std::move(options)} {
  if (options_.starts < 1) {
    throw std::invalid_argument(fmt::format("per-sequence: starts is {}, at least 1 is needed", options_.starts));
  }
}

std::string PerSequence::name() const { return fmt::format("per-sequence:inner={}", modsearch::name(options_.inner)); }

std::unique_ptr<Search> PerSequence::start(const DesignProblem& problem, Rng rng) const {
  return std::make_unique<SequenceSearch>(problem, options_, rng);
}

}  // namespace modsearch
