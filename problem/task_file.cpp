#include <fmt/format.h>

#include <algorithm>
#include <array>
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

Obstacle read_obstacle(const JsonCursor& cursor) {
  cursor.expect_keys({"ID", "name", "collision", "pose", "motion"});
  Obstacle obstacle;
  obstacle.name = cursor.text_or("name", cursor.at("ID").text());
  if (const std::optional<JsonCursor> motion = cursor.find("motion"))
    motion->fail("moving obstacles are not supported yet");
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
  std::optional<Eigen::Isometry3d> X_WB;
  std::vector<std::string> order;  // goal IDs
  std::optional<JsonCursor> order_place;
};

void read_constraint(const JsonCursor& cursor, Constraints& constraints) {
  switch (cursor.at("type").choice({"joint", "selfCollisionFree", "collisionFree", "allGoalsFulfilled", "validAssembly",
                                    "allGoalsFulfilledInOrder", "basePlacement", "endEffector"})) {
    case 0:
      cursor.expect_keys({"type", "parts"});
      for (const JsonCursor& part : cursor.at("parts").items())
        static_cast<void>(part.choice({"q", "dq", "ddq", "tau"}));
      return;
    case 1:
    case 2:
    case 3:
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
      for (const char* key : {"toleranceProjection", "tolerance", "toleranceFrame", "nominalParent"}) {
        if (pose.has(key)) pose.at(key).fail("a base that may be placed within tolerances is not supported yet");
      }
      pose.expect_keys({"nominal"});
      constraints.X_WB = pose.at("nominal").pose();
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

Goal read_goal(const JsonCursor& cursor) {
  const JsonCursor type = cursor.at("type");
  const std::size_t which = type.choice({"at", "reach", "returnTo", "pause", "follow"});
  if (which > 1) type.fail(fmt::format("goals of type {} are not supported yet", preview(type.value())));
  cursor.expect_keys({"ID", "type", "constraints", "goalPose", "externalForce", "externalTorque"});
  for (const char* load : {"externalForce", "externalTorque"}) {
    const std::optional<JsonCursor> found = cursor.find(load);
    if (found && !found->vector(3).isZero(0.0)) found->fail_value("zero: loads on the tip are not supported yet");
  }
  if (const std::optional<JsonCursor> constraints = cursor.find("constraints")) read_goal_constraints(*constraints);
  return {cursor.at("ID").text(), which == 0 ? GoalType::kAt : GoalType::kReach, read_region(cursor.at("goalPose"))};
}

std::vector<Goal> read_goals(const JsonCursor& list) {
  std::vector<Goal> goals;
  for (const JsonCursor& entry : list.items_or_single()) {
    Goal goal = read_goal(entry);
    for (const Goal& other : goals) {
      if (other.id == goal.id) entry.at("ID").fail_value("a new ID: another goal has it");
    }
    goals.push_back(std::move(goal));
  }
  return goals;
}

/// `goals` such that those named in the order follow it; the others keep their places.
std::vector<Goal> ordered(const std::vector<Goal>& goals, const Constraints& constraints) {
  std::vector<std::size_t> named;
  for (std::size_t i = 0; i < constraints.order.size(); ++i) {
    const auto found =
        std::find_if(goals.begin(), goals.end(), [&](const Goal& goal) { return goal.id == constraints.order[i]; });
    const JsonCursor place = constraints.order_place->items()[i];
    if (found == goals.end()) place.fail_value("the ID of a goal");
    const auto index = static_cast<std::size_t>(found - goals.begin());
    if (std::find(named.begin(), named.end(), index) != named.end()) place.fail_value("named once only (limit 1)");
    named.push_back(index);
  }
  std::vector<std::size_t> places = named;
  std::sort(places.begin(), places.end());
  std::vector<Goal> result = goals;
  for (std::size_t i = 0; i < named.size(); ++i) result[places[i]] = goals[named[i]];
  return result;
}

}  // namespace

TaskFile read_task(const JsonCursor& cursor) {
  cursor.expect_keys({"header", "obstacles", "constraints", "goals", "objects", "home"});
  TaskFile result;
  const JsonCursor header = cursor.at("header");
  header.expect_keys({"ID", "version", "taskName", "timeStepSize", "gravity"});
  const std::string id = header.at("ID").text();
  if (const std::optional<JsonCursor> version = header.find("version"); version && !version->value().is_number()) {
    static_cast<void>(version->text());
  }
  static_cast<void>(header.text_or("taskName", ""));
  result.time_step = header.number_or("timeStepSize", result.time_step, {.lower = 0.0, .above_lower = true});
  if (const std::optional<JsonCursor> gravity = header.find("gravity")) static_cast<void>(gravity->vector(3));
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
  result.goals = ordered(read_goals(cursor.at("goals")), constraints);
  Eigen::VectorXd home;
  if (const std::optional<JsonCursor> given = cursor.find("home")) home = given->vector();
  if (!result.goals.empty()) {
    result.task = cursor.guard([&] { return std::make_shared<const GoalTask>(id, result.goals, home); });
  }
  return result;
}

}  // namespace detail

TaskFile load_task(const std::filesystem::path& file) { return detail::read_task(detail::load_json(file).cursor()); }

}  // namespace modsearch
