#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <modsearch/problem/module_library.hpp>
#include <set>
#include <stdexcept>

namespace modsearch {
namespace {

constexpr std::string_view kBaseConnector = "base";
constexpr std::string_view kTipConnector = "eef";

[[noreturn]] void refuse(const ModuleType& module, const std::string& what) {
  throw std::invalid_argument(fmt::format("module '{}': {}", module.id, what));
}

/// Half a turn about x: what lies between two joined connectors, both of which point away from their bodies.
Eigen::Isometry3d facing() {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.linear() = Eigen::Vector3d(1.0, -1.0, -1.0).asDiagonal();
  return X;
}

const Connector& connector_at(const ModuleType& module, int body, int connector) {
  return module.bodies[static_cast<std::size_t>(body)].connectors[static_cast<std::size_t>(connector)];
}

bool has_connector(const ModuleType& module, std::string_view type) {
  for (const ModuleBody& body : module.bodies) {
    for (const Connector& connector : body.connectors) {
      if (connector.type == type) return true;
    }
  }
  return false;
}

/// The joint by which `body` is reached from the root of a module's tree of joints; -1 at the root.
struct Tree {
  std::vector<int> joint;   // [n_bodies]
  std::vector<int> parent;  // [n_bodies], the body on the other side of that joint
};

/// The bodies of a module as a tree with `root`. Throws unless the joints form one.
Tree tree_from(const ModuleType& module, int root) {
  const std::size_t n = module.bodies.size();
  if (module.joints.size() + 1 != n) {
    refuse(module, fmt::format("{} joints between {} bodies are not a serial chain (limit {})", module.joints.size(), n,
                               n - 1));
  }
  Tree tree{std::vector<int>(n, -1), std::vector<int>(n, -1)};
  std::vector<bool> seen(n, false);
  std::vector<int> open{root};
  seen[static_cast<std::size_t>(root)] = true;
  while (!open.empty()) {
    const int body = open.back();
    open.pop_back();
    for (std::size_t j = 0; j < module.joints.size(); ++j) {
      const ModuleJoint& joint = module.joints[j];
      if (joint.parent != body && joint.child != body) continue;
      const int other = joint.parent == body ? joint.child : joint.parent;
      if (seen[static_cast<std::size_t>(other)]) continue;
      seen[static_cast<std::size_t>(other)] = true;
      tree.joint[static_cast<std::size_t>(other)] = static_cast<int>(j);
      tree.parent[static_cast<std::size_t>(other)] = body;
      open.push_back(other);
    }
  }
  const auto loose = std::find(seen.begin(), seen.end(), false);
  if (loose != seen.end()) {
    refuse(module, fmt::format("body '{}' is not joined to body '{}'",
                               module.bodies[static_cast<std::size_t>(loose - seen.begin())].id,
                               module.bodies[static_cast<std::size_t>(root)].id));
  }
  return tree;
}

/// Bodies from the root of `tree` to `tip`, both included.
std::vector<int> path_to(const Tree& tree, int tip) {
  std::vector<int> path;
  for (int body = tip; body != -1; body = tree.parent[static_cast<std::size_t>(body)]) path.push_back(body);
  std::reverse(path.begin(), path.end());
  return path;
}

/// The parameters that a number uses exist and have the unit that its place asks for.
void check_indices(const ModuleType& module, const AffineScalar& number, const std::string& what,
                   std::string_view unit = "m") {
  for (const AffineScalar::Term& term : number.terms) {
    if (term.parameter < 0 || term.parameter >= module.n_parameters()) {
      refuse(module, fmt::format("{} uses parameter {} of {}", what, term.parameter, module.n_parameters()));
    }
    const ParameterRange& range = module.parameters[static_cast<std::size_t>(term.parameter)];
    if (range.unit != unit) {
      refuse(module, fmt::format("{} uses parameter '{}' of unit \"{}\" (limit: \"{}\")", what, range.name, range.unit,
                                 unit));
    }
  }
}

/// Masses and sizes must not become negative anywhere in the box of the parameters.
void check_not_negative(const ModuleType& module, const AffineScalar& number, const std::string& what) {
  check_indices(module, number, what);
  Eigen::VectorXd lower(module.n_parameters());
  Eigen::VectorXd upper(module.n_parameters());
  for (int i = 0; i < module.n_parameters(); ++i) {
    lower[i] = module.parameters[static_cast<std::size_t>(i)].lower;
    upper[i] = module.parameters[static_cast<std::size_t>(i)].upper;
  }
  const double least = number.least(lower, upper);
  if (!(least >= 0.0) || !std::isfinite(number.greatest(lower, upper))) {
    refuse(module, fmt::format("{} can become {} (limit: finite and at least 0)", what, least));
  }
}

void check_translation(const ModuleType& module, const AffineVector& vector, const std::string& what) {
  if (!vector.offset.allFinite()) refuse(module, fmt::format("{} is not finite", what));
  for (const AffineVector::Term& term : vector.terms)
    check_indices(module, AffineScalar::of_parameter(term.parameter), what);
}

bool is_zero(const AffineScalar& number) { return number.terms.empty() && number.offset == 0.0; }

void check_parameters(const ModuleType& module) {
  if (module.n_parameters() > ModuleLibrary::kMaxParameters) {
    refuse(module, fmt::format("has {} parameters (limit {})", module.n_parameters(), ModuleLibrary::kMaxParameters));
  }
  std::set<std::string> names;
  for (const ParameterRange& range : module.parameters) {
    if (!names.insert(range.name).second) refuse(module, fmt::format("has two parameters named '{}'", range.name));
    if (!std::isfinite(range.lower) || !std::isfinite(range.upper) || range.lower > range.upper) {
      refuse(module,
             fmt::format("parameter '{}': [{}, {}] is not a finite interval", range.name, range.lower, range.upper));
    }
  }
}

void check_bodies(const ModuleType& module) {
  if (module.bodies.empty()) refuse(module, "has no bodies");
  std::set<std::string> ids;
  for (const ModuleBody& body : module.bodies) {
    if (!ids.insert(body.id).second) refuse(module, fmt::format("has two bodies with the ID '{}'", body.id));
    const std::string what = fmt::format("body '{}'", body.id);
    check_not_negative(module, body.mass, "the mass of " + what);
    check_translation(module, body.r_com, "the centre of mass of " + what);
    for (const Connector& connector : body.connectors) {
      check_translation(module, connector.X_BC.translation, fmt::format("connector '{}'", connector.id));
    }
    for (const BodyGeometry& geometry : body.collision) {
      if (!geometry.X_FG.affine()) refuse(module, "a collision pose of " + what + " is turned by a parameter");
      check_translation(module, geometry.X_FG.head.translation, "a collision pose of " + what);
      for (const AffineScalar& size : geometry.shape.size)
        check_not_negative(module, size, "a collision size of " + what);
    }
  }
}

void check_joints(const ModuleType& module) {
  const int n_bodies = static_cast<int>(module.bodies.size());
  std::set<std::string> ids;
  for (const ModuleJoint& joint : module.joints) {
    const std::string what = fmt::format("joint '{}'", joint.joint.name);
    if (!ids.insert(joint.joint.name).second)
      refuse(module, fmt::format("has two joints with the ID '{}'", joint.joint.name));
    for (const int body : {joint.parent, joint.child}) {
      if (body < 0 || body >= n_bodies) refuse(module, fmt::format("{} names body {} of {}", what, body, n_bodies));
    }
    if (joint.parent == joint.child) refuse(module, what + " joins a body to itself");
    check_translation(module, joint.X_PJ.translation, what);
    check_translation(module, joint.X_JC.translation, what);
    check_indices(module, joint.angle, "the angle of " + what, "rad");
    if (!std::isfinite(joint.angle.offset)) refuse(module, "the angle of " + what + " is not finite");
    if (!joint.fixed && !is_zero(joint.angle)) refuse(module, what + " moves and has an angle, which only a fixed one may");
    if (!joint.fixed && !(joint.joint.lower <= joint.joint.upper)) {
      refuse(module,
             fmt::format("{}: limits [{}, {}] are not an interval", what, joint.joint.lower, joint.joint.upper));
    }
  }
}

/// Every moving joint lies between the two connectors: what hangs beside the chain must be rigid.
void check_serial(const ModuleType& module, int entry_body, int exit_body) {
  const Tree tree = tree_from(module, entry_body);
  const std::vector<int> path = path_to(tree, exit_body);
  std::set<int> on_path;
  for (const int body : path) on_path.insert(tree.joint[static_cast<std::size_t>(body)]);
  for (std::size_t j = 0; j < module.joints.size(); ++j) {
    if (!module.joints[j].fixed && !on_path.contains(static_cast<int>(j))) {
      refuse(module, fmt::format("joint '{}' is not between the two connectors: only serial chains are supported",
                                 module.joints[j].joint.name));
    }
  }
}

/// Pose of the other body in the frame of the one that a fixed joint is crossed from; `forward`: from parent to child.
ParametricPose across(const ModuleJoint& joint, bool forward) {
  const ParametricPose X_PC = ParametricPose{joint.X_PJ} * ParametricPose::turn(joint.angle) * joint.X_JC;
  return forward ? X_PC : X_PC.inverse();
}

/// Lays one module after the other from the base outwards.
class Assembly {
 public:
  Assembly(int n_parameters, const Eigen::Isometry3d& X_WB) : builder_{n_parameters} { builder_.move(X_WB); }

  /// Adds `module`, entered by one connector and left by another; its parameters follow those of the modules before.
  void add(const ModuleType& module, int placement, const Connector& entry, int entry_body, const Connector& exit,
           int exit_body) {
    const Tree tree = tree_from(module, entry_body);
    builder_.move(facing()).move(entry.X_BC.shifted(shift_).inverse());
    int current = -1;  // chain index of the body that the current frame is fixed to
    for (const int body : path_to(tree, exit_body)) {
      const int joint = tree.joint[static_cast<std::size_t>(body)];
      if (joint >= 0) cross(module, placement, joint, body, current);
      current = n_bodies_;
      add_body(module, placement, body, ParametricPose{});
      add_rigid_branches(module, placement, tree, body, exit_body, ParametricPose{});
    }
    builder_.move(exit.X_BC.shifted(shift_));
    shift_ += module.n_parameters();
  }

  [[nodiscard]] Chain chain(NeighbourRule rule) const { return builder_.build(rule); }

 private:
  /// Moves the current frame over a joint to `body`. Against the joint's direction the axis is turned over twice,
  /// Rz(-q) = Rx(pi) Rz(q) Rx(pi), so that it stays z and q keeps its sign and limits.
  void cross(const ModuleType& module, int placement, int joint_index, int body, int from) {
    const ModuleJoint& joint = module.joints[static_cast<std::size_t>(joint_index)];
    const bool forward = joint.child == body;
    if (joint.fixed) {
      builder_.move(across(joint, forward).shifted(shift_));
      return;
    }
    const AffinePose X_PJ = joint.X_PJ.shifted(shift_);
    const AffinePose X_JC = joint.X_JC.shifted(shift_);
    builder_.move(forward ? X_PJ : X_JC.inverse());
    Joint axis = joint.joint;
    axis.name = fmt::format("{}.{}.{}", placement + 1, module.id, axis.name);
    if (!forward) builder_.move(facing());
    builder_.joint(std::move(axis), from, n_bodies_);
    if (!forward) builder_.move(facing());
    builder_.move(forward ? X_JC : X_PJ.inverse());
  }

  /// `X_FB`: pose of the body in the current frame.
  void add_body(const ModuleType& module, int placement, int index, const ParametricPose& X_FB) {
    const ModuleBody& body = module.bodies[static_cast<std::size_t>(index)];
    std::vector<BodyGeometry> geometries = body.collision;
    for (BodyGeometry& geometry : geometries) {
      geometry = {geometry.shape.shifted(shift_), X_FB * geometry.X_FG.shifted(shift_)};
    }
    builder_.body(fmt::format("{}.{}.{}", placement + 1, module.id, body.id), placement, body.mass.shifted(shift_),
                  std::move(geometries),
                  {X_FB, body.r_com.shifted(shift_), body.uniform_inertia, body.inertia});
    ++n_bodies_;
  }

  /// Bodies that hang on `body` by fixed joints beside the path to `exit_body`.
  void add_rigid_branches(const ModuleType& module, int placement, const Tree& tree, int body, int exit_body,
                          const ParametricPose& X_FB) {
    const std::vector<int> path = path_to(tree, exit_body);
    for (int other = 0; other < static_cast<int>(module.bodies.size()); ++other) {
      if (tree.parent[static_cast<std::size_t>(other)] != body) continue;
      if (std::find(path.begin(), path.end(), other) != path.end()) continue;
      const ModuleJoint& joint = module.joints[static_cast<std::size_t>(tree.joint[static_cast<std::size_t>(other)])];
      const ParametricPose X_FO = X_FB * across(joint, joint.child == other).shifted(shift_);
      add_body(module, placement, other, X_FO);
      add_rigid_branches(module, placement, tree, other, exit_body, X_FO);
    }
  }

  ChainBuilder builder_;
  int shift_ = 0;
  int n_bodies_ = 0;
};

}  // namespace

bool Connector::fits(const Connector& other) const {
  const bool genders_mate = (gender == Gender::kFemale && other.gender == Gender::kMale) ||
                            (gender == Gender::kMale && other.gender == Gender::kFemale) ||
                            (gender == Gender::kHermaphroditic && other.gender == Gender::kHermaphroditic);
  return genders_mate && type == other.type && size == other.size;
}

ModuleRole ModuleType::role() const {
  if (has_connector(*this, kBaseConnector)) return ModuleRole::kBase;
  if (has_connector(*this, kTipConnector)) return ModuleRole::kEndEffector;
  const bool moves = std::any_of(joints.begin(), joints.end(), [](const ModuleJoint& joint) { return !joint.fixed; });
  return moves ? ModuleRole::kJoint : ModuleRole::kLink;
}

ModuleLibrary::ModuleLibrary(std::string name, std::vector<ModuleType> modules, NeighbourRule rule)
    : name_{std::move(name)}, rule_{rule} {
  std::set<std::string> ids;
  bool has_base = false;
  for (ModuleType& module : modules) {
    if (!ids.insert(module.id).second) refuse(module, "another module has the same ID");
    check_parameters(module);
    check_bodies(module);
    check_joints(module);
    const Ends module_ends = ends(module);
    check_serial(module, module_ends[0].body, module_ends[1].body);
    if (module.role() == ModuleRole::kBase) {
      if (has_base) refuse(module, fmt::format("is a second base beside '{}' (limit 1)", base_.id));
      if (!module.parameters.empty()) refuse(module, "is a base with parameters, which is not supported");
      has_base = true;
      const int ground = module_ends[0].mate < 0 ? 0 : 1;
      ground_end_ = module_ends[static_cast<std::size_t>(ground)];
      base_end_ = module_ends[static_cast<std::size_t>(1 - ground)];
      base_ = std::move(module);
      continue;
    }
    if (module.role() == ModuleRole::kEndEffector) has_end_effectors_ = true;
    ends_.push_back(module_ends);
    types_.push_back(std::move(module));
  }
  if (!has_base) {
    throw std::invalid_argument(fmt::format("library '{}': no module has a connector of type 'base'", name_));
  }
}

ModuleLibrary::Ends ModuleLibrary::ends(const ModuleType& module) {
  std::vector<End> found;
  int n_joining = 0;
  for (std::size_t b = 0; b < module.bodies.size(); ++b) {
    const std::vector<Connector>& connectors = module.bodies[b].connectors;
    for (std::size_t c = 0; c < connectors.size(); ++c) {
      End end{static_cast<int>(b), static_cast<int>(c), -1, connectors[c].gender};
      if (connectors[c].type != kBaseConnector && connectors[c].type != kTipConnector) {
        std::pair<std::string, std::vector<double>> mate{connectors[c].type, connectors[c].size};
        const auto known = std::find(mates_.begin(), mates_.end(), mate);
        end.mate = static_cast<int>(known - mates_.begin());
        if (known == mates_.end()) mates_.push_back(std::move(mate));
        ++n_joining;
      }
      found.push_back(end);
    }
  }
  if (found.size() != 2) {
    refuse(module, fmt::format("has {} connectors: only modules with two are supported", found.size()));
  }
  if (n_joining == 0) refuse(module, "has no connector that another module could join");
  return {found[0], found[1]};
}

const ModuleType& ModuleLibrary::type(int k) const {
  if (k < 0 || k >= n_types()) {
    throw std::invalid_argument(fmt::format("library '{}': type {} is not in [0, {})", name_, k, n_types()));
  }
  return types_[static_cast<std::size_t>(k)];
}

const ModuleLibrary::Ends& ModuleLibrary::ends_of(int k) const {
  static_cast<void>(type(k));  // checks k
  return ends_[static_cast<std::size_t>(k)];
}

std::optional<int> ModuleLibrary::find(std::string_view id) const {
  for (int k = 0; k < n_types(); ++k) {
    if (types_[static_cast<std::size_t>(k)].id == id) return k;
  }
  for (int k = 0; k < n_types(); ++k) {
    if (types_[static_cast<std::size_t>(k)].name == id) return k;
  }
  return std::nullopt;
}

int ModuleLibrary::max_parameters() const {
  int most = 0;
  for (const ModuleType& module : types_) most = std::max(most, module.n_parameters());
  return most;
}

int ModuleLibrary::entry(const End& previous, int k) const {
  const Ends& module_ends = ends_of(k);
  if (previous.mate < 0) return -1;
  for (int e = 0; e < 2; ++e) {
    const End& end = module_ends[static_cast<std::size_t>(e)];
    if (end.mate != previous.mate) continue;
    const bool both_hermaphroditic =
        end.gender == Gender::kHermaphroditic && previous.gender == Gender::kHermaphroditic;
    const bool opposite = end.gender != previous.gender && end.gender != Gender::kHermaphroditic &&
                          previous.gender != Gender::kHermaphroditic;
    if (both_hermaphroditic || opposite) return e;
  }
  return -1;
}

std::optional<ModuleLibrary::Coupling> ModuleLibrary::coupling_after(const Coupling& free, int k) const {
  const int e = entry({.mate = free.mate, .gender = free.gender}, k);
  if (e < 0) return std::nullopt;
  const End& end = ends_of(k)[static_cast<std::size_t>(1 - e)];
  return Coupling{end.mate, end.gender};
}

ModuleLibrary::Passage ModuleLibrary::base_passage() const {
  return {ground_end_.body, ground_end_.connector, base_end_.body, base_end_.connector};
}

std::optional<ModuleLibrary::Passage> ModuleLibrary::passage(const Coupling& free, int k) const {
  const int e = entry({.mate = free.mate, .gender = free.gender}, k);
  if (e < 0) return std::nullopt;
  const End& in = ends_of(k)[static_cast<std::size_t>(e)];
  const End& out = ends_of(k)[static_cast<std::size_t>(1 - e)];
  return Passage{in.body, in.connector, out.body, out.connector};
}

std::optional<ModuleLibrary::End> ModuleLibrary::free_end(std::span<const int> types) const {
  End free = base_end_;
  for (const int k : types) {
    const int e = entry(free, k);
    if (e < 0) return std::nullopt;
    free = ends_of(k)[static_cast<std::size_t>(1 - e)];
  }
  return free;
}

std::vector<int> ModuleLibrary::successors(std::span<const int> types) const {
  const std::optional<End> free = free_end(types);
  if (!free) throw std::invalid_argument(fmt::format("library '{}': the modules do not fit together", name_));
  std::vector<int> result;
  for (int k = 0; k < n_types(); ++k) {
    if (entry(*free, k) >= 0) result.push_back(k);
  }
  return result;
}

bool ModuleLibrary::fits_together(std::span<const int> types) const { return free_end(types).has_value(); }

bool ModuleLibrary::complete(std::span<const int> types) const {
  if (!has_end_effectors_) return true;
  return !types.empty() && type(types.back()).role() == ModuleRole::kEndEffector;
}

int ModuleLibrary::entry_or_throw(const End& previous, std::span<const int> types, std::size_t i) const {
  const int e = entry(previous, types[i]);
  if (e < 0) {
    throw std::invalid_argument(fmt::format("placement {}: module '{}' does not fit '{}'", i, type(types[i]).id,
                                            i == 0 ? base_.id : type(types[i - 1]).id));
  }
  return e;
}

std::vector<std::pair<std::string, std::string>> ModuleLibrary::connections(std::span<const int> types) const {
  std::vector<std::pair<std::string, std::string>> result;
  const ModuleType* before = &base_;
  End free = base_end_;
  for (std::size_t i = 0; i < types.size(); ++i) {
    const ModuleType& module = type(types[i]);
    const int e = entry_or_throw(free, types, i);
    const End& in = ends_of(types[i])[static_cast<std::size_t>(e)];
    result.emplace_back(connector_at(*before, free.body, free.connector).id,
                        connector_at(module, in.body, in.connector).id);
    free = ends_of(types[i])[static_cast<std::size_t>(1 - e)];
    before = &module;
  }
  return result;
}

const std::string& ModuleLibrary::ground_connector() const {
  return connector_at(base_, ground_end_.body, ground_end_.connector).id;
}

Chain ModuleLibrary::assemble(std::span<const int> types, const Eigen::Isometry3d& X_WB) const {
  int n_parameters = 0;
  for (const int k : types) n_parameters += type(k).n_parameters();
  const auto connector = [](const ModuleType& module, const End& end) -> const Connector& {
    return connector_at(module, end.body, end.connector);
  };

  Assembly assembly{n_parameters, X_WB};
  assembly.add(base_, -1, connector(base_, ground_end_), ground_end_.body, connector(base_, base_end_), base_end_.body);
  End free = base_end_;
  for (std::size_t i = 0; i < types.size(); ++i) {
    const ModuleType& module = type(types[i]);
    const int e = entry_or_throw(free, types, i);
    const End& in = ends_of(types[i])[static_cast<std::size_t>(e)];
    const End& out = ends_of(types[i])[static_cast<std::size_t>(1 - e)];
    assembly.add(module, static_cast<int>(i), connector(module, in), in.body, connector(module, out), out.body);
    free = out;
  }
  return assembly.chain(rule_);
}

}  // namespace modsearch
