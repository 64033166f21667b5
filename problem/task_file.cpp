#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <modsearch/problem/geometry_internal.hpp>
#include <modsearch/problem/readers_internal.hpp>
#include <modsearch/problem/task_pose_internal.hpp>

namespace modsearch {
namespace detail {
namespace {

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

/// What the constraints of a task say, as far as it is not the problem's `collision` and `library` that decide.
struct Constraints {
  std::optional<BaseOfTask> base;
  bool torques = false;  // "tau" is among the joints' parts
  bool all_in_any_order = false;
  std::vector<std::string> order;  // goal IDs
  std::optional<JsonCursor> order_place;
};

/// Whether "tau" is among the parts of a constraint of the joints.
bool read_joint_parts(const JsonCursor& cursor) {
  cursor.expect_keys({"type", "parts"});
  bool torques = false;
  for (const JsonCursor& part : cursor.at("parts").items()) {
    if (part.choice({"q", "dq", "ddq", "tau"}) == 3) torques = true;
  }
  return torques;
}

/// A constraint of the end effector along the whole motion, which nothing here looks at: accepted only where it says
/// nothing.
void read_end_effector(const JsonCursor& cursor) {
  cursor.expect_keys({"type", "pose", "v_min", "v_max", "o_min", "o_max"});
  if (const std::optional<JsonCursor> pose = cursor.find("pose")) {
    pose->fail("holding the end effector within a pose along the motion is not supported yet");
  }
  for (const auto& [key, what] : {std::pair{"v_min", "speed"}, std::pair{"v_max", "speed"},
                                  std::pair{"o_min", "rate of turn"}, std::pair{"o_max", "rate of turn"}}) {
    const std::optional<JsonCursor> limit = cursor.find(key);
    if (!limit) continue;
    const double value = limit->number({.allow_infinity = true});
    const bool least = std::string_view{key}.ends_with("min");
    if (least ? value <= 0.0 : value == std::numeric_limits<double>::infinity()) continue;
    limit->fail(fmt::format("a limit of the end effector's {} along the motion is not supported yet", what));
  }
}

void read_constraint(const JsonCursor& cursor, const TaskFrames& frames, Constraints& constraints) {
  if (cursor.value() == Json::object()) return;  // Timor 1.1.1 writes one that always holds as nothing
  switch (cursor.at("type").choice({"joint", "selfCollisionFree", "collisionFree", "allGoalsFulfilled", "validAssembly",
                                    "allGoalsFulfilledInOrder", "basePlacement", "endEffector", "alwaysTrue",
                                    "goalsBySameRobot"})) {
    case 0:
      if (read_joint_parts(cursor)) constraints.torques = true;
      return;
    case 3:
      constraints.all_in_any_order = true;
      [[fallthrough]];
    case 1:
    case 2:
    case 4:
    case 8:
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
      if (constraints.base) cursor.fail("the base is placed twice (limit 1)");
      constraints.base = read_base(cursor.at("pose"), frames);
      return;
    }
    case 7:
      return read_end_effector(cursor);
    default:
      cursor.expect_keys({"type", "goals"});  // there is one robot
  }
}

/// A goal's own constraints: those that hold for the whole task anyway.
void read_goal_constraints(const JsonCursor& list) {
  for (const JsonCursor& entry : list.items_or_single()) {
    if (entry.value() == Json::object()) continue;
    switch (entry.at("type").choice({"joint", "selfCollisionFree", "collisionFree", "alwaysTrue", "endEffector"})) {
      case 0:
        static_cast<void>(read_joint_parts(entry));
        break;
      case 4:
        read_end_effector(entry);
        break;
      default:
        entry.expect_keys({"type"});
    }
  }
}

/// What acts on the tip, turned into the axes of the world.
Wrench read_wrench(const JsonCursor& goal, const TaskFrames& frames) {
  const std::optional<JsonCursor> frame = goal.find("forceTorqueReferenceFrame");
  const Eigen::Matrix3d R_WF = frame ? frames.at(*frame).linear() : Eigen::Matrix3d{Eigen::Matrix3d::Identity()};
  Wrench wrench;
  if (const std::optional<JsonCursor> force = goal.find("externalForce")) wrench.force = R_WF * force->vector(3);
  if (const std::optional<JsonCursor> torque = goal.find("externalTorque")) wrench.torque = R_WF * torque->vector(3);
  return wrench;
}

/// Times of `n` rows: a list, or the step between them.
std::vector<double> read_times(const JsonCursor& cursor, std::size_t n) {
  std::vector<double> times;
  if (cursor.value().is_number()) {
    const double step = cursor.number({.lower = 0.0, .above_lower = true});
    for (std::size_t i = 0; i < n; ++i) times.push_back(step * static_cast<double>(i));
  } else if (!cursor.value().empty()) {
    for (const JsonCursor& time : cursor.items()) times.push_back(time.number());
  }
  return times;
}

Trajectory read_trajectory(const JsonCursor& cursor, const TaskFrames& frames) {
  for (const char* joints : {"q", "dq", "ddq", "goal2time"}) {
    if (!cursor.has(joints)) continue;
    cursor.at(joints).fail("a goal asks for a trajectory of the end effector's poses, not of the joints'");
  }
  cursor.expect_keys({"pose", "t"});
  Trajectory trajectory;
  for (const JsonCursor& pose : cursor.at("pose").items()) trajectory.poses.push_back(read_region(pose, frames));
  if (const std::optional<JsonCursor> times = cursor.find("t"); times && !times->value().is_null()) {
    trajectory.times = read_times(*times, trajectory.poses.size());
  }
  return trajectory;
}

/// What is done, and the goals that it is done with.
struct Doings {
  std::vector<Goal> goals;
  std::vector<TaskStep> steps;
};

/// Appends one goal of the file; those that a return refers to are looked up later, when all are known.
void read_goal(const JsonCursor& cursor, TaskFrames& frames, Doings& doings) {
  const std::size_t type = cursor.at("type").choice({"at", "reach", "returnTo", "pause", "follow"});
  TaskStep step{.id = cursor.at("ID").text()};
  if (const std::optional<JsonCursor> constraints = cursor.find("constraints")) read_goal_constraints(*constraints);
  switch (type) {
    case 2:
      cursor.expect_keys({"ID", "type", "constraints", "returnToGoal", "externalForce", "externalTorque",
                          "forceTorqueReferenceFrame"});
      step.kind = TaskStep::Kind::kReturn;
      step.goal = -1;
      break;
    case 3:
      cursor.expect_keys(
          {"ID", "type", "constraints", "duration", "externalForce", "externalTorque", "forceTorqueReferenceFrame"});
      step.kind = TaskStep::Kind::kPause;
      step.duration = cursor.at("duration").number({.lower = 0.0});
      break;
    case 4: {
      cursor.expect_keys(
          {"ID", "type", "constraints", "trajectory", "externalForce", "externalTorque", "forceTorqueReferenceFrame"});
      FollowStep following = cursor.guard([&] {
        return follow(step.id, read_trajectory(cursor.at("trajectory"), frames), static_cast<int>(doings.goals.size()),
                      read_wrench(cursor, frames));
      });
      doings.goals.insert(doings.goals.end(), following.goals.begin(), following.goals.end());
      step = std::move(following.step);
      break;
    }
    default:
      cursor.expect_keys(
          {"ID", "type", "constraints", "goalPose", "externalForce", "externalTorque", "forceTorqueReferenceFrame"});
      step.goal = static_cast<int>(doings.goals.size());
      doings.goals.push_back({step.id, type == 0 ? GoalType::kAt : GoalType::kReach,
                              read_region(cursor.at("goalPose"), frames), read_wrench(cursor, frames)});
      frames.add_goal(step.id, doings.goals.back().region.nominal());
  }
  doings.steps.push_back(std::move(step));
}

Doings read_goals(const JsonCursor& list, TaskFrames& frames) {
  Doings doings;
  const std::vector<JsonCursor> entries = list.items_or_single();
  for (const JsonCursor& entry : entries) {
    read_goal(entry, frames, doings);
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

Scene read_obstacles(const JsonCursor& list) {
  std::vector<Obstacle> obstacles;
  for (const JsonCursor& entry : list.items_or_single()) {
    obstacles.push_back(read_obstacle(entry));
    // One obstacle at a time, so that a refusal names it.
    static_cast<void>(entry.guard([&] { return Scene{{obstacles.back()}}; }));
  }
  return Scene{std::move(obstacles)};
}

}  // namespace

TaskFile read_task(const JsonCursor& cursor) {
  cursor.expect_keys({"header", "obstacles", "constraints", "goals", "objects", "frames", "home", "payload"});
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
    if (!objects->value().empty()) {
      objects->fail("\"objects\" may only be empty (limit 0 entries): moving them is not supported yet");
    }
  }

  const std::optional<JsonCursor> obstacles = cursor.find("obstacles");
  result.scene = std::make_shared<const Scene>(obstacles ? read_obstacles(*obstacles) : Scene{});

  const std::optional<JsonCursor> named = cursor.find("frames");
  TaskFrames frames = named ? TaskFrames{*named} : TaskFrames{};
  Doings doings = read_goals(cursor.at("goals"), frames);
  Constraints constraints;
  if (const std::optional<JsonCursor> list = cursor.find("constraints")) {
    for (const JsonCursor& entry : list->items_or_single()) read_constraint(entry, frames, constraints);
  }
  if (constraints.base) {
    result.X_WB = constraints.base->X_WB;
    result.base = constraints.base->placement;
  }
  statics.limited = constraints.torques;
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

TaskFile load_task(const std::filesystem::path& file, const FileOptions& options) {
  return detail::read_task(detail::load_json(file, {}, options.mesh_root).cursor());
}

}  // namespace modsearch
