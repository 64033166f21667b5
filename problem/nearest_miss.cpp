#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <modsearch/kinematics/statics.hpp>
#include <modsearch/problem/nearest_miss.hpp>
#include <modsearch/problem/posture_choice_internal.hpp>
#include <numbers>

namespace modsearch {
namespace {

using Kind = TaskStep::Kind;

std::string length_text(double metres) {
  return metres < 1.0 ? fmt::format("{:.3g} mm", 1000.0 * metres) : fmt::format("{:.3g} m", metres);
}

bool is_length(Projection projection) {
  switch (projection) {
    case Projection::kX:
    case Projection::kY:
    case Projection::kZ:
    case Projection::kRCyl:
    case Projection::kRSph:
      return true;
    case Projection::kPhiCyl:
    case Projection::kTheta:
    case Projection::kPhiSph:
    case Projection::kNx:
    case Projection::kNy:
    case Projection::kNz:
    case Projection::kThetaR:
      return false;
  }
  return false;
}

// A joint that does not turn all round and stands at one of its ends; -1: none.
int joint_at_its_end(const Chain& chain, const Eigen::VectorXd& q) {
  constexpr double kAtTheEnd = 1e-9;  // [rad] or [m]
  for (int j = 0; j < chain.n_joints(); ++j) {
    const Joint& joint = chain.joints()[static_cast<std::size_t>(j)];
    if (!joint.full_circle() && (q[j] <= joint.lower + kAtTheEnd || q[j] >= joint.upper - kAtTheEnd)) return j;
  }
  return -1;
}

// A posture that the arm assumes, with what is asked of it there.
struct Stance {
  std::string place;
  int goal = -1;
  const PoseRegion* region = nullptr;  // null: no pose is asked for
  Eigen::VectorXd q;
};

// Looks at the postures of one attempt.
class Inspection {
 public:
  Inspection(const RobotProblem& problem, const Design& design, const Attempt& attempt)
      : problem_{problem},
        design_{design},
        attempt_{attempt},
        chain_{problem.chain(design.types())},
        arm_{chain_->at(design.parameters())} {}

  // The postures are as many as the goals, and each has as many joints as the arm.
  [[nodiscard]] bool has_postures() const {
    const auto n_trajectories =
        static_cast<std::size_t>(std::count_if(problem_.task().steps().begin(), problem_.task().steps().end(),
                                               [](const TaskStep& step) { return step.kind == Kind::kFollow; }));
    return attempt_.postures.rows() == static_cast<Eigen::Index>(problem_.task().goals().size()) &&
           attempt_.postures.cols() == arm_.n_joints() && attempt_.trajectories.size() == n_trajectories;
  }

  [[nodiscard]] std::vector<Miss> at_goals() const {
    std::vector<Miss> misses;
    std::size_t trajectory = 0;
    for (const TaskStep& step : steps_of(problem_.task())) {
      std::optional<Miss> miss;
      if (step.kind == Kind::kVisit) miss = visited(step);
      if (step.kind == Kind::kFollow) miss = followed(step, attempt_.trajectories[trajectory++]);
      if (miss) misses.push_back(*std::move(miss));
    }
    return misses;
  }

  [[nodiscard]] Miss at_home() const {
    const Stance home{.place = "home", .q = home_posture(problem_.task(), arm_, problem_.scene())};
    Miss miss = overlap(home).value_or(Miss{.place = home.place, .words = "home: the arm is in collision there"});
    miss.why = Failure::kHomeInCollision;
    return miss;
  }

  [[nodiscard]] Miss on_the_way() const {
    Miss miss{.why = Failure::kNoPath, .words = "no collision-free path was found"};
    if (!attempt_.missing_motion) return miss;
    const auto [from, to] = *attempt_.missing_motion;
    const std::span<const Goal> goals = problem_.task().goals();
    const auto place = [&](int goal) {
      return goal < 0 ? std::string{"home"} : "goal " + goals[static_cast<std::size_t>(goal)].id;
    };
    // Beside home, a pose within a trajectory has no goal to name.
    const auto& steps = problem_.task().steps();
    const bool follows =
        std::any_of(steps.begin(), steps.end(), [](const TaskStep& step) { return step.kind == Kind::kFollow; });
    if (from == to || (follows && (from < 0 || to < 0))) return miss;
    miss.from = place(from);
    miss.to = place(to);
    miss.words = fmt::format("no collision-free path was found from {} to {}", miss.from, miss.to);
    return miss;
  }

 private:
  [[nodiscard]] std::optional<Miss> visited(const TaskStep& step) const {
    const Goal& goal = problem_.task().goals()[static_cast<std::size_t>(step.goal)];
    return look_at({"goal " + goal.id, step.goal, &goal.region, attempt_.postures.row(step.goal).transpose()});
  }

  // The first pose that the arm does not get to, else the one that it stands worst at.
  [[nodiscard]] std::optional<Miss> followed(const TaskStep& step, const Eigen::MatrixXd& postures) const {
    const std::vector<PoseRegion>& poses = step.trajectory->poses;
    std::optional<Miss> worst;
    for (std::size_t k = 0; k < poses.size() && static_cast<Eigen::Index>(k) < postures.rows(); ++k) {
      const auto knot = std::lower_bound(step.knots.begin(), step.knots.end(), static_cast<int>(k));
      const auto behind = std::min<std::ptrdiff_t>(knot - step.knots.begin(), step.n_goals - 1);
      std::optional<Miss> miss =
          look_at({fmt::format("pose {} of trajectory {}", k, step.id), step.goal + static_cast<int>(behind), &poses[k],
                   postures.row(static_cast<Eigen::Index>(k)).transpose()});
      if (!miss) continue;
      const bool pose = miss->why != Failure::kTorque && !miss->touch;
      if (pose && attempt_.why == Failure::kJump) {
        miss->why = Failure::kJump;
        miss->words += ", unless the arm jumps to another branch of postures";
      }
      if (pose && attempt_.why == Failure::kLimit && !step.trajectory->times.empty()) {
        miss->why = Failure::kLimit;
        miss->words += ", unless a joint is faster than it may be";
      }
      const bool worse = !worst || miss->torque_share > worst->torque_share ||
                         (miss->touch && worst->touch && miss->touch->depth > worst->touch->depth);
      if (pose || worse) worst = std::move(miss);
      if (pose) break;
    }
    return worst;
  }

  // The first thing that is amiss at one posture, in the order in which an attempt asks.
  [[nodiscard]] std::optional<Miss> look_at(const Stance& stance) const {
    if (std::optional<Miss> miss = missed_pose(stance)) return miss;
    if (std::optional<Miss> miss = too_weak(stance)) return miss;
    return overlap(stance);
  }

  [[nodiscard]] std::optional<Miss> missed_pose(const Stance& stance) const {
    const Eigen::Isometry3d X_WE = arm_.forward(stance.q).tip;
    const Eigen::VectorXd violations = stance.region->violations(X_WE);
    double lengths = 0.0;
    double angles = 0.0;
    for (Eigen::Index i = 0; i < violations.size(); ++i) {
      if (std::abs(violations[i]) <= PoseRegion::kSlack) continue;
      double& sum = is_length(stance.region->tolerances()[static_cast<std::size_t>(i)].projection) ? lengths : angles;
      sum += violations[i] * violations[i];
    }
    if (lengths == 0.0 && angles == 0.0) return std::nullopt;
    Miss miss{.place = stance.place,
              .goal = stance.goal,
              .distance = std::sqrt(lengths),
              .angle = std::sqrt(angles),
              .away = (X_WE.translation() - stance.region->nominal().translation()).norm()};
    std::vector<std::string> parts;
    if (lengths > 0.0) parts.push_back(length_text(miss.distance));
    if (angles > 0.0) parts.push_back(fmt::format("{:.3g} degrees", miss.angle * 180.0 / std::numbers::pi));
    miss.words = fmt::format("{}: {} outside its tolerance", stance.place, fmt::join(parts, " and "));
    const double from_base = (stance.region->nominal().translation() - arm_.segment(0).translation()).norm();
    constexpr double kRounding = 1e-9;  // [m]
    if (from_base - position_slack(*stance.region) > arm_.reach() + kRounding) {
      miss.why = Failure::kProvedInfeasible;
      miss.words += ": the arm is too short for it, whatever its joints do";
    } else if (const int j = joint_at_its_end(*chain_, stance.q); j >= 0) {
      miss.why = Failure::kLimit;
      miss.joint = chain_->joints()[static_cast<std::size_t>(j)].name;
      miss.words += fmt::format(", with joint {} at its limit", miss.joint);
    }
    return miss;
  }

  [[nodiscard]] std::optional<Miss> too_weak(const Stance& stance) const {
    if (!problem_.task().statics().limited) return std::nullopt;
    const Eigen::VectorXd torques = static_torques(arm_, arm_.forward(stance.q), load_at(problem_.task(), stance.goal));
    Miss miss{.why = Failure::kTorque, .place = stance.place, .goal = stance.goal};
    for (int j = 0; j < chain_->n_joints(); ++j) {
      const Joint& joint = chain_->joints()[static_cast<std::size_t>(j)];
      const double share = std::abs(torques[j]) / joint.peak_torque;
      if (share <= std::max(1.0, miss.torque_share)) continue;
      miss.torque_share = share;
      miss.joint = joint.name;
    }
    if (miss.torque_share == 0.0) return std::nullopt;
    miss.words = fmt::format("{}: joint {} would have to hold {:.3g} % of its peak torque", stance.place, miss.joint,
                             100.0 * miss.torque_share);
    return miss;
  }

  [[nodiscard]] std::optional<Miss> overlap(const Stance& stance) const {
    const Level level = problem_.spec().level;
    const Posture posture = arm_.forward(stance.q);
    Work work;
    const auto deepest = [](const std::vector<Contact>& contacts) {
      return *std::min_element(contacts.begin(), contacts.end(), [](const Contact& a, const Contact& b) {
        return a.separation.distance < b.separation.distance;
      });
    };
    if (detail::looks_at_obstacles(level)) {
      const std::vector<Contact> contacts = problem_.scene().contacts(arm_, posture, 0.0, work);
      if (!contacts.empty()) return told(stance, deepest(contacts), true);
    }
    if (detail::looks_at_itself(level)) {
      const std::vector<Contact> contacts = self_contacts(arm_, posture, 0.0, work);
      if (!contacts.empty()) return told(stance, deepest(contacts), false);
    }
    return std::nullopt;
  }

  [[nodiscard]] Miss told(const Stance& stance, const Contact& contact, bool with_obstacle) const {
    const auto body_of = [&](int geometry) { return arm_.geometries()[static_cast<std::size_t>(geometry)].body; };
    Touch touch{.body = body_of(contact.geometry),
                .obstacle = with_obstacle,
                .other = with_obstacle ? contact.other : body_of(contact.other),
                .depth = -contact.separation.distance,
                .p_WA = contact.separation.p_WA,
                .p_WB = contact.separation.p_WB};
    Miss miss{.why = with_obstacle ? Failure::kObstacle : Failure::kSelfCollision,
              .place = stance.place,
              .goal = stance.goal,
              .touch = touch};
    miss.words = with_obstacle ? fmt::format("{}: {} is {} deep in obstacle {}", stance.place, name_of_body(touch.body),
                                             length_text(touch.depth),
                                             problem_.scene().obstacles()[static_cast<std::size_t>(touch.other)].name)
                               : fmt::format("{}: {} and {} overlap by {}", stance.place, name_of_body(touch.body),
                                             name_of_body(touch.other), length_text(touch.depth));
    return miss;
  }

  [[nodiscard]] std::string name_of_body(int body) const {
    const int module = chain_->bodies()[static_cast<std::size_t>(body)].module;
    if (module < 0) return "the base";
    const int type = design_.modules[static_cast<std::size_t>(module)].type;
    return fmt::format("{} (module {})", problem_.library().type(type).id, module + 1);
  }

  const RobotProblem& problem_;
  const Design& design_;
  const Attempt& attempt_;
  std::shared_ptr<const Chain> chain_;
  Arm arm_;
};

}  // namespace

std::string NearestMiss::words() const {
  std::vector<std::string> all;
  for (const Miss& miss : misses) all.push_back(miss.words);
  return fmt::format("{}", fmt::join(all, "; "));
}

NearestMiss nearest_miss(const RobotProblem& problem, const Design& design, const Evaluation& evaluation) {
  check(problem.library(), design);
  const Attempt& attempt = evaluation.attempt;
  NearestMiss result;
  if (attempt.achieved) return result;
  const Inspection inspection{problem, design, attempt};
  if (inspection.has_postures()) result.misses = inspection.at_goals();
  if (attempt.why == Failure::kIncomplete) {
    result.misses.insert(result.misses.begin(),
                         {.why = attempt.why, .words = "the design ends without an end effector"});
  }
  if (attempt.why == Failure::kHomeInCollision) result.misses.push_back(inspection.at_home());
  if (attempt.why == Failure::kNoPath) result.misses.push_back(inspection.on_the_way());
  if (result.misses.empty()) result.misses.push_back({.why = attempt.why, .words = std::string{name(attempt.why)}});
  return result;
}

}  // namespace modsearch
