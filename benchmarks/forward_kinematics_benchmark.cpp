// Forward kinematics of an arm, all frames and the tip: Arm::forward against a chain of Eigen isometries.
#include <benchmark/benchmark.h>

#include <modsearch/kinematics/arm.hpp>
#include <random>
#include <string>
#include <vector>

#include "kinematics/sample_arms.hpp"

namespace modsearch {
namespace {

// The usual way: a product of isometries, one per fixed transform and one per joint.
void chain_of_isometries(const Arm& arm, const double* q, Posture& posture) {
  const int n = arm.n_joints();
  posture.frames.resize(static_cast<std::size_t>(n) + 1);
  posture.frames[0].setIdentity();
  for (int j = 0; j < n; ++j) {
    const auto i = static_cast<std::size_t>(j);
    posture.frames[i + 1] = posture.frames[i] * arm.segment(j) * Eigen::AngleAxisd{q[j], Eigen::Vector3d::UnitZ()};
  }
  posture.tip = posture.frames.back() * arm.segment(n);
}

// Six joints of a general arm: no transform is without a rotation.
Chain general_arm() {
  ChainBuilder builder{0};
  for (int j = 0; j < 6; ++j) {
    Eigen::Isometry3d X{Eigen::AngleAxisd{0.3 + 0.4 * j, Eigen::Vector3d{1.0, 0.2 * j, -0.5}.normalized()}};
    X.translation() << 0.1, 0.2 - 0.1 * j, 0.3;
    builder.joint({.name = "j", .lower = -sample::kPi, .upper = sample::kPi}).move(X);
  }
  return builder.build();
}

struct Case {
  explicit Case(Chain the_chain)
      : chain{std::move(the_chain)}, arm{chain.at(Eigen::VectorXd::Constant(chain.n_parameters(), 0.7))} {
    std::mt19937 generator{1};
    for (int i = 0; i < 256; ++i) postures.push_back(sample::random_joints(chain, generator));
  }
  Case(const Case&) = delete;  // the arm points to the chain
  Case& operator=(const Case&) = delete;

  Chain chain;
  Arm arm;
  std::vector<Eigen::VectorXd> postures;
};

bool both_agree(const Case& test) {
  Posture own, reference;
  for (const Eigen::VectorXd& q : test.postures) {
    test.arm.forward(q.data(), own);
    chain_of_isometries(test.arm, q.data(), reference);
    if ((own.tip.matrix() - reference.tip.matrix()).cwiseAbs().maxCoeff() > 1e-13) return false;
    for (std::size_t f = 0; f < own.frames.size(); ++f) {
      if ((own.frames[f].matrix() - reference.frames[f].matrix()).cwiseAbs().maxCoeff() > 1e-13) return false;
    }
  }
  return true;
}

template <typename Forward>
void run(benchmark::State& state, const Case& test, const Forward& forward) {
  if (!both_agree(test)) {
    state.SkipWithError("the two do not agree");
    return;
  }
  Posture posture;
  std::size_t i = 0;
  for (auto _ : state) {
    forward(test.arm, test.postures[i].data(), posture);
    benchmark::DoNotOptimize(posture.tip);
    i = (i + 1) % test.postures.size();
  }
}

void register_pair(const std::string& name, const Case& test) {
  benchmark::RegisterBenchmark(("Ref/forward/" + name).c_str(),
                               [&test](benchmark::State& state) { run(state, test, chain_of_isometries); });
  benchmark::RegisterBenchmark(("Own/forward/" + name).c_str(), [&test](benchmark::State& state) {
    run(state, test, [](const Arm& arm, const double* q, Posture& posture) { arm.forward(q, posture); });
  });
}

const bool kRegistered = [] {
  for (const char* types : {"h", "hh", "hrh", "hrhrhrhrh"}) {
    register_pair(std::string{"seed_"} + types, *new Case{sample::seed_chain(types)});  // lives as long as the program
  }
  register_pair("general_6", *new Case{general_arm()});
  return true;
}();

}  // namespace
}  // namespace modsearch

BENCHMARK_MAIN();
