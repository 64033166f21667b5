#include "platform/platform_environment.hpp"

#include <fmt/format.h>

#include <stdexcept>

namespace modsearch {

PlatformEnvironment::PlatformEnvironment(Options options) : options_{options} {
  if (options_.most_actions < 1) {
    throw std::invalid_argument(
        fmt::format("Platform: most_actions is {}, at least 1 is needed", options_.most_actions));
  }
  if (!(options_.noise >= 0.0)) {
    throw std::invalid_argument(fmt::format("Platform: noise is {}, at least 0 is needed", options_.noise));
  }
}

std::unique_ptr<Environment> PlatformEnvironment::clone() const {
  return std::make_unique<PlatformEnvironment>(options_);
}

const PlatformWorld& PlatformEnvironment::world() const {
  if (!world_) throw std::logic_error("Platform: no episode has begun");
  return *world_;
}

Environment::View PlatformEnvironment::do_reset(Rng rng) {
  world_.emplace(rng, options_.noise);
  actions_ = 0;
  return view();
}

Step PlatformEnvironment::do_step(int k, std::span<const float> x_k, View& next) {
  const auto action = static_cast<PlatformAction>(k);
  const double parameter = 0.5 * (1.0 + static_cast<double>(x_k[0])) * PlatformWorld::largest(action);
  const PlatformOutcome outcome = world_->act(action, parameter);
  ++actions_;
  next = view();
  return {.reward = outcome.reward,
          .terminated = outcome.over(),
          .truncated = !outcome.over() && actions_ == options_.most_actions,
          .success = outcome.arrived};
}

Environment::View PlatformEnvironment::view() const {
  View result{.observation = Eigen::VectorXf(PlatformWorld::kStateSize), .mask = space_.all()};
  const auto state = world_->scaled_state();
  for (std::size_t i = 0; i < state.size(); ++i) {
    result.observation[static_cast<Eigen::Index>(i)] = static_cast<float>(2.0 * state[i] - 1.0);
  }
  return result;
}

}  // namespace modsearch
