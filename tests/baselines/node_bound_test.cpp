#include <gtest/gtest.h>

#include <modsearch/baselines/certify/node_bound_internal.hpp>
#include <modsearch/baselines/certify/obstacle_rows_internal.hpp>
#include <modsearch/problem/files.hpp>
#include <modsearch/problem/rng.hpp>

namespace modsearch::certify {
namespace {

// Arms drawn at random, free of obstacles, whose tips are made the goals: whatever the multipliers and rows, no bound
// of a box with the arm in it may be above its mass, and none may say that nothing is there.
TEST(NodeBound, IsNeverAboveAnArmInTheBox) {
  int with_rows = 0, useful = 0;
  for (const char* id : {"seed/random_obstacles", "breakeven/clutter", "breakeven/two_goals"}) {
    const auto problem = load_problem(id);
    Scenery scenery = scenery_of(*problem);
    const auto n_goals = scenery.targets.size();
    Rng rng{5};
    std::vector<RowCandidate> candidates;
    Work work;
    for (int i = 0; i < 4000; ++i) {
      std::vector<int> types;
      for (int n = 1 + rng.index(2); n > 0; --n) types.push_back(rng.index(3));
      const SequenceModel model{*problem, types};
      Eigen::VectorXd x(model.parameter_lower.size());
      for (Eigen::Index k = 0; k < x.size(); ++k) {
        x[k] = rng.uniform(model.parameter_lower[k], model.parameter_upper[k]);
      }
      const std::shared_ptr<const Chain> chain = problem->chain(types);
      const Arm arm = chain->at(x);
      std::vector<double> centre(static_cast<std::size_t>(model.n_lengths()));
      for (Eigen::Index k = 0; k < x.size(); ++k) {
        centre[static_cast<std::size_t>(model.length_of[static_cast<std::size_t>(k)])] += x[k];
      }
      bool free = true;
      for (Target& target : scenery.targets) {
        Eigen::VectorXd q(model.n_joints());
        for (double& angle : q) angle = rng.uniform(-3.0, 3.0);
        const Posture posture = arm.forward(q);
        target.position = posture.tip.translation();
        free = free && problem->scene().clearance(arm, posture, work) >= 0.0;
        centre.insert(centre.end(), q.begin(), q.end());
      }
      const double width = std::exp2(rng.uniform(-10.0, 0.0));
      Box box;
      for (const double place : centre) {
        box.lower.push_back(place - width * rng.uniform(0.0, 1.0));
        box.upper.push_back(place + width * rng.uniform(0.0, 1.0));
      }
      NodeBound bound{model, scenery};
      bound.set_box(box);
      std::vector<double> multipliers;
      for (std::size_t m = 0; m < 3 * n_goals; ++m) multipliers.push_back(rng.uniform(-2.0, 2.0));
      if (free) {
        find_rows(bound, model, scenery, {}, candidates);
        for (const RowCandidate& candidate : candidates) {
          EXPECT_FALSE(candidate.inside);
          if (bound.add_row(candidate.row)) multipliers.push_back(rng.uniform(0.0, 2.0));
        }
      }
      with_rows += bound.n_rows() > 0 ? 1 : 0;
      const bool cap = rng.uniform(0.0, 1.0) < 0.3;
      const double mass = bound.value(multipliers.data(), cap, Objective::kMass, nullptr);
      EXPECT_LE(mass, arm.mass() + 1e-9);
      useful += mass > 0.0 ? 1 : 0;
      EXPECT_LE(bound.value(multipliers.data(), cap, Objective::kNothing, nullptr), 1e-9);
    }
  }
  EXPECT_GT(with_rows, 1000);
  EXPECT_GT(useful, 1000);
}

}  // namespace
}  // namespace modsearch::certify
