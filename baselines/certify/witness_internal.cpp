#include <algorithm>
#include <cmath>
#include <modsearch/baselines/certify/witness_internal.hpp>

namespace modsearch::certify {

std::optional<Witness> witness(const RobotProblem& problem, const Design& design, const Eigen::MatrixXd& postures) {
  const std::vector<int> types = design.types();
  if (!problem.library().complete(types)) return std::nullopt;
  const std::shared_ptr<const Chain> kept = problem.chain(types);
  const Chain& chain = *kept;
  const Arm arm = chain.at(design.parameters());
  const std::span<const Goal> goals = problem.task().goals();
  if (postures.rows() != static_cast<Eigen::Index>(goals.size()) || postures.cols() != chain.n_joints()) {
    return std::nullopt;
  }
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
  return weight > 0.0 ? weight * witness.mass : std::max(1.0, std::abs(witness.score));
}

}  // namespace modsearch::certify
