#include <gmock/gmock.h>

#include <modsearch/rl/adam.hpp>
#include <modsearch/rl/float_kernels_internal.hpp>
#include <modsearch/rl/mlp.hpp>

#include "rl/reference_network.hpp"

namespace modsearch {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXf;
using reference::DoubleAdam;
using reference::DoubleNetwork;
using reference::Gradients;
using reference::random_rows;
using testing::HasSubstr;
using testing::ThrowsMessage;

Mlp drawn(const Mlp::Shape& shape, std::uint64_t seed) {
  Mlp mlp{shape};
  Rng rng{seed};
  mlp.initialise({}, rng);
  for (int l = 0; l < mlp.n_layers(); ++l) {
    for (float& b : mlp.bias(l)) b = static_cast<float>(rng.uniform(-0.5, 0.5));
  }
  return mlp;
}

// What is not a weight or a bias.
VectorXf padding(const Mlp& mlp, VectorXf values) {
  const Network network{mlp.shape()};
  for (int l = 0; l < mlp.n_layers(); ++l) {
    Mlp::weights(network, values.data(), l).setZero();
    Mlp::bias(network, values.data(), l).setZero();
  }
  return values;
}

const std::vector<Mlp::Shape> kShapes{
    {.inputs = 16, .hidden = {128, 64}, .outputs = 6},
    {.inputs = 22, .hidden = {128}, .outputs = 3},
    {.inputs = 5, .hidden = {}, .outputs = 3},
    {.inputs = 5, .hidden = {}, .outputs = 20},
    {.inputs = 7, .hidden = {10}, .outputs = 1, .leak = 0.01F},
    {.inputs = 3, .hidden = {33, 17}, .outputs = 12, .leak = 0.1F},
    {.inputs = 36, .hidden = {20, 40, 8}, .outputs = 9},
};

// All networks on all instruction sets.
class MlpOn : public testing::TestWithParam<std::tuple<Isa, std::size_t>> {
 protected:
  MlpOn() { use_float_kernels(std::get<0>(GetParam())); }
  ~MlpOn() override { use_float_kernels(before); }

  const Isa before = chosen_isa(std::string{kernel_isa()}.c_str());
  const Mlp::Shape shape = kShapes[std::get<1>(GetParam())];
  Rng rng{7};
};

INSTANTIATE_TEST_SUITE_P(
    All, MlpOn, testing::Combine(testing::ValuesIn(supported_isas()), testing::Range(std::size_t{0}, kShapes.size())),
    [](const auto& instance) {
      return std::string{name(std::get<0>(instance.param))} + "_" + std::to_string(std::get<1>(instance.param));
    });

TEST_P(MlpOn, OutputsAndGradientsAreThoseOfANetworkInDouble) {
  const Mlp mlp = drawn(shape, 1);
  DoubleNetwork exact{mlp};
  Mlp::Pass pass;
  for (const int rows : {1, 2, 31, 128, 5}) {
    const RowMatrixXf x = random_rows(rows, shape.inputs, rng);
    const RowMatrixXf dy = random_rows(rows, shape.outputs, rng);
    const MatrixXd y = exact.forward(x.cast<double>());
    ASSERT_LT((mlp.forward(x, pass).cast<double>() - y).cwiseAbs().maxCoeff(), 1e-5);
    const Gradients g = exact.backward(dy.cast<double>());
    VectorXf gradient = VectorXf::Zero(mlp.parameters().size());
    RowMatrixXf dx;
    mlp.backward(dy, pass, &gradient, &dx);
    ASSERT_LT((dx.cast<double>() - g.x).cwiseAbs().maxCoeff(), 1e-5);
    const DoubleNetwork as_weights{Network{shape}, gradient.data()};
    for (std::size_t l = 0; l < g.w.size(); ++l) {
      ASSERT_LT((as_weights.w[l] - g.w[l]).cwiseAbs().maxCoeff(), 1e-4);  // sums of 128
      ASSERT_LT((as_weights.b[l] - g.b[l]).cwiseAbs().maxCoeff(), 1e-4);
    }
    ASSERT_EQ(padding(mlp, gradient), VectorXf::Zero(gradient.size()));
  }
}

TEST_P(MlpOn, TwentyStepsOfLearningEndAtTheWeightsOfANetworkInDouble) {
  Mlp mlp = drawn(shape, 2);
  DoubleNetwork exact{mlp};
  Adam adam{mlp.parameters().size(), {.clip = 1.0}};
  DoubleAdam exact_adam;
  Mlp::Pass pass;
  const RowMatrixXf wanted = random_rows(64, shape.outputs, rng);
  const RowMatrixXf x = random_rows(64, shape.inputs, rng);
  for (int update = 0; update < 20; ++update) {
    VectorXf gradient = VectorXf::Zero(mlp.parameters().size());
    mlp.backward((mlp.forward(x, pass) - wanted) / 64.0F, pass, &gradient, nullptr);
    adam.step(mlp.parameters(), gradient, 1e-3F);
    const MatrixXd dy = (exact.forward(x.cast<double>()) - wanted.cast<double>()) / 64.0;
    exact_adam.step(exact, exact.backward(dy), 1e-3, 1.0);
  }
  EXPECT_LT(reference::difference(exact, Network{shape}, mlp.parameters().data()), 1e-5);
  EXPECT_EQ(padding(mlp, mlp.parameters()), VectorXf::Zero(mlp.parameters().size()));
}

TEST_P(MlpOn, ARowIsTheSameBitsAloneAmongOthersAndAgain) {
  const Mlp mlp = drawn(shape, 3);
  Mlp::Pass all, single;
  const RowMatrixXf x = random_rows(29, shape.inputs, rng);
  const RowMatrixXf y = mlp.forward(x, all);
  EXPECT_EQ(mlp.forward(x, all), y);
  for (Eigen::Index row = 0; row < x.rows(); ++row) {
    EXPECT_EQ(mlp.forward(x.row(row), single).row(0), y.row(row));
    EXPECT_EQ(mlp.forward_one(x.row(row).transpose(), single).transpose(), y.row(row));
  }
}

// The loss sum(c * y), c fixed, in double: central differences are exact to 1e-9 between kinks.
TEST(Mlp, GradientsAreTheSlopesOfTheLoss) {
  const Mlp mlp = drawn({.inputs = 4, .hidden = {9, 5}, .outputs = 2, .leak = 0.1F}, 4);
  Rng rng{5};
  const RowMatrixXf x = random_rows(3, 4, rng);
  const RowMatrixXf c = random_rows(3, 2, rng);
  Mlp::Pass pass;
  static_cast<void>(mlp.forward(x, pass));
  VectorXf gradient = VectorXf::Zero(mlp.parameters().size());
  RowMatrixXf dx;
  mlp.backward(c, pass, &gradient, &dx);
  const DoubleNetwork slopes{Network{mlp.shape()}, gradient.data()};
  DoubleNetwork network{mlp};
  MatrixXd inputs = x.cast<double>();
  const auto check = [&](double& value, double slope) {
    constexpr double kStep = 1e-6;
    const double before = value;
    value = before + kStep;
    const double above = network.forward(inputs).cwiseProduct(c.cast<double>()).sum();
    value = before - kStep;
    const double below = network.forward(inputs).cwiseProduct(c.cast<double>()).sum();
    value = before;
    EXPECT_NEAR((above - below) / (2.0 * kStep), slope, 1e-5);
  };
  for (std::size_t l = 0; l < network.w.size(); ++l) {
    for (Eigen::Index i = 0; i < network.w[l].size(); ++i) check(network.w[l].data()[i], slopes.w[l].data()[i]);
    for (Eigen::Index i = 0; i < network.b[l].size(); ++i) check(network.b[l][i], slopes.b[l][i]);
  }
  const MatrixXd dx_exact = dx.cast<double>();
  for (Eigen::Index i = 0; i < inputs.size(); ++i) check(inputs.data()[i], dx_exact.data()[i]);
}

// x = -2 through w = 1, leak 0.1, w = 3: y = 3 * 0.1 * -2 = -0.6, dy/dx = 0.3. With a plain ReLU: 0 and 0.
TEST(Mlp, LeaksBelowZeroAsMuchAsItIsTold) {
  for (const float leak : {0.0F, 0.1F}) {
    Mlp mlp{{.inputs = 1, .hidden = {1}, .outputs = 1, .leak = leak}};
    mlp.weights(0)(0, 0) = 1.0F;
    mlp.weights(1)(0, 0) = 3.0F;
    Mlp::Pass pass;
    EXPECT_FLOAT_EQ(mlp.forward(RowMatrixXf::Constant(1, 1, -2.0F), pass)(0, 0), -6.0F * leak);
    RowMatrixXf dx;
    mlp.backward(RowMatrixXf::Ones(1, 1), pass, nullptr, &dx);
    EXPECT_FLOAT_EQ(dx(0, 0), 3.0F * leak);
  }
}

TEST(Mlp, TakesInputsInTwoPartsAndGivesTheSlopesOfTheSecond) {
  const Mlp mlp = drawn({.inputs = 7, .hidden = {20}, .outputs = 2}, 6);
  Rng rng{8};
  const RowMatrixXf x = random_rows(5, 7, rng);
  const RowMatrixXf dy = random_rows(5, 2, rng);
  Mlp::Pass whole, parts;
  EXPECT_EQ(mlp.forward(x.leftCols(4), x.rightCols(3), parts), mlp.forward(x, whole));
  RowMatrixXf dx, dx_right;
  mlp.backward(dy, whole, nullptr, &dx);
  mlp.backward(dy, parts, nullptr, &dx_right, 4);
  EXPECT_EQ(dx_right, dx.rightCols(3));
}

TEST(Mlp, AddsToTheGradient) {
  const Mlp mlp = drawn({.inputs = 3, .hidden = {4}, .outputs = 2}, 9);
  Rng rng{10};
  Mlp::Pass pass;
  static_cast<void>(mlp.forward(random_rows(6, 3, rng), pass));
  const RowMatrixXf dy = random_rows(6, 2, rng);
  VectorXf once = VectorXf::Zero(mlp.parameters().size());
  mlp.backward(dy, pass, &once, nullptr);
  VectorXf twice = once;
  mlp.backward(dy, pass, &twice, nullptr);
  EXPECT_LT((twice - 2.0F * once).cwiseAbs().maxCoeff(), 1e-5F);
}

// Means over n draws have the deviation sigma / sqrt(n), variances sigma^2 sqrt(2 / n): five of them are allowed.
TEST(Mlp, DrawsHiddenWeightsAfterHeAndOutputsAsTold) {
  Mlp mlp{{.inputs = 50, .hidden = {400}, .outputs = 30}};
  Rng rng{11};
  mlp.initialise({.output_deviation = 0.25F}, rng);
  const auto variance = [](const auto& w) { return w.squaredNorm() / static_cast<float>(w.size()); };
  EXPECT_NEAR(mlp.weights(0).mean(), 0.0F, 5.0F * 0.2F / std::sqrt(20000.0F));
  EXPECT_NEAR(variance(mlp.weights(0)), 0.04F, 5.0F * 0.04F * std::sqrt(2.0F / 20000.0F));
  EXPECT_NEAR(variance(mlp.weights(1)), 0.0625F, 5.0F * 0.0625F * std::sqrt(2.0F / 12000.0F));
  EXPECT_EQ(mlp.bias(0).norm() + mlp.bias(1).norm(), 0.0F);

  // Uniform in +-1/20: variance (1/20)^2 / 3, of which the relative deviation is sqrt(0.8 / n).
  mlp.initialise({.output_deviation = -1.0F}, rng);
  EXPECT_LE(mlp.weights(1).cwiseAbs().maxCoeff(), 0.05F);
  EXPECT_NEAR(variance(mlp.weights(1)), 0.0025F / 3.0F, 5.0F * 0.0025F / 3.0F * std::sqrt(0.8F / 12000.0F));

  mlp.initialise({.output_deviation = 0.0F}, rng);
  EXPECT_EQ(mlp.weights(1).norm(), 0.0F);
  EXPECT_GT(mlp.weights(0).norm(), 0.0F);
}

TEST(Mlp, ACopyIsIndependent) {
  const Mlp mlp = drawn({.inputs = 2, .hidden = {3}, .outputs = 1}, 12);
  Mlp copy = mlp;
  copy.parameters().setZero();
  EXPECT_GT(mlp.parameters().norm(), 0.0F);
}

TEST(Mlp, RefusesImpossibleShapesAndOtherSizes) {
  EXPECT_THAT([] { Mlp({.inputs = 3, .hidden = {0}, .outputs = 1}); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("a layer of width 0, at least 1 is needed")));
  EXPECT_THROW(Mlp({.inputs = 0, .hidden = {}, .outputs = 1}), std::invalid_argument);
  EXPECT_THROW(Mlp({.inputs = 1, .hidden = {}, .outputs = 1, .leak = 1.0F}), std::invalid_argument);
  const Mlp mlp{{.inputs = 3, .hidden = {4}, .outputs = 2}};
  Mlp::Pass pass;
  RowMatrixXf dx;
  EXPECT_THROW(mlp.backward(RowMatrixXf::Zero(1, 2), pass, nullptr, &dx), std::invalid_argument);  // no forward pass
  EXPECT_THROW(static_cast<void>(mlp.forward(RowMatrixXf::Zero(1, 4), pass)), std::invalid_argument);
  EXPECT_THROW(static_cast<void>(mlp.forward_one(VectorXf::Zero(2), pass)), std::invalid_argument);
  static_cast<void>(mlp.forward(RowMatrixXf::Zero(2, 3), pass));
  EXPECT_THROW(mlp.backward(RowMatrixXf::Zero(3, 2), pass, nullptr, &dx), std::invalid_argument);
  VectorXf small = VectorXf::Zero(1);
  EXPECT_THROW(mlp.backward(RowMatrixXf::Zero(2, 2), pass, &small, nullptr), std::invalid_argument);
}

}  // namespace
}  // namespace modsearch
