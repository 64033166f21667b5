// Can this arm reach this point? inverse_kinematics against the usual way, damped least squares from four starts.
#include <benchmark/benchmark.h>

#include <Eigen/Cholesky>
#include <modsearch/kinematics/inverse_kinematics.hpp>
#include <modsearch/kinematics/low_discrepancy.hpp>
#include <random>
#include <string>
#include <vector>

#include "kinematics/sample_arms.hpp"

namespace modsearch {
namespace {

constexpr double kTolerance = 1e-3;  // [m]
constexpr int kStarts = 4;

// Distance reached by damped least squares (Wampler 1986), joints clamped to their limits.
double damped_least_squares(const Arm& arm, const Eigen::Vector3d& t) {
  constexpr int kSteps = 50;
  constexpr double kDamping = 1e-3;
  Posture posture;
  double least = std::numeric_limits<double>::infinity();
  for (int start = 0; start < kStarts && least > kTolerance; ++start) {
    const Eigen::VectorXd lower = arm.chain().lower_limits();
    const Eigen::VectorXd upper = arm.chain().upper_limits();
    Eigen::VectorXd q = lower + halton(start, arm.n_joints()).cwiseProduct(upper - lower);
    for (int step = 0; step < kSteps; ++step) {
      arm.forward(q.data(), posture);
      const Eigen::Vector3d e = t - posture.tip.translation();
      least = std::min(least, e.norm());
      if (least <= kTolerance) break;
      const Eigen::Matrix3Xd J = arm.point_jacobian_q(posture, arm.n_joints(), posture.tip.translation());
      const Eigen::Matrix3d A = J * J.transpose() + kDamping * Eigen::Matrix3d::Identity();
      q = (q + J.transpose() * A.llt().solve(e)).cwiseMax(lower).cwiseMin(upper);
    }
  }
  return least;
}

double own_distance(const Arm& arm, const Eigen::Vector3d& t) {
  return inverse_kinematics(arm, PoseRegion::ball(t, kTolerance), {.all = false}).position_error;
}

// Three revolute joints without structure: nothing but the search helps.
Chain general_arm(int n_joints) {
  ChainBuilder builder{n_joints};
  for (int j = 0; j < n_joints; ++j) {
    Eigen::Isometry3d X{Eigen::AngleAxisd{0.9 + 0.4 * j, Eigen::Vector3d{1.0, 0.2 + 0.3 * j, -0.5}.normalized()}};
    X.translation() << 0.1, 0.2 - 0.1 * j, 0.0;
    builder.joint({.name = "j", .lower = -sample::kPi, .upper = sample::kPi}).move(X);
    builder.move(AffinePose{Eigen::Matrix3d::Identity(), {0.0, 0.0, AffineScalar::of_parameter(j)}});
  }
  return builder.build();
}

struct Case {
  Case(Chain the_chain) : chain{std::move(the_chain)} {
    std::mt19937 generator{1};
    std::uniform_real_distribution<double> unit{0.0, 1.0};
    for (int i = 0; i < 256; ++i) {
      Eigen::VectorXd x(chain.n_parameters());
      for (double& length : x) length = 0.5 + unit(generator);
      arms.push_back(chain.at(x));
      targets.emplace_back(unit(generator), unit(generator), 2.0 * unit(generator));  // seed/random_wide
    }
  }
  Case(const Case&) = delete;  // the arms point to the chain
  Case& operator=(const Case&) = delete;

  Chain chain;
  std::vector<Arm> arms;
  std::vector<Eigen::Vector3d> targets;
};

template <typename Distance>
void run(benchmark::State& state, const Case& test, const Distance& distance) {
  for (std::size_t i = 0; i < test.arms.size(); ++i) {
    const double own = own_distance(test.arms[i], test.targets[i]);
    const double reference = damped_least_squares(test.arms[i], test.targets[i]);
    // The usual way stops inside the tolerance; ours gives the least distance.
    if (own > std::max(reference, kTolerance) + 1e-9) {
      state.SkipWithError("the reference came closer");
      return;
    }
  }
  std::size_t i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(distance(test.arms[i], test.targets[i]));
    i = (i + 1) % test.arms.size();
  }
}

void register_pair(const std::string& name, const Case& test) {
  benchmark::RegisterBenchmark(("Ref/reach/" + name).c_str(),
                               [&test](benchmark::State& state) { run(state, test, damped_least_squares); });
  benchmark::RegisterBenchmark(("Own/reach/" + name).c_str(),
                               [&test](benchmark::State& state) { run(state, test, own_distance); });
}

const bool kRegistered = [] {
  for (const char* types : {"l", "h", "r", "hh", "hr", "rh", "rr", "hhh"}) {
    register_pair(std::string{"seed_"} + types, *new Case{sample::seed_chain(types)});  // lives as long as the program
  }
  for (const int n : {2, 3}) register_pair("general_" + std::to_string(n), *new Case{general_arm(n)});
  register_pair("limited_hh", *new Case{sample::seed_chain("hh", 2.5)});
  return true;
}();

}  // namespace
}  // namespace modsearch

BENCHMARK_MAIN();
