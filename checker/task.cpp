#include <algorithm>
#include <checker/problem.hpp>
#include <optional>

namespace modsearch_check {
namespace {

/// Poses may hang on named frames in tasks; nothing is proved about those.
void only_in_the_world(const Value& pose) {
  pose.only({"nominal", "nominalParent", "toleranceProjection", "tolerance", "toleranceFrame", "frame"});
  if (pose.has("nominalParent") && pose["nominalParent"].text() != "world") {
    throw Rejected("nothing is proved about poses that hang on other frames than the world");
  }
}

/// A base at its nominal pose: tolerances, if any, limit its place and its turn to CoBRA's default ones (1 mm, 0.5
/// degrees), which say how exactly it is mounted.
Pose read_base(const Value& pose) {
  if (!pose.json().is_object()) return pose.pose();
  only_in_the_world(pose);
  if (!pose.has("toleranceProjection") || pose["toleranceProjection"].json().empty()) return pose["nominal"].pose();
  bool turns = true;
  const std::vector<Value> projections = pose["toleranceProjection"].items();
  const std::vector<Value> intervals = pose["tolerance"].items(projections.size());
  for (std::size_t i = 0; i < projections.size(); ++i) {
    const std::size_t which = projections[i].choice({"x", "y", "z", "r_cyl", "r_sph", "N_x", "N_y", "N_z", "Theta_R"});
    const double most = which < 5 ? 0.001 + 1e-9 : 0.5 * 3.14159265358979 / 180.0 + 1e-6;
    const std::vector<Value> ends = intervals[i].items(2);
    const bool tilt = which == 5 || which == 6;  // held at 0, however wide
    const bool mounted = ends[0].number() <= 0.0 && ends[1].number() >= 0.0 &&
                         (tilt || (ends[0].number() >= -most && ends[1].number() <= most));
    if (!mounted) throw Rejected("nothing is proved about bases that may be placed");
    if (which >= 7) turns = false;
  }
  if (turns) throw Rejected("nothing is proved about bases that may be placed");
  return pose["nominal"].pose();
}

/// A goal that is a ball about a position, whatever the orientation: the only kind that is proved.
Goal read_goal(const Value& value) {
  value.only({"ID", "type", "constraints", "goalPose", "externalForce", "externalTorque", "forceTorqueReferenceFrame"});
  if (value["type"].choice({"at", "reach", "returnTo", "pause", "follow"}) > 1) {
    throw Rejected("nothing is proved about goals of other types than at and reach");
  }
  const Value pose = value["goalPose"];
  only_in_the_world(pose);
  if (!pose.has("toleranceProjection") || pose["toleranceProjection"].items().size() != 1 ||
      pose["toleranceProjection"].items()[0].text() != "r_sph") {
    throw Rejected("nothing is proved about goals that are not balls (the one tolerance r_sph)");
  }
  const std::vector<Value> ends = pose["tolerance"].items(1)[0].items(2);
  if (!(ends[0].number() <= 0.0 && ends[1].number() >= 0.0)) throw Rejected("nothing is proved about hollow goals");
  const Pose nominal = pose["nominal"].pose();
  return {value["ID"].text(), middle(nominal.move.offset), ends[1].number()};
}

/// The goals that `order` names, in that order, on the places where they stand; the others stay.
void put_in_order(std::vector<Goal>& goals, const Value& order) {
  std::vector<std::size_t> named;
  for (const Value& entry : order.items()) {
    const std::string id = entry.text();
    const auto found = std::find_if(goals.begin(), goals.end(), [&](const Goal& goal) { return goal.id == id; });
    const auto place = static_cast<std::size_t>(found - goals.begin());
    if (found == goals.end()) entry.fail("there is no such goal");
    if (std::find(named.begin(), named.end(), place) != named.end()) entry.fail("the goal is named twice");
    named.push_back(place);
  }
  std::vector<std::size_t> places = named;
  std::sort(places.begin(), places.end());
  const std::vector<Goal> before = goals;
  for (std::size_t i = 0; i < named.size(); ++i) goals[places[i]] = before[named[i]];
}

}  // namespace

Task read_task(const Value& value) {
  value.only({"header", "obstacles", "constraints", "goals", "objects", "frames", "home"});
  value["header"].only({"ID", "version", "taskName", "timeStepSize", "gravity"});
  if (value.has("objects") && !value["objects"].json().empty()) value["objects"].fail("may only be empty");
  Task task;
  if (value.has("obstacles")) {
    for (const Value& obstacle : value["obstacles"].items_or_one()) {
      obstacle.only({"ID", "name", "collision", "pose"});  // `pose` repeats that of the shapes and is not applied
      for (const Value& shape : obstacle["collision"].items_or_one()) task.obstacles.push_back(read_shape(shape, {}));
    }
  }
  std::vector<std::string> ids;
  for (const Value& entry : value["goals"].items_or_one()) {
    task.goals.push_back(read_goal(entry));
    if (std::find(ids.begin(), ids.end(), task.goals.back().id) != ids.end()) entry.fail("the ID is taken");
    ids.push_back(task.goals.back().id);
  }
  if (task.goals.empty()) value["goals"].fail("there are no goals");
  std::optional<Value> order;
  bool placed = false;
  for (const Value& entry : value.has("constraints") ? value["constraints"].items_or_one() : std::vector<Value>{}) {
    if (entry.json().is_object() && entry.json().empty()) continue;
    // The others only forbid more, or are what the problem's own words decide.
    const std::size_t type = entry["type"].choice({"basePlacement", "allGoalsFulfilledInOrder", "allGoalsFulfilled",
                                                   "joint", "selfCollisionFree", "collisionFree", "validAssembly",
                                                   "alwaysTrue", "goalsBySameRobot", "endEffector"});
    if (type == 0) {
      if (placed) entry.fail("the base is placed twice");
      placed = true;
      task.base = read_base(entry["pose"]);
    } else if (type == 1) {
      if (order) entry.fail("the order of the goals is given twice");
      order = entry["order"];
    }
  }
  if (order) put_in_order(task.goals, *order);
  return task;
}

}  // namespace modsearch_check
