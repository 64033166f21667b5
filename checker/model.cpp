#include <algorithm>
#include <checker/model.hpp>
#include <cmath>
#include <optional>

namespace modsearch_check {
namespace {

using Place = std::pair<std::size_t, std::size_t>;  // body, connector

const Connector& connector_at(const Module& module, Place place) {
  return module.bodies[place.first].connectors[place.second];
}

bool fit(const Connector& a, const Connector& b) {
  const auto joins = [](const Connector& c) { return c.type != "base" && c.type != "eef"; };
  const bool genders = (a.gender == 2 && b.gender == 2) || (a.gender + b.gender == 1);  // f-m or h-h
  return joins(a) && joins(b) && a.type == b.type && a.size == b.size && genders;
}

/// The connectors by which `module` is entered from `free` and left: the first that fits is the entry.
std::optional<std::pair<Place, Place>> passage(const Connector& free, const Module& module) {
  const auto places = module.connectors();
  for (std::size_t e = 0; e < 2; ++e) {
    if (fit(free, connector_at(module, places[e]))) return std::pair{places[e], places[1 - e]};
  }
  return std::nullopt;
}

std::pair<Place, Place> passage_of_base(const Module& base) {
  const auto places = base.connectors();
  const std::size_t ground = connector_at(base, places[0]).type == "base" ? 0 : 1;
  return {places[ground], places[1 - ground]};
}

/// Half a turn about x: what lies between two joined connectors, and on both sides of an axis that is turned over.
Pose half_turn(std::size_t n) {
  return {{Vector{1.0, 0.0, 0.0}, {0.0, -1.0, 0.0}, {0.0, 0.0, -1.0}}, AffineVector::zero(n)};
}

/// The numbers of one module among those of a design with `n` parameters, of which the module's are `first`, ...
AffineScalar among(const AffineScalar& a, std::size_t first, std::size_t n) {
  AffineScalar result{a.offset, std::vector<Interval>(n)};
  std::copy(a.columns.begin(), a.columns.end(), result.columns.begin() + static_cast<std::ptrdiff_t>(first));
  return result;
}
Pose among(const Pose& a, std::size_t first, std::size_t n) {
  Pose result{a.turn, AffineVector::zero(n)};
  result.move.offset = a.move.offset;
  std::copy(a.move.columns.begin(), a.move.columns.end(),
            result.move.columns.begin() + static_cast<std::ptrdiff_t>(first));
  return result;
}

/// A chain under construction: `here` is where the walk stands, in the frame that moves with the last joint.
struct Walk {
  Model model;
  Pose here;
  std::size_t n = 0;      // parameters of the design
  std::size_t first = 0;  // of the module that is being walked through

  [[nodiscard]] Pose mine(const Pose& pose) const { return among(pose, first, n); }

  void add_body(const Body& body, const Pose& pose) {
    const AffineScalar mass = among(body.mass, first, n);
    model.mass.offset += mass.offset;
    for (std::size_t i = 0; i < n; ++i) model.mass.columns[i] += mass.columns[i];
    for (const Shape& shape : body.shapes) {
      Shape placed{shape.kind, {}, pose * mine(shape.pose)};
      for (const AffineScalar& size : shape.size) placed.size.push_back(among(size, first, n));
      model.shapes.push_back({model.frames.size(), std::move(placed)});
    }
  }

  /// From `body`, reached through joint `from`, to `target`: first joint of the way, or none if it is not there.
  [[nodiscard]] static bool leads_to(const Module& module, std::size_t body, std::size_t from, std::size_t target) {
    if (body == target) return true;
    for (std::size_t j = 0; j < module.joints.size(); ++j) {
      const Joint& joint = module.joints[j];
      if (j == from || (joint.parent != body && joint.child != body)) continue;
      if (leads_to(module, joint.parent == body ? joint.child : joint.parent, j, target)) return true;
    }
    return false;
  }

  /// A joint taken along or against its direction; against it, Rz(-q) = Rx(pi) Rz(q) Rx(pi) keeps q as it is.
  void cross(const Joint& joint, bool forward) {
    here = here * (forward ? mine(joint.before) : inverse(mine(joint.after)));
    if (!joint.fixed) {
      if (!forward) here = here * half_turn(n);
      model.frames.push_back({here.move, here.turn, 0});
      model.joints.push_back(joint);
      here = forward ? Pose{identity(), AffineVector::zero(n)} : half_turn(n);
    }
    here = here * (forward ? mine(joint.after) : inverse(mine(joint.before)));
  }

  /// Bodies that hang on `body` by fixed joints beside the way to `target`.
  void add_branches(const Module& module, std::size_t body, std::size_t from, std::size_t target, const Pose& pose) {
    for (std::size_t j = 0; j < module.joints.size(); ++j) {
      const Joint& joint = module.joints[j];
      if (j == from || (joint.parent != body && joint.child != body)) continue;
      const bool forward = joint.parent == body;
      const std::size_t other = forward ? joint.child : joint.parent;
      if (leads_to(module, other, j, target)) continue;
      if (!joint.fixed) throw Malformed("module " + module.id + ": a joint lies beside the chain");
      const Pose there = pose * (forward ? mine(joint.before) * mine(joint.after)
                                         : inverse(mine(joint.after)) * inverse(mine(joint.before)));
      add_body(module.bodies[other], there);
      add_branches(module, other, j, target, there);
    }
  }

  void through(const Module& module, const std::pair<Place, Place>& passage) {
    here = here * half_turn(n) * inverse(mine(connector_at(module, passage.first).pose));
    std::size_t body = passage.first.first;
    std::size_t from = module.joints.size();
    const std::size_t target = passage.second.first;
    for (;;) {
      add_body(module.bodies[body], here);
      add_branches(module, body, from, target, here);
      if (body == target) break;
      std::size_t next = module.joints.size();
      for (std::size_t j = 0; j < module.joints.size() && next == module.joints.size(); ++j) {
        const Joint& joint = module.joints[j];
        if (j == from || (joint.parent != body && joint.child != body)) continue;
        if (leads_to(module, joint.parent == body ? joint.child : joint.parent, j, target)) next = j;
      }
      if (next == module.joints.size()) throw Malformed("module " + module.id + ": its bodies are not one chain");
      const bool forward = module.joints[next].parent == body;
      cross(module.joints[next], forward);
      body = forward ? module.joints[next].child : module.joints[next].parent;
      from = next;
    }
    here = here * mine(connector_at(module, passage.second).pose);
    first += module.parameters.size();
  }
};

/// Throws unless the joints of a module make a tree: then no walk goes round in circles.
void check_tree(const Module& module) {
  std::vector<std::size_t> group(module.bodies.size());
  for (std::size_t b = 0; b < group.size(); ++b) group[b] = b;
  for (const Joint& joint : module.joints) {
    const std::size_t merged = group[joint.child];
    if (group[joint.parent] == merged) throw Malformed("module " + module.id + ": its joints form a ring");
    std::replace(group.begin(), group.end(), merged, std::size_t{group[joint.parent]});
  }
}

constexpr double kRounding = 1e-12;  // of what was computed in two ways: axes, columns, places [m]

/// No parameter that length k is the sum of can be negative.
bool is_positive(const Model& model, std::size_t k) {
  for (std::size_t i = 0; i < model.variable_of.size(); ++i) {
    if (model.variable_of[i] == k && !(model.parameters[i].lower >= kSlack)) return false;
  }
  return true;
}

/// `vector`, affine in the parameters, as one in the lengths; none if the parameters of a length move it differently.
/// As in merge_parameters, columns that are alike but for rounding have to belong to parameters that are positive.
std::optional<AffineVector> in_lengths(const AffineVector& vector, const Model& model) {
  AffineVector result{vector.offset, std::vector<Vector>(model.n_lengths())};
  std::vector<bool> seen(model.n_lengths());
  for (std::size_t i = 0; i < vector.columns.size(); ++i) {
    const std::size_t k = model.variable_of[i];
    const Vector& column = vector.columns[i];
    const Vector both = seen[k] ? hull(result.columns[k], column) : column;
    // Each of them is alike to that of the first parameter.
    if (seen[k] && !(alike(result.columns[k], column, 4.0 * kRounding) && (is_exact(both) || is_positive(model, k)))) {
      return std::nullopt;
    }
    result.columns[k] = both;
    seen[k] = true;
  }
  return result;
}

/// Whether parameters m and i move the chain and weigh alike, but for rounding; `exact`: and without any.
bool move_alike(const Model& model, std::size_t m, std::size_t i, bool& exact) {
  const Interval mass = hull(model.mass.columns[m], model.mass.columns[i]);
  bool result = alike(model.mass.columns[m], model.mass.columns[i], kRounding);
  exact = mass.is_exact();
  for (const Frame& frame : model.frames) {
    result = result && alike(frame.v.columns[m], frame.v.columns[i], kRounding);
    exact = exact && is_exact(hull(frame.v.columns[m], frame.v.columns[i]));
  }
  return result;
}

/// Parameters that move the chain and weigh alike, but for rounding, are one length, their sum. Where their columns are
/// not the same numbers the parameters have to be positive: then the sum of two lies on a ray within what encloses
/// both.
void merge_parameters(Model& model) {
  std::vector<std::size_t> leader;  // of each length
  AffineScalar mass{model.mass.offset, {}};
  for (std::size_t i = 0; i < model.parameters.size(); ++i) {
    const Parameter& p = model.parameters[i];
    std::size_t k = 0;
    for (; k < leader.size(); ++k) {
      bool exact = false;
      if (!move_alike(model, leader[k], i, exact)) continue;
      if (exact || (p.lower >= kSlack && is_positive(model, k))) break;
    }
    const Interval range = Interval{p.lower, p.upper} + Interval{-kSlack, kSlack};
    if (k == leader.size()) {
      leader.push_back(i);
      model.lower.push_back(0.0);
      model.upper.push_back(0.0);
      mass.columns.push_back(model.mass.columns[i]);
    }
    mass.columns[k] = hull(mass.columns[k], model.mass.columns[i]);
    const Interval sum = Interval{model.lower[k], model.upper[k]} + range;
    model.lower[k] = sum.lower();
    model.upper[k] = sum.upper();
    model.variable_of.push_back(k);
  }
  model.mass = mass;
}

/// How long a vector can be at most, whatever the parameters.
double greatest_norm(const AffineVector& vector, const Model& model) {
  Interval most = norm(vector.offset);
  for (std::size_t i = 0; i < vector.columns.size(); ++i) {
    const Parameter& p = model.parameters[i];
    most += norm(vector.columns[i]) * Interval{std::max(std::abs(p.lower), std::abs(p.upper)) + kSlack};
  }
  return most.upper();
}

/// Makes `before` longer by `next`, where that begins at its end (`joined`) along its axis, but for rounding. If the
/// two are off by e, a ball that sinks deeper than a few e into the one long cylinder sinks into one of the two.
bool continued(Run& before, const Run& next, const Vector& axis, const AffineVector& joined, const AffineVector& end,
               const Model& model) {
  const double turned = norm(before.axis - axis).upper();
  const double away = greatest_norm(before.end + Interval{-1.0} * joined, model);
  if (!(turned <= kRounding && away <= kRounding)) return false;
  const double length = greatest_norm(next.end + Interval{-1.0} * next.start, model);
  before.end = end;
  before.slack =
      (Interval{before.slack} + 4.0 * (Interval{away} + Interval{turned} * (length + 2.0 * next.radius))).upper();
  return true;
}

/// Cylinders of a frame, one after the other where each begins on the axis and at the end of the one before.
std::vector<Run> find_runs(const Model& model) {
  std::vector<Run> runs;  // affine in the parameters first
  for (const PlacedBodyShape& placed : model.shapes) {
    const Shape& shape = placed.shape;
    if (shape.kind != Kind::kCylinder) continue;
    const AffineScalar& height = shape.size[1];
    const Vector z = column(shape.pose.turn, 2);
    AffineVector half{Interval{0.5} * height.offset * z, {}};
    for (const Interval& c : height.columns) half.columns.push_back(Interval{0.5} * c * z);
    const AffineVector back = Interval{-1.0} * half;
    Run run{placed.frame, z, shape.pose.move + back, shape.pose.move + half, shape.size[0].offset.upper(), true};
    for (const Interval& c : shape.size[0].columns) run.usable = run.usable && c.is_zero();  // constant radius
    const auto continues = [&](Run& before) {
      if (before.frame != run.frame || !before.usable || !run.usable || before.radius != run.radius) return false;
      return continued(before, run, run.axis, run.start, run.end, model) ||
             continued(before, run, -run.axis, run.end, run.start, model);
    };
    if (std::none_of(runs.begin(), runs.end(), continues)) runs.push_back(std::move(run));
  }
  for (Run& run : runs) {
    const std::optional<AffineVector> start = in_lengths(run.start, model);
    const std::optional<AffineVector> end = in_lengths(run.end, model);
    run.usable = run.usable && start && end;
    if (run.usable) {
      run.start = *start;
      run.end = *end;
    }
  }
  return runs;
}

/// Joint j may stand still if joint j + 1 turns about a parallel axis and nothing between the two lies beside it:
/// Rz(a) C Rz(b) = C Rz(b + a) or C Rz(b - a). The other then has to be free to turn all the way round.
bool stands_still(const Model& model, std::size_t j) {
  if (j + 1 >= model.n_joints()) return false;
  const Frame& between = model.frames[j + 1];
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Interval& entry = between.turn[i][k];
      const double size = std::abs(entry.upper());
      if (!entry.is_exact() || (size != 0.0 && size != 1.0)) return false;
      if ((i == 2) != (k == 2) && size != 0.0) return false;
    }
  }
  if (!along_z(between.v)) return false;
  return std::all_of(model.runs.begin(), model.runs.end(), [&](const Run& run) {
    return run.frame != j + 1 || !run.usable || (along_z(run.start) && along_z(run.end));
  });
}

std::size_t acting_on(const Model& model, std::size_t j, Vector vector) {
  for (; j > 0; --j) {
    if (!along_z(vector)) return j;
    vector = model.frames[j - 1].turn * vector;
  }
  return 0;
}

}  // namespace

std::size_t Model::acting(std::size_t j, const AffineVector& vector) const {
  std::size_t most = acting_on(*this, j, vector.offset);
  for (const Vector& column : vector.columns) most = std::max(most, acting_on(*this, j, column));
  return most;
}

bool Assembler::fits(const std::vector<std::size_t>& types) const {
  const Module* before = &problem_->library.base;
  Place free = passage_of_base(*before).second;
  for (const std::size_t type : types) {
    const Module& module = problem_->library.types[type];
    const auto way = passage(connector_at(*before, free), module);
    if (!way) return false;
    before = &module;
    free = way->second;
  }
  return true;
}

Model Assembler::model(const std::vector<std::size_t>& types) const {
  const Library& library = problem_->library;
  Walk walk;
  for (const std::size_t type : types) {
    const Module& module = library.types[type];
    walk.model.parameters.insert(walk.model.parameters.end(), module.parameters.begin(), module.parameters.end());
  }
  walk.n = walk.model.parameters.size();
  walk.model.types = types;
  walk.model.mass.columns.resize(walk.n);
  walk.here = among(problem_->task.base, 0, walk.n);
  walk.model.costs = library.base.cost;
  check_tree(library.base);
  std::pair<Place, Place> way = passage_of_base(library.base);
  walk.through(library.base, way);
  const Module* before = &library.base;
  for (const std::size_t type : types) {
    const Module& module = library.types[type];
    check_tree(module);
    const auto next = passage(connector_at(*before, way.second), module);
    if (!next) throw Rejected("the modules of a sequence do not fit together");
    way = *next;
    walk.through(module, way);
    walk.model.costs += module.cost;
    before = &module;
  }
  walk.model.frames.push_back({walk.here.move, walk.here.turn, 0});

  Model model = std::move(walk.model);
  merge_parameters(model);
  model.runs = find_runs(model);
  for (std::size_t j = 0; j < model.frames.size(); ++j) {
    model.frames[j].v = *in_lengths(model.frames[j].v, model);  // equal columns: that is how they were merged
    model.frames[j].acting = model.acting(j, model.frames[j].v);
  }
  for (std::size_t j = 0; j < model.n_joints(); ++j) model.idle.push_back(stands_still(model, j));
  if (model.n_lengths() > 10 || model.n_joints() > 40) throw Rejected("an arm has more than 10 lengths or 40 joints");
  return model;
}

}  // namespace modsearch_check
