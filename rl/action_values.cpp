#include <modsearch/rl/action_values.hpp>

#include <fmt/format.h>

#include <modsearch/rl/mlp.hpp>
#include <stdexcept>

namespace modsearch {
namespace {

void check(const char* what, Eigen::Index value, Eigen::Index needed) {
  if (value != needed) {
    throw std::invalid_argument(fmt::format("action values: {} {}, {} are needed", value, what, needed));
  }
}

void check_states(const RowMatrixXf& s, const RowMatrixXf& x, int observation_size, const HybridSpace& space) {
  check("columns of states", s.cols(), observation_size);
  check("columns of parameters", x.cols(), space.n_parameters());
  check("rows of parameters", x.rows(), s.rows());
}

void check_actions(const Eigen::VectorXi& k, Eigen::Index rows, const HybridSpace& space) {
  check("actions taken", k.size(), rows);
  for (const int action : k) {
    if (action < 0 || action >= space.n_actions()) {
      throw std::invalid_argument(
          fmt::format("action values: action {}, not in [0, {})", action, space.n_actions()));
    }
  }
}

Mlp drawn(Mlp::Shape shape, float output_deviation, Rng rng) {
  Mlp network{std::move(shape)};
  network.initialise({.output_deviation = output_deviation}, rng);
  return network;
}

// P-DQN and MP-DQN: one network [s; x] -> R^K.
class OneNetwork final : public ActionValues {
 public:
  OneNetwork(ValueKind kind, const HybridSpace& space, const Options& options, Rng rng)
      : kind_{kind},
        space_{space},
        n_s_{options.observation_size},
        network_{drawn({n_s_ + space.n_parameters(), options.hidden, space.n_actions(), options.leak},
                       options.output_deviation, rng)} {}

  std::unique_ptr<ActionValues> clone() const override { return std::make_unique<OneNetwork>(*this); }
  ValueKind kind() const override { return kind_; }
  Eigen::VectorXf& parameters() override { return network_.parameters(); }
  const Eigen::VectorXf& parameters() const override { return network_.parameters(); }

  const RowMatrixXf& forward(const RowMatrixXf& s, const RowMatrixXf& x) override {
    check_states(s, x, n_s_, space_);
    const Eigen::Index rows = s.rows();
    const int passes = kind_ == ValueKind::kMultiPass ? space_.n_actions() : 1;
    inputs_.setZero(passes * rows, n_s_ + space_.n_parameters());
    for (int pass = 0; pass < passes; ++pass) {
      inputs_.block(pass * rows, 0, rows, n_s_) = s;
      if (passes == 1) {
        inputs_.rightCols(space_.n_parameters()) = x;
      } else {
        inputs_.block(pass * rows, n_s_ + space_.offset(pass), rows, space_.count(pass)) =
            x.middleCols(space_.offset(pass), space_.count(pass));
      }
    }
    const RowMatrixXf& all = network_.forward(inputs_, pass_);
    rows_ = rows;
    if (passes == 1) return all;
    values_.resize(rows, space_.n_actions());
    for (int k = 0; k < passes; ++k) values_.col(k) = all.col(k).segment(k * rows, rows);
    return values_;
  }

  const RowMatrixXf& parameters_gradient(const RowMatrixXf& dq) override {
    if (rows_ < 0) throw std::logic_error("action values: a gradient without its forward pass");
    check("rows of slopes", dq.rows(), rows_);
    check("columns of slopes", dq.cols(), space_.n_actions());
    if (kind_ == ValueKind::kJoint) {
      network_.backward(dq, pass_, nullptr, &d_inputs_);
      dx_ = d_inputs_.rightCols(space_.n_parameters());
      return dx_;
    }
    d_all_.setZero(space_.n_actions() * rows_, space_.n_actions());
    for (int k = 0; k < space_.n_actions(); ++k) d_all_.col(k).segment(k * rows_, rows_) = dq.col(k);
    network_.backward(d_all_, pass_, nullptr, &d_inputs_);
    dx_.resize(rows_, space_.n_parameters());
    for (int k = 0; k < space_.n_actions(); ++k) {
      dx_.middleCols(space_.offset(k), space_.count(k)) =
          d_inputs_.block(k * rows_, n_s_ + space_.offset(k), rows_, space_.count(k));
    }
    return dx_;
  }

  const Eigen::VectorXf& forward_taken(const RowMatrixXf& s, const RowMatrixXf& x, const Eigen::VectorXi& k) override {
    check_states(s, x, n_s_, space_);
    check_actions(k, s.rows(), space_);
    taken_ = k;
    taken_inputs_.resize(s.rows(), n_s_ + space_.n_parameters());
    taken_inputs_.leftCols(n_s_) = s;
    taken_inputs_.rightCols(space_.n_parameters()) = x;
    if (kind_ == ValueKind::kMultiPass) {
      for (Eigen::Index row = 0; row < s.rows(); ++row) {
        auto parameters = taken_inputs_.row(row).tail(space_.n_parameters());
        const int before = space_.offset(k[row]);
        parameters.head(before).setZero();
        parameters.tail(space_.n_parameters() - before - space_.count(k[row])).setZero();
      }
    }
    const RowMatrixXf& all = network_.forward(taken_inputs_, taken_pass_);
    taken_values_.resize(s.rows());
    for (Eigen::Index row = 0; row < s.rows(); ++row) taken_values_[row] = all(row, k[row]);
    return taken_values_;
  }

  void weights_gradient(const Eigen::VectorXf& dq, Eigen::VectorXf& gradient) override {
    check("slopes", dq.size(), taken_.size());
    d_taken_.setZero(dq.size(), space_.n_actions());
    for (Eigen::Index row = 0; row < dq.size(); ++row) d_taken_(row, taken_[row]) = dq[row];
    network_.backward(d_taken_, taken_pass_, &gradient, nullptr);
  }

  const Eigen::VectorXf& forward_one(const Eigen::VectorXf& s, const Eigen::VectorXf& x) override {
    const Eigen::Index rows = rows_;
    const RowMatrixXf kept = inputs_;
    one_ = forward(s.transpose(), x.transpose()).row(0);
    inputs_ = kept;
    rows_ = rows;
    if (rows >= 0) network_.forward(inputs_, pass_);
    return one_;
  }

 private:
  ValueKind kind_;
  HybridSpace space_;
  int n_s_;
  Mlp network_;
  Mlp::Pass pass_, taken_pass_;
  Eigen::Index rows_ = -1;
  RowMatrixXf inputs_, values_, d_all_, d_inputs_, dx_;
  Eigen::VectorXi taken_;
  RowMatrixXf taken_inputs_, d_taken_;
  Eigen::VectorXf taken_values_, one_;
};

// SP-DQN: a network [s; x_k] -> R for every action. Each learns from the rows that took its action.
class SeparateNetworks final : public ActionValues {
 public:
  SeparateNetworks(const HybridSpace& space, const Options& options, const Rng& rng)
      : space_{space}, n_s_{options.observation_size} {
    Eigen::Index size = 0;
    for (int k = 0; k < space.n_actions(); ++k) {
      networks_.push_back(drawn({n_s_ + space.count(k), options.hidden, 1, options.leak}, options.output_deviation,
                                rng.fork(static_cast<std::uint64_t>(k))));
      size += networks_.back().parameters().size();
    }
    parameters_.resize(size);
    Eigen::Index place = 0;
    for (const Mlp& network : networks_) {
      parameters_.segment(place, network.parameters().size()) = network.parameters();
      place += network.parameters().size();
    }
    passes_.resize(networks_.size());
    taken_passes_.resize(networks_.size());
    rows_of_.resize(networks_.size());
  }

  std::unique_ptr<ActionValues> clone() const override { return std::make_unique<SeparateNetworks>(*this); }
  ValueKind kind() const override { return ValueKind::kSeparate; }
  Eigen::VectorXf& parameters() override { return parameters_; }
  const Eigen::VectorXf& parameters() const override { return parameters_; }

  const RowMatrixXf& forward(const RowMatrixXf& s, const RowMatrixXf& x) override {
    check_states(s, x, n_s_, space_);
    spread();
    values_.resize(s.rows(), space_.n_actions());
    for (int k = 0; k < space_.n_actions(); ++k) {
      RowMatrixXf inputs(s.rows(), n_s_ + space_.count(k));
      inputs << s, x.middleCols(space_.offset(k), space_.count(k));
      values_.col(k) = networks_[at(k)].forward(inputs, passes_[at(k)]).col(0);
    }
    rows_ = s.rows();
    return values_;
  }

  const RowMatrixXf& parameters_gradient(const RowMatrixXf& dq) override {
    if (rows_ < 0) throw std::logic_error("action values: a gradient without its forward pass");
    check("rows of slopes", dq.rows(), rows_);
    check("columns of slopes", dq.cols(), space_.n_actions());
    dx_.resize(rows_, space_.n_parameters());
    for (int k = 0; k < space_.n_actions(); ++k) {
      RowMatrixXf d_inputs;
      networks_[at(k)].backward(dq.col(k), passes_[at(k)], nullptr, &d_inputs);
      dx_.middleCols(space_.offset(k), space_.count(k)) = d_inputs.rightCols(space_.count(k));
    }
    return dx_;
  }

  const Eigen::VectorXf& forward_taken(const RowMatrixXf& s, const RowMatrixXf& x, const Eigen::VectorXi& k) override {
    check_states(s, x, n_s_, space_);
    check_actions(k, s.rows(), space_);
    spread();
    taken_ = k;
    taken_values_.resize(s.rows());
    for (int action = 0; action < space_.n_actions(); ++action) {
      std::vector<Eigen::Index>& rows = rows_of_[at(action)];
      rows.clear();
      for (Eigen::Index row = 0; row < k.size(); ++row) {
        if (k[row] == action) rows.push_back(row);
      }
      if (rows.empty()) continue;
      const auto count = static_cast<Eigen::Index>(rows.size());
      RowMatrixXf inputs(count, n_s_ + space_.count(action));
      for (Eigen::Index i = 0; i < count; ++i) {
        const Eigen::Index row = rows[static_cast<std::size_t>(i)];
        inputs.row(i) << s.row(row), x.row(row).segment(space_.offset(action), space_.count(action));
      }
      const RowMatrixXf& q = networks_[at(action)].forward(inputs, taken_passes_[at(action)]);
      for (Eigen::Index i = 0; i < count; ++i) taken_values_[rows[static_cast<std::size_t>(i)]] = q(i, 0);
    }
    return taken_values_;
  }

  void weights_gradient(const Eigen::VectorXf& dq, Eigen::VectorXf& gradient) override {
    check("slopes", dq.size(), taken_.size());
    check("numbers of the gradient", gradient.size(), parameters_.size());
    Eigen::Index place = 0;
    for (int k = 0; k < space_.n_actions(); ++k) {
      const Eigen::Index size = networks_[at(k)].parameters().size();
      const std::vector<Eigen::Index>& rows = rows_of_[at(k)];
      if (!rows.empty()) {
        const RowMatrixXf slopes = dq(rows);
        Eigen::VectorXf part = Eigen::VectorXf::Zero(size);
        networks_[at(k)].backward(slopes, taken_passes_[at(k)], &part, nullptr);
        gradient.segment(place, size) += part;
      }
      place += size;
    }
  }

  const Eigen::VectorXf& forward_one(const Eigen::VectorXf& s, const Eigen::VectorXf& x) override {
    check("columns of states", s.size(), n_s_);
    check("columns of parameters", x.size(), space_.n_parameters());
    spread();
    one_.resize(space_.n_actions());
    for (int k = 0; k < space_.n_actions(); ++k) {
      Eigen::VectorXf input(n_s_ + space_.count(k));
      input << s, x.segment(space_.offset(k), space_.count(k));
      one_[k] = networks_[at(k)].forward_one(input, one_pass_)[0];
    }
    return one_;
  }

 private:
  static std::size_t at(int k) { return static_cast<std::size_t>(k); }

  // parameters_ is what counts: callers write there.
  void spread() {
    Eigen::Index place = 0;
    for (Mlp& network : networks_) {
      network.parameters() = parameters_.segment(place, network.parameters().size());
      place += network.parameters().size();
    }
  }

  HybridSpace space_;
  int n_s_;
  std::vector<Mlp> networks_;
  Eigen::VectorXf parameters_;
  std::vector<Mlp::Pass> passes_, taken_passes_;
  std::vector<std::vector<Eigen::Index>> rows_of_;
  Mlp::Pass one_pass_;
  Eigen::Index rows_ = -1;
  Eigen::VectorXi taken_;
  RowMatrixXf values_, dx_;
  Eigen::VectorXf taken_values_, one_;
};

}  // namespace

std::unique_ptr<ActionValues> make_action_values(ValueKind kind, const HybridSpace& space,
                                                 const ActionValues::Options& options, Rng rng) {
  if (options.observation_size < 1) {
    throw std::invalid_argument(
        fmt::format("action values: observations of length {}, at least 1 is needed", options.observation_size));
  }
  if (kind == ValueKind::kSeparate) return std::make_unique<SeparateNetworks>(space, options, rng);
  return std::make_unique<OneNetwork>(kind, space, options, rng);
}

}  // namespace modsearch
