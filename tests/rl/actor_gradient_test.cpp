#include <gtest/gtest.h>

#include <cmath>
#include <modsearch/rl/actor_gradient.hpp>

namespace modsearch {
namespace {

TEST(InvertGradients, ShrinksWithTheRoomThatIsLeft) {
  // Hausknecht and Stone's formula on [-1, 1]: times (1 - p) / 2 upwards, (p + 1) / 2 downwards.
  RowMatrixXf g(1, 6), p(1, 6);
  g << 1.0F, 1.0F, 1.0F, 1.0F, -1.0F, -1.0F;
  p << 0.0F, 0.5F, 1.0F, 2.0F, 2.0F, -1.0F;
  invert_gradients(g, p, 1.0F);
  RowMatrixXf expected(1, 6);
  expected << 0.5F, 0.25F, 0.0F, -0.5F, -1.5F, -0.0F;
  EXPECT_TRUE(g.isApprox(expected)) << g;
}

TEST(InvertGradients, LetsAParameterRestOnItsBoundWithinWiderBounds) {
  RowMatrixXf g = RowMatrixXf::Constant(1, 1, 1.0F);
  invert_gradients(g, RowMatrixXf::Constant(1, 1, 1.0F), 1.1F);
  EXPECT_NEAR(g(0, 0), 0.1F / 2.2F, 1e-6F);
}

TEST(ZeroOutwardGradients, StopsWhatLeadsAwayBeyondABoundAndNothingElse) {
  RowMatrixXf g(1, 6), p(1, 6);
  g << 2.0F, -2.0F, 2.0F, -2.0F, 2.0F, -2.0F;
  p << 0.9F, 0.9F, 1.2F, 1.2F, -1.2F, -1.2F;
  zero_outward_gradients(g, p, 1.1F);
  RowMatrixXf expected(1, 6);
  expected << 2.0F, -2.0F, 0.0F, -2.0F, 2.0F, 0.0F;
  EXPECT_EQ(g, expected);
}

TEST(KeepTakenSlices, ClearsTheGradientsOfOtherActions) {
  const HybridSpace space{{1, 2, 0, 1}};
  Batch batch;
  batch.resize(3, 1, 4);
  batch.k << 1, 3, 2;
  RowMatrixXf g = RowMatrixXf::Ones(3, 4);
  keep_taken_slices(batch, space, g);
  RowMatrixXf expected(3, 4);
  expected << 0, 1, 1, 0,  //
      0, 0, 0, 1,          //
      0, 0, 0, 0;
  EXPECT_EQ(g, expected);
}

TEST(SmoothingNoise, StaysWithinItsClipAndTheBounds) {
  Rng rng{0};
  RowMatrixXf x = RowMatrixXf::Constant(200, 2, 0.9F);
  add_smoothing_noise({.smoothing = 0.5, .smoothing_clip = 0.2}, rng, x);
  EXPECT_LE(x.maxCoeff(), 1.0F);
  EXPECT_GE(x.minCoeff(), 0.7F - 1e-6F);
  EXPECT_GT(x.maxCoeff() - x.minCoeff(), 0.25F);
  const RowMatrixXf before = x;
  add_smoothing_noise({}, rng, x);
  EXPECT_EQ(x, before);
}

// A model that knows the error e = |x - 0.3| and the mass 2 x, of action 1 only.
class LineModel final : public ActionModel {
 public:
  [[nodiscard]] std::optional<Look> look(int k, std::span<const float> x_k, Work& work) const override {
    if (k != 1) return std::nullopt;
    ++work.ik_iterations;
    const double difference = static_cast<double>(x_k[0]) - 0.3;
    return Look{.error = std::abs(difference),
                .tolerance = 0.001,
                .mass = 2.0 * static_cast<double>(x_k[0]),
                .error_slope = Eigen::VectorXd::Constant(1, difference > 0.0 ? 1.0 : -1.0),
                .mass_slope = Eigen::VectorXd::Constant(1, 2.0)};
  }
  [[nodiscard]] std::vector<double> key() const override { return {1.0}; }
};

TEST(ModelGradient, PullsTowardsTheGoalAndDownTheMass) {
  const LineModel model;
  const HybridSpace space{{1, 1}};
  Batch batch;
  batch.resize(2, 1, 2);
  batch.model = {&model, nullptr};
  const RowMatrixXf x = RowMatrixXf::Constant(2, 2, 0.7F);
  RowMatrixXf g = RowMatrixXf::Zero(2, 2);
  const Work work = add_model_gradient(batch, space, {.reach = 10.0, .mass = 3.0, .width = 0.3}, x, g);
  // -(1 / B) (reach e / hypot(e, width) de/dx + mass dm/dx) with e = 0.4, hypot = 0.5.
  EXPECT_NEAR(g(0, 1), -0.5 * (10.0 * 0.8 + 3.0 * 2.0), 1e-5);
  EXPECT_EQ(g(0, 0), 0.0F);
  EXPECT_EQ(g.row(1).norm(), 0.0F);
  EXPECT_EQ(work.ik_iterations, 1);
}

// The pull on x, of one row, as float.
float pull_at(float x, ModelGradientOptions options) {
  const LineModel model;
  Batch batch;
  batch.resize(1, 1, 2);
  batch.model = {&model};
  RowMatrixXf g = RowMatrixXf::Zero(1, 2);
  options.pull = 10.0;
  static_cast<void>(add_model_gradient(batch, HybridSpace{{1, 1}}, options, RowMatrixXf::Constant(1, 2, x), g));
  EXPECT_EQ(g(0, 0), 0.0F);  // the model has no answer for action 0
  return g(0, 1);
}

TEST(ModelGradient, PullsTowardsThePolishedParameters) {
  // The lightest that reach within 0.3 of the tolerance lie at 0.3 - 0.0003; the way there is -0.4003, the width 0.3.
  const ModelGradientOptions lightest{.pull_width = 0.3, .pull_aim = 0.3};
  EXPECT_NEAR(pull_at(0.7F, lightest), -10.0 * 0.4003 / std::hypot(0.4003, 0.3), 1e-4);
  // The nearest lie at half of that on the near side: 0.3 + 0.00015.
  const ModelGradientOptions nearest{.pull_width = 0.3, .pull_aim = 0.3, .pull_mass = false};
  EXPECT_NEAR(pull_at(0.7F, nearest), -10.0 * 0.39985 / std::hypot(0.39985, 0.3), 1e-4);
  EXPECT_EQ(pull_at(0.3F, nearest), 0.0F);
}

TEST(ModelGradient, PullsInwardsFromWithinTheToleranceToo) {
  const ModelGradientOptions options{.pull_aim = 0.3};
  EXPECT_GT(pull_at(0.3F - 0.0009F, options), 0.0F);  // reaches, and is lighter than the aim
  EXPECT_LT(pull_at(0.3F + 0.0009F, options), 0.0F);
}

TEST(ModelGradient, CountsAParameterBeyondItsBoundAsOnIt) {
  // x counts as 1, from where 0.3 is down, and as -1, from where it is up: beyond a bound it is no further.
  const ModelGradientOptions options{.pull_width = 0.3};
  EXPECT_EQ(pull_at(1.5F, options), pull_at(1.0F, options));
  EXPECT_EQ(pull_at(-1.5F, options), pull_at(-1.0F, options));
}

TEST(ModelGradient, MovesOnlyTheTakenActionWhereAsked) {
  const LineModel model;
  const HybridSpace space{{1, 1}};
  Batch batch;
  batch.resize(2, 1, 2);
  batch.model = {&model, &model};
  batch.k << 0, 1;
  const RowMatrixXf x = RowMatrixXf::Constant(2, 2, 0.7F);
  RowMatrixXf g = RowMatrixXf::Zero(2, 2);
  const Work work = add_model_gradient(batch, space, {.reach = 10.0, .taken = true}, x, g);
  EXPECT_EQ(g.row(0).norm(), 0.0F);
  EXPECT_LT(g(1, 1), 0.0F);
  EXPECT_EQ(work.ik_iterations, 1);
}

}  // namespace
}  // namespace modsearch
