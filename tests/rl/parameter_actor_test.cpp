#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <modsearch/rl/parameter_actor.hpp>

namespace modsearch {
namespace {

constexpr int kStates = 3;
constexpr int kHeads = 2;

RowMatrixXf drawn(int rows, int cols, Rng rng) {
  RowMatrixXf result(rows, cols);
  for (float& value : result.reshaped()) value = static_cast<float>(rng.uniform(-1.0, 1.0));
  return result;
}

AgentOptions learned() {
  return {.actor_hidden = {8},
          .actor_rate = 1e-3,
          .actor_tau = 0.25,
          .bounds = BoundGradients::kNone,
          .passthrough_rate = 1e-2};
}

TEST(Passthrough, HasTheGradientOfFiniteDifferencesAndLeavesTheHeadsAlone) {
  ParameterActor actor{HybridSpace{{1, 2}}, kStates, kHeads, learned(), Rng{1}};
  const RowMatrixXf s = drawn(5, kStates, Rng{2});
  const RowMatrixXf slopes = drawn(5, kHeads + 3, Rng{3});
  const auto loss = [&] { return actor.forward(s).cwiseProduct(slopes).sum(); };
  static_cast<void>(loss());
  Eigen::VectorXf gradient = Eigen::VectorXf::Ones(actor.passthrough().size());  // something to add to
  actor.passthrough_backward(slopes, s, gradient);
  for (Eigen::Index i = 0; i < gradient.size(); ++i) {
    const float was = actor.passthrough()[i];
    // mu is linear in these weights, so a wide step is exact but for rounding.
    actor.passthrough()[i] = was + 1.0F;
    const float above = loss();
    actor.passthrough()[i] = was - 1.0F;
    const float below = loss();
    actor.passthrough()[i] = was;
    EXPECT_NEAR(gradient[i], 1.0F + (above - below) / 2.0F, 1e-5F) << i;
  }
  const RowMatrixXf before = actor.forward(s);
  actor.passthrough().setConstant(0.5F);
  EXPECT_EQ(actor.forward(s).leftCols(kHeads), before.leftCols(kHeads));
  EXPECT_NE(actor.forward(s).rightCols(3), before.rightCols(3));
}

TEST(Passthrough, IsTheSameForOneStateAndForMany) {
  ParameterActor actor{HybridSpace{{1, 2}}, kStates, kHeads, learned(), Rng{1}};
  actor.passthrough() = drawn(1, static_cast<int>(actor.passthrough().size()), Rng{4}).row(0).transpose();
  const RowMatrixXf s = drawn(4, kStates, Rng{2});
  const RowMatrixXf many = actor.forward(s);
  for (int row = 0; row < 4; ++row) {
    EXPECT_TRUE(actor.forward_one(s.row(row).transpose()).isApprox(many.row(row).transpose(), 1e-5F));
  }
}

// Greatest error of an actor that has learned x = a s + b from its squared error.
float error_after_learning(const AgentOptions& options) {
  LearningActor actor{HybridSpace{{1}}, kStates, 0, options, Rng{1}};
  const Eigen::Vector3f a{0.5F, -0.75F, 0.25F};
  const auto wanted = [&](const RowMatrixXf& s) { return RowMatrixXf{((s * a).array() + 0.125F).matrix()}; };
  constexpr int kSteps = 4000;
  for (int step = 0; step < kSteps; ++step) {
    const RowMatrixXf s = drawn(32, kStates, Rng{5}.fork(static_cast<std::uint64_t>(step)));
    const RowMatrixXf x = actor.mu.forward(s);
    const double share = static_cast<double>(step) / kSteps;
    static_cast<void>(actor.climb(wanted(s) - x, s, x, std::pow(1e-3, share)));
  }
  const RowMatrixXf s = drawn(200, kStates, Rng{6});
  return (actor.mu.forward(s) - wanted(s)).cwiseAbs().maxCoeff();
}

TEST(Passthrough, LearnsWhatIsLinearMoreExactlyThanThePerceptron) {
  AgentOptions options = learned();
  const float with = error_after_learning(options);
  options.passthrough_rate = 0.0;
  const float without = error_after_learning(options);
  EXPECT_LT(with, 0.1F * without);
}

TEST(Passthrough, IsFollowedByTheTargetWhereItLearns) {
  LearningActor actor{HybridSpace{{1}}, kStates, 0, learned(), Rng{1}};
  actor.mu.passthrough().setConstant(1.0F);
  actor.follow();
  EXPECT_TRUE(actor.target.passthrough().isConstant(0.25F));  // tau (1 - 0)
}

TEST(Passthrough, RemembersItsMeansOnlyWhereItLearns) {
  const auto has_means = [](const AgentOptions& options) {
    LearningActor actor{HybridSpace{{1}}, kStates, 0, options, Rng{1}};
    std::vector<StatePart> parts;
    actor.append_state(parts);
    return std::any_of(parts.begin(), parts.end(),
                       [](const StatePart& part) { return part.name == "mu.passthrough.adam.v"; });
  };
  EXPECT_TRUE(has_means(learned()));
  EXPECT_FALSE(has_means({}));
}

}  // namespace
}  // namespace modsearch
