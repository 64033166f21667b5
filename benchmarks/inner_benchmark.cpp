// Minimise the length of an arm that reaches a target: Ipopt (exact Hessian) and NLopt's SLSQP against the own solver.
// One iteration is one solve, from one start, to the default tolerance of 1e-9.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <limits>
#include <map>
#include <modsearch/solvers/inner_solver.hpp>
#include <string>
#include <utility>
#include <vector>

#include "solvers/test_programs.hpp"

namespace modsearch {
namespace {

constexpr int kStarts = 4;
constexpr double kFeasible = 1e-6;  // [m], against a tolerance of 1 mm

/// Starts that ended at a feasible point, and the best objective per arm.
struct Quality {
  int solved = 0;
  std::vector<double> best;
};

/// Arms of n / 2 joints with targets within reach, and what each of the solvers makes of them.
class Case {
 public:
  Case(int n_variables, int n_arms) {
    for (int i = 0; i < n_arms; ++i) {
      arms_.push_back(test::random_arm(n_variables / 2, 3000U + static_cast<unsigned>(i)));
    }
  }

  [[nodiscard]] std::size_t solves() const { return arms_.size() * kStarts; }

  [[nodiscard]] InnerResult solve(Inner inner, std::size_t solve) {
    test::ArmProgram& arm = arms_[solve / kStarts % arms_.size()];
    Meter meter;
    return minimise(inner, arm, arm.start(static_cast<int>(solve % kStarts)), {}, meter);
  }

  /// Found once, because benchmarks are entered several times.
  [[nodiscard]] const Quality& quality(Inner inner) {
    const auto [found, is_new] = qualities_.try_emplace(inner);
    Quality& quality = found->second;
    if (!is_new) return quality;
    quality.best.assign(arms_.size(), std::numeric_limits<double>::infinity());
    for (std::size_t i = 0; i < solves(); ++i) {
      const InnerResult result = solve(inner, i);
      if (result.violation > kFeasible) continue;
      ++quality.solved;
      quality.best[i / kStarts] = std::min(quality.best[i / kStarts], result.objective);
    }
    return quality;
  }

 private:
  std::vector<test::ArmProgram> arms_;
  std::map<Inner, Quality> qualities_;
};

/// The own solver is allowed 15 % fewer solved starts than the reference, and one arm in ten whose best of all starts
/// is more than 1 % longer.
bool good_enough(const Quality& own, const Quality& reference) {
  if (own.solved < 0.85 * reference.solved) return false;
  std::size_t longer = 0;
  for (std::size_t i = 0; i < own.best.size(); ++i) longer += own.best[i] > 1.01 * reference.best[i] ? 1 : 0;
  return 10 * longer <= own.best.size();
}

void run(benchmark::State& state, Case& test, Inner inner) {
  std::size_t i = 0;
  double evaluations = 0.0;
  for (auto _ : state) {
    const InnerResult result = test.solve(inner, i++);
    evaluations += static_cast<double>(result.evaluations);
  }
  state.counters["evaluations"] = benchmark::Counter(evaluations, benchmark::Counter::kAvgIterations);
  state.counters["solved"] = test.quality(inner).solved / static_cast<double>(test.solves());
}

void register_pair(const std::string& name, Case& test, Inner reference) {
  for (const auto& [prefix, inner] : {std::pair{"Ref/", reference}, std::pair{"Own/", Inner::kOwn}}) {
    benchmark::RegisterBenchmark((prefix + name).c_str(), [&test, inner = inner, reference](benchmark::State& state) {
      if (good_enough(test.quality(Inner::kOwn), test.quality(reference))) return run(state, test, inner);
      state.SkipWithError("the reference solves more, or shorter");
    })->Unit(benchmark::kMicrosecond);
  }
}

void register_alone(const std::string& name, Case& test, Inner inner) {
  benchmark::RegisterBenchmark(("Alone/" + name).c_str(), [&test, inner](benchmark::State& state) {
    run(state, test, inner);
  })->Unit(benchmark::kMicrosecond);
}

const bool kRegistered = [] {
  for (const int n : {4, 6, 8, 10}) {
    Case& test = *new Case{n, 16};  // lives as long as the program
    const std::string size = "/n_" + std::to_string(n);
    for (const Inner inner : inner_solvers()) {
      if (inner == Inner::kOwn) continue;
      if (inner == Inner::kIpopt || inner == Inner::kSlsqp) {
        register_pair(std::string{name(inner)} + size, test, inner);
      } else {
        register_alone(std::string{name(inner)} + size, test, inner);
      }
    }
  }
  return true;
}();

}  // namespace
}  // namespace modsearch

BENCHMARK_MAIN();
