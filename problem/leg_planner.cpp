#include <modsearch/kinematics/space_time.hpp>
#include <modsearch/problem/leg_planner_internal.hpp>

namespace modsearch::detail {

LegPlanner::LegPlanner(const Arm& arm, const Scene& scene, const AttemptOptions& options)
    : arm_{arm}, scene_{scene}, options_{options.planner} {}

Plan LegPlanner::plan(const Eigen::VectorXd& from, double start, const Eigen::VectorXd& to, double hold, Work& work) {
  if (scene_.any_moves()) {
    Plan plan = plan_in_time(arm_, scene_, from, start, to, hold, {.plan = options_});
    work += plan.work;
    if (plan.status == PlanStatus::kNotFound) ++failures_;
    return plan;
  }
  std::vector<double> key(from.begin(), from.end());
  key.insert(key.end(), to.begin(), to.end());
  const auto [entry, unknown] = known_.try_emplace(std::move(key));
  if (unknown) {
    entry->second = plan_path(arm_, scene_, from, to, options_);
    work += entry->second.work;
    if (entry->second.status == PlanStatus::kNotFound) ++failures_;
  }
  return entry->second;
}

}  // namespace modsearch::detail
