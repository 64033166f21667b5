// One update of P-DQN and MP-DQN and one choice of an action, ours against LibTorch (C++, one thread), where that is
// installed; and MP-DQN's update against P-DQN's. LibTorch wants OpenBLAS (libopenblas0-pthread); the log
// says which library it had. MODSEARCH_ISA=sse2|avx2|avx512 chooses the instruction set of ours.
#include <benchmark/benchmark.h>

#include <cstdio>
#include <memory>
#include <modsearch/rl/agents.hpp>
#include <modsearch/rl/float_kernels.hpp>
#include <modsearch/rl/pdqn.hpp>
#include <string>

#include "rl/reference_network.hpp"
#ifdef MODSEARCH_TORCH
#include "torch_pdqn.hpp"
#endif

namespace modsearch {
namespace {

// 16 observations, three actions of two parameters; value network [128], actor [128, 64], batch 128.
constexpr int kStates = 16;
constexpr int kRows = 128;
constexpr double kTolerance = 1e-5;  // of any weight after kUpdates updates, against LibTorch in double precision
constexpr int kUpdates = 20;

const HybridSpace& space() {
  static const HybridSpace instance{{2, 2, 2}};
  return instance;
}

AgentOptions options() {
  AgentOptions result;
  result.gamma = 0.95;
  result.passthrough_weight_deviation = 0.1;
  return result;
}

AgentKind agent_kind(ValueKind kind) { return kind == ValueKind::kJoint ? AgentKind::kPdqn : AgentKind::kMpdqn; }

struct Case {
  explicit Case(ValueKind the_kind) : kind{the_kind} {
    Rng rng{1};
    batch.resize(kRows, kStates, space().n_parameters());
    batch.s = reference::random_rows(kRows, kStates, rng);
    batch.s_next = reference::random_rows(kRows, kStates, rng);
    batch.x = reference::random_rows(kRows, space().n_parameters(), rng);
    batch.reward = reference::random_rows(kRows, 1, rng).col(0);
    for (int row = 0; row < kRows; ++row) {
      batch.k[row] = rng.index(space().n_actions());
      batch.discount[row] = rng.index(5) == 0 ? 0.0F : 0.95F;
      batch.remaining[row] = 0.0F;
      batch.next_mask[static_cast<std::size_t>(row)] = space().all();
      batch.model[static_cast<std::size_t>(row)] = nullptr;
    }
  }
  [[nodiscard]] std::unique_ptr<Agent> agent() const {
    return make_agent(agent_kind(kind), space(), kStates, options(), Rng{2});
  }

  ValueKind kind;
  Batch batch;
};

void update_own(benchmark::State& state, const Case& test) {
  const std::unique_ptr<Agent> agent = test.agent();
  Rng rng{3};
  for (auto _ : state) benchmark::DoNotOptimize(agent->update(test.batch, rng));
}

[[maybe_unused]] void act_own(benchmark::State& state, const Case& test) {
  const std::unique_ptr<Agent> agent = test.agent();
  Eigen::Index row = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(agent->greedy(test.batch.s.row(row).transpose(), space().all()).k);
    row = (row + 1) % kRows;
  }
}

// Q of MP-DQN is that of P-DQN's network with all parameters but those of one action zero.
bool multi_pass_is_naive() {
  const Case test{ValueKind::kMultiPass};
  const auto multi = make_action_values(ValueKind::kMultiPass, space(), {.observation_size = kStates}, Rng{4});
  const auto joint = make_action_values(ValueKind::kJoint, space(), {.observation_size = kStates}, Rng{4});
  for (int k = 0; k < space().n_actions(); ++k) {
    RowMatrixXf x = RowMatrixXf::Zero(kRows, space().n_parameters());
    x.middleCols(space().offset(k), 2) = test.batch.x.middleCols(space().offset(k), 2);
    const Eigen::VectorXf naive = joint->forward(test.batch.s, x).col(k);
    const Eigen::VectorXf own = multi->forward(test.batch.s, test.batch.x).col(k);
    if ((own - naive).cwiseAbs().maxCoeff() > 1e-5F) return false;
  }
  return true;
}

#ifdef MODSEARCH_TORCH
// Largest difference of a weight to LibTorch in double precision after kUpdates updates.
double update_error(const Case& test) {
  const std::unique_ptr<Agent> agent = test.agent();
  TorchPdqn exact{test.kind, *agent, options(), true};
  exact.set_batch(test.batch);
  Rng rng{3};
  for (int update = 0; update < kUpdates; ++update) {
    static_cast<void>(agent->update(test.batch, rng));
    exact.update();
  }
  return exact.difference(*agent);
}

bool choices_are_equal(const Case& test) {
  const std::unique_ptr<Agent> agent = test.agent();
  const TorchPdqn torch{test.kind, *agent, options(), false};
  for (int row = 0; row < kRows; ++row) {
    const Eigen::VectorXf s = test.batch.s.row(row).transpose();
    if (agent->greedy(s, space().all()).k != torch.act(s)) return false;
  }
  return true;
}

void update_torch(benchmark::State& state, const Case& test) {
  const std::unique_ptr<Agent> agent = test.agent();
  TorchPdqn torch{test.kind, *agent, options(), false};
  torch.set_batch(test.batch);
  for (auto _ : state) torch.update();
}

void act_torch(benchmark::State& state, const Case& test) {
  const std::unique_ptr<Agent> agent = test.agent();
  const TorchPdqn torch{test.kind, *agent, options(), false};
  Eigen::Index row = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(torch.act(test.batch.s.row(row).transpose()));
    row = (row + 1) % kRows;
  }
}
#endif

using Body = void (*)(benchmark::State&, const Case&);

// `error`: nothing if the two agree.
void register_one(const std::string& name, const Case& test, Body body, const std::string& error) {
  benchmark::RegisterBenchmark(name.c_str(), [&test, body, error](benchmark::State& state) {
    if (!error.empty()) return state.SkipWithError(error.c_str());
    body(state, test);
  })->Unit(benchmark::kMicrosecond);
}

void register_all() {
  static const Case joint{ValueKind::kJoint}, multi_pass{ValueKind::kMultiPass};
  const std::string naive = multi_pass_is_naive() ? "" : "MP-DQN differs from its naive form";
  register_one("Ref/update/mpdqn_by_pdqn", joint, update_own, naive);
  register_one("Own/update/mpdqn_by_pdqn", multi_pass, update_own, naive);
#ifdef MODSEARCH_TORCH
  for (const Case* test : {&joint, &multi_pass}) {
    const std::string name{modsearch::name(agent_kind(test->kind))};
    const double error = update_error(*test);
    const std::string differs =
        error <= kTolerance ? "" : "weights differ from LibTorch in double by " + std::to_string(error);
    register_one("Ref/update/" + name, *test, update_torch, differs);
    register_one("Own/update/" + name, *test, update_own, differs);
    const std::string chooses = choices_are_equal(*test) ? "" : "another action than LibTorch's";
    register_one("Ref/act/" + name, *test, act_torch, chooses);
    register_one("Own/act/" + name, *test, act_own, chooses);
  }
#else
  std::puts("LibTorch (libtorch-dev) was not found when this was built: its half of the comparison is left out");
#endif
}

}  // namespace
}  // namespace modsearch

int main(int argc, char** argv) {
  benchmark::AddCustomContext("kernels", std::string{modsearch::kernel_isa()});
#ifdef MODSEARCH_TORCH
  benchmark::AddCustomContext("BLAS of LibTorch", modsearch::torch_blas());
#endif
  modsearch::register_all();
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}
