#pragma once

#include <modsearch/rl/agent.hpp>
#include <modsearch/rl/agent_options.hpp>

namespace modsearch {

/// Inverting gradients (Hausknecht and Stone 2016, "Deep reinforcement learning in parameterized action space", eq. 11)
/// for parameters in [-bound, bound]: a gradient that would raise a parameter shrinks with the room above it, one that
/// would lower it with the room below, and outside the bounds it points back. `g`: ascent gradient at the parameters
/// `p`, changed in place [B x n].
void invert_gradients(Eigen::Ref<RowMatrixXf> g, const Eigen::Ref<const RowMatrixXf>& p, float bound);

/// Zeroing gradients (the same, section 4), but only those that lead further away: beyond the bounds the way back stays
/// open. Within them `g` is left alone.
void zero_outward_gradients(Eigen::Ref<RowMatrixXf> g, const Eigen::Ref<const RowMatrixXf>& p, float bound);

/// Sets dJ/dx [B x D] to 0 outside the slice of the action that each row took.
void keep_taken_slices(const Batch& batch, const HybridSpace& space, Eigen::Ref<RowMatrixXf> g);

/// Target policy smoothing (Fujimoto et al. 2018, eq. 14): x = clip(x + clip(noise)), nothing where it is off.
void add_smoothing_noise(const Td3Options& options, Rng& rng, RowMatrixXf& x);

/// Adds the exact derivatives of reach error and mass to the ascent gradient dJ/dx [B x D] at the proposals x, for
/// every action, or the one taken, of every row that has a model. Returns the inner work.
Work add_model_gradient(const Batch& batch, const HybridSpace& space, const ModelGradientOptions& options,
                        const Eigen::Ref<const RowMatrixXf>& x, Eigen::Ref<RowMatrixXf> g);

}  // namespace modsearch
