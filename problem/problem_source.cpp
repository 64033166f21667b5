#include <modsearch/problem/problem_source.hpp>

namespace modsearch {

ProblemSource problem_source(ProblemFile file) {
  if (!file.sampled()) return problem_source(file, Instance{});
  return [file = std::move(file)](Rng rng) -> std::shared_ptr<const DesignProblem> {
    const std::uint64_t seed = rng.bits();
    return file.instance({seed, rng.bits()});
  };
}

ProblemSource problem_source(const ProblemFile& file, Instance instance) {
  return [problem = file.instance(instance)](Rng) -> std::shared_ptr<const DesignProblem> { return problem; };
}

}  // namespace modsearch
