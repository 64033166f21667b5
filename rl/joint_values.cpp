#include <modsearch/rl/one_network_values_internal.hpp>

namespace modsearch {
namespace {

// P-DQN: every value reads all parameters.
class JointValues final : public OneNetworkValues {
 public:
  JointValues(const HybridSpace& space, const Options& options, Rng rng) : OneNetworkValues{space, options, rng} {}

  std::unique_ptr<ActionValues> clone() const override { return std::make_unique<JointValues>(*this); }
  ValueKind kind() const override { return ValueKind::kJoint; }

  const RowMatrixXf& forward(const RowMatrixXf& s, const RowMatrixXf& x) override {
    check_states(s, x, n_s(), space());
    rows_ = s.rows();
    return network().forward(s, x, pass_);
  }

  const RowMatrixXf& parameters_gradient(const RowMatrixXf& dq) override {
    check_slopes(dq, rows_, space());
    network().backward(dq, pass_, nullptr, &dx_, n_s());
    return dx_;
  }

  const Eigen::VectorXf& forward_one(const Eigen::VectorXf& s, const Eigen::VectorXf& x) override {
    check_size("columns of states", s.size(), n_s());
    check_size("columns of parameters", x.size(), space().n_parameters());
    input_.resize(s.size() + x.size());
    input_ << s, x;
    return network().forward_one(input_, pass_);
  }

 private:
  void hide_others(int, float*) const override {}

  Mlp::Pass pass_;
  Eigen::Index rows_ = -1;
  RowMatrixXf dx_;
  Eigen::VectorXf input_;
};

}  // namespace

std::unique_ptr<ActionValues> make_joint_values(const HybridSpace& space, const ActionValues::Options& options,
                                                Rng rng) {
  return std::make_unique<JointValues>(space, options, rng);
}

}  // namespace modsearch
