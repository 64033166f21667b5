#include <gmock/gmock.h>

#include <modsearch/rl/adam.hpp>
#include <stdexcept>

namespace modsearch {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

// rate 0.1, gradients 0.5 and -0.25 for a weight that starts at 1:
// m = 0.05, v = 0.00025; m^ = 0.5, v^ = 0.25: w = 1 - 0.1 * 0.5 / 0.5 = 0.9
// m = 0.9 * 0.05 - 0.1 * 0.25 = 0.02, v = 0.999 * 0.00025 + 0.001 * 0.0625 = 0.00031225;
// m^ = 0.02 / 0.19, v^ = 0.00031225 / 0.001999: w = 0.9 - 0.1 * 0.1052632 / 0.3952248 = 0.8733663
TEST(Adam, TakesTheTwoStepsDoneByHand) {
  Adam adam{1, {}};
  Eigen::VectorXf w = Eigen::VectorXf::Ones(1);
  EXPECT_FLOAT_EQ(adam.step(w, Eigen::VectorXf::Constant(1, 0.5F), 0.1F), 0.5F);
  EXPECT_NEAR(w[0], 0.9F, 1e-6F);
  adam.step(w, Eigen::VectorXf::Constant(1, -0.25F), 0.1F);
  EXPECT_NEAR(w[0], 0.8733663F, 1e-6F);
  EXPECT_NEAR(adam.m[0], 0.02F, 1e-8F);
  EXPECT_NEAR(adam.v[0], 0.00031225F, 1e-10F);
  EXPECT_EQ(adam.steps, 2);
}

// (30, 40) has the norm 50: at most 10 leaves (6, 8), of which m keeps a tenth.
TEST(Adam, ScalesALongGradientBack) {
  Adam adam{2, {.clip = 10.0}};
  Eigen::VectorXf w = Eigen::VectorXf::Zero(2);
  EXPECT_FLOAT_EQ(adam.step(w, Eigen::Vector2f{30.0F, 40.0F}, 0.1F), 50.0F);
  EXPECT_NEAR(adam.m[0], 0.6F, 1e-6F);
  EXPECT_NEAR(adam.m[1], 0.8F, 1e-6F);
}

TEST(Adam, LeavesAWeightWithoutSlopeWhereItIs) {
  Adam adam{100, {}};
  Eigen::VectorXf w = Eigen::VectorXf::LinSpaced(100, -1.0F, 1.0F);
  const Eigen::VectorXf before = w;
  adam.step(w, Eigen::VectorXf::Zero(100), 0.1F);
  EXPECT_EQ(w, before);
}

TEST(Adam, RefusesOtherSizesAndImpossibleOptions) {
  Adam adam{3, {}};
  Eigen::VectorXf w = Eigen::VectorXf::Zero(3);
  EXPECT_THAT([&] { adam.step(w, Eigen::VectorXf::Zero(2), 0.1F); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("3 weights and 2 slopes, made for 3")));
  EXPECT_THROW((Adam{1, {.beta1 = 1.0}}), std::invalid_argument);
  EXPECT_THROW((Adam{1, {.beta2 = -0.1}}), std::invalid_argument);
  EXPECT_THROW((Adam{1, {.epsilon = 0.0}}), std::invalid_argument);
  EXPECT_THROW((Adam{1, {.clip = 0.0}}), std::invalid_argument);
}

TEST(SoftUpdate, MovesTheTargetByTauOfTheDistance) {
  Eigen::VectorXf target = Eigen::VectorXf::Constant(5, 1.0F);
  soft_update(target, Eigen::VectorXf::Constant(5, 3.0F), 0.25F);
  EXPECT_EQ(target, Eigen::VectorXf::Constant(5, 1.5F));
  soft_update(target, Eigen::VectorXf::Constant(5, -2.0F), 1.0F);
  EXPECT_EQ(target, Eigen::VectorXf::Constant(5, -2.0F));
  EXPECT_THROW(soft_update(target, Eigen::VectorXf::Zero(4), 0.5F), std::invalid_argument);
}

}  // namespace
}  // namespace modsearch
