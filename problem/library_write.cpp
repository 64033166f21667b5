#include <fmt/format.h>

#include <cmath>
#include <modsearch/problem/library_write_internal.hpp>
#include <modsearch/problem/relative_path_internal.hpp>

namespace modsearch::detail {
namespace {

using nlohmann::ordered_json;

/// Stands where a bare Infinity is to stand in the text.
const std::string kInfinityMark = "\u0001Infinity";

/// Writes one module: its parameters by their names.
class ModuleWriter {
 public:
  ModuleWriter(const ModuleType& module, const LibraryStyle& style) : module_{module}, style_{style} {}

  [[nodiscard]] ordered_json module() const {
    ordered_json out;
    out["header"] = {{"ID", module_.id}, {"name", module_.name}, {"cost", module_.cost}};
    for (const ParameterRange& range : module_.parameters) {
      out["parameters"].push_back(
          {{"name", range.name}, {"unit", range.unit}, {"lower", range.lower}, {"upper", range.upper}});
    }
    out["bodies"] = ordered_json::array();
    for (const ModuleBody& each : module_.bodies) out["bodies"].push_back(body(each));
    out["joints"] = ordered_json::array();
    for (const ModuleJoint& each : module_.joints) out["joints"].push_back(joint(each));
    return out;
  }

 private:
  [[nodiscard]] ordered_json number(double offset, const std::vector<AffineScalar::Term>& terms) const {
    if (terms.empty()) return offset + 0.0;
    if (terms.size() > 1) {
      throw std::invalid_argument(
          fmt::format("module '{}': a number depends on {} parameters (limit 1)", module_.id, terms.size()));
    }
    return {{"parameter", module_.parameters[static_cast<std::size_t>(terms[0].parameter)].name},
            {"scale", terms[0].scale},
            {"offset", offset + 0.0}};
  }
  [[nodiscard]] ordered_json number(const AffineScalar& affine) const { return number(affine.offset, affine.terms); }

  [[nodiscard]] ordered_json component(const AffineVector& vector, Eigen::Index axis) const {
    std::vector<AffineScalar::Term> terms;
    for (const AffineVector::Term& term : vector.terms) {
      if (term.direction[axis] != 0.0) terms.push_back({term.parameter, term.direction[axis]});
    }
    return number(vector.offset[axis], terms);
  }

  [[nodiscard]] ordered_json pose(const AffinePose& X) const {
    ordered_json rows = ordered_json::array();
    for (Eigen::Index i = 0; i < 3; ++i) {
      ordered_json row = ordered_json::array();
      for (Eigen::Index j = 0; j < 3; ++j) row.push_back(X.rotation(i, j) + 0.0);
      row.push_back(component(X.translation, i));
      rows.push_back(std::move(row));
    }
    rows.push_back({0, 0, 0, 1});
    return rows;
  }

  [[nodiscard]] ordered_json geometry(const BodyGeometry& each) const {
    const std::vector<AffineScalar>& size = each.shape.size;
    ordered_json out;
    switch (each.shape.kind) {
      case AffineShape::Kind::kSphere:
        out = {{"type", "sphere"}, {"parameters", {{"r", number(size[0])}}}};
        break;
      case AffineShape::Kind::kBox:
        out = {{"type", "box"},
               {"parameters", {{"x", number(size[0])}, {"y", number(size[1])}, {"z", number(size[2])}}}};
        break;
      case AffineShape::Kind::kCylinder:
        out = {{"type", "cylinder"}, {"parameters", {{"r", number(size[0])}, {"z", number(size[1])}}}};
        break;
      case AffineShape::Kind::kCapsule:
        throw std::invalid_argument(fmt::format("module '{}': the format has no capsules", module_.id));
      case AffineShape::Kind::kMesh: {
        const Eigen::Vector3d& scale = each.shape.mesh->scale;
        const bool even = scale[0] == scale[1] && scale[1] == scale[2];
        out = {{"type", "mesh"},
               {"parameters",
                {{"file", relative_to(each.shape.mesh->source, style_.folder)},
                 {"scale", even ? ordered_json(scale[0]) : ordered_json{scale[0], scale[1], scale[2]}}}}};
      }
    }
    out["pose"] = pose(each.X_FG.head);
    return out;
  }

  [[nodiscard]] ordered_json body(const ModuleBody& each) const {
    ordered_json out{{"ID", each.id}, {"mass", number(each.mass)}};
    if (each.uniform_inertia) {
      out["inertia"] = "uniform";
    } else {
      out["inertia"] = ordered_json::array();
      for (Eigen::Index i = 0; i < 3; ++i) out["inertia"].push_back(to_json(Eigen::VectorXd(each.inertia.row(i))));
    }
    out["r_com"] = {component(each.r_com, 0), component(each.r_com, 1), component(each.r_com, 2)};
    out["connectors"] = ordered_json::array();
    for (const Connector& connector : each.connectors) {
      constexpr const char* kGenders[] = {"f", "m", "h"};
      out["connectors"].push_back({{"ID", connector.id},
                                   {"pose", pose(connector.X_BC)},
                                   {"gender", kGenders[static_cast<std::size_t>(connector.gender)]},
                                   {"type", connector.type},
                                   {"size", connector.size}});
    }
    out["collision"] = ordered_json::array();
    for (const BodyGeometry& shape : each.collision) out["collision"].push_back(geometry(shape));
    return out;
  }

  /// A limit, left out where there is none; Timor's files say Infinity.
  void add_limit(const char* key, double limit, ordered_json& out) const {
    if (std::isfinite(limit)) {
      out[key] = limit;
    } else if (style_.bare_infinity) {
      out[key] = infinity_mark(limit);
    }
  }

  [[nodiscard]] ordered_json joint(const ModuleJoint& each) const {
    constexpr const char* kTypes[] = {"revolute", "prismatic", "continuous"};
    ordered_json out{{"ID", each.joint.name},
                     {"parent", module_.bodies[static_cast<std::size_t>(each.parent)].id},
                     {"child", module_.bodies[static_cast<std::size_t>(each.child)].id},
                     {"type", each.fixed ? "fixed" : kTypes[static_cast<std::size_t>(each.joint.type)]},
                     {"passive", false},
                     {"poseParent", pose(each.X_PJ)},
                     {"poseChild", pose(each.X_JC)}};
    if (each.fixed) {
      if (!each.angle.terms.empty() || each.angle.offset != 0.0) out["angle"] = number(each.angle);
      if (!style_.bare_infinity) return out;
    } else {
      ordered_json limits = ordered_json::object();
      add_limit("positionLower", each.joint.lower, limits);
      add_limit("positionUpper", each.joint.upper, limits);
      add_limit("peakTorque", each.joint.peak_torque, limits);
      add_limit("velocity", each.joint.velocity, limits);
      add_limit("acceleration", each.joint.acceleration, limits);
      out["limits"] = std::move(limits);
    }
    out["gearRatio"] = each.gear_ratio;
    out["motorInertia"] = each.motor_inertia;
    out["frictionCoulomb"] = each.friction_coulomb;
    out["frictionViscous"] = each.friction_viscous;
    return out;
  }

  const ModuleType& module_;
  const LibraryStyle& style_;
};

}  // namespace

std::string infinity_mark(double limit) { return limit > 0.0 ? kInfinityMark : "-" + kInfinityMark; }

std::string with_bare_infinity(std::string text) {
  const auto replace = [&text](const std::string& mark, std::string_view word) {
    const std::string quoted = ordered_json(mark).dump();
    for (std::size_t at = text.find(quoted); at != std::string::npos; at = text.find(quoted, at)) {
      text.replace(at, quoted.size(), word);
    }
  };
  replace(kInfinityMark, "Infinity");
  replace("-" + kInfinityMark, "-Infinity");
  return text;
}

ordered_json to_json(const ModuleLibrary& library, const LibraryStyle& style) {
  constexpr const char* kRules[] = {"rigid", "via_joint", "rigid_via_joint"};
  ordered_json out{{"ignore_collisions", kRules[static_cast<std::size_t>(library.neighbour_rule())]}};
  out["modules"] = ordered_json::array({ModuleWriter{library.base(), style}.module()});  // {one} is no list to clang
  for (int k = 0; k < library.n_types(); ++k) out["modules"].push_back(ModuleWriter{library.type(k), style}.module());
  return out;
}

}  // namespace modsearch::detail
