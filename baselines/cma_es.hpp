#pragma once

#include <modsearch/solvers/search.hpp>
#include <optional>
#include <string_view>

namespace modsearch {

struct CmaEsOptions {
  enum class Space {
    kLengths,  ///< one search per number of modules, those first whose bound is highest
    kPadded,   ///< one search over all slots, some of which are empty: the source's form
  };
  Space space = Space::kLengths;
  int population = 0;   ///< points per generation of the first round; 0: 4 + 3 ln(variables), Hansen 2016
  double growth = 2.0;  ///< population of a round over that of the round before: IPOP (Auger and Hansen 2005)
  double sigma = 0.3;   ///< first standard deviation, share of a parameter's interval (Hansen 2016, appendix A)
  /// A search ends when every standard deviation is below this share of the interval: a hundredth of a millimetre of a
  /// metre, and a hundredth of the reference tolerance.
  double least_sigma = 1e-5;
};
/// "lengths", "padded".
[[nodiscard]] std::string_view name(CmaEsOptions::Space space);
[[nodiscard]] std::optional<CmaEsOptions::Space> space_from_name(std::string_view name);

/// CMA-ES with margin for designs: a categorical distribution over the types of each slot times one normal distribution
/// over the parameters of all slots (baselines/cat_cma.hpp, where the sources are), told points in the order of their
/// rank (baselines/lexicographic.hpp). Restarts with a larger population whenever all searches of a round have
/// converged.
///
/// A slot has as many parameters as the type with most of them; a type uses the first ones, scaled to its intervals.
/// Parameters are unbounded inside and folded into their interval at its ends, so that an optimum at a bound is an
/// optimum like any other. A type that does not fit the module before is not drawn: the slot's probabilities are
/// renormalised over those that do.
///
/// A normal distribution has one mode, and a sequence with one module more is another valley: the source's form, all
/// slots at once, commits itself to a sequence before its lengths are right. Hence a search per number of modules by
/// default, which the problem's bounds put in order and cut off.
class CmaEs final : public SteppedSolver {
 public:
  /// Throws std::invalid_argument for an option out of range.
  explicit CmaEs(CmaEsOptions options = {});
  [[nodiscard]] std::string name() const override { return "cmaes"; }
  [[nodiscard]] const CmaEsOptions& options() const { return options_; }
  [[nodiscard]] std::unique_ptr<Search> start(const DesignProblem& problem, Rng rng) const override;

 private:
  CmaEsOptions options_;
};

}  // namespace modsearch
