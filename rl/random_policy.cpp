#include <fmt/format.h>

#include <modsearch/rl/design_environment.hpp>
#include <modsearch/rl/only_problem_internal.hpp>
#include <modsearch/rl/random_policy.hpp>
#include <optional>
#include <stdexcept>

namespace modsearch {
namespace {

// The only type to propose; nothing: any.
std::optional<int> only_type(const DesignProblem& problem, const std::string& id) {
  if (id.empty()) return std::nullopt;
  const std::optional<int> k = problem.library().find(id);
  if (!k) throw std::invalid_argument(fmt::format("type '{}': library '{}' has none", id, problem.library().name()));
  return k;
}

// Uniform among the allowed ones, unless only one is wanted and allowed.
int random_type(ActionMask mask, int n_actions, std::optional<int> only, Rng& rng) {
  if (only && (mask >> *only & 1) != 0) return *only;
  std::vector<int> allowed;
  for (int k = 0; k < n_actions; ++k) {
    if ((mask >> k & 1) != 0) allowed.push_back(k);
  }
  return allowed[static_cast<std::size_t>(rng.index(static_cast<int>(allowed.size())))];
}

}  // namespace

RandomPolicy::RandomPolicy(RandomPolicyOptions options) : options_{std::move(options)} {
  if (options_.proposals < 1 || options_.polish < 0) {
    throw std::invalid_argument(fmt::format("random policy: {} proposals with {} steps (at least 1 and 0)",
                                            options_.proposals, options_.polish));
  }
}

SearchEnd RandomPolicy::do_solve(const DesignProblem& problem, Meter& meter, Rng rng) const {
  DesignEnvironment environment{detail::only(problem), {.end_on = EndOn::kAchieved}};
  environment.set_evaluate([&meter](const DesignProblem& p, const Design& design, Fidelity fidelity) {
    return meter.evaluate(p, design, fidelity);
  });
  const std::optional<int> only = only_type(problem, options_.type);
  const ActingOptions acting{.polish = options_.polish, .polishing = options_.polishing};
  const HybridSpace& space = environment.space();
  Work work;
  environment.reset(rng.fork("episode"));
  while (environment.running() && !meter.stopped()) {
    std::optional<HybridAction> best;
    double best_reward = 0.0;
    for (int i = 0; i < options_.proposals; ++i) {
      HybridAction proposal;
      proposal.k = random_type(environment.mask(), space.n_actions(), only, rng);
      proposal.x.resize(space.n_parameters());
      for (float& value : proposal.x) value = static_cast<float>(rng.uniform(-1.0, 1.0));
      proposal = refined(proposal, environment, acting, rng, work);
      if (options_.proposals == 1) {
        best = proposal;
        break;
      }
      const auto x_k = proposal.x.segment(space.offset(proposal.k), space.count(proposal.k));
      const std::optional<double> reward =
          environment.preview(proposal.k, {x_k.data(), static_cast<std::size_t>(x_k.size())});
      if (!reward) break;
      if (best && *reward <= best_reward) continue;
      best = proposal;
      best_reward = *reward;
    }
    if (!best) break;
    static_cast<void>(environment.step(*best));
  }
  meter.count(work);
  return {};
}

}  // namespace modsearch
