#include <algorithm>
#include <cmath>
#include <modsearch/problem/posture_choice_internal.hpp>

namespace modsearch::detail {
namespace {

// Whether turning the frame of the shape about its z axis leaves the shape where it is.
bool turns_invisibly(const ArmGeometry& geometry) {
  constexpr double kRounding = 1e-12;  // [m]: a body moves by less than that
  const Eigen::Vector3d centre = geometry.X_FG.translation();
  const Eigen::Vector3d axis = geometry.X_FG.linear().col(2);
  if (std::hypot(centre.x(), centre.y()) > kRounding) return false;
  if (std::holds_alternative<Sphere>(geometry.shape)) return true;
  const Shape& shape = geometry.shape;
  if (!std::holds_alternative<Cylinder>(shape) && !std::holds_alternative<Capsule>(shape)) return false;
  return std::hypot(axis.x(), axis.y()) <= kRounding;
}

// Whether bodies move when two neighbouring joints about one line share a turn differently: only those between the two.
bool shared_turns_show(const Arm& arm) {
  constexpr double kNearlyCoaxial = 1e-9;  // wider than what inverse kinematics takes for one line
  const auto coaxial_with_next = [&](int j) {
    const Joint* joint = arm.chain().joints().data() + j;
    if (!joint[0].rotates() || !joint[1].rotates()) return false;
    const Eigen::Isometry3d& X = arm.segment(j + 1);
    return std::hypot(X(0, 2), X(1, 2)) < kNearlyCoaxial && std::hypot(X(0, 3), X(1, 3)) < kNearlyCoaxial;
  };
  return std::any_of(arm.geometries().begin(), arm.geometries().end(), [&](const ArmGeometry& geometry) {
    const int j = geometry.frame - 1;  // the joint that moves it
    return j >= 0 && j + 1 < arm.n_joints() && coaxial_with_next(j) && !turns_invisibly(geometry);
  });
}

// Whether turning the only joint moves anything that can be seen: an arm of links on a turning base does not.
bool single_turn_shows(const Arm& arm) {
  if (arm.n_joints() != 1 || !arm.chain().joints().front().rotates()) return true;
  return !std::all_of(arm.geometries().begin(), arm.geometries().end(),
                      [](const ArmGeometry& geometry) { return geometry.frame == 0 || turns_invisibly(geometry); });
}

// Nothing can collide: one posture is as good as another.
bool clearance_matters(const Arm& arm, const Scene& scene, Level level) {
  return (looks_at_obstacles(level) && scene.any_rests()) ||
         (looks_at_itself(level) && !arm.chain().self_pairs().empty());
}

// Any joint has a peak torque.
bool torques_matter(const Task& task, const Arm& arm) {
  return task.statics().limited && std::any_of(arm.chain().joints().begin(), arm.chain().joints().end(),
                                               [](const Joint& joint) { return std::isfinite(joint.peak_torque); });
}

}  // namespace

bool looks_at_obstacles(Level level) { return level != Level::kNone; }
bool looks_at_itself(Level level) { return level == Level::kPostureSelf || level == Level::kPath; }

PostureJudge::PostureJudge(const Task& task, const Arm& arm, const Scene& scene, const AttemptOptions& options)
    : arm_{arm}, scene_{scene}, level_{options.level}, torques_{torques_matter(task, arm)}, ik_{options.ik} {
  choosy_ = clearance_matters(arm, scene, level_);
  // Postures that place every body alike need not be told apart, unless the joints bear them differently.
  ik_.all = torques_ || (choosy_ && single_turn_shows(arm));
  ik_.shared_turns = ik_.shared_turns && (torques_ || shared_turns_show(arm));
  choosy_ = choosy_ || torques_;
}

Candidate PostureJudge::judge(const Eigen::VectorXd& q, const StaticLoad& load, Work& work) {
  Candidate result{.q = q};
  if (!looks_at_obstacles(level_) && !torques_) return result;
  arm_.forward(q.data(), posture_);
  ++work.forward;
  if (torques_) result.torque_share = torque_share(arm_.chain(), static_torques(arm_, posture_, load));
  if (looks_at_obstacles(level_)) result.obstacle_clearance = scene_.clearance(arm_, posture_, work);
  if (looks_at_itself(level_)) result.self_clearance = self_clearance(arm_, posture_, work);
  return result;
}

Candidate PostureJudge::best(const IkSolution& solution, const StaticLoad& load, Work& work) {
  if (!choosy_) return {.q = solution.postures.front()};
  Candidate best = judge(solution.postures.front(), load, work);
  for (std::size_t i = 1; i < solution.postures.size(); ++i) {
    Candidate other = judge(solution.postures[i], load, work);
    if (other.better_than(best)) best = std::move(other);
  }
  return best;
}

}  // namespace modsearch::detail
