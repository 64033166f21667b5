#include <algorithm>
#include <checker/incumbent.hpp>
#include <checker/posture.hpp>
#include <checker/separation.hpp>

namespace modsearch_check {
namespace {

std::vector<std::size_t> read_types(const Problem& problem, const Value& design) {
  std::vector<std::size_t> types;
  for (const Value& placement : design.items()) {
    placement.only({"type", "parameters"});
    const std::string id = placement["type"].text();
    const auto& known = problem.library.types;
    const auto found = std::find_if(known.begin(), known.end(), [&](const Module& module) { return module.id == id; });
    if (found == known.end()) throw Rejected("the library has no module " + id);
    types.push_back(static_cast<std::size_t>(found - known.begin()));
  }
  return types;
}

std::vector<double> read_parameters(const Problem& problem, const Value& design,
                                    const std::vector<std::size_t>& types) {
  std::vector<double> x;
  const std::vector<Value> placements = design.items();
  for (std::size_t i = 0; i < types.size(); ++i) {
    const Value given = placements[i]["parameters"];
    const std::vector<Parameter>& parameters = problem.library.types[types[i]].parameters;
    if (given.members().size() != parameters.size()) given.fail("these are not the parameters of the module");
    for (const Parameter& parameter : parameters) {
      x.push_back(given[parameter.name].hex());
      if (!(x.back() >= parameter.lower - kSlack && x.back() <= parameter.upper + kSlack)) {
        throw Rejected("the incumbent's parameter " + parameter.name + " is outside its interval");
      }
    }
  }
  return x;
}

Interval at(const AffineScalar& scalar, const std::vector<Interval>& x) {
  Interval value = scalar.offset;
  for (std::size_t i = 0; i < x.size(); ++i) value += scalar.columns[i] * x[i];
  return value;
}

Vector at(const AffineVector& vector, const std::vector<Interval>& x) {
  Vector value = vector.offset;
  for (std::size_t i = 0; i < x.size(); ++i) value = value + x[i] * vector.columns[i];
  return value;
}

Solid solid(const Shape& shape, const std::vector<Interval>& x, const Matrix& R, const Vector& origin) {
  Solid result{shape.kind, {}, R * shape.pose.turn, origin + R * at(shape.pose.move, x)};
  for (const AffineScalar& size : shape.size) result.size.push_back(at(size, x));
  return result;
}

/// Normals by which the file says that bodies are apart.
std::vector<Numbers> given_normals(const Value& value, std::size_t goal, std::size_t body, std::size_t shape) {
  std::vector<Numbers> normals;
  if (!value.has("separations")) return normals;
  for (const Value& entry : value["separations"].items()) {
    entry.only({"goal", "body", "shape", "normal"});
    const bool meant = entry["goal"].natural(1000) == goal && entry["body"].natural(10'000) == body &&
                       entry["shape"].natural(100'000) == shape;
    const std::vector<Value> normal = entry["normal"].items(3);
    if (meant) normals.push_back({normal[0].hex(), normal[1].hex(), normal[2].hex()});
  }
  return normals;
}

}  // namespace

Incumbent check_incumbent(const Problem& problem, const Value& value) {
  value.only({"design", "postures", "separations"});
  const Value design = value["design"];
  const std::vector<std::size_t> types = read_types(problem, design);
  if (types.size() + 1 > problem.max_modules) throw Rejected("the incumbent has too many modules");
  if (problem.library.has_tips && (types.empty() || !problem.library.types[types.back()].has_connector("eef"))) {
    throw Rejected("the incumbent does not end in an end effector");
  }
  const Model model = Assembler{problem}.model(types);
  const std::vector<double> parameters = read_parameters(problem, design, types);
  const std::vector<Interval> x(parameters.begin(), parameters.end());
  std::vector<Interval> z(model.n_lengths());
  for (std::size_t i = 0; i < x.size(); ++i) z[model.variable_of[i]] += x[i];

  const std::vector<Value> postures = value["postures"].items(problem.task.goals.size());
  for (std::size_t g = 0; g < postures.size(); ++g) {
    std::vector<double> q;
    for (const Value& angle : postures[g].items(model.n_joints())) q.push_back(angle.hex());
    for (std::size_t j = 0; j < q.size(); ++j) {
      if (!(q[j] >= model.joints[j].lower - kSlack && q[j] <= model.joints[j].upper + kSlack)) {
        throw Rejected("a joint of the incumbent is beyond its limits");
      }
    }
    const Posture posture{model, q.data()};
    std::vector<Vector> origin(model.frames.size() + 1);
    for (std::size_t j = 0; j < model.frames.size(); ++j) {
      origin[j + 1] = origin[j] + posture.turn[j] * at(model.frames[j].v, z);
    }
    const Goal& goal = problem.task.goals[g];
    if (!(norm(origin.back() - vector_of(goal.position)).upper() <= goal.radius + kSlack)) {
      throw Rejected("the incumbent does not reach goal " + goal.id);
    }
    if (!problem.sees_obstacles()) continue;
    for (std::size_t b = 0; b < model.shapes.size(); ++b) {
      const std::size_t j = model.shapes[b].frame;
      const Solid body = solid(model.shapes[b].shape, x, posture.turn[j], origin[j]);
      for (std::size_t s = 0; s < problem.task.obstacles.size(); ++s) {
        const Solid obstacle = solid(problem.task.obstacles[s], {}, identity(), Vector{});
        if (!are_apart(body, obstacle, given_normals(value, g, b, s))) {
          throw Rejected("body " + std::to_string(b) + " of the incumbent is not shown to be clear of obstacle shape " +
                         std::to_string(s) + " at goal " + goal.id);
        }
      }
    }
  }
  const Interval mass = at(model.mass, z);
  return {problem.scoring.head(types.size() + 1, model.costs) - Interval{problem.scoring.mass_weight} * mass, mass};
}

}  // namespace modsearch_check
