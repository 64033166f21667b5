#include "contracts/task_contract.hpp"

#include <gtest/gtest.h>

#include <modsearch/problem/files.hpp>
#include <modsearch/problem/row_sink.hpp>

namespace modsearch {
namespace {

TEST(TaskContract, IsKeptByTheReferenceTasks) {
  for (const char* id : {"seed/fixed", "seed/random_narrow", "seed/random_obstacles"}) {
    testing::expect_task_contract(*load_problem(id, {.seed = 5, .index = 1}), 6);
  }
}

// Two goals that the base joint must not turn between by more than 0.3 rad.
class TwoPoints final : public Task {
 public:
  TwoPoints()
      : goals_{{"a", GoalType::kAt, PoseRegion::ball({0.9, -0.1, 1.0}, 1e-3)},
               {"b", GoalType::kReach, PoseRegion::ball({0.9, 0.1, 1.0}, 1e-3)}} {}
  [[nodiscard]] std::string_view name() const override { return "two points"; }
  [[nodiscard]] std::span<const Goal> goals() const override { return goals_; }
  void add_rows(RowSink& sink, const Chain&) const override {
    const int before = sink.joint(0, 0);
    const int after = sink.joint(1, 0);
    sink.add(-0.3, 0.3, [=](const Eigen::VectorXd& v, Eigen::Ref<Eigen::RowVectorXd> gradient) {
      gradient[before] = -1.0;
      gradient[after] = 1.0;
      return v[after] - v[before];
    });
  }

 private:
  std::vector<Goal> goals_;
};

TEST(TaskContract, IsKeptByATaskOfAUsersOwn) {
  RobotProblemSpec spec = load_problem("seed/fixed")->spec();
  spec.name = "two points";
  spec.task = std::make_shared<TwoPoints>();
  testing::expect_task_contract(RobotProblem{spec}, 6);
}

}  // namespace
}  // namespace modsearch
