#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <modsearch/problem/geometry_internal.hpp>
#include <modsearch/problem/readers_internal.hpp>

namespace modsearch {
namespace detail {
namespace {

/// R_TN of one tolerance frame: "nominal", "world", or a pose given in the world, of which only the rotation matters.
Eigen::Matrix3d read_tolerance_frame(const JsonCursor& cursor, const Eigen::Isometry3d& X_WN) {
  if (cursor.value().is_array()) return cursor.pose().linear().transpose() * X_WN.linear();
  const bool nominal = cursor.choice({"nominal", "world"}) == 0;
  if (nominal) return Eigen::Matrix3d::Identity();
  return X_WN.linear();
}

/// The frames of `n` tolerances: one for all, or a list beside them.
std::vector<Eigen::Matrix3d> read_tolerance_frames(const JsonCursor& pose, const Eigen::Isometry3d& X_WN,
                                                   std::size_t n) {
  const std::optional<JsonCursor> cursor = pose.find("toleranceFrame");
  if (!cursor) return std::vector<Eigen::Matrix3d>(n, Eigen::Matrix3d::Identity());
  const Json& value = cursor->value();
  const bool is_matrix =
      value.is_array() && !value.empty() && value[0].is_array() && !value[0].empty() && value[0][0].is_number();
  if (!value.is_array() || is_matrix) return std::vector<Eigen::Matrix3d>(n, read_tolerance_frame(*cursor, X_WN));
  std::vector<Eigen::Matrix3d> frames;
  if (value.size() != n) cursor->fail(fmt::format("has {} frames for {} projections", value.size(), n));
  for (const JsonCursor& entry : cursor->items()) frames.push_back(read_tolerance_frame(entry, X_WN));
  return frames;
}

constexpr std::array kProjections = {Projection::kX,    Projection::kY,      Projection::kZ,     Projection::kRSph,
                                     Projection::kRCyl, Projection::kPhiCyl, Projection::kTheta, Projection::kPhiSph,
                                     Projection::kNx,   Projection::kNy,     Projection::kNz,    Projection::kThetaR};

PoseRegion read_region(const JsonCursor& cursor) {
  cursor.expect_keys({"nominal", "nominalParent", "toleranceProjection", "tolerance", "toleranceFrame"});
  const Eigen::Isometry3d X_WN = cursor.at("nominal").pose();
  if (const std::optional<JsonCursor> parent = cursor.find("nominalParent")) {
    if (parent->value() != Json("world")) parent->fail_value("\"world\", the only nominalParent that is supported yet");
  }
  if (!cursor.has("toleranceProjection") && !cursor.has("tolerance")) {
    if (const std::optional<JsonCursor> frame = cursor.find("toleranceFrame")) {
      frame->fail("a toleranceFrame needs toleranceProjection and tolerance");
    }
    return PoseRegion::with_default_tolerances(X_WN);
  }
  const std::vector<JsonCursor> projections = cursor.at("toleranceProjection").items();
  const JsonCursor intervals_list = cursor.at("tolerance");
  const std::vector<JsonCursor> intervals = intervals_list.items();
  if (intervals.size() != projections.size()) {
    intervals_list.fail(fmt::format("has {} intervals for {} projections", intervals.size(), projections.size()));
  }
  const std::vector<Eigen::Matrix3d> frames = read_tolerance_frames(cursor, X_WN, projections.size());
  std::vector<Tolerance> tolerances;
  for (std::size_t i = 0; i < projections.size(); ++i) {
    const std::size_t which = projections[i].choice(
        {"x", "y", "z", "r_sph", "r_cyl", "phi_cyl", "theta", "phi_sph", "N_x", "N_y", "N_z", "Theta_R"});
    const std::vector<JsonCursor> ends = intervals[i].items(2);
    Tolerance tolerance{kProjections[which], ends[0].number(), ends[1].number(), frames[i]};
    if (tolerance.lower > tolerance.upper)
      ends[1].fail_value(fmt::format("at least {}, the lower end", tolerance.lower));
    tolerances.push_back(tolerance);
  }
  return cursor.guard([&] { return PoseRegion{X_WN, std::move(tolerances)}; });
}

/// Times and the poses that move the whole obstacle; when they make no motion, Scene says so.
Keyframes read_motion(const JsonCursor& cursor) {
  cursor.expect_keys({"t", "pose"});
  Keyframes motion;
  for (const JsonCursor& time : cursor.at("t").items()) motion.times.push_back(time.number());
  for (const JsonCursor& pose : cursor.at("pose").items()) motion.X_WO.push_back(pose.pose());
  if (motion.times.empty()) cursor.at("t").fail("has 0 entries (limit: at least 1)");
  return motion;
}

Obstacle read_obstacle(const JsonCursor& cursor) {
  cursor.expect_keys({"ID", "name", "collision", "pose", "motion"});
  Obstacle obstacle;
  obstacle.name = cursor.text_or("name", cursor.at("ID").text());
  if (const std::optional<JsonCursor> motion = cursor.find("motion")) obstacle.motion = read_motion(*motion);
  if (const std::optional<JsonCursor> pose = cursor.find("pose")) {
    // Older files repeat the pose of the geometries here: checked, and not applied again.
    if (pose->value().is_object()) pose->expect_keys({"nominal"});
    static_cast<void>(pose->value().is_object() ? pose->at("nominal").pose() : pose->pose());
  }
  for (const JsonCursor& entry : cursor.at("collision").items_or_single()) {
    const BodyGeometry geometry = read_geometry(entry, {});
    const Eigen::VectorXd no_parameters(0);
    obstacle.shapes.push_back({geometry.shape.at(no_parameters), geometry.X_FG.at(no_parameters)});
  }
  return obstacle;
}

/// A base within tolerances: intervals of x, y and z, all in one frame, and of the turn about its own z axis (N_z or
/// Theta_R). What is not listed stays at its nominal value.
BasePlacement read_base(const JsonCursor& cursor) {
  const PoseRegion region = read_region(cursor);
  const std::vector<JsonCursor> projections = cursor.at("toleranceProjection").items();
  BasePlacement base;
  base.X_WN = region.nominal();
  bool has_frame = false;
  for (std::size_t i = 0; i < projections.size(); ++i) {
    const Tolerance& tolerance = region.tolerances()[i];
    const BasePlacement::Interval interval{tolerance.lower, tolerance.upper};
    const JsonCursor place = cursor.at("tolerance").items()[i];
    if (!std::isfinite(interval.lower) || !std::isfinite(interval.upper)) place.fail_value("two finite ends");
    const bool slides = tolerance.projection <= Projection::kZ;
    if (slides && has_frame && tolerance.R_TN != base.R_TN) {
      projections[i].fail("a base that is placed along axes of two frames is not supported yet");
    }
    if (slides) {
      base.R_TN = tolerance.R_TN;
      has_frame = true;
    }
    switch (tolerance.projection) {
      case Projection::kX:
        base.x = interval;
        break;
      case Projection::kY:
        base.y = interval;
        break;
      case Projection::kZ:
        base.z = interval;
        break;
      case Projection::kNz:
        base.yaw = interval;
        break;
      case Projection::kThetaR:
        if (interval.lower > 0.0 || interval.upper < 0.0) place.fail_value("an interval that holds 0");
        base.yaw = {-interval.upper, interval.upper};
        break;
      case Projection::kNx:
      case Projection::kNy:
        if (interval.lower > 0.0 || interval.upper < 0.0) place.fail_value("an interval that holds 0");
        break;
      case Projection::kRCyl:
      case Projection::kPhiCyl:
      case Projection::kRSph:
      case Projection::kTheta:
      case Projection::kPhiSph:
        projections[i].fail_value("one of \"x\", \"y\", \"z\", \"N_x\", \"N_y\", \"N_z\", \"Theta_R\" for a base");
    }
  }
  return base;
}

/// What the constraints of a task say, as far as it is not the problem's `collision` and `library` that decide.
struct Constraints {
  std::optional<Eigen::Isometry3d> X_WB;
  std::optional<BasePlacement> base;
  bool torques = false;  // "tau" is among the joints' parts
  bool all_in_any_order = false;
  std::vector<std::string> order;  // goal IDs
  std::optional<JsonCursor> order_place;
};

void read_constraint(const JsonCursor& cursor, Constraints& constraints) {
  switch (cursor.at("type").choice({"joint", "selfCollisionFree", "collisionFree", "allGoalsFulfilled", "validAssembly",
                                    "allGoalsFulfilledInOrder", "basePlacement", "endEffector"})) {
    case 0:
      cursor.expect_keys({"type", "parts"});
      for (const JsonCursor& part : cursor.at("parts").items()) {
        if (part.choice({"q", "dq", "ddq", "tau"}) == 3) constraints.torques = true;
      }
      return;
    case 3:
      constraints.all_in_any_order = true;
      [[fallthrough]];
    case 1:
    case 2:
    case 4:
      cursor.expect_keys({"type"});
      return;
    case 5:
      cursor.expect_keys({"type", "order"});
      if (constraints.order_place) cursor.fail("the order of the goals is given twice (limit 1)");
      constraints.order_place = cursor.at("order");
      for (const JsonCursor& id : constraints.order_place->items()) constraints.order.push_back(id.text());
      return;
    case 6: {
      cursor.expect_keys({"type", "pose"});
      if (constraints.X_WB) cursor.fail("the base is placed twice (limit 1)");
      const JsonCursor pose = cursor.at("pose");
      if (pose.value().is_array()) {
        constraints.X_WB = pose.pose();
        return;
      }
      constraints.X_WB = pose.at("nominal").pose();
      if (pose.has("toleranceProjection") || pose.has("tolerance")) {
        constraints.base = read_base(pose);
      } else {
        pose.expect_keys({"nominal"});
      }
      return;
    }
    default:
      cursor.at("type").fail("constraints of type \"endEffector\" are not supported yet");
  }
}

/// A goal's own constraints: those that hold for the whole task anyway.
void read_goal_constraints(const JsonCursor& list) {
  for (const JsonCursor& entry : list.items_or_single()) {
    switch (entry.at("type").choice({"joint", "selfCollisionFree", "collisionFree", "endEffector"})) {
      case 0:
        entry.expect_keys({"type", "parts"});
        for (const JsonCursor& part : entry.at("parts").items())
          static_cast<void>(part.choice({"q", "dq", "ddq", "tau"}));
        break;
      case 1:
      case 2:
        entry.expect_keys({"type"});
        break;
      default:
        entry.at("type").fail("constraints of type \"endEffector\" are not supported yet");
    }
  }
}

Wrench read_wrench(const JsonCursor& goal) {
  Wrench wrench;
  if (const std::optional<JsonCursor> force = goal.find("externalForce")) wrench.force = force->vector(3);
  if (const std::optional<JsonCursor> torque = goal.find("externalTorque")) wrench.torque = torque->vector(3);
  return wrench;
}

Trajectory read_trajectory(const JsonCursor& cursor) {
  cursor.expect_keys({"pose", "t"});
  Trajectory trajectory;
  for (const JsonCursor& pose : cursor.at("pose").items()) trajectory.poses.push_back(read_region(pose));
  if (const std::optional<JsonCursor> times = cursor.find("t"); times && !times->value().empty()) {
    for (const JsonCursor& time : times->items()) trajectory.times.push_back(time.number());
  }
  return trajectory;
}

/// What is done, and the goals that it is done with.
struct Doings {
  std::vector<Goal> goals;
  std::vector<TaskStep> steps;
};

/// Appends one goal of the file; those that a return refers to are looked up later, when all are known.
void read_goal(const JsonCursor& cursor, Doings& doings) {
  const std::size_t type = cursor.at("type").choice({"at", "reach", "returnTo", "pause", "follow"});
  TaskStep step{.id = cursor.at("ID").text()};
  if (const std::optional<JsonCursor> constraints = cursor.find("constraints")) read_goal_constraints(*constraints);
  switch (type) {
    case 2:
      cursor.expect_keys({"ID", "type", "constraints", "returnToGoal", "externalForce", "externalTorque"});
      step.kind = TaskStep::Kind::kReturn;
      step.goal = -1;
      break;
    case 3:
      cursor.expect_keys({"ID", "type", "constraints", "duration", "externalForce", "externalTorque"});
      step.kind = TaskStep::Kind::kPause;
      step.duration = cursor.at("duration").number({.lower = 0.0});
      break;
    case 4: {
      cursor.expect_keys({"ID", "type", "constraints", "trajectory", "externalForce", "externalTorque"});
      FollowStep following = cursor.guard([&] {
        return follow(step.id, read_trajectory(cursor.at("trajectory")), static_cast<int>(doings.goals.size()),
                      read_wrench(cursor));
      });
      doings.goals.insert(doings.goals.end(), following.goals.begin(), following.goals.end());
      step = std::move(following.step);
      break;
    }
    default:
      cursor.expect_keys({"ID", "type", "constraints", "goalPose", "externalForce", "externalTorque"});
      step.goal = static_cast<int>(doings.goals.size());
      doings.goals.push_back({step.id, type == 0 ? GoalType::kAt : GoalType::kReach, read_region(cursor.at("goalPose")),
                              read_wrench(cursor)});
  }
  doings.steps.push_back(std::move(step));
}

Doings read_goals(const JsonCursor& list) {
  Doings doings;
  const std::vector<JsonCursor> entries = list.items_or_single();
  for (const JsonCursor& entry : entries) {
    read_goal(entry, doings);
    const TaskStep& added = doings.steps.back();
    const auto same = std::count_if(doings.steps.begin(), doings.steps.end(),
                                    [&](const TaskStep& other) { return other.id == added.id; });
    if (same > 1) entry.at("ID").fail_value("a new ID: another goal has it");
  }
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const std::optional<JsonCursor> target = entries[i].find("returnToGoal");
    if (!target || target->value().is_null()) continue;
    const std::string id = target->text();
    const auto found = std::find_if(doings.steps.begin(), doings.steps.end(), [&](const TaskStep& other) {
      return other.id == id && (other.kind == TaskStep::Kind::kVisit || other.kind == TaskStep::Kind::kFollow);
    });
    if (found == doings.steps.end()) target->fail_value("the ID of a goal with a pose");
    doings.steps[i].goal = found->goal + found->n_goals - 1;  // where a trajectory ends
  }
  return doings;
}

/// `steps` such that those named in the order follow it; the others keep their places.
std::vector<TaskStep> ordered(const std::vector<TaskStep>& steps, const Constraints& constraints) {
  std::vector<std::size_t> named;
  for (std::size_t i = 0; i < constraints.order.size(); ++i) {
    const auto found =
        std::find_if(steps.begin(), steps.end(), [&](const TaskStep& step) { return step.id == constraints.order[i]; });
    const JsonCursor place = constraints.order_place->items()[i];
    if (found == steps.end()) place.fail_value("the ID of a goal");
    const auto index = static_cast<std::size_t>(found - steps.begin());
    if (std::find(named.begin(), named.end(), index) != named.end()) place.fail_value("named once only (limit 1)");
    named.push_back(index);
  }
  std::vector<std::size_t> places = named;
  std::sort(places.begin(), places.end());
  std::vector<TaskStep> result = steps;
  for (std::size_t i = 0; i < named.size(); ++i) result[places[i]] = steps[named[i]];
  return result;
}

/// Goals in the order of the steps that have them, which the steps are told.
std::vector<Goal> sorted_goals(const std::vector<Goal>& goals, std::vector<TaskStep>& steps) {
  std::vector<Goal> result;
  std::vector<int> place(goals.size(), 0);
  for (TaskStep& step : steps) {
    if (step.kind != TaskStep::Kind::kVisit && step.kind != TaskStep::Kind::kFollow) continue;
    const int first = step.goal;
    step.goal = static_cast<int>(result.size());
    for (int k = 0; k < step.n_goals; ++k) {
      place[static_cast<std::size_t>(first + k)] = static_cast<int>(result.size());
      result.push_back(goals[static_cast<std::size_t>(first + k)]);
    }
  }
  for (TaskStep& step : steps) {
    if (step.kind == TaskStep::Kind::kReturn && step.goal >= 0) step.goal = place[static_cast<std::size_t>(step.goal)];
  }
  return result;
}

}  // namespace

TaskFile read_task(const JsonCursor& cursor) {
  cursor.expect_keys({"header", "obstacles", "constraints", "goals", "objects", "home", "payload"});
  TaskFile result;
  const JsonCursor header = cursor.at("header");
  header.expect_keys({"ID", "version", "taskName", "timeStepSize", "gravity"});
  const std::string id = header.at("ID").text();
  if (const std::optional<JsonCursor> version = header.find("version"); version && !version->value().is_number()) {
    static_cast<void>(version->text());
  }
  static_cast<void>(header.text_or("taskName", ""));
  result.time_step = header.number_or("timeStepSize", result.time_step, {.lower = 0.0, .above_lower = true});
  Statics statics;
  if (const std::optional<JsonCursor> gravity = header.find("gravity")) statics.gravity = gravity->vector(3);
  statics.payload = cursor.number_or("payload", 0.0, {.lower = 0.0});
  if (const std::optional<JsonCursor> objects = cursor.find("objects")) {
    if (!objects->value().empty()) objects->fail("\"objects\" may only be empty (limit 0 entries)");
  }

  std::vector<Obstacle> obstacles;
  if (const std::optional<JsonCursor> list = cursor.find("obstacles")) {
    for (const JsonCursor& entry : list->items_or_single()) {
      obstacles.push_back(read_obstacle(entry));
      // One obstacle at a time, so that a refusal names it.
      static_cast<void>(entry.guard([&] { return Scene{{obstacles.back()}}; }));
    }
  }
  result.scene = std::make_shared<const Scene>(std::move(obstacles));

  Constraints constraints;
  if (const std::optional<JsonCursor> list = cursor.find("constraints")) {
    for (const JsonCursor& entry : list->items_or_single()) read_constraint(entry, constraints);
  }
  if (constraints.X_WB) result.X_WB = *constraints.X_WB;
  if (constraints.base && !constraints.base->fixed()) result.base = constraints.base;
  statics.limited = constraints.torques;
  Doings doings = read_goals(cursor.at("goals"));
  GoalTaskSpec task{.name = id};
  task.steps = ordered(doings.steps, constraints);
  task.goals = sorted_goals(doings.goals, task.steps);
  task.statics = statics;
  task.any_order = constraints.all_in_any_order && !constraints.order_place && task.steps.size() > 1;
  if (const std::optional<JsonCursor> given = cursor.find("home")) task.home = given->vector();
  // Goals that are only visited need no steps.
  if (task.steps.size() == task.goals.size() &&
      std::all_of(task.steps.begin(), task.steps.end(),
                  [](const TaskStep& step) { return step.kind == TaskStep::Kind::kVisit; })) {
    task.steps.clear();
  }
  result.goals = task.goals;
  if (result.goals.empty() && !task.steps.empty()) cursor.at("goals").fail("no goal has a pose (limit: at least 1)");
  if (!result.goals.empty()) {
    result.task = cursor.at("goals").guard([&] { return std::make_shared<const GoalTask>(std::move(task)); });
  }
  return result;
}

TaskFile read_task_text(std::string text, const std::string& label) {
  return read_task(parse_json(std::move(text), {label, {}}).cursor());
}

}  // namespace detail

TaskFile load_task(const std::filesystem::path& file) { return detail::read_task(detail::load_json(file).cursor()); }

}  // namespace modsearch
