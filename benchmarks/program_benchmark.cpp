// The smooth program of six drives at three generated poses among three boxes, with a row for every pair of bodies
// (Ref) and with those that are near (Own): one evaluation with derivatives, and a whole solve from starts that meet
// the poses. A pair is timed only if both give the same answers. Beside them the static torques, with a Jacobian per
// body (Ref) and from composite masses (Own).
#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <modsearch/kinematics/statics.hpp>
#include <modsearch/problem/files.hpp>
#include <modsearch/problem/task_program.hpp>
#include <modsearch/solvers/inner_solver.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace modsearch {
namespace {

constexpr double kFeasible = 1e-8;

InnerOptions inner_options() {
  InnerOptions options;
  options.first_penalty = 1e3;  // a start that meets the poses is to stay where it is
  return options;
}

/// A type sequence of a generated problem, and points that meet its poses and torques, whatever they touch.
class Case {
 public:
  Case() {
    const std::shared_ptr<const RobotProblem> found = load_problem_file("whitman/3g_3o").instance({0, 0});
    problem_.emplace(found->spec());
    for (const char* name : {"adapter_120_60", "drive_60_inline", "drive_60_bent", "link_60", "drive_60_bent",
                             "drive_60_inline", "drive_60_bent", "drive_60_inline", "gripper_60"}) {
      types_.push_back(problem_->library().find(name).value());
    }
    const RobotProblem free = problem_->with_level(Level::kNone);
    TaskProgram poses{free, types_, {}};
    Meter meter;
    for (int i = 0; i < 64 && starts_.size() < 8; ++i) {
      const InnerResult result = minimise(Inner::kOwn, poses, poses.start(i), {}, meter);
      if (result.violation <= kFeasible) starts_.push_back(result.v);
    }
  }

  [[nodiscard]] TaskProgram program(bool all_rows) const {
    return TaskProgram{*problem_, types_, {.all_rows = all_rows}};
  }
  [[nodiscard]] const std::vector<Eigen::VectorXd>& starts() const { return starts_; }
  [[nodiscard]] const RobotProblem& problem() const { return *problem_; }
  [[nodiscard]] const std::vector<int>& types() const { return types_; }

  /// What is wrong with the answers of the working set; empty: nothing.
  [[nodiscard]] std::string fault() const {
    if (starts_.empty()) return "no start meets the poses";
    TaskProgram all = program(true), some = program(false);
    SmoothProgram::Values values;
    int feasible_all = 0, feasible_some = 0;
    for (const Eigen::VectorXd& start : starts_) {
      Meter meter;
      const InnerResult with_all = minimise(Inner::kOwn, all, start, inner_options(), meter);
      const InnerResult with_some = minimise(Inner::kOwn, some, start, inner_options(), meter);
      feasible_all += with_all.violation <= kFeasible ? 1 : 0;
      feasible_some += with_some.violation <= kFeasible ? 1 : 0;
      all.evaluate(with_some.v, values);
      const double violation = all.violation(with_some.v, values.rows);
      if (std::abs(violation - with_some.violation) > kFeasible) {
        return fmt::format("violates {} of all rows, {} of its own", violation, with_some.violation);
      }
    }
    if (feasible_some < feasible_all) {
      return fmt::format("{} of {} starts end feasible, {} with all rows", feasible_some, starts_.size(), feasible_all);
    }
    return "";
  }

 private:
  std::optional<RobotProblem> problem_;
  std::vector<int> types_;
  std::vector<Eigen::VectorXd> starts_;
};

const Case& the_case() {
  static const Case* const made = new Case;
  return *made;
}

void evaluate(benchmark::State& state, bool all_rows) {
  static const std::string fault = the_case().fault();
  if (!fault.empty()) return state.SkipWithError(fault.c_str());
  TaskProgram program = the_case().program(all_rows);
  SmoothProgram::Values values;
  // Two points in turn, because a program remembers where it is.
  Eigen::VectorXd here = the_case().starts().front(), there = here;
  there[0] += 1e-6;
  program.grow(here);
  for (auto _ : state) {
    program.evaluate(here, values);
    benchmark::DoNotOptimize(values.objective);
    std::swap(here, there);
  }
  state.counters["rows"] = program.n_rows();
}

// As a solve evaluates: all pairs are looked at before.
void look_and_evaluate(benchmark::State& state, bool all_rows) {
  static const std::string fault = the_case().fault();
  if (!fault.empty()) return state.SkipWithError(fault.c_str());
  TaskProgram program = the_case().program(all_rows);
  SmoothProgram::Values values;
  Eigen::VectorXd here = the_case().starts().front(), there = here;
  there[0] += 1e-6;
  for (auto _ : state) {
    program.grow(here);
    program.evaluate(here, values);
    benchmark::DoNotOptimize(values.objective);
    std::swap(here, there);
  }
  state.counters["rows"] = program.n_rows();
}

void hessian(benchmark::State& state, bool all_rows) {
  TaskProgram program = the_case().program(all_rows);
  Eigen::VectorXd here = the_case().starts().front(), there = here;
  there[0] += 1e-6;
  const Eigen::VectorXd multipliers = Eigen::VectorXd::Ones(program.n_rows());
  for (auto _ : state) {
    benchmark::DoNotOptimize(program.hessian(here, 1.0, multipliers));
    std::swap(here, there);
  }
}

void solve(benchmark::State& state, bool all_rows) {
  static const std::string fault = the_case().fault();
  if (!fault.empty()) return state.SkipWithError(fault.c_str());
  TaskProgram program = the_case().program(all_rows);
  double evaluations = 0.0, feasible = 0.0;
  std::size_t i = 0;
  for (auto _ : state) {
    Meter meter;
    const std::vector<Eigen::VectorXd>& starts = the_case().starts();
    const InnerResult result = minimise(Inner::kOwn, program, starts[i++ % starts.size()], inner_options(), meter);
    evaluations += static_cast<double>(result.evaluations);
    feasible += result.violation <= kFeasible ? 1.0 : 0.0;
  }
  state.counters["evaluations"] = benchmark::Counter(evaluations, benchmark::Counter::kAvgIterations);
  state.counters["feasible"] = benchmark::Counter(feasible, benchmark::Counter::kAvgIterations);
  state.counters["rows"] = program.n_rows();
}

// A Jacobian for the centre of mass of every body.
Eigen::VectorXd torques_by_jacobians(const Arm& arm, const Posture& posture, const StaticLoad& load) {
  Eigen::VectorXd torques = Eigen::VectorXd::Zero(arm.n_joints());
  for (const Body& body : arm.chain().bodies()) {
    const Eigen::Vector3d p_FM = body.spread.X_FB.at(arm.parameters()) * body.spread.r_com.at(arm.parameters());
    const Eigen::Vector3d p_WM = posture.frames[static_cast<std::size_t>(body.frame)] * p_FM;
    torques -=
        arm.point_jacobian_q(posture, body.frame, p_WM).transpose() * body.mass.at(arm.parameters()) * load.gravity;
  }
  return torques - arm.point_jacobian_q(posture, arm.n_joints(), posture.tip.translation()).transpose() * load.payload *
                       load.gravity;
}

void torques(benchmark::State& state, bool composite) {
  const std::shared_ptr<const Chain> chain = the_case().problem().chain(the_case().types());
  const Eigen::VectorXd& v = the_case().starts().front();
  const Arm arm = chain->at(v.head(chain->n_parameters()));
  const Posture posture = arm.forward(v.segment(chain->n_parameters(), chain->n_joints()));
  const StaticLoad load{.payload = 1.5};
  if ((static_torques(arm, posture, load) - torques_by_jacobians(arm, posture, load)).norm() > 1e-9) {
    return state.SkipWithError("the torques differ");
  }
  for (auto _ : state) {
    if (composite) {
      benchmark::DoNotOptimize(static_torques(arm, posture, load));
    } else {
      benchmark::DoNotOptimize(torques_by_jacobians(arm, posture, load));
    }
  }
}

BENCHMARK_CAPTURE(evaluate, all, true)->Name("Ref/evaluate")->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(evaluate, near, false)->Name("Own/evaluate")->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(look_and_evaluate, all, true)->Name("Ref/look_and_evaluate")->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(look_and_evaluate, near, false)->Name("Own/look_and_evaluate")->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(hessian, all, true)->Name("Ref/hessian")->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(hessian, near, false)->Name("Own/hessian")->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(solve, all, true)->Name("Ref/solve")->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(solve, near, false)->Name("Own/solve")->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(torques, jacobians, false)->Name("Ref/static_torques");
BENCHMARK_CAPTURE(torques, composite, true)->Name("Own/static_torques");

}  // namespace
}  // namespace modsearch

BENCHMARK_MAIN();
