#include <gmock/gmock.h>

#include <modsearch/rl/action_values.hpp>
#include <modsearch/rl/adam.hpp>
#include <modsearch/rl/float_kernels_internal.hpp>

#include "rl/reference_network.hpp"

namespace modsearch {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXf;
using Eigen::VectorXi;
using reference::DoubleNetwork;
using reference::Gradients;
using reference::random_rows;
using testing::HasSubstr;
using testing::ThrowsMessage;

constexpr int kStates = 5;
constexpr Index kRows = 37;

// The values as their papers define them, in double precision: whole inputs, zeroed where Q_k does not look.
struct NaiveValues {
  NaiveValues(const ActionValues& values, const HybridSpace& the_space, const ActionValues::Options& options)
      : kind{values.kind()}, space{the_space} {
    Index place = 0;
    for (int k = 0; k < (kind == ValueKind::kSeparate ? space.n_actions() : 1); ++k) {
      const bool separate = kind == ValueKind::kSeparate;
      shapes.push_back({.inputs = kStates + (separate ? space.count(k) : space.n_parameters()),
                        .hidden = options.hidden,
                        .outputs = separate ? 1 : space.n_actions(),
                        .leak = options.leak});
      networks.emplace_back(Network{shapes.back()}, values.parameters().data() + place);
      places.push_back(place);
      place += Network{shapes.back()}.size();
    }
    EXPECT_EQ(place, values.parameters().size());
  }

  // Network, input and output of Q_k.
  DoubleNetwork& network(int k) { return networks[kind == ValueKind::kSeparate ? static_cast<std::size_t>(k) : 0]; }
  [[nodiscard]] Index output(int k) const { return kind == ValueKind::kSeparate ? 0 : k; }
  [[nodiscard]] MatrixXd input(const RowMatrixXf& s, const RowMatrixXf& x, int k) const {
    const RowMatrixXf x_k = x.middleCols(space.offset(k), space.count(k));
    RowMatrixXf seen = x;
    if (kind == ValueKind::kMultiPass) {
      seen.setZero();
      seen.middleCols(space.offset(k), space.count(k)) = x_k;
    }
    if (kind == ValueKind::kSeparate) seen = x_k;
    MatrixXd result(s.rows(), s.cols() + seen.cols());
    result << s.cast<double>(), seen.cast<double>();
    return result;
  }

  MatrixXd forward(const RowMatrixXf& s, const RowMatrixXf& x) {
    MatrixXd q(s.rows(), space.n_actions());
    for (int k = 0; k < space.n_actions(); ++k) q.col(k) = network(k).forward(input(s, x, k)).col(output(k));
    return q;
  }

  // dL/d inputs and weights for dL/dQ_k.
  Gradients backward(const RowMatrixXf& s, const RowMatrixXf& x, int k, const Eigen::VectorXd& dq) {
    const MatrixXd y = network(k).forward(input(s, x, k));
    MatrixXd dy = MatrixXd::Zero(y.rows(), y.cols());
    dy.col(output(k)) = dq;
    return network(k).backward(dy);
  }

  MatrixXd parameters_gradient(const RowMatrixXf& s, const RowMatrixXf& x, const RowMatrixXf& dq) {
    MatrixXd dx = MatrixXd::Zero(x.rows(), x.cols());
    for (int k = 0; k < space.n_actions(); ++k) {
      const MatrixXd all = backward(s, x, k, dq.col(k).cast<double>()).x;
      const int offset = space.offset(k), count = space.count(k);
      if (kind == ValueKind::kJoint) dx += all.rightCols(x.cols());
      if (kind == ValueKind::kMultiPass) dx.middleCols(offset, count) += all.middleCols(kStates + offset, count);
      if (kind == ValueKind::kSeparate) dx.middleCols(offset, count) += all.rightCols(count);
    }
    return dx;
  }

  ValueKind kind;
  HybridSpace space;
  std::vector<Mlp::Shape> shapes;
  std::vector<DoubleNetwork> networks;
  std::vector<Index> places;
};

struct Case {
  ValueKind kind;
  std::vector<int> counts;
  std::vector<int> hidden;
  float leak;
};

const std::vector<int> kNineActions{1, 0, 2, 3, 1, 1, 2, 0, 4};  // more than a transposed last layer has

std::vector<Case> all_cases() {
  std::vector<Case> cases;
  for (const ValueKind kind : {ValueKind::kJoint, ValueKind::kMultiPass, ValueKind::kSeparate}) {
    for (const std::vector<int>& counts : {std::vector<int>{2, 2, 2}, {1, 2, 0, 3}, {3}, kNineActions}) {
      cases.push_back({kind, counts, {24}, 0.0F});
      cases.push_back({kind, counts, {20, 40, 13}, 0.1F});
      cases.push_back({kind, counts, {}, 0.0F});
    }
  }
  return cases;
}

class ActionValuesOf : public testing::TestWithParam<std::tuple<Isa, Case>> {
 protected:
  ActionValuesOf() { use_float_kernels(std::get<0>(GetParam())); }
  ~ActionValuesOf() override { use_float_kernels(before); }

  const Isa before = chosen_isa(std::string{kernel_isa()}.c_str());
  const Case test = std::get<1>(GetParam());
  const HybridSpace space{test.counts};
  const ActionValues::Options options{.observation_size = kStates, .hidden = test.hidden, .leak = test.leak};
  const std::unique_ptr<ActionValues> values = make_action_values(test.kind, space, options, Rng{3});
  NaiveValues naive{*values, space, options};
  Rng rng{1};
  const RowMatrixXf s = random_rows(kRows, kStates, rng);
  const RowMatrixXf x = random_rows(kRows, space.n_parameters(), rng);
};

INSTANTIATE_TEST_SUITE_P(All, ActionValuesOf,
                         testing::Combine(testing::ValuesIn(supported_isas()), testing::ValuesIn(all_cases())),
                         [](const auto& instance) {
                           return std::string{name(std::get<0>(instance.param))} + "_" + std::to_string(instance.index);
                         });

TEST_P(ActionValuesOf, ForwardIsTheNaiveFormInDouble) {
  EXPECT_LT((values->forward(s, x).cast<double>() - naive.forward(s, x)).cwiseAbs().maxCoeff(), 1e-5);
}

TEST_P(ActionValuesOf, ParametersGradientIsTheNaiveFormInDouble) {
  const RowMatrixXf dq = random_rows(kRows, space.n_actions(), rng);
  static_cast<void>(values->forward(s, x));
  const RowMatrixXf& dx = values->parameters_gradient(dq);
  ASSERT_EQ(dx.rows(), kRows);
  ASSERT_EQ(dx.cols(), space.n_parameters());
  EXPECT_LT((dx.cast<double>() - naive.parameters_gradient(s, x, dq)).cwiseAbs().maxCoeff(), 1e-5);
}

TEST_P(ActionValuesOf, TakenActionsAndTheirWeightsGradientAreTheNaiveFormInDouble) {
  VectorXi k(kRows);
  for (int& action : k) action = rng.index(space.n_actions());
  const VectorXf dq = random_rows(kRows, 1, rng).col(0);
  const VectorXf taken = values->forward_taken(s, x, k);
  const MatrixXd q = naive.forward(s, x);
  for (Index row = 0; row < kRows; ++row) ASSERT_NEAR(taken[row], q(row, k[row]), 1e-5);

  VectorXf gradient = VectorXf::Zero(values->parameters().size());
  values->weights_gradient(dq, gradient);
  Eigen::VectorXd expected = Eigen::VectorXd::Zero(gradient.size());
  for (int action = 0; action < space.n_actions(); ++action) {
    Eigen::VectorXd dq_k = dq.cast<double>();
    for (Index row = 0; row < kRows; ++row) dq_k[row] *= k[row] == action ? 1.0 : 0.0;
    const Gradients g = naive.backward(s, x, action, dq_k);
    const std::size_t i = naive.shapes.size() > 1 ? static_cast<std::size_t>(action) : 0;
    const Network network{naive.shapes[i]};
    VectorXf part = VectorXf::Zero(network.size());
    for (int l = 0; l < static_cast<int>(g.w.size()); ++l) {
      Mlp::weights(network, part.data(), l) = g.w[static_cast<std::size_t>(l)].cast<float>();
      Mlp::bias(network, part.data(), l) = g.b[static_cast<std::size_t>(l)].cast<float>();
    }
    expected.segment(naive.places[i], part.size()) += part.cast<double>();
  }
  EXPECT_LT((gradient.cast<double>() - expected).cwiseAbs().maxCoeff(), 3e-5);  // padding included, which stays 0
}

TEST_P(ActionValuesOf, OneStateHasTheValuesOfItsRow) {
  const RowMatrixXf q = values->forward(s, x);
  const RowMatrixXf dq = random_rows(kRows, space.n_actions(), rng);
  const RowMatrixXf dx = values->parameters_gradient(dq);
  for (const Index row : {0, 20}) {
    const VectorXf one = values->forward_one(s.row(row).transpose(), x.row(row).transpose());
    EXPECT_EQ(one.transpose(), q.row(row));
  }
  EXPECT_EQ(values->parameters_gradient(dq), dx);  // still that of the whole batch
}

TEST_P(ActionValuesOf, OnlyTheJointKindReadsTheOthersParameters) {
  const RowMatrixXf q = values->forward(s, x);
  for (int j = 0; j < space.n_actions(); ++j) {
    RowMatrixXf other = x;
    other.middleCols(space.offset(j), space.count(j)).array() += 0.5F;
    const RowMatrixXf changed = values->forward(s, other);
    for (int k = 0; k < space.n_actions(); ++k) {
      if (k == j || test.kind == ValueKind::kJoint) continue;
      ASSERT_EQ(changed.col(k), q.col(k));
    }
  }
  if (test.kind == ValueKind::kJoint) return;
  static_cast<void>(values->forward(s, x));
  for (int k = 0; k < space.n_actions(); ++k) {
    RowMatrixXf dq = RowMatrixXf::Zero(kRows, space.n_actions());
    dq.col(k).setOnes();
    RowMatrixXf dx = values->parameters_gradient(dq);
    dx.middleCols(space.offset(k), space.count(k)).setZero();
    ASSERT_EQ(dx, RowMatrixXf::Zero(kRows, space.n_parameters()));
  }
}

TEST_P(ActionValuesOf, ACloneIsEqualAndIndependent) {
  const std::unique_ptr<ActionValues> copy = values->clone();
  EXPECT_EQ(copy->kind(), test.kind);
  EXPECT_EQ(copy->forward(s, x), values->forward(s, x));
  copy->parameters().setZero();
  EXPECT_EQ(copy->forward(s, x), RowMatrixXf::Zero(kRows, space.n_actions()));
  EXPECT_GT(values->forward(s, x).norm(), 0.0F);
}

// Twenty steps towards fixed targets for the actions taken, as the agents do them.
TEST(ActionValues, TwentyStepsOfLearningEndAtTheWeightsOfANetworkInDouble) {
  for (const ValueKind kind : {ValueKind::kJoint, ValueKind::kMultiPass}) {
    const HybridSpace space{{2, 2, 2}};
    const ActionValues::Options options{.observation_size = kStates};
    const std::unique_ptr<ActionValues> values = make_action_values(kind, space, options, Rng{5});
    NaiveValues naive{*values, space, options};
    Rng rng{6};
    const RowMatrixXf s = random_rows(128, kStates, rng);
    const RowMatrixXf x = random_rows(128, 6, rng);
    const VectorXf y = random_rows(128, 1, rng).col(0);
    VectorXi k(128);
    for (int& action : k) action = rng.index(3);
    Adam adam{values->parameters().size(), {}};
    reference::DoubleAdam exact_adam;
    for (int update = 0; update < 20; ++update) {
      VectorXf gradient = VectorXf::Zero(values->parameters().size());
      values->weights_gradient(2.0F / 128.0F * (values->forward_taken(s, x, k) - y), gradient);
      adam.step(values->parameters(), gradient, 1e-3F);

      Gradients sum;
      for (int action = 0; action < 3; ++action) {
        Eigen::VectorXd dq = naive.network(0).forward(naive.input(s, x, action)).col(action) - y.cast<double>();
        for (Index row = 0; row < 128; ++row) dq[row] *= k[row] == action ? 2.0 / 128.0 : 0.0;
        const Gradients g = naive.backward(s, x, action, dq);
        if (action == 0) sum = g;
        for (std::size_t l = 0; action > 0 && l < g.w.size(); ++l) {
          sum.w[l] += g.w[l];
          sum.b[l] += g.b[l];
        }
      }
      exact_adam.step(naive.network(0), sum, 1e-3, 10.0);
    }
    const Network network{naive.shapes.front()};
    EXPECT_LT(reference::difference(naive.network(0), network, values->parameters().data()), 1e-5);
  }
}

TEST(MultiPassValues, EqualJointValuesWhereTheOtherParametersAreZero) {
  const HybridSpace space{{2, 1, 3}};
  const ActionValues::Options options{.observation_size = kStates};
  const auto joint = make_action_values(ValueKind::kJoint, space, options, Rng{8});
  const auto multi = make_action_values(ValueKind::kMultiPass, space, options, Rng{8});
  Rng rng{9};
  const RowMatrixXf s = random_rows(kRows, kStates, rng);
  const RowMatrixXf all = random_rows(kRows, 6, rng);
  for (int k = 0; k < 3; ++k) {
    RowMatrixXf x = RowMatrixXf::Zero(kRows, 6);
    x.middleCols(space.offset(k), space.count(k)) = all.middleCols(space.offset(k), space.count(k));
    const VectorXf expected = joint->forward(s, x).col(k);
    EXPECT_LT((multi->forward(s, all).col(k) - expected).cwiseAbs().maxCoeff(), 1e-6F);
    EXPECT_EQ(multi->forward_taken(s, all, VectorXi::Constant(kRows, k)),
              joint->forward_taken(s, x, VectorXi::Constant(kRows, k)));
  }
}

TEST(SeparateValues, LearnOnlyFromTheRowsOfTheirAction) {
  const HybridSpace space{{2, 2}};
  const auto values = make_action_values(ValueKind::kSeparate, space, {.observation_size = kStates}, Rng{10});
  Rng rng{11};
  const RowMatrixXf s = random_rows(kRows, kStates, rng);
  const RowMatrixXf x = random_rows(kRows, 4, rng);
  static_cast<void>(values->forward_taken(s, x, VectorXi::Ones(kRows)));
  VectorXf gradient = VectorXf::Zero(values->parameters().size());
  values->weights_gradient(VectorXf::Ones(kRows), gradient);
  const Index half = gradient.size() / 2;  // equal networks: those of action 0 come first
  EXPECT_EQ(gradient.head(half).norm(), 0.0F);
  EXPECT_GT(gradient.tail(half).norm(), 0.0F);
}

TEST(ActionValues, RefuseWhatDoesNotFit) {
  const HybridSpace space{{2, 1}};
  EXPECT_THROW(static_cast<void>(make_action_values(ValueKind::kJoint, space, {}, Rng{1})), std::invalid_argument);
  for (const ValueKind kind : {ValueKind::kJoint, ValueKind::kMultiPass, ValueKind::kSeparate}) {
    const auto values = make_action_values(kind, space, {.observation_size = 4}, Rng{1});
    const RowMatrixXf s = RowMatrixXf::Zero(2, 4);
    const RowMatrixXf x = RowMatrixXf::Zero(2, 3);
    EXPECT_THROW(static_cast<void>(values->parameters_gradient(RowMatrixXf::Zero(2, 2))), std::logic_error);
    EXPECT_THAT([&] { static_cast<void>(values->forward(RowMatrixXf::Zero(2, 5), x)); },
                ThrowsMessage<std::invalid_argument>(HasSubstr("5 columns of states, 4 are needed")));
    EXPECT_THROW(static_cast<void>(values->forward(s, RowMatrixXf::Zero(2, 2))), std::invalid_argument);
    EXPECT_THROW(static_cast<void>(values->forward(s, RowMatrixXf::Zero(3, 3))), std::invalid_argument);
    EXPECT_THAT([&] { static_cast<void>(values->forward_taken(s, x, VectorXi::Constant(2, 2))); },
                ThrowsMessage<std::invalid_argument>(HasSubstr("action 2, not in [0, 2)")));
    static_cast<void>(values->forward(s, x));
    EXPECT_THROW(static_cast<void>(values->parameters_gradient(RowMatrixXf::Zero(1, 2))), std::invalid_argument);
    EXPECT_THROW(static_cast<void>(values->forward_one(VectorXf::Zero(3), VectorXf::Zero(3))), std::invalid_argument);
    static_cast<void>(values->forward_taken(s, x, VectorXi::Zero(2)));
    VectorXf gradient = VectorXf::Zero(1);
    EXPECT_THROW(values->weights_gradient(VectorXf::Zero(3), gradient), std::invalid_argument);
    EXPECT_THROW(values->weights_gradient(VectorXf::Zero(2), gradient), std::invalid_argument);
  }
}

}  // namespace
}  // namespace modsearch
