#pragma once

#include <modsearch/rl/action_values.hpp>

namespace modsearch {

// Checks that the three kinds share; std::invalid_argument names what does not fit.
void check_size(const char* what, Eigen::Index value, Eigen::Index needed);
void check_states(const RowMatrixXf& s, const RowMatrixXf& x, int observation_size, const HybridSpace& space);
void check_slopes(const RowMatrixXf& dq, Eigen::Index rows, const HybridSpace& space);  // rows < 0: no forward pass yet
void check_actions(const Eigen::VectorXi& k, Eigen::Index rows, const HybridSpace& space);

[[nodiscard]] std::unique_ptr<ActionValues> make_joint_values(const HybridSpace& space,
                                                              const ActionValues::Options& options, Rng rng);
[[nodiscard]] std::unique_ptr<ActionValues> make_multi_pass_values(const HybridSpace& space,
                                                                   const ActionValues::Options& options, Rng rng);
[[nodiscard]] std::unique_ptr<ActionValues> make_separate_values(const HybridSpace& space,
                                                                 const ActionValues::Options& options, const Rng& rng);

}  // namespace modsearch
