#include <algorithm>
#include <cmath>
#include <modsearch/problem/posture_choice_internal.hpp>
#include <optional>
#include <utility>

namespace modsearch::detail {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

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

bool is_mesh(const Shape& shape) { return std::holds_alternative<Mesh>(shape); }

bool has_meshes(const Arm& arm, const Scene& scene) {
  const auto any = [](const auto& shapes) {
    return std::any_of(shapes.begin(), shapes.end(), [](const auto& each) { return is_mesh(each.shape); });
  };
  return any(arm.geometries()) || std::any_of(scene.obstacles().begin(), scene.obstacles().end(),
                                              [&](const Obstacle& obstacle) { return any(obstacle.shapes); });
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
    : arm_{arm},
      scene_{scene},
      level_{options.level},
      torques_{torques_matter(task, arm)},
      meshes_{has_meshes(arm, scene)},
      ik_{options.ik} {
  choosy_ = clearance_matters(arm, scene, level_);
  // Postures that place every body alike need not be told apart, unless the joints bear them differently.
  ik_.all = torques_ || (choosy_ && single_turn_shows(arm));
  ik_.shared_turns = ik_.shared_turns && (torques_ || shared_turns_show(arm));
  choosy_ = choosy_ || torques_;
}

void PostureJudge::pose(const Eigen::VectorXd& q, Work& work) {
  arm_.forward(q.data(), posture_);
  ++work.forward;
}

Failure PostureJudge::touched(Work& work) const {
  if (looks_at_obstacles(level_) && scene_.collides(arm_, posture_, work)) return Failure::kObstacle;
  if (looks_at_itself(level_) && self_collides(arm_, posture_, work)) return Failure::kSelfCollision;
  return Failure::kNone;
}

void PostureJudge::measure(Candidate& candidate, double ceiling, double floor, Work& work) const {
  if (looks_at_obstacles(level_)) {
    candidate.obstacle_clearance = scene_.clearance(arm_, posture_, work, ceiling, floor);
  }
  if (candidate.obstacle_clearance <= floor || !looks_at_itself(level_)) return;
  candidate.self_clearance = self_clearance(arm_, posture_, work, candidate.obstacle_clearance, floor);
}

double PostureJudge::share(const StaticLoad& load) const {
  return torques_ ? torque_share(arm_.chain(), static_torques(arm_, posture_, load)) : 0.0;
}

Candidate PostureJudge::judge(const Eigen::VectorXd& q, const StaticLoad& load, Work& work, double ceiling) {
  Candidate result{.q = q};
  if (!choosy_) return result;
  pose(q, work);
  result.torque_share = share(load);
  measure(result, ceiling, -kInfinity, work);
  return result;
}

Candidate PostureJudge::best(const IkSolution& solution, const StaticLoad& load, double ceiling, Work& work) {
  const std::vector<Eigen::VectorXd>& postures = solution.postures;
  if (postures.size() == 1) return judge(postures.front(), load, work, ceiling);
  if (!choosy_) return {.q = postures.front()};
  std::vector<double> shares(postures.size(), 0.0);
  for (std::size_t i = 0; torques_ && i < postures.size(); ++i) {
    pose(postures[i], work);
    shares[i] = share(load);
  }
  const bool held = std::any_of(shares.begin(), shares.end(), [](double each) { return each <= 1.0; });
  std::optional<Candidate> best;
  const auto look_at_all = [&](bool free_ones_only) {
    for (std::size_t i = 0; i < postures.size(); ++i) {
      if (held && shares[i] > 1.0) continue;
      pose(postures[i], work);
      if (free_ones_only && touched(work) != Failure::kNone) continue;
      Candidate other{.q = postures[i], .torque_share = shares[i]};
      measure(other, kInfinity, best ? best->clearance() : -kInfinity, work);
      if (!best || other.clearance() > best->clearance()) best = std::move(other);
    }
  };
  // Where anything is free, how deep the others overlap is of no interest.
  if (meshes_) look_at_all(true);
  if (!best) look_at_all(false);
  return *std::move(best);
}

Candidate PostureJudge::free_one(const IkSolution& solution, Work& work) {
  std::optional<Candidate> first;
  for (const Eigen::VectorXd& q : solution.postures) {
    Candidate other{.q = q};
    if (!choosy_) return other;
    pose(q, work);
    other.touches = touched(work);
    if (other.touches == Failure::kNone) return other;
    if (!first) first = std::move(other);
  }
  return *std::move(first);
}

std::vector<Candidate> PostureJudge::others(const IkSolution& solution, const Eigen::VectorXd& first,
                                            const StaticLoad& load, Work& work) {
  constexpr double kAlike = 0.3;  // in every joint [rad] or [m]: about the same way there (arbitrary)
  const auto alike = [&](const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
    return a.size() == 0 || (a - b).cwiseAbs().maxCoeff() < kAlike;
  };
  std::vector<Candidate> result;
  for (const Eigen::VectorXd& q : solution.postures) {
    const bool known = alike(q, first) || std::any_of(result.begin(), result.end(),
                                                      [&](const Candidate& other) { return alike(q, other.q); });
    if (known) continue;
    pose(q, work);
    if (touched(work) != Failure::kNone) continue;
    Candidate other = judge(q, load, work);
    if (other.holds() && other.collision() == Failure::kNone) result.push_back(std::move(other));
  }
  std::stable_sort(result.begin(), result.end(),
                   [](const Candidate& a, const Candidate& b) { return a.clearance() > b.clearance(); });
  return result;
}

}  // namespace modsearch::detail
