// Evaluations per second on the reference scenarios, and the per-sequence optimum with our inner solver against plain
// Ipopt on equal instances. The pair is timed only if both give the same answers.
#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <cmath>
#include <modsearch/baselines/per_sequence.hpp>
#include <modsearch/baselines/random_search.hpp>
#include <modsearch/problem/files.hpp>

#include "problem/drawn_reach.hpp"

namespace modsearch {
namespace {

constexpr std::uint64_t kInstances = 8;

Solution solved(const DesignProblem& problem, Inner inner) {
  Meter meter;
  return PerSequence{{.inner = inner}}.solve(problem, meter, Rng{0});
}

std::vector<std::shared_ptr<const RobotProblem>> instances(const char* scenario) {
  const ProblemFile file = load_problem_file(scenario);
  std::vector<std::shared_ptr<const RobotProblem>> result;
  for (std::uint64_t i = 0; i < kInstances; ++i) result.push_back(file.instance({7, i}));
  return result;
}

// Random designs with as many modules as a random search draws, and designs of one module.
void evaluate(benchmark::State& state, const char* scenario, int modules) {
  const auto problem = instances(scenario).front();
  std::vector<Design> designs;
  Rng rng{1};
  while (designs.size() < 256) {
    Design design = random_design(*problem, rng);
    if (modules == 0 || static_cast<int>(design.modules.size()) == modules) designs.push_back(std::move(design));
  }
  std::size_t at = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(problem->evaluate(designs[at]));
    at = (at + 1) % designs.size();
  }
  state.SetItemsProcessed(state.iterations());
}

// Six drives, three full poses and three boxes, with and without the postures that a search would hand over.
void reach(benchmark::State& state, Fidelity fidelity, bool witnessed) {
  std::vector<testing::DrawnReach> drawn;
  const ProblemFile file = load_problem_file("whitman/3g_3o");
  for (std::uint64_t i = 0; i < 32; ++i) {
    std::optional<testing::DrawnReach> reach = testing::drawn_reach(file.instance({0, i})->spec(), Rng{i});
    if (!reach) continue;
    const bool achieved = reach->problem->evaluate(reach->design, Fidelity::kFull, {reach->postures}).attempt.achieved;
    if (achieved) drawn.push_back(*std::move(reach));
  }
  std::size_t at = 0;
  for (auto _ : state) {
    const testing::DrawnReach& reach = drawn[at];
    const Witness witness{witnessed ? reach.postures : Eigen::MatrixXd{}};
    benchmark::DoNotOptimize(reach.problem->evaluate(reach.design, fidelity, witness));
    at = (at + 1) % drawn.size();
  }
  state.SetItemsProcessed(state.iterations());
}

void per_sequence(benchmark::State& state, const char* scenario, Inner inner) {
  const auto problems = instances(scenario);
  for (const auto& problem : problems) {
    const double own = solved(*problem, Inner::kOwn).evaluation.score;
    const double ipopt = solved(*problem, Inner::kIpopt).evaluation.score;
    if (own < ipopt - 0.01) {
      state.SkipWithError(fmt::format("own scores {}, Ipopt {}", own, ipopt).c_str());
      return;
    }
  }
  std::size_t at = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(solved(*problems[at], inner));
    at = (at + 1) % problems.size();
  }
}

void register_all() {
  for (const char* scenario : {"seed/fixed", "seed/random_wide", "seed/random_obstacles"}) {
    for (const int modules : {1, 2, 0}) {
      benchmark::RegisterBenchmark(
          fmt::format("evaluate/{}/{}", scenario, modules == 0 ? "random" : fmt::format("{}_modules", modules)).c_str(),
          [=](benchmark::State& state) { evaluate(state, scenario, modules); });
    }
  }
  for (const auto& [name, fidelity] :
       {std::pair{"poses", Fidelity::kPoses}, {"screen", Fidelity::kScreen}, {"path", Fidelity::kFull}}) {
    for (const bool witnessed : {false, true}) {
      benchmark::RegisterBenchmark(fmt::format("reach/{}/{}", name, witnessed ? "witnessed" : "alone").c_str(),
                                   [=](benchmark::State& state) { reach(state, fidelity, witnessed); })
          ->Unit(benchmark::kMicrosecond);
    }
  }
  for (const char* scenario : {"seed/fixed", "seed/random_narrow", "seed/random_wide"}) {
    const std::string name = fmt::format("per_sequence/{}", scenario);
    benchmark::RegisterBenchmark(("Ref/" + name).c_str(), [=](benchmark::State& state) {
      per_sequence(state, scenario, Inner::kIpopt);
    })->Unit(benchmark::kMicrosecond);
    benchmark::RegisterBenchmark(("Own/" + name).c_str(), [=](benchmark::State& state) {
      per_sequence(state, scenario, Inner::kOwn);
    })->Unit(benchmark::kMicrosecond);
  }
}

}  // namespace
}  // namespace modsearch

int main(int argc, char** argv) {
  modsearch::register_all();
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
}
