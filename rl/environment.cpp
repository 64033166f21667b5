#include <modsearch/rl/environment.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace modsearch {

void Environment::reset(Rng rng) {
  View first = do_reset(rng);
  observation_ = std::move(first.observation);
  mask_ = first.mask;
  running_ = true;
}

Step Environment::step(const HybridAction& action) {
  if (!running_) throw std::logic_error(fmt::format("{}: a step outside an episode; reset comes first", name()));
  const HybridSpace& actions = space();
  if (action.k < 0 || action.k >= actions.n_actions() || !(mask_ >> action.k & 1)) {
    throw std::invalid_argument(fmt::format("{}: action {} is not allowed here (mask {:#x})", name(), action.k, mask_));
  }
  if (action.x.size() != actions.n_parameters()) {
    throw std::invalid_argument(fmt::format("{}: {} action parameters, {} are needed", name(), action.x.size(),
                                            actions.n_parameters()));
  }
  const Eigen::VectorXf x_k = action.x.segment(actions.offset(action.k), actions.count(action.k));
  if (x_k.hasNaN()) throw std::invalid_argument(fmt::format("{}: NaN among the parameters of action {}", name(), action.k));
  const Eigen::VectorXf clipped = x_k.cwiseMax(-1.0F).cwiseMin(1.0F);
  View next;
  const Step result = do_step(action.k, {clipped.data(), static_cast<std::size_t>(clipped.size())}, next);
  observation_ = std::move(next.observation);
  mask_ = next.mask;
  running_ = !result.terminated && !result.truncated;
  return result;
}

std::shared_ptr<const ActionModel> Environment::restore_model(std::span<const double>) const {
  throw std::invalid_argument(fmt::format("{}: has no models of its actions", name()));
}

std::optional<double> Environment::preview(int, std::span<const float>) const { return std::nullopt; }

std::vector<Transition> Environment::hindsight(int, Rng&) const { return {}; }

}  // namespace modsearch
