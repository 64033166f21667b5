// Step 5: a kind of task of your own. Declare the goals; the attempt, the smooth program, the bounds and the agents'
// features follow from them, so that every solver can solve it: here Ipopt, evolution and a trained agent.
#include <cstdio>
#include <modsearch/modsearch.hpp>

namespace {

using namespace modsearch;

/// Weld a seam: the tip passes `n` points on a straight line, each within a millimetre.
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

void print(const RobotProblem& problem, const char* solver, const Solution& solution) {
  std::printf("%-8s %-10.3f %-12s %-8lld %s\n", solver, solution.evaluation.score,
              solution.evaluation.attempt.achieved ? "achieved" : "not achieved",
              static_cast<long long>(solution.spent.evaluations),
              to_string(problem.library(), solution.design).c_str());
}

}  // namespace

int main() {
  // 1. The task goes into a problem: a library, a scene (none here), a score.
  RobotProblemSpec spec = load_problem("seed/fixed")->spec();
  spec.name = "seam";
  spec.task = std::make_shared<SeamTask>(Eigen::Vector3d{0.9, -0.2, 1.0}, Eigen::Vector3d{0.9, 0.2, 1.0}, 5);
  const auto problem = std::make_shared<const RobotProblem>(spec);
  std::printf("%-8s %-10s %-12s %-8s %s\n", "solver", "score", "", "evals", "design");

  // 2. Ipopt: the smooth program of each promising type sequence.
  Meter ipopt_meter;
  print(*problem, "ipopt", PerSequence{{.inner = Inner::kIpopt}}.solve(*problem, ipopt_meter, Rng{0}));

  // 3. Evolution: nothing but scores (and a polish of its best).
  Meter ga_meter{{.evaluations = 5000}};
  print(*problem, "ga", GeneticAlgorithm{}.solve(*problem, ga_meter, Rng{0}));

  // 4. MP-DQN: an agent that places module after module, trained on this one problem.
  LearnerSettings settings = settings_of(AgentKind::kMpdqn, Preset::kBest);
  Meter training_meter;
  const Training training = AgentLearner{settings}.train([&](Rng) { return problem; }, training_meter, Rng{0});
  Meter policy_meter;
  print(*problem, "mpdqn", training.policy->solve(*problem, policy_meter, Rng{0}));
}
