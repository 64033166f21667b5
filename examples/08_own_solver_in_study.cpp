// Step 8: a solver and a task of your own in the comparison, beside those that are there. Cells run in copies of this
// program, so nothing has to be registered, and a solver that crashes costs its own cells only.
#include <algorithm>
#include <filesystem>
#include <iostream>
#include <modsearch/modsearch.hpp>

namespace {

using namespace modsearch;

/// Reach two points one after the other, the second above the first.
std::shared_ptr<const DesignProblem> stacking(Instance instance) {
  RobotProblemSpec spec = load_problem("seed/fixed")->spec();
  spec.name = "stacking";
  const double height = 0.9 + 0.1 * static_cast<double>(instance.index);
  const auto at = [](const char* id, double z) {
    return Goal{id, GoalType::kAt, PoseRegion::ball(Eigen::Vector3d{0.8, 0.2, z}, 1e-3)};
  };
  spec.task = std::make_shared<GoalTask>("stacking", std::vector<Goal>{at("pick", 0.6), at("place", height)});
  return std::make_shared<RobotProblem>(spec);
}

/// Random search among designs of at most two modules: the score likes them short.
class ShortSearch final : public Solver {
 public:
  std::string name() const override { return "short"; }

 private:
  SearchEnd do_solve(const DesignProblem& problem, Meter& meter, Rng rng) const override {
    Design design;
    do {
      design = random_design(problem, rng);
      if (design.modules.size() > 2) design = design.prefix(2);
    } while (meter.evaluate(problem, design));
    return {};
  }
};

}  // namespace

int main() {
  const Study study{.name = "own solver, own task",
                    .problems = {{.name = "stacking", .instances = InstanceRange{.count = 5}, .make = stacking}},
                    .solvers = {{.label = "random", .text = "random", .solver = std::make_shared<RandomSearch>()},
                                {.label = "mine", .text = "short", .solver = std::make_shared<ShortSearch>()},
                                {.label = "slsqp",
                                 .text = "per-sequence:inner=slsqp",
                                 .solver = std::make_shared<PerSequence>(PerSequenceOptions{.inner = Inner::kSlsqp})}},
                    .seeds = {0, 1, 2},
                    .budget = {.evaluations = 300}};
  const std::filesystem::path folder = std::filesystem::temp_directory_path() / "modsearch_example_own_study";
  std::filesystem::remove_all(folder);
  const StudyRecord record = run(study, {.folder = folder, .jobs = 2, .recheck = 3});

  for (const StudySolver& solver : study.solvers) {
    int achieved = 0;
    double sum = 0.0;
    for (const CellRecord& cell : record.cells) {
      if (cell.key.label != solver.label || !cell.outcome || !cell.outcome->achieved) continue;
      ++achieved;
      sum += cell.outcome->score;
    }
    std::cout << solver.label << ": achieved " << achieved << " of 15, mean score of these " << sum / std::max(achieved, 1) << '\n';
  }
}
