#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <modsearch/rl/environment.hpp>
#include <stdexcept>
#include <vector>

namespace modsearch::testing {

/// A uniform allowed action, parameters uniform in [-1, 1].
inline HybridAction random_action(const Environment& environment, Rng& rng) {
  std::vector<int> allowed;
  for (int k = 0; k < environment.space().n_actions(); ++k) {
    if (environment.mask() >> k & 1) allowed.push_back(k);
  }
  HybridAction action{allowed.at(static_cast<std::size_t>(rng.index(static_cast<int>(allowed.size())))),
                      Eigen::VectorXf(environment.space().n_parameters()),
                      {}};
  for (float& x : action.x) x = static_cast<float>(rng.uniform(-1.0, 1.0));
  return action;
}

/// One moment of an episode, as an agent sees it.
struct Moment {
  Eigen::VectorXf observation;
  ActionMask mask = 0;
  Step step;
};

inline bool operator==(const Moment& a, const Moment& b) {
  return a.observation == b.observation && a.mask == b.mask && a.step.reward == b.step.reward &&
         a.step.terminated == b.step.terminated && a.step.truncated == b.step.truncated &&
         a.step.success == b.step.success;
}

/// A whole episode with random actions.
inline std::vector<Moment> random_episode(Environment& environment, Rng episode, Rng actions) {
  environment.reset(episode);
  std::vector<Moment> moments{{environment.observation(), environment.mask(), {}}};
  while (environment.running()) {
    const Step step = environment.step(random_action(environment, actions));
    moments.push_back({environment.observation(), environment.mask(), step});
    if (moments.size() > 100'000) throw std::runtime_error("the episode does not end");
  }
  return moments;
}

struct EnvironmentContract {
  int episodes = 20;
  double largest_observation = 2.0;  ///< "about in [-1, 1]"
};

inline void expect_episode_is_sound(const Environment& environment, const std::vector<Moment>& moments,
                                    const EnvironmentContract& contract) {
  for (std::size_t i = 0; i < moments.size(); ++i) {
    const auto& [observation, mask, step] = moments[i];
    const bool last = i + 1 == moments.size();
    ASSERT_EQ(observation.size(), environment.observation_size());
    EXPECT_TRUE(observation.allFinite());
    EXPECT_LE(observation.cwiseAbs().maxCoeff(), contract.largest_observation);
    EXPECT_EQ(mask & ~environment.space().all(), 0U) << "the mask speaks of actions that there are";
    EXPECT_TRUE(std::isfinite(step.reward));
    EXPECT_FALSE(step.terminated && step.truncated) << "an end is one or the other";
    EXPECT_EQ(step.terminated || step.truncated, last);
    if (!last) {
      EXPECT_NE(mask, 0U) << "there is something to do while an episode runs";
      EXPECT_FALSE(step.success);
    }
  }
}

inline void expect_misuse_is_refused(Environment& environment, Rng rng) {
  const HybridSpace& space = environment.space();
  environment.reset(rng);
  HybridAction action = random_action(environment, rng);
  const Moment before{environment.observation(), environment.mask(), {}};
  const auto refused = [&](const HybridAction& wrong) {
    EXPECT_THROW((void)environment.step(wrong), std::invalid_argument);
    EXPECT_EQ((Moment{environment.observation(), environment.mask(), {}}), before) << "nothing has happened";
    EXPECT_TRUE(environment.running());
  };
  for (const int k : {-1, space.n_actions()}) refused({k, action.x, {}});
  for (int k = 0; k < space.n_actions(); ++k) {
    if (!(environment.mask() >> k & 1)) refused({k, action.x, {}});
  }
  refused({action.k, Eigen::VectorXf::Zero(space.n_parameters() + 1), {}});
  for (int i = 0; i < space.count(action.k); ++i) {
    HybridAction wrong = action;
    wrong.x[space.offset(action.k) + i] = std::numeric_limits<float>::quiet_NaN();
    refused(wrong);
  }
  // Parameters of other actions do not count, not even NaN.
  for (int i = 0; i < space.n_parameters(); ++i) {
    const bool own = i >= space.offset(action.k) && i < space.offset(action.k) + space.count(action.k);
    if (!own) action.x[i] = std::numeric_limits<float>::quiet_NaN();
  }
  EXPECT_NO_THROW((void)environment.step(action));
  while (environment.running()) (void)environment.step(random_action(environment, rng));
  EXPECT_THROW((void)environment.step(action), std::logic_error) << "a step after the end";
}

inline void expect_parameters_are_clipped(const Environment& environment, Rng rng) {
  const auto beyond = environment.clone();
  const auto at_end = environment.clone();
  beyond->reset(rng);
  at_end->reset(rng);
  HybridAction action = random_action(*beyond, rng);
  action.x.setConstant(7.0F);
  const Step one = beyond->step(action);
  action.x.setOnes();
  const Step other = at_end->step(action);
  EXPECT_EQ((Moment{beyond->observation(), beyond->mask(), one}),
            (Moment{at_end->observation(), at_end->mask(), other}));
}

/// Models give equal answers after a round trip through their keys; a preview is what the step then pays.
inline void expect_look_ahead_holds(Environment& environment, Rng rng) {
  environment.reset(rng);
  const HybridSpace& space = environment.space();
  while (environment.running()) {
    const HybridAction action = random_action(environment, rng);
    const Eigen::VectorXf x_k = action.x.segment(space.offset(action.k), space.count(action.k));
    const std::span<const float> parameters{x_k.data(), static_cast<std::size_t>(x_k.size())};
    if (const std::shared_ptr<const ActionModel> model = environment.model()) {
      const std::shared_ptr<const ActionModel> restored = environment.restore_model(model->key());
      ASSERT_NE(restored, nullptr);
      Work work;
      const auto look = model->look(action.k, parameters, work);
      const auto again = restored->look(action.k, parameters, work);
      ASSERT_EQ(look.has_value(), again.has_value());
      if (look) {
        EXPECT_EQ(look->error, again->error);
        EXPECT_EQ(look->tolerance, again->tolerance);
        EXPECT_EQ(look->mass, again->mass);
        EXPECT_EQ(look->error_slope, again->error_slope);
        EXPECT_EQ(look->mass_slope, again->mass_slope);
        EXPECT_EQ(look->error_slope.size(), space.count(action.k));
        EXPECT_EQ(look->mass_slope.size(), space.count(action.k));
      }
    }
    const std::optional<double> preview = environment.preview(action.k, parameters);
    const Step step = environment.step(action);
    if (preview) {
      EXPECT_EQ(*preview, step.reward);
    }
  }
}

/// What every Environment promises; run it on yours.
inline void expect_environment_contract(const Environment& prototype, EnvironmentContract contract = {}) {
  SCOPED_TRACE(prototype.name());
  const auto environment = prototype.clone();
  ASSERT_NE(environment, nullptr);
  EXPECT_FALSE(environment->running()) << "a clone is between episodes";
  EXPECT_EQ(environment->space(), prototype.space());
  EXPECT_EQ(environment->observation_size(), prototype.observation_size());
  EXPECT_THROW((void)environment->step({0, Eigen::VectorXf::Zero(prototype.space().n_parameters()), {}}),
               std::logic_error)
      << "a step before the first reset";
  EXPECT_THROW((void)environment->restore_model(std::vector<double>{-1.0}), std::invalid_argument);

  const auto other = environment->clone();
  for (int i = 0; i < contract.episodes; ++i) {
    const Rng rng = Rng{77}.fork(static_cast<std::uint64_t>(i));
    const std::vector<Moment> moments = random_episode(*environment, rng.fork("episode"), rng.fork("actions"));
    expect_episode_is_sound(*environment, moments, contract);

    // A clone half way through an episode of its own neither disturbs nor is disturbed.
    other->reset(rng.fork("other"));
    Rng other_actions = rng.fork("other actions");
    const Step first_of_other = other->step(random_action(*other, other_actions));
    const Moment of_other{other->observation(), other->mask(), first_of_other};
    EXPECT_EQ(random_episode(*environment, rng.fork("episode"), rng.fork("actions")), moments)
        << "an episode is a function of its random stream and the actions";
    EXPECT_EQ((Moment{other->observation(), other->mask(), first_of_other}), of_other);
    EXPECT_EQ(random_episode(*other, rng.fork("episode"), rng.fork("actions")), moments) << "clones are alike";

    expect_misuse_is_refused(*environment, rng.fork("misuse"));
    expect_parameters_are_clipped(*environment, rng.fork("clipping"));
    expect_look_ahead_holds(*environment, rng.fork("look ahead"));
  }
}

}  // namespace modsearch::testing
