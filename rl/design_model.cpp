#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <modsearch/rl/design_model.hpp>
#include <modsearch/rl/observation_encoder.hpp>
#include <stdexcept>

namespace modsearch {
namespace {

// An arm whose lengths change from look to look: building one costs more than moving it. It keeps its chain alive, so
// that no other chain can have its address.
struct Workbench {
  std::shared_ptr<const Chain> chain;
  std::optional<Arm> arm;
  Posture posture;
  Eigen::VectorXd x;
};

// The workbench for `chain`, one of the last few that this thread has used.
Workbench& workbench(const std::shared_ptr<const Chain>& chain) {
  constexpr std::size_t kKept = 8;  // a handful of types on one prefix; arbitrary
  thread_local std::array<Workbench, kKept> benches;
  thread_local std::size_t next = 0;
  for (Workbench& bench : benches) {
    if (bench.chain == chain) return bench;
  }
  Workbench& bench = benches[next];
  next = (next + 1) % kKept;
  bench.arm.reset();
  bench.chain = chain;
  bench.x = Eigen::VectorXd::Zero(chain->n_parameters());
  return bench;
}

}  // namespace

std::optional<std::vector<DesignModel::Target>> DesignModel::targets_of(const RobotProblem& problem) {
  std::vector<Target> targets;
  for (const Goal& goal : problem.task().goals()) {
    if (!goal.region.is_ball()) return std::nullopt;
    targets.push_back({goal.position(), goal.region.tolerances().front().upper});
  }
  return targets;
}

std::shared_ptr<const DesignModel> DesignModel::of(std::shared_ptr<const RobotProblem> problem, const Design& prefix,
                                                   int max_joints) {
  std::optional<std::vector<Target>> targets = targets_of(*problem);
  if (!targets) return nullptr;
  return std::make_shared<const DesignModel>(std::move(problem), *std::move(targets), prefix, max_joints);
}

DesignModel::DesignModel(std::shared_ptr<const RobotProblem> family, std::vector<Target> targets, Design prefix,
                         int max_joints)
    : family_{std::move(family)}, targets_{std::move(targets)}, prefix_{std::move(prefix)}, max_joints_{max_joints} {
  if (!family_ || targets_.empty()) throw std::invalid_argument("DesignModel: needs a problem and at least one target");
}

std::optional<ActionModel::Look> DesignModel::look(int k, std::span<const float> x_k, Work& work) const {
  const std::vector<ParameterRange>& ranges = family_->library().type(k).parameters;
  if (x_k.size() != ranges.size()) {
    throw std::invalid_argument(fmt::format("DesignModel: {} parameters given, type '{}' has {}", x_k.size(),
                                            family_->library().type(k).id, ranges.size()));
  }
  thread_local std::vector<int> types;  // keeps its memory between calls
  types.clear();
  for (const Placement& placement : prefix_.modules) types.push_back(placement.type);
  types.push_back(k);
  if (!family_->library().fits_together(types)) return std::nullopt;
  const std::shared_ptr<const Chain> kept = family_->chain(types);
  const Chain& chain = *kept;
  if (chain.n_joints() > max_joints_) return std::nullopt;

  Workbench& bench = workbench(kept);
  Eigen::Index at = 0;
  for (const Placement& placement : prefix_.modules) {
    bench.x.segment(at, placement.parameters.size()) = placement.parameters;
    at += placement.parameters.size();
  }
  const Eigen::Index first = at;
  for (std::size_t p = 0; p < ranges.size(); ++p) {
    bench.x[at++] = from_unit(ranges[p], std::clamp(x_k[p], -1.0F, 1.0F));
  }
  if (bench.arm) {
    bench.arm->set_parameters(bench.x);
  } else {
    bench.arm.emplace(chain, bench.x);
  }

  Look look;
  const Target* missed = nullptr;
  Eigen::VectorXd q;
  IkOptions options = family_->spec().ik;
  options.all = false;
  for (const Target& target : targets_) {
    const IkSolution solution = inverse_kinematics(*bench.arm, PoseRegion::ball(target.p_W, target.tolerance), options);
    work.ik_iterations += solution.iterations;
    work.forward += solution.forward + 1;
    if (missed != nullptr && solution.position_error - target.tolerance <= look.error - look.tolerance) continue;
    missed = &target;
    look.error = solution.position_error;
    look.tolerance = target.tolerance;
    q = solution.postures.front();
  }

  const auto n = static_cast<Eigen::Index>(ranges.size());
  look.error_slope = Eigen::VectorXd::Zero(n);
  look.mass_slope = Eigen::VectorXd::Zero(n);
  look.mass = chain.mass(bench.x);
  const auto unit = [&](int parameter) {  // of a parameter of module k: length that one scaled unit stands for
    const ParameterRange& range = ranges[static_cast<std::size_t>(parameter - first)];
    return 0.5 * (range.upper - range.lower);
  };
  for (const AffineScalar::Term& term : chain.mass().terms) {
    if (term.parameter >= first) look.mass_slope[term.parameter - first] += term.scale * unit(term.parameter);
  }
  if (look.error == 0.0) return look;  // the tip is on the target: no direction is worse than another
  bench.arm->forward(q.data(), bench.posture);
  const Eigen::Vector3d away = (bench.posture.tip.translation() - missed->p_W) / look.error;
  for (int j = 0; j <= chain.n_joints(); ++j) {
    const Eigen::Isometry3d& X_WF = bench.posture.frames[static_cast<std::size_t>(j)];
    chain.segment(j).for_each_move(bench.x, [&](const ParameterMove& move) {
      if (move.parameter < first) return;
      const Eigen::Vector3d velocity = move.velocity(X_WF, bench.posture.tip.translation());
      look.error_slope[move.parameter - first] += away.dot(velocity) * unit(move.parameter);
    });
  }
  return look;
}

// [targets: x, y, z, tolerance ..] and [modules: type, parameters ..], each with its length before it.
std::vector<double> DesignModel::key() const {
  std::vector<double> key{static_cast<double>(targets_.size())};
  for (const Target& target : targets_) {
    key.insert(key.end(), target.p_W.begin(), target.p_W.end());
    key.push_back(target.tolerance);
  }
  key.push_back(static_cast<double>(prefix_.modules.size()));
  for (const Placement& placement : prefix_.modules) {
    key.push_back(placement.type);
    key.insert(key.end(), placement.parameters.begin(), placement.parameters.end());
  }
  return key;
}

std::shared_ptr<const DesignModel> DesignModel::restore(std::shared_ptr<const RobotProblem> family,
                                                        std::span<const double> key, int max_joints) {
  std::size_t at = 0;
  const auto refuse = [&](const char* what) {
    throw std::invalid_argument(
        fmt::format("DesignModel: number {} of {} of a model's key is {}", at, key.size(), what));
  };
  const auto next = [&] {
    if (at >= key.size()) refuse("missing");
    if (!std::isfinite(key[at])) refuse("not finite");
    return key[at++];
  };
  const auto next_index = [&](int least, int limit) {
    const double number = next();
    if (number != std::floor(number) || number < least || number >= limit) {
      --at;
      refuse("out of range");
    }
    return static_cast<int>(number);
  };

  constexpr int kMostTargets = 1'000'000;  // only keeps nonsense out
  std::vector<Target> targets(static_cast<std::size_t>(next_index(1, kMostTargets)));
  if (4 * targets.size() > key.size()) refuse("missing");
  for (Target& target : targets) {
    for (double& coordinate : target.p_W) coordinate = next();
    target.tolerance = next();
  }
  Design prefix;
  const int n_modules = next_index(0, family->max_modules());
  for (int i = 0; i < n_modules; ++i) {
    Placement placement{next_index(0, family->library().n_types()), {}};
    placement.parameters.resize(family->library().type(placement.type).n_parameters());
    for (double& parameter : placement.parameters) parameter = next();
    prefix.modules.push_back(std::move(placement));
  }
  if (at != key.size()) refuse("one too many");
  check(family->library(), prefix);
  return std::make_shared<const DesignModel>(std::move(family), std::move(targets), std::move(prefix), max_joints);
}

}  // namespace modsearch
