#include <fmt/format.h>

#include <modsearch/rl/action_values.hpp>
#include <modsearch/rl/action_values_internal.hpp>
#include <stdexcept>

namespace modsearch {

void check_size(const char* what, Eigen::Index value, Eigen::Index needed) {
  if (value != needed) {
    throw std::invalid_argument(fmt::format("action values: {} {}, {} are needed", value, what, needed));
  }
}

void check_states(const RowMatrixXf& s, const RowMatrixXf& x, int observation_size, const HybridSpace& space) {
  check_size("columns of states", s.cols(), observation_size);
  check_size("columns of parameters", x.cols(), space.n_parameters());
  check_size("rows of parameters", x.rows(), s.rows());
}

void check_slopes(const RowMatrixXf& dq, Eigen::Index rows, const HybridSpace& space) {
  if (rows < 0) throw std::logic_error("action values: a gradient without its forward pass");
  check_size("rows of slopes", dq.rows(), rows);
  check_size("columns of slopes", dq.cols(), space.n_actions());
}

void check_actions(const Eigen::VectorXi& k, Eigen::Index rows, const HybridSpace& space) {
  check_size("actions taken", k.size(), rows);
  for (const int action : k) {
    if (action < 0 || action >= space.n_actions()) {
      throw std::invalid_argument(fmt::format("action values: action {}, not in [0, {})", action, space.n_actions()));
    }
  }
}

std::unique_ptr<ActionValues> make_action_values(ValueKind kind, const HybridSpace& space,
                                                 const ActionValues::Options& options, Rng rng) {
  if (options.observation_size < 1) {
    throw std::invalid_argument(
        fmt::format("action values: observations of length {}, at least 1 is needed", options.observation_size));
  }
  switch (kind) {
    case ValueKind::kJoint:
      return make_joint_values(space, options, rng);
    case ValueKind::kMultiPass:
      return make_multi_pass_values(space, options, rng);
    case ValueKind::kSeparate:
      return make_separate_values(space, options, rng);
  }
  throw std::invalid_argument(fmt::format("action values: kind {}", static_cast<int>(kind)));
}

}  // namespace modsearch
