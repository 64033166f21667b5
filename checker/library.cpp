#include <algorithm>
#include <checker/problem.hpp>
#include <checker/trigonometry.hpp>

namespace modsearch_check {
namespace {

constexpr std::size_t kMostParameters = 8;
constexpr std::size_t kMostBodies = 64;  // walks go that deep

AffineScalar read_scalar(const Value& value, const std::vector<Parameter>& parameters) {
  AffineScalar scalar{0.0, std::vector<Interval>(parameters.size())};
  if (!value.json().is_object()) {
    scalar.offset = value.number();
    return scalar;
  }
  value.only({"parameter", "scale", "offset"});
  const std::string name = value["parameter"].text();
  const auto found =
      std::find_if(parameters.begin(), parameters.end(), [&](const Parameter& p) { return p.name == name; });
  if (found == parameters.end()) value.fail("there is no parameter \"" + name + "\"");
  scalar.offset = value.number_or("offset", 0.0);
  scalar.columns[static_cast<std::size_t>(found - parameters.begin())] = value.number_or("scale", 1.0);
  return scalar;
}

AffineVector read_vector(const std::array<Value, 3>& entries, const std::vector<Parameter>& parameters) {
  AffineVector vector = AffineVector::zero(parameters.size());
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const AffineScalar entry = read_scalar(entries[axis], parameters);
    vector.offset[axis] = entry.offset;
    for (std::size_t i = 0; i < parameters.size(); ++i) vector.columns[i][axis] = entry.columns[i];
  }
  return vector;
}

Pose read_pose(const Value& value, const std::vector<Parameter>& parameters) {
  const std::vector<Value> rows = value.items(4);
  std::vector<Value> moves;
  Json constant = value.json();  // with the translation taken out
  for (std::size_t i = 0; i < 3; ++i) {
    moves.push_back(rows[i].items(4)[3]);
    constant[i][3] = 0.0;
  }
  Pose pose = Value{constant, value.place()}.pose();
  pose.move = read_vector({moves[0], moves[1], moves[2]}, parameters);
  return pose;
}

Connector read_connector(const Value& value, const std::vector<Parameter>& parameters) {
  value.only({"ID", "pose", "gender", "type", "size"});
  static_cast<void>(value["ID"].text());
  Connector connector{
      read_pose(value["pose"], parameters), value["gender"].choice({"f", "m", "h"}), value["type"].text(), {}};
  const Value size = value["size"];
  if (size.json().is_number()) {
    connector.size = {size.number()};
  } else {
    for (const Value& entry : size.items()) connector.size.push_back(entry.number());
  }
  return connector;
}

Body read_body(const Value& value, const std::vector<Parameter>& parameters) {
  value.only({"ID", "mass", "inertia", "r_com", "connectors", "collision"});
  Body body{value["ID"].text(), read_scalar(value["mass"], parameters), {}, {}};
  for (const Value& entry : value["connectors"].items_or_one())
    body.connectors.push_back(read_connector(entry, parameters));
  if (value.has("collision")) {
    for (const Value& entry : value["collision"].items_or_one()) body.shapes.push_back(read_shape(entry, parameters));
  }
  return body;
}

std::size_t body_named(const Value& value, const std::vector<Body>& bodies) {
  const std::string id = value.text();
  const auto found = std::find_if(bodies.begin(), bodies.end(), [&](const Body& body) { return body.id == id; });
  if (found == bodies.end()) value.fail("there is no body \"" + id + "\"");
  return static_cast<std::size_t>(found - bodies.begin());
}

Joint read_joint(const Value& value, const Module& module) {
  value.only({"ID", "parent", "child", "type", "passive", "poseParent", "poseChild", "limits", "gearRatio",
              "motorInertia", "frictionCoulomb", "frictionViscous", "angle"});
  Joint joint;
  joint.parent = body_named(value["parent"], module.bodies);
  joint.child = body_named(value["child"], module.bodies);
  joint.before = read_pose(value["poseParent"], module.parameters);
  joint.after = read_pose(value["poseChild"], module.parameters);
  if (value.has("passive") && value["passive"].boolean()) throw Rejected("nothing is proved about passive joints");
  switch (value["type"].choice({"revolute", "continuous", "fixed", "prismatic"})) {
    case 0: {
      const Value limits = value["limits"];
      limits.only({"positionLower", "positionUpper", "peakTorque", "velocity", "acceleration"});
      joint.lower = limits["positionLower"].number();
      joint.upper = limits["positionUpper"].number();
      if (!(joint.lower <= joint.upper)) limits.fail("the lower limit lies above the upper one");
      if (!(joint.lower >= -1000.0 && joint.upper <= 1000.0))
        throw Rejected("nothing is proved about limits above 1000 rad");
      break;
    }
    case 1:  // whatever its file says: any angle is one of a full turn
      joint.lower = -kPiUp;
      joint.upper = kPiUp;
      break;
    case 2:
      joint.fixed = true;
      if (value.has("angle")) {
        if (!value["angle"].json().is_number()) throw Rejected("nothing is proved about angles that are parameters");
        const SinCos turn = sin_cos(value["angle"].number());
        const Matrix about_z = {Vector{turn.cos, -turn.sin, 0.0}, {turn.sin, turn.cos, 0.0}, {0.0, 0.0, 1.0}};
        joint.after = Pose{about_z, AffineVector::zero(module.parameters.size())} * joint.after;
      }
      return joint;
    default:
      throw Rejected("nothing is proved about prismatic joints");
  }
  if (value.has("angle")) value.fail("only a fixed joint has an angle");
  return joint;
}

Module read_module(const Value& value) {
  value.only({"header", "parameters", "bodies", "joints"});
  const Value header = value["header"];
  header.only({"ID", "name", "cost"});
  Module module;
  module.id = header["ID"].text();
  module.cost = header.number_or("cost", 0.0);
  if (value.has("parameters")) {
    for (const Value& entry : value["parameters"].items_or_one()) {
      entry.only({"name", "unit", "lower", "upper"});
      if (entry["unit"].choice({"m", "rad"}) != 0) throw Rejected("nothing is proved about angles that are parameters");
      Parameter parameter{entry["name"].text(), entry["lower"].number(), entry["upper"].number()};
      if (!(parameter.lower <= parameter.upper)) entry.fail("the lower end lies above the upper one");
      for (const Parameter& other : module.parameters) {
        if (other.name == parameter.name) entry.fail("the name is taken");
      }
      module.parameters.push_back(std::move(parameter));
    }
  }
  if (module.parameters.size() > kMostParameters) value.fail("there are more than 8 parameters");
  for (const Value& entry : value["bodies"].items_or_one())
    module.bodies.push_back(read_body(entry, module.parameters));
  if (value.has("joints")) {
    for (const Value& entry : value["joints"].items_or_one()) module.joints.push_back(read_joint(entry, module));
  }
  if (module.bodies.size() > kMostBodies) value.fail("there are more than 64 bodies");
  if (module.joints.size() + 1 != module.bodies.size()) value.fail("the joints do not make one chain of the bodies");
  if (module.connectors().size() != 2) value.fail("only modules with two connectors are supported");
  return module;
}

}  // namespace

std::vector<std::pair<std::size_t, std::size_t>> Module::connectors() const {
  std::vector<std::pair<std::size_t, std::size_t>> result;
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    for (std::size_t c = 0; c < bodies[b].connectors.size(); ++c) result.emplace_back(b, c);
  }
  return result;
}

bool Module::has_connector(std::string_view type) const {
  const auto all = connectors();
  return std::any_of(all.begin(), all.end(),
                     [&](const auto& at) { return bodies[at.first].connectors[at.second].type == type; });
}

Shape read_shape(const Value& value, const std::vector<Parameter>& parameters) {
  value.only({"type", "parameters", "pose"});
  const Value sizes = value["parameters"];
  Shape shape;
  const auto take = [&](std::initializer_list<std::string_view> keys) {
    sizes.only(keys);
    for (const std::string_view key : keys) shape.size.push_back(read_scalar(sizes[std::string{key}], parameters));
  };
  switch (value["type"].choice({"box", "cylinder", "sphere", "mesh"})) {
    case 0:
      shape.kind = Kind::kBox;
      take({"x", "y", "z"});
      break;
    case 1:
      shape.kind = Kind::kCylinder;
      take({"r", "z"});
      break;
    case 2:
      shape.kind = Kind::kSphere;
      take({"r"});
      break;
    default:
      shape.kind = Kind::kMesh;
  }
  for (const AffineScalar& size : shape.size) {
    Interval least = size.offset;
    for (std::size_t i = 0; i < parameters.size(); ++i) {
      least += size.columns[i] * Interval{parameters[i].lower, parameters[i].upper};
    }
    if (!(least.upper() >= 0.0) || (parameters.empty() && !(least.lower() >= 0.0))) sizes.fail("a size is negative");
  }
  shape.pose.move = AffineVector::zero(parameters.size());
  if (value.has("pose")) shape.pose = read_pose(value["pose"], parameters);
  return shape;
}

Library read_library(const Value& value) {
  const bool bare = value.json().is_array();  // the list of modules alone, an older form
  if (!bare) value.only({"modules", "ignore_collisions"});
  Library library;
  bool has_base = false;
  std::vector<std::string> ids;
  for (const Value& entry : bare ? value.items() : value["modules"].items_or_one()) {
    Module module = read_module(entry);
    if (std::find(ids.begin(), ids.end(), module.id) != ids.end()) entry.fail("the ID is taken");
    ids.push_back(module.id);
    if (module.has_connector("base")) {
      if (has_base) entry.fail("there are two bases");
      if (!module.parameters.empty()) entry.fail("the base has parameters");
      library.base = std::move(module);
      has_base = true;
      continue;
    }
    library.has_tips = library.has_tips || module.has_connector("eef");
    library.types.push_back(std::move(module));
  }
  if (!has_base) value.fail("no module has a connector of type \"base\"");
  return library;
}

}  // namespace modsearch_check
