#include <fmt/format.h>

#include <modsearch/baselines/enumerate.hpp>
#include <modsearch/baselines/random_search.hpp>
#include <modsearch/baselines/sequence_search_internal.hpp>
#include <modsearch/baselines/staged.hpp>
#include <stdexcept>

namespace modsearch {
namespace {

class Enumeration final : public SequenceSearch {
 public:
  Enumeration(const DesignProblem& problem, const EnumerateOptions& options, Rng rng)
      : SequenceSearch{problem, options.continuous, rng}, samples_{options.samples} {}

 private:
  bool optimise_without_program(const SequenceFrontier::Sequence& sequence, Rng rng, Meter& meter) override {
    for (int i = 0; i < samples_; ++i) {
      Design design;
      for (const int k : sequence.types) design.modules.push_back(random_placement(problem().library(), k, rng));
      if (!evaluate_staged(meter, problem(), design)) break;
    }
    return true;
  }

  int samples_;
};

}  // namespace

Enumerate::Enumerate(EnumerateOptions options) : options_{std::move(options)} {
  if (options_.continuous.starts < 1 || options_.samples < 1) {
    throw std::invalid_argument(fmt::format("enumerate: starts is {} and samples {}, at least 1 is needed of both",
                                            options_.continuous.starts, options_.samples));
  }
}

std::unique_ptr<Search> Enumerate::start(const DesignProblem& problem, Rng rng) const {
  return std::make_unique<Enumeration>(problem, options_, rng);
}

}  // namespace modsearch
