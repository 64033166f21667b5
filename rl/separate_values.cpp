#include <modsearch/rl/action_values_internal.hpp>
#include <modsearch/rl/mlp.hpp>

namespace modsearch {
namespace {

// SP-DQN: a network [s; x_k] -> R for every action, all in one vector of weights. Each learns from the rows that took
// its action.
class SeparateValues final : public ActionValues {
 public:
  SeparateValues(const HybridSpace& space, const Options& options, const Rng& rng)
      : space_{space}, n_s_{options.observation_size} {
    for (int k = 0; k < space.n_actions(); ++k) {
      One one{Network{{.inputs = n_s_ + space.count(k), .hidden = options.hidden, .outputs = 1, .leak = options.leak}}};
      one.place = parameters_.size();
      Rng draw = rng.fork(static_cast<std::uint64_t>(k));
      const Eigen::VectorXf w = draw_weights(one.network, {.output_deviation = options.output_deviation}, draw);
      parameters_.conservativeResize(one.place + w.size());
      parameters_.tail(w.size()) = w;
      ones_.push_back(std::move(one));
    }
  }

  std::unique_ptr<ActionValues> clone() const override { return std::make_unique<SeparateValues>(*this); }
  ValueKind kind() const override { return ValueKind::kSeparate; }
  Eigen::VectorXf& parameters() override { return parameters_; }
  const Eigen::VectorXf& parameters() const override { return parameters_; }

  const RowMatrixXf& forward(const RowMatrixXf& s, const RowMatrixXf& x) override {
    check_states(s, x, n_s_, space_);
    rows_ = s.rows();
    values_.resize(rows_, space_.n_actions());
    for (int k = 0; k < space_.n_actions(); ++k) {
      One& one = at(k);
      one.x = x.middleCols(space_.offset(k), space_.count(k));
      values_.col(k) = one.network.forward(weights(one), s, one.x, one.pass).col(0);
    }
    return values_;
  }

  const RowMatrixXf& parameters_gradient(const RowMatrixXf& dq) override {
    check_slopes(dq, rows_, space_);
    dx_.resize(rows_, space_.n_parameters());
    for (int k = 0; k < space_.n_actions(); ++k) {
      One& one = at(k);
      one.slopes = dq.col(k);
      one.network.backward(weights(one), one.slopes, one.pass, nullptr, &one.dx, n_s_);
      dx_.middleCols(space_.offset(k), space_.count(k)) = one.dx;
    }
    return dx_;
  }

  const Eigen::VectorXf& forward_taken(const RowMatrixXf& s, const RowMatrixXf& x, const Eigen::VectorXi& k) override {
    check_states(s, x, n_s_, space_);
    check_actions(k, s.rows(), space_);
    taken_ = k;
    taken_values_.resize(k.size());
    for (One& one : ones_) one.rows.clear();
    for (Eigen::Index row = 0; row < k.size(); ++row) at(k[row]).rows.push_back(row);
    for (int action = 0; action < space_.n_actions(); ++action) {
      One& one = at(action);
      if (one.rows.empty()) continue;
      one.taken_s = s(one.rows, Eigen::all);
      one.taken_x = x(one.rows, Eigen::seqN(space_.offset(action), space_.count(action)));
      taken_values_(one.rows) = one.network.forward(weights(one), one.taken_s, one.taken_x, one.taken_pass).col(0);
    }
    return taken_values_;
  }

  void weights_gradient(const Eigen::VectorXf& dq, Eigen::VectorXf& gradient) override {
    check_size("slopes", dq.size(), taken_.size());
    check_size("numbers of the gradient", gradient.size(), parameters_.size());
    for (One& one : ones_) {
      if (one.rows.empty()) continue;
      one.slopes = dq(one.rows);
      one.network.backward(weights(one), one.slopes, one.taken_pass, gradient.data() + one.place, nullptr);
    }
  }

  const Eigen::VectorXf& forward_one(const Eigen::VectorXf& s, const Eigen::VectorXf& x) override {
    check_size("columns of states", s.size(), n_s_);
    check_size("columns of parameters", x.size(), space_.n_parameters());
    one_.resize(space_.n_actions());
    for (int k = 0; k < space_.n_actions(); ++k) {
      One& one = at(k);
      input_.resize(n_s_ + space_.count(k));
      input_ << s, x.segment(space_.offset(k), space_.count(k));
      one_[k] = one.network.forward_one(weights(one), input_, one.pass)[0];
    }
    return one_;
  }

 private:
  // The network of one action and its memory.
  struct One {
    Network network;
    Eigen::Index place = 0;  // of its weights
    Network::Pass pass{}, taken_pass{};
    std::vector<Eigen::Index> rows{};  // that took the action
    RowMatrixXf x{}, dx{}, slopes{}, taken_s{}, taken_x{};
  };

  One& at(int k) { return ones_[static_cast<std::size_t>(k)]; }
  const float* weights(const One& one) const { return parameters_.data() + one.place; }

  HybridSpace space_;
  int n_s_;
  std::vector<One> ones_;
  Eigen::VectorXf parameters_;
  Eigen::Index rows_ = -1;
  Eigen::VectorXi taken_;
  RowMatrixXf values_, dx_;
  Eigen::VectorXf taken_values_, one_, input_;
};

}  // namespace

std::unique_ptr<ActionValues> make_separate_values(const HybridSpace& space, const ActionValues::Options& options,
                                                   const Rng& rng) {
  return std::make_unique<SeparateValues>(space, options, rng);
}

}  // namespace modsearch
