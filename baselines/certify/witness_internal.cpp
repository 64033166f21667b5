#include <algorithm>
#include <cmath>
#include <modsearch/baselines/certify/witness_internal.hpp>
#include <numbers>

namespace modsearch::certify {
namespace {

// Joints that turn without end, within half a turn of 0: where the checker has them.
Eigen::MatrixXd wrapped(const Chain& chain, Eigen::MatrixXd postures) {
  for (int j = 0; j < chain.n_joints(); ++j) {
    if (chain.joints()[static_cast<std::size_t>(j)].type != JointType::kContinuous) continue;
    for (double& q : postures.col(j)) q = std::remainder(q, 2.0 * std::numbers::pi);
  }
  return postures;
}

}  // namespace

std::optional<Witness> witness(const RobotProblem& problem, const Design& design, const Eigen::MatrixXd& given) {
  const std::vector<int> types = design.types();
  if (!problem.library().complete(types)) return std::nullopt;
  const std::shared_ptr<const Chain> kept = problem.chain(types);
  const Chain& chain = *kept;
  const Arm arm = chain.at(design.parameters());
  const std::span<const Goal> goals = problem.task().goals();
  if (given.rows() != static_cast<Eigen::Index>(goals.size()) || given.cols() != chain.n_joints()) {
    return std::nullopt;
  }
  const Eigen::MatrixXd postures = wrapped(chain, given);
  for (std::size_t g = 0; g < goals.size(); ++g) {
    const Eigen::VectorXd q = postures.row(static_cast<Eigen::Index>(g));
    if (!q.allFinite() || (q.array() < chain.lower_limits().array()).any() ||
        (q.array() > chain.upper_limits().array()).any()) {
      return std::nullopt;
    }
    const Posture posture = arm.forward(q);
    if (!goals[g].region.contains(posture.tip)) return std::nullopt;
    if (problem.spec().level == Level::kNone) continue;
    Work work;
    constexpr double kApart = 1e-9;  // a plane between them is certain to be found
    if (problem.scene().clearance(arm, posture, work, 1e-3) < kApart) return std::nullopt;
  }
  return Witness{design, postures, arm.mass(), score_of(problem, types, arm.mass())};
}

double score_of(const RobotProblem& problem, std::span<const int> types, double mass) {
  double cost = problem.library().base().cost;
  for (const int k : types) cost += problem.library().type(k).cost;
  return problem.spec()
      .scoring
      ->terms({.modules = static_cast<int>(types.size()) + 1,
               .mass = mass,
               .cost = cost,
               .reached = true,
               .achieved = true})
      .sum();
}

double unit_of_gap(const RobotProblem& problem, const Witness& witness) {
  const double weight = problem.spec().scoring->mass_weight();
  const double unit = weight * witness.mass;
  return unit > 0.0 ? unit : std::max(1.0, std::abs(witness.score));
}

}  // namespace modsearch::certify
