#include <algorithm>
#include <cmath>
#include <modsearch/rl/actor_gradient.hpp>

namespace modsearch {

void invert_gradients(Eigen::Ref<RowMatrixXf> g, const Eigen::Ref<const RowMatrixXf>& p, float bound) {
  const float range = 2.0F * bound;
  g = (g.array() > 0.0F).select(g.array() * (bound - p.array()) / range, g.array() * (p.array() + bound) / range);
}

void zero_outward_gradients(Eigen::Ref<RowMatrixXf> g, const Eigen::Ref<const RowMatrixXf>& p, float bound) {
  g = (p.array().abs() >= bound && g.array() * p.array() > 0.0F).select(0.0F, g.array());
}

void keep_taken_slices(const Batch& batch, const HybridSpace& space, Eigen::Ref<RowMatrixXf> g) {
  for (int row = 0; row < batch.size(); ++row) {
    const int first = space.offset(batch.k[row]);
    const int count = space.count(batch.k[row]);
    g.row(row).head(first).setZero();
    g.row(row).tail(g.cols() - first - count).setZero();
  }
}

void add_smoothing_noise(const Td3Options& options, Rng& rng, RowMatrixXf& x) {
  if (options.smoothing == 0.0) return;
  for (float& value : x.reshaped()) {
    const double noise = std::clamp(options.smoothing * rng.normal(), -options.smoothing_clip, options.smoothing_clip);
    value = static_cast<float>(std::clamp(static_cast<double>(value) + noise, -1.0, 1.0));
  }
}

Work add_model_gradient(const Batch& batch, const HybridSpace& space, const ModelGradientOptions& options,
                        const Eigen::Ref<const RowMatrixXf>& x, Eigen::Ref<RowMatrixXf> g) {
  Work work;
  const double share = 1.0 / batch.size();
  Eigen::VectorXf x_k;
  for (int row = 0; row < batch.size(); ++row) {
    const ActionModel* model = batch.model[static_cast<std::size_t>(row)];
    if (model == nullptr) continue;
    for (int k = 0; k < space.n_actions(); ++k) {
      if (space.count(k) == 0 || (options.taken && k != batch.k[row])) continue;
      // The model knows the parameters' own ranges only; beyond them the nearest point says which way is back.
      x_k = x.row(row).segment(space.offset(k), space.count(k)).transpose().cwiseMax(-1.0F).cwiseMin(1.0F);
      const auto look = model->look(k, {x_k.data(), static_cast<std::size_t>(x_k.size())}, work);
      if (!look) continue;
      const double pull = options.reach * look->error / std::hypot(look->error, options.width);
      g.row(row).segment(space.offset(k), space.count(k)) -=
          (share * (pull * look->error_slope + options.mass * look->mass_slope)).cast<float>().transpose();
    }
  }
  return work;
}

}  // namespace modsearch
