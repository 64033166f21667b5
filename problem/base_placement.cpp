#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <modsearch/problem/base_placement.hpp>
#include <stdexcept>

namespace modsearch {
namespace {

constexpr std::string_view kBaseConnector = "base";
constexpr const char* kPlace = "placement";  // connector type and joint by which the base stands

// Half a turn about x, which joining two connectors inserts.
Eigen::Isometry3d facing() {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.linear() = Eigen::Vector3d(1.0, -1.0, -1.0).asDiagonal();
  return X;
}

// A connector whose mate is at `X_BM`: joining turns by half a turn.
Connector connector(const char* id, const Eigen::Isometry3d& X_BM, std::string type) {
  return {.id = id, .X_BC = X_BM, .gender = Gender::kHermaphroditic, .type = std::move(type), .size = {}};
}

// What the base stands on: its pose is the base's nominal one.
ModuleType ground_for(const ModuleType& base) {
  ModuleType ground;
  ground.id = base.id + "@ground";
  ground.name = "ground";
  ModuleBody body;
  body.id = "ground";
  body.connectors = {connector("ground", facing(), std::string{kBaseConnector}),
                     connector("place", Eigen::Isometry3d::Identity(), kPlace)};
  ground.bodies = {std::move(body)};
  return ground;
}

AffineScalar parameter_or_constant(ModuleType& module, const char* name, const char* unit,
                                   const BasePlacement::Interval& interval) {
  if (!std::isfinite(interval.lower) || !std::isfinite(interval.upper) || interval.lower > interval.upper) {
    throw std::invalid_argument(fmt::format("placement of base '{}': {} in [{}, {}] is not a finite interval",
                                            module.id, name, interval.lower, interval.upper));
  }
  if (interval.lower == interval.upper) return interval.lower;
  module.parameters.push_back({name, unit, interval.lower, interval.upper});
  return AffineScalar::of_parameter(module.n_parameters() - 1);
}

}  // namespace

bool BasePlacement::fixed() const {
  const auto point = [](const Interval& interval) { return interval.lower == interval.upper; };
  return point(x) && point(y) && point(z) && point(yaw);
}

ModuleLibrary with_placed_base(const ModuleLibrary& library, const BasePlacement& placement) {
  ModuleType base = library.base();
  const ModuleType ground = ground_for(base);
  const AffineVector along_T{parameter_or_constant(base, "x", "m", placement.x),
                             parameter_or_constant(base, "y", "m", placement.y),
                             parameter_or_constant(base, "z", "m", placement.z)};
  ModuleJoint joint;
  joint.joint.name = kPlace;
  joint.fixed = true;
  joint.angle = parameter_or_constant(base, "yaw", "rad", placement.yaw);
  joint.X_PJ = AffinePose{Eigen::Matrix3d::Identity(), along_T.rotated(placement.R_TN.transpose())};
  joint.parent = static_cast<int>(base.bodies.size());
  std::string ground_id;
  for (std::size_t b = 0; b < base.bodies.size(); ++b) {
    std::vector<Connector>& connectors = base.bodies[b].connectors;
    const auto ground_end = std::find_if(connectors.begin(), connectors.end(),
                                         [](const Connector& each) { return each.type == kBaseConnector; });
    if (ground_end == connectors.end()) continue;
    joint.child = static_cast<int>(b);
    ground_id = ground_end->id;  // by which files say that the base stands on the ground
    joint.X_JC = AffinePose{facing()} * ground_end->X_BC.inverse();
    connectors.erase(ground_end);
    break;
  }
  ModuleBody place;
  place.id = kPlace;
  place.connectors = {connector(ground_id.c_str(), facing(), kPlace)};
  base.bodies.push_back(std::move(place));
  base.joints.push_back(std::move(joint));

  std::vector<ModuleType> modules{ground, std::move(base)};
  for (int k = 0; k < library.n_types(); ++k) modules.push_back(library.type(k));
  return {library.name(), std::move(modules), library.neighbour_rule()};
}

Eigen::Isometry3d placement_of(const ModuleType& base, const Eigen::VectorXd& parameters) {
  const ModuleJoint& joint = base.joints.back();
  return joint.X_PJ.at(parameters) * Eigen::AngleAxisd{joint.angle.at(parameters), Eigen::Vector3d::UnitZ()};
}

}  // namespace modsearch
