// Lengths and postures that meet three full poses: one iteration is one point at which all are met, from as many starts
// as that takes. The reference is what there was before: the smooth program without bodies, whose starts come from
// inverse kinematics goal by goal; the other is the pose program, from random starts.
#include <benchmark/benchmark.h>

#include <modsearch/problem/files.hpp>
#include <modsearch/problem/robot_problem.hpp>
#include <modsearch/solvers/inner_solver.hpp>
#include <string>
#include <vector>

namespace modsearch {
namespace {

/// A task of the family `whitman/3g_3o` at level none, and an arm that can meet such tasks.
struct Case {
  std::string name;
  std::vector<std::string> modules;
};

const std::vector<Case>& cases() {
  static const std::vector<Case> all{
      {"six_drives_four_parameters",
       {"adapter_120_60", "drive_60_inline", "drive_60_bent", "link_60", "drive_60_bent", "drive_60_inline", "link_60",
        "drive_60_bent", "drive_60_inline", "gripper_60"}},
      {"five_drives_eight_parameters",
       {"adapter_120_60", "drive_60_inline", "link_60", "drive_60_bent", "elbow_60", "drive_60_bent", "link_60",
        "drive_60_inline", "elbow_60", "drive_60_bent", "gripper_60"}}};
  return all;
}

class Arm {
 public:
  explicit Arm(const Case& test) : problem_{load_problem("whitman/3g_3o", {.seed = 3})->with_level(Level::kNone)} {
    for (const std::string& id : test.modules) types_.push_back(problem_.library().find(id).value());
    smooth_ = problem_.relax(types_);
    poses_ = problem_.pose_program(types_);
  }

  /// Starts that were needed; the point is `v`.
  int by_smooth_program(Eigen::VectorXd& v) {
    for (int starts = 1;; ++starts) {
      Meter meter;
      const InnerResult result =
          minimise(Inner::kOwn, *smooth_, smooth_->start(next_++), {.first_penalty = 1e3}, meter);
      v = result.v;
      if (result.violation < 1e-6) return starts;
    }
  }

  int by_pose_program(Eigen::VectorXd& v) {
    int starts = 0;
    (void)poses_->solve(
        100'000,
        [&](int i, Eigen::Ref<Eigen::VectorXd> start) {
          starts = std::max(starts, i + 1);
          for (Eigen::Index k = 0; k < start.size(); ++k)
            start[k] = rng_.uniform(poses_->lower()[k], poses_->upper()[k]);
        },
        [&](int, const Eigen::VectorXd& found) {
          v = found;
          return false;
        });
    return starts;
  }

  [[nodiscard]] bool meets_the_poses(const Eigen::VectorXd& v) const {
    Witness witness = poses_->witness(v);
    witness.only = true;
    return problem_.evaluate(poses_->design(v), Fidelity::kPoses, witness).attempt.reached;
  }

 private:
  RobotProblem problem_;
  std::vector<int> types_;
  std::unique_ptr<SmoothProgram> smooth_;
  std::unique_ptr<PoseProgram> poses_;
  int next_ = 0;
  Rng rng_{1};
};

template <typename Find>
void run(benchmark::State& state, Arm& arm, Find&& find) {
  double starts = 0.0;
  Eigen::VectorXd v;
  for (auto _ : state) starts += find(v);
  if (!arm.meets_the_poses(v)) state.SkipWithError("the point that was found does not meet the poses");
  state.counters["starts"] = benchmark::Counter(starts, benchmark::Counter::kAvgIterations);
}

const bool kRegistered = [] {
  for (const Case& test : cases()) {
    Arm& arm = *new Arm{test};  // lives as long as the program
    benchmark::RegisterBenchmark(("Ref/" + test.name).c_str(), [&](benchmark::State& state) {
      run(state, arm, [&](Eigen::VectorXd& v) { return arm.by_smooth_program(v); });
    })->Unit(benchmark::kMicrosecond);
    benchmark::RegisterBenchmark(("Own/" + test.name).c_str(), [&](benchmark::State& state) {
      run(state, arm, [&](Eigen::VectorXd& v) { return arm.by_pose_program(v); });
    })->Unit(benchmark::kMicrosecond);
  }
  return true;
}();

}  // namespace
}  // namespace modsearch

BENCHMARK_MAIN();
