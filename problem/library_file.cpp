#include <fmt/format.h>

#include <cmath>
#include <modsearch/problem/files.hpp>
#include <modsearch/problem/geometry_internal.hpp>
#include <modsearch/problem/readers_internal.hpp>

namespace modsearch {
namespace detail {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();

ParameterList read_parameters(const JsonCursor& cursor) {
  ParameterList result;
  for (const JsonCursor& entry : cursor.items_or_single()) {
    entry.expect_keys({"name", "unit", "lower", "upper"});
    ParameterRange range;
    range.name = entry.at("name").text();
    for (const ParameterRange& other : result) {
      if (other.name == range.name) entry.at("name").fail_value("a new name: another parameter of the module has it");
    }
    range.unit = entry.at("unit").choice({"m", "rad"}) == 0 ? "m" : "rad";
    range.lower = entry.at("lower").number();
    range.upper = entry.at("upper").number();
    if (range.lower > range.upper) {
      entry.at("upper").fail_value(fmt::format("at least {}, the lower end of the interval", range.lower));
    }
    result.push_back(std::move(range));
  }
  if (result.size() > ModuleLibrary::kMaxParameters) {
    cursor.fail(fmt::format("{} parameters are too many (limit {})", result.size(), ModuleLibrary::kMaxParameters));
  }
  return result;
}

Connector read_connector(const JsonCursor& cursor, const ParameterList& parameters) {
  cursor.expect_keys({"ID", "pose", "gender", "type", "size"});
  Connector connector;
  connector.id = cursor.at("ID").text();
  connector.X_BC = read_affine_pose(cursor.at("pose"), parameters);
  constexpr Gender kGenders[] = {Gender::kFemale, Gender::kMale, Gender::kHermaphroditic};
  connector.gender = kGenders[cursor.at("gender").choice({"f", "m", "h"})];
  connector.type = cursor.at("type").text();
  const JsonCursor size = cursor.at("size");
  if (size.value().is_number()) {
    connector.size = {size.number({.lower = 0.0})};
  } else {
    for (const JsonCursor& entry : size.items()) connector.size.push_back(entry.number({.lower = 0.0}));
  }
  return connector;
}

Eigen::Matrix3d read_inertia(const JsonCursor& cursor) {
  Eigen::Matrix3d inertia;
  const std::vector<JsonCursor> rows = cursor.items(3);
  for (std::size_t i = 0; i < 3; ++i) inertia.row(static_cast<Eigen::Index>(i)) = rows[i].vector(3);
  return inertia;
}

ModuleBody read_body(const JsonCursor& cursor, const ParameterList& parameters) {
  cursor.expect_keys({"ID", "mass", "inertia", "r_com", "connectors", "collision"});
  ModuleBody body;
  body.id = cursor.at("ID").text();
  body.mass = read_affine(cursor.at("mass"), parameters, 0.0);
  body.r_com = read_affine_vector(cursor.at("r_com"), parameters);
  for (const JsonCursor& entry : cursor.at("connectors").items_or_single()) {
    body.connectors.push_back(read_connector(entry, parameters));
  }
  if (const std::optional<JsonCursor> collision = cursor.find("collision")) {
    for (const JsonCursor& entry : collision->items_or_single())
      body.collision.push_back(read_geometry(entry, parameters));
  }
  const JsonCursor inertia = cursor.at("inertia");
  body.uniform_inertia = inertia.value() == Json("uniform");
  if (!body.uniform_inertia) {
    if (inertia.value().is_string()) inertia.fail_value("\"uniform\" or a 3x3 matrix");
    body.inertia = read_inertia(inertia);
  } else if (body.collision.empty()) {
    inertia.fail("\"uniform\" needs collision geometry to spread the mass over");
  }
  return body;
}

int body_index(const JsonCursor& cursor, const std::vector<ModuleBody>& bodies) {
  const std::string id = cursor.text();
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    if (bodies[i].id == id) return static_cast<int>(i);
  }
  cursor.fail_value("the ID of a body of this module");
}

void read_limits(const JsonCursor& limits, Joint& joint) {
  limits.expect_keys({"positionLower", "positionUpper", "peakTorque", "velocity", "acceleration"});
  constexpr NumberLimits kAny{.allow_infinity = true};
  constexpr NumberLimits kPositive{.lower = 0.0, .above_lower = true, .allow_infinity = true};
  if (joint.type == JointType::kContinuous) {
    joint.lower = limits.number_or("positionLower", -kInf, kAny);
    joint.upper = limits.number_or("positionUpper", kInf, kAny);
  } else {
    joint.lower = limits.at("positionLower").number(kAny);
    joint.upper = limits.at("positionUpper").number(kAny);
  }
  if (joint.lower > joint.upper) {
    limits.at("positionUpper").fail_value(fmt::format("at least {}, the lower limit", joint.lower));
  }
  if (joint.type == JointType::kContinuous) {
    joint.lower = -kInf;  // it turns without end, whatever the file says besides
    joint.upper = kInf;
  } else if (!std::isfinite(joint.lower) || !std::isfinite(joint.upper)) {
    limits.at(std::isfinite(joint.lower) ? "positionUpper" : "positionLower")
        .fail_value("a finite limit (only a continuous joint may do without)");
  }
  joint.velocity = limits.number_or("velocity", kInf, kPositive);
  joint.acceleration = limits.number_or("acceleration", kInf, kPositive);
  joint.peak_torque = limits.number_or("peakTorque", kInf, kPositive);
}

ModuleJoint read_joint(const JsonCursor& cursor, const ParameterList& parameters,
                       const std::vector<ModuleBody>& bodies) {
  cursor.expect_keys({"ID", "parent", "child", "type", "passive", "poseParent", "poseChild", "angle", "limits",
                      "gearRatio", "motorInertia", "frictionCoulomb", "frictionViscous"});
  ModuleJoint result;
  result.joint.name = cursor.at("ID").text();
  result.parent = body_index(cursor.at("parent"), bodies);
  result.child = body_index(cursor.at("child"), bodies);
  if (result.parent == result.child) cursor.at("child").fail_value("another body than the parent");
  const std::size_t type = cursor.at("type").choice({"revolute", "prismatic", "continuous", "fixed"});
  constexpr JointType kTypes[] = {JointType::kRevolute, JointType::kPrismatic, JointType::kContinuous};
  result.fixed = type == 3;
  if (!result.fixed) result.joint.type = kTypes[type];
  if (const std::optional<JsonCursor> passive = cursor.find("passive"); passive && passive->boolean()) {
    passive->fail("passive joints are not supported yet");
  }
  result.X_PJ = read_affine_pose(cursor.at("poseParent"), parameters);
  result.X_JC = read_affine_pose(cursor.at("poseChild"), parameters);
  if (result.joint.type == JointType::kContinuous && !cursor.has("limits")) {
    result.joint.lower = -kInf;
    result.joint.upper = kInf;
  } else if (!result.fixed) {
    read_limits(cursor.at("limits"), result.joint);
  }
  if (const std::optional<JsonCursor> angle = cursor.find("angle")) {
    if (!result.fixed) angle->fail("only a joint of type \"fixed\" may have an angle");
    result.angle = read_affine(*angle, parameters, -kInf, "rad");
  }
  constexpr NumberLimits kNotNegative{.lower = 0.0};
  result.gear_ratio = cursor.number_or("gearRatio", 1.0);
  result.motor_inertia = cursor.number_or("motorInertia", 0.0, kNotNegative);
  result.friction_coulomb = cursor.number_or("frictionCoulomb", 0.0, kNotNegative);
  result.friction_viscous = cursor.number_or("frictionViscous", 0.0, kNotNegative);
  return result;
}

ModuleType read_module(const JsonCursor& cursor) {
  cursor.expect_keys({"header", "parameters", "bodies", "joints"});
  const JsonCursor header = cursor.at("header");
  header.expect_keys({"ID", "name", "cost"});
  ModuleType module;
  module.id = header.at("ID").text();
  module.name = header.text_or("name", module.id);
  module.cost = header.number_or("cost", 0.0);
  if (const std::optional<JsonCursor> parameters = cursor.find("parameters")) {
    module.parameters = read_parameters(*parameters);
  }
  for (const JsonCursor& entry : cursor.at("bodies").items_or_single()) {
    module.bodies.push_back(read_body(entry, module.parameters));
  }
  if (const std::optional<JsonCursor> joints = cursor.find("joints")) {
    for (const JsonCursor& entry : joints->items_or_single()) {
      module.joints.push_back(read_joint(entry, module.parameters, module.bodies));
    }
  }
  return module;
}

NeighbourRule read_rule(const JsonCursor& cursor) {
  constexpr NeighbourRule kRules[] = {NeighbourRule::kRigid, NeighbourRule::kViaJoint, NeighbourRule::kRigidViaJoint};
  return kRules[cursor.choice({"rigid", "via_joint", "rigid_via_joint"})];
}

}  // namespace

bool is_list_of_modules(const Json& root) {
  return root.is_array() && !root.empty() && root[0].is_object() && root[0].contains("header");
}

std::shared_ptr<const ModuleLibrary> read_library(const JsonCursor& cursor, const std::string& name) {
  const bool bare = cursor.value().is_array();
  if (!bare) cursor.expect_keys({"modules", "ignore_collisions"});
  std::vector<ModuleType> modules;
  const JsonCursor list = bare ? cursor : cursor.at("modules");
  for (const JsonCursor& entry : list.items_or_single()) {
    modules.push_back(read_module(entry));
    for (std::size_t i = 0; i + 1 < modules.size(); ++i) {
      if (modules[i].id == modules.back().id) {
        entry.at("header").at("ID").fail_value(fmt::format("a new ID: module {} has it", i));
      }
    }
  }
  const std::optional<JsonCursor> rule = bare ? std::nullopt : cursor.find("ignore_collisions");
  const NeighbourRule neighbours = rule ? read_rule(*rule) : NeighbourRule::kViaJoint;
  return list.guard([&] { return std::make_shared<const ModuleLibrary>(name, std::move(modules), neighbours); });
}

std::shared_ptr<const ModuleLibrary> load_library_from(const std::string& file_or_id, const JsonSource& referrer) {
  if (const std::optional<std::string_view> text = builtin_library(file_or_id)) {
    const JsonDocument document = parse_json(std::string{*text}, {"built-in library " + file_or_id, {}});
    return read_library(document.cursor(), file_or_id);
  }
  if (referrer.label.empty()) require_file_or_id(file_or_id, "library", builtin_libraries());
  const std::filesystem::path file = referrer.directory / file_or_id;
  return read_library(load_json(file, referrer.label, referrer.mesh_root).cursor(), file.string());
}

}  // namespace detail

std::shared_ptr<const ModuleLibrary> load_library(const std::string& file_or_id) {
  return detail::load_library_from(file_or_id, {});
}

}  // namespace modsearch
