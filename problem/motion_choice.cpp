#include <algorithm>
#include <modsearch/problem/motion_choice_internal.hpp>
#include <modsearch/problem/motion_internal.hpp>
#include <numeric>
#include <set>
#include <utility>
#include <vector>

namespace modsearch::detail {
namespace {

constexpr int kMostFailures = 8;       // planner runs in vain after the first
constexpr int kShare = 8;              // part of the planner's iterations that each of them gets
constexpr int kMostCombinations = 64;  // of postures: most differ from earlier ones in legs that are known

// The number of the posture of each goal [n_goals], and how far down the lists it is altogether.
using Choices = std::pair<int, std::vector<int>>;

Choices choices(std::vector<int> numbers) {
  const int sum = std::accumulate(numbers.begin(), numbers.end(), 0);
  return {sum, std::move(numbers)};
}

}  // namespace

Failure plan_motion(const Task& task, const Arm& arm, const Scene& scene, const AttemptOptions& options, Trial& trial) {
  const Eigen::VectorXd home = home_posture(task, arm, scene);
  LegPlanner legs{arm, scene, options};
  const auto n_goals = task.goals().size();
  std::set<Choices> open{choices(std::vector<int>(n_goals, 0))};  // cheapest first
  std::set<std::vector<int>> met{open.begin()->second};
  for (int i = 0; i < kMostCombinations && legs.failures() <= kMostFailures && !open.empty(); ++i) {
    const std::vector<int> numbers = open.extract(open.begin()).value().second;
    for (std::size_t goal = 0; goal < n_goals; ++goal) trial.choose(static_cast<int>(goal), numbers[goal]);
    const MotionEnd end = plan_motion(task, arm, scene, options, home, legs, trial.attempt());
    if (end.why == Failure::kNone) {
      trial.attempt().missing_motion.reset();
      return Failure::kNone;
    }
    if (end.why != Failure::kNoPath) return end.why;
    if (i == 0) trial.attempt().missing_motion = {end.from, end.to};
    legs.limit(options.planner.max_iterations / kShare);
    for (const int goal : {end.to, end.from}) {
      if (goal < 0 || numbers[static_cast<std::size_t>(goal)] + 1 >= trial.n_choices(goal)) continue;
      std::vector<int> other = numbers;
      ++other[static_cast<std::size_t>(goal)];
      if (met.insert(other).second) open.insert(choices(std::move(other)));
    }
  }
  for (std::size_t goal = 0; goal < n_goals; ++goal) trial.choose(static_cast<int>(goal), 0);
  return Failure::kNoPath;
}

}  // namespace modsearch::detail
