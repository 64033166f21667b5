#include <algorithm>
#include <cmath>
#include <modsearch/rl/actor_gradient.hpp>
#include <modsearch/rl/polish.hpp>

namespace modsearch {
namespace {

// A model with a part of its tolerance: what is polished on it ends well inside, whichever side it came from.
class Tightened final : public ActionModel {
 public:
  Tightened(const ActionModel& model, double share) : model_{model}, share_{share} {}
  [[nodiscard]] std::optional<Look> look(int k, std::span<const float> x_k, Work& work) const override {
    std::optional<Look> look = model_.look(k, x_k, work);
    if (look) look->tolerance *= share_;
    return look;
  }
  [[nodiscard]] std::vector<double> key() const override { return model_.key(); }

 private:
  const ActionModel& model_;
  double share_;
};

// The pull [n_k] of weight 1 from x_k towards what the polish makes of it.
Eigen::VectorXf pull_to_polished(const ActionModel& model, int k, const Eigen::VectorXf& x_k,
                                 const ModelGradientOptions& options, Work& work) {
  Eigen::VectorXf polished = x_k;
  polish(Tightened{model, options.pull_aim}, k, {polished.data(), static_cast<std::size_t>(polished.size())},
         options.pull_steps, {.descend_mass = options.pull_mass}, work);
  const Eigen::ArrayXf way = (polished - x_k).array();
  return way / (way.square() + static_cast<float>(options.pull_width * options.pull_width)).sqrt();
}

}  // namespace

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
      if (options.pull != 0.0) {
        g.row(row).segment(space.offset(k), space.count(k)) +=
            static_cast<float>(share * options.pull) * pull_to_polished(*model, k, x_k, options, work).transpose();
      }
      if (options.reach == 0.0 && options.mass == 0.0) continue;
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
