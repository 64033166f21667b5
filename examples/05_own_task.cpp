// Step 5: a kind of task of your own. Declare the goals; the attempt, the smooth program, the bounds and the agents'
// features follow from them, so that every solver can solve it.
#include <iostream>
#include <modsearch/modsearch.hpp>

namespace {

using namespace modsearch;

/// Weld a seam: the tip passes `n` points on a straight line, in order, each within a millimetre.
class SeamTask final : public Task {
 public:
  SeamTask(const Eigen::Vector3d& from, const Eigen::Vector3d& to, int n) : ends_(6) {
    ends_ << from, to;
    for (int i = 0; i < n; ++i) {
      const Eigen::Vector3d point = from + (to - from) * i / (n - 1);
      goals_.push_back({"point " + std::to_string(i), GoalType::kAt, PoseRegion::ball(point, 1e-3)});
    }
  }

  std::string_view name() const override { return "seam"; }
  std::span<const Goal> goals() const override { return goals_; }
  // An agent needs to know the ends only.
  Eigen::VectorXd features() const override { return 0.5 * ends_; }
  // The smooth program keeps the base joint from turning by more than 0.3 rad between neighbouring points: no jumps.
  void add_rows(RowSink& sink, const Chain&) const override {
    for (int i = 1; i < static_cast<int>(goals_.size()); ++i) {
      const int before = sink.joint(i - 1, 0);
      const int after = sink.joint(i, 0);
      sink.add(-0.3, 0.3, [=](const Eigen::VectorXd& v, Eigen::Ref<Eigen::RowVectorXd> gradient) {
        gradient[before] = -1.0;
        gradient[after] = 1.0;
        return v[after] - v[before];
      });
    }
  }

 private:
  std::vector<Goal> goals_;
  Eigen::VectorXd ends_;
};

}  // namespace

int main() {
  RobotProblemSpec spec = load_problem("seed/fixed")->spec();
  spec.name = "seam";
  spec.task = std::make_shared<SeamTask>(Eigen::Vector3d{0.9, -0.2, 1.0}, Eigen::Vector3d{0.9, 0.2, 1.0}, 5);
  const RobotProblem problem{spec};
  for (const Inner inner : {Inner::kOwn, Inner::kSlsqp, Inner::kIpopt}) {
    Meter meter;
    const Solution solution = PerSequence{{.inner = inner}}.solve(problem, meter, Rng{0});
    std::cout << name(inner) << ": " << to_string(problem.library(), solution.design) << " scores "
              << solution.evaluation.score << (solution.evaluation.attempt.achieved ? ", achieved" : ", not achieved") << '\n';
  }
}
