#pragma once

#include <Eigen/Core>
#include <modsearch/rl/adam.hpp>
#include <vector>

namespace modsearch {

/// How the values of the actions are weighted in the actor's objective J = mean_B sum_k w_k Q_k(s, mu(s)).
enum class ActorWeighting {
  kSum,       ///< w_k = 1: Xiong et al. 2018, eq. 6
  kWeighted,  ///< w_k: share of action k among the batch's actions
  kAverage,   ///< w_k = 1 / K
  kRandom,    ///< uniform in [0, 1]^K, scaled to length 1, drawn anew in every update
};

/// What becomes of the actor's gradient g in a parameter p that approaches its bounds [-b, b] (Hausknecht and Stone
/// 2016, section 4). mu is linear in its last layer: where nothing holds a parameter back, it drifts away.
enum class BoundGradients {
  kInvert,  ///< eq. 11: g (b - p) / 2b upwards, g (p + b) / 2b downwards; near a bound one way counts far more
  kZero,    ///< g, but 0 beyond a bound and away from it: both ways count the same up to there
  kNone,
};

/// The exact derivatives of reach error and mass, added to the actor's gradient where the environment has a model:
/// g_k += -reach e / sqrt(e^2 + width^2) de/dx_k - mass dm/dx_k. The root turns the pull off at the goal instead of
/// letting it jump.
///
/// Their sum has valleys in which a length that should rest at its bound makes up for the others' errors. A pull
/// towards what the polish makes of x_k has none: g_k += pull (x* - x_k) / sqrt((x* - x_k)^2 + pull_width^2) per
/// parameter.
struct ModelGradientOptions {
  double reach = 0.0;   ///< weight of the error e; 0: no model gradient
  double mass = 0.0;    ///< weight of the mass
  double width = 2e-3;  ///< [m]; twice the tolerance of the reference task
  bool taken = false;   ///< only in the taken action's parameters: what is proposed for types that are never the best,
                        ///< and may never reach, then does not compete for the network
  double pull = 0.0;    ///< weight of the pull towards the polished parameters; 0: none
  double pull_width = 0.01;  ///< in scaled units, ten times the tolerance there; an L2 norm below, an L1 norm above
  int pull_steps = 5;        ///< of the polish; arbitrary, most proposals need one or two
  double pull_aim = 0.3;     ///< share of the tolerance to which it goes: room for what the network misses it by
  bool pull_mass = true;     ///< on to the lightest parameters that reach, instead of the nearest
  double critic = 1.0;       ///< weight of dQ/dx beside it; 0: the critic only chooses the type

  [[nodiscard]] bool any() const { return reach != 0.0 || mass != 0.0 || pull != 0.0; }
};

/// What makes a critic "TD3" (Fujimoto et al. 2018).
struct Td3Options {
  bool twin = false;            ///< two value networks, the smaller of both in the target (section 4.2)
  int delay = 1;                ///< the actor and the targets learn in every delay-th update (section 5.2); 2 there
  double smoothing = 0.0;       ///< deviation of the noise on mu'(s') (section 5.3); 0.2 there
  double smoothing_clip = 0.5;  ///< largest absolute noise; as there
};

/// Settings of the agents; defaults are those of the report's published text (128 hidden units, batch and replay belong
/// to the training) and, where it is silent, of Bester et al. 2019.
struct AgentOptions {
  double gamma = 0.99;                     ///< discount; the report's code
  std::vector<int> value_hidden{128};      ///< the report, section "agents"
  std::vector<int> actor_hidden{128, 64};  ///< the report
  double leak = 0.0;                       ///< slope of the leaky ReLU; 0: ReLU. PA-DDPG's authors use 0.01
  double value_rate = 1e-3;                ///< learning rate of the value network (Bester et al. 2019)
  double actor_rate = 1e-4;                ///< of the actor
  double value_tau = 0.01;                 ///< soft update of the value target; the report's code
  double actor_tau = 0.001;                ///< of the actor's target
  double clip = 10.0;                      ///< largest gradient norm (Bester et al. 2019)
  double value_output_deviation = -1.0;    ///< see Mlp::Init; PyTorch's default as in the reference
  double actor_output_deviation = 1e-4;    ///< near zero, so that the first parameters are the passthrough's

  ActorWeighting weighting = ActorWeighting::kSum;
  bool indexed = false;                             ///< only the replayed action's term of J
  bool zero_index_gradients = false;                ///< dJ/dx is kept only in the replayed action's slice
  BoundGradients bounds = BoundGradients::kInvert;  ///< Hausknecht and Stone 2016
  double bound = 1.0;           ///< b of `bounds`; above 1 a parameter can rest exactly on its bound, which is 1
  bool clip_parameters = true;  ///< to [-1, 1], before values see and the replay keeps what mu proposes (mu' in targets
                                ///< and mu in J are never clipped); false: the published code, which only acts clipped
  bool average = false;         ///< act by mu', a running mean of mu's weights (Polyak and Juditsky 1992)

  /// Linear passthrough added to mu, frozen unless it has a rate: weights N(mean, deviation^2), bias N(0, deviation^2)
  /// or as given.
  double passthrough_rate = 0.0;              ///< its learning rate; 0: frozen, as published
  double passthrough_bias_deviation = 0.0;    ///< the report's code: 2 (of which 62 % lie outside the bounds)
  double passthrough_weight_mean = 0.0;       ///< the report's text: 1
  double passthrough_weight_deviation = 0.0;  ///< the report's text: 1
  std::vector<double> passthrough_bias{};     ///< [D] in scaled units, instead of a drawn one

  double mixed_target = 0.0;  ///< beta in y = beta G + (1 - beta) y_1: share of the whole return (HFO: 0.2)
  Td3Options td3{};
  ModelGradientOptions model{};
  int bins = 11;  ///< DQN only: values per parameter; 11 are 0.1 m apart in the reference library

  [[nodiscard]] Adam::Options adam() const { return {.clip = clip}; }
};

}  // namespace modsearch
