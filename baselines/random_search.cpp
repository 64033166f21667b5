#include <modsearch/baselines/random_search.hpp>
#include <modsearch/baselines/staged.hpp>

namespace modsearch {

Placement random_placement(const ModuleLibrary& library, int k, Rng& rng) {
  const std::vector<ParameterRange>& ranges = library.type(k).parameters;
  Placement placement{k, Parameters(static_cast<Eigen::Index>(ranges.size()))};
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    placement.parameters[static_cast<Eigen::Index>(i)] = rng.uniform(ranges[i].lower, ranges[i].upper);
  }
  return placement;
}

Design random_design(const DesignProblem& problem, Rng& rng) {
  Design design;
  std::vector<int> types;
  const int length = problem.max_modules() > 1 ? 1 + rng.index(problem.max_modules() - 1) : 0;
  while (static_cast<int>(types.size()) < length) {
    const std::vector<int> allowed = problem.successors(types);
    if (allowed.empty()) break;
    const int k = allowed[static_cast<std::size_t>(rng.index(static_cast<int>(allowed.size())))];
    design.modules.push_back(random_placement(problem.library(), k, rng));
    types.push_back(k);
  }
  return design;
}

namespace {

class Draws final : public Search {
 public:
  Draws(const DesignProblem& problem, Rng rng) : problem_{problem}, rng_{rng} {}

  std::optional<SearchEnd> step(Meter& meter) override {
    constexpr int kBatch = 64;  // designs between two places where the search can be taken up: arbitrary
    for (int i = 0; i < kBatch; ++i) {
      if (!evaluate_staged(meter, problem_, random_design(problem_, rng_))) return SearchEnd{};
    }
    return std::nullopt;
  }
  void save(Archive& archive) const override { put(archive, "rng", rng_); }
  void restore(const Archive& archive) override { rng_ = restored_rng(archive, "rng"); }

 private:
  const DesignProblem& problem_;
  Rng rng_;
};

}  // namespace

std::unique_ptr<Search> RandomSearch::start(const DesignProblem& problem, Rng rng) const {
  return std::make_unique<Draws>(problem, rng);
}

}  // namespace modsearch
