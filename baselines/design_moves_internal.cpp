#include <algorithm>
#include <modsearch/baselines/design_moves_internal.hpp>
#include <modsearch/baselines/random_search.hpp>

namespace modsearch {
namespace {

int drawn(const std::vector<int>& choices, Rng& rng) {
  return choices[static_cast<std::size_t>(rng.index(static_cast<int>(choices.size())))];
}

int random_type(const DesignProblem& problem, Rng& rng) { return rng.index(problem.library().n_types()); }

// Cuts the design back as little as possible so that a last module completes it; leaves it alone if none does.
void complete(const DesignProblem& problem, Design& design, Rng& rng) {
  const ModuleLibrary& library = problem.library();
  for (int n = static_cast<int>(design.modules.size()); n >= 0; --n) {
    std::vector<int> types = design.prefix(n).types();
    std::vector<int> endings;
    for (const int k : problem.successors(types)) {
      types.push_back(k);
      if (library.complete(types)) endings.push_back(k);
      types.pop_back();
    }
    if (endings.empty()) continue;
    design = design.prefix(n);
    design.modules.push_back(random_placement(library, drawn(endings, rng), rng));
    return;
  }
}

}  // namespace

void mend(const DesignProblem& problem, Design& design, Rng& rng) {
  std::vector<int> types;
  for (Placement& placement : design.modules) {
    const std::vector<int> allowed = problem.successors(types);
    if (allowed.empty()) break;
    if (std::find(allowed.begin(), allowed.end(), placement.type) == allowed.end()) {
      placement = random_placement(problem.library(), drawn(allowed, rng), rng);
    }
    types.push_back(placement.type);
  }
  design.modules.resize(types.size());
  if (!problem.library().complete(types)) complete(problem, design, rng);
}

Design changed_sequence(const DesignProblem& problem, const Design& design, Rng& rng) {
  enum { kInsert, kRemove, kReplace, kSwap };
  const int n = static_cast<int>(design.modules.size());
  std::vector<int> possible;
  if (n + 1 < problem.max_modules()) possible.push_back(kInsert);
  if (n > 1) possible.push_back(kRemove);
  if (n > 0) possible.push_back(kReplace);
  if (n > 1) possible.push_back(kSwap);
  if (possible.empty()) return design;

  Design result = design;
  const auto random_module = [&] { return random_placement(problem.library(), random_type(problem, rng), rng); };
  switch (drawn(possible, rng)) {
    case kInsert:
      result.modules.insert(result.modules.begin() + rng.index(n + 1), random_module());
      break;
    case kRemove:
      result.modules.erase(result.modules.begin() + rng.index(n));
      break;
    case kReplace:
      result.modules[static_cast<std::size_t>(rng.index(n))] = random_module();
      break;
    case kSwap: {
      const auto first = result.modules.begin() + rng.index(n - 1);
      std::iter_swap(first, first + 1);
      break;
    }
  }
  mend(problem, result, rng);
  return result;
}

void clamp(const ModuleLibrary& library, Design& design) {
  for (Placement& placement : design.modules) {
    const std::vector<ParameterRange>& ranges = library.type(placement.type).parameters;
    for (std::size_t i = 0; i < ranges.size(); ++i) {
      double& value = placement.parameters[static_cast<Eigen::Index>(i)];
      value = std::clamp(value, ranges[i].lower, ranges[i].upper);
    }
  }
}

int n_parameters(const Design& design) {
  int n = 0;
  for (const Placement& placement : design.modules) n += static_cast<int>(placement.parameters.size());
  return n;
}

}  // namespace modsearch
