#include <fmt/format.h>

#include <modsearch/kinematics/inertial.hpp>
#include <modsearch/problem/frozen_design.hpp>

namespace modsearch {
namespace {

ModuleBody frozen_body(const ModuleBody& body, const Eigen::VectorXd& x) {
  ModuleBody result = body;
  result.mass = body.mass.at(x);
  result.r_com = body.r_com.at(x);
  if (body.uniform_inertia) {
    const Body alone{body.id, 0, 0, body.mass, body.collision, {ParametricPose{}, body.r_com}};
    result.inertia = inertial(alone, x).inertia;
    result.uniform_inertia = false;
  }
  for (Connector& connector : result.connectors) connector.X_BC = connector.X_BC.at(x);
  for (BodyGeometry& geometry : result.collision) {
    for (AffineScalar& size : geometry.shape.size) size = size.at(x);
    geometry.X_FG = geometry.X_FG.at(x);
  }
  return result;
}

ModuleJoint frozen_joint(const ModuleJoint& joint, const Eigen::VectorXd& x) {
  ModuleJoint result = joint;
  const Eigen::Isometry3d turn{Eigen::AngleAxisd{joint.angle.at(x), Eigen::Vector3d::UnitZ()}};
  result.X_PJ = joint.X_PJ.at(x) * turn;
  result.X_JC = joint.X_JC.at(x);
  result.angle = 0.0;
  return result;
}

ModuleType frozen_module(const ModuleType& module, const Eigen::VectorXd& x, std::string id) {
  ModuleType result{std::move(id), module.name, module.cost, {}, {}, {}};
  for (const ModuleBody& body : module.bodies) result.bodies.push_back(frozen_body(body, x));
  for (const ModuleJoint& joint : module.joints) result.joints.push_back(frozen_joint(joint, x));
  return result;
}

std::shared_ptr<const ModuleLibrary> library_of(const ModuleLibrary& like, std::vector<ModuleType> modules) {
  return std::make_shared<const ModuleLibrary>(like.name(), std::move(modules), like.neighbour_rule());
}

}  // namespace

FrozenDesign frozen(const ModuleLibrary& library, const Design& design) {
  check(library, design);
  std::vector<ModuleType> modules{frozen_module(library.base(), Eigen::VectorXd(0), library.base().id)};
  std::vector<std::string> ids;
  for (const Placement& placement : design.modules) {
    const ModuleType& module = library.type(placement.type);
    const bool parametric = module.n_parameters() > 0;
    const std::string place = parametric ? fmt::format("@{}", ids.size() + 1) : "";
    ids.push_back(module.id + place);
    const bool known =
        std::any_of(modules.begin(), modules.end(), [&](const auto& each) { return each.id == ids.back(); });
    if (!known) {
      modules.push_back(frozen_module(module, Eigen::VectorXd(placement.parameters), ids.back()));
      modules.back().name += place;  // names are told apart like IDs
    }
  }
  FrozenDesign result;
  result.library = library_of(library, std::move(modules));
  for (const std::string& id : ids) result.design.modules.push_back({*result.library->find(id), Parameters(0)});
  return result;
}

std::shared_ptr<const ModuleLibrary> frozen(const ModuleLibrary& library) {
  const Eigen::VectorXd none(0);
  std::vector<ModuleType> modules{frozen_module(library.base(), none, library.base().id)};
  for (int k = 0; k < library.n_types(); ++k) {
    const ModuleType& module = library.type(k);
    if (module.n_parameters() > 0) throw std::invalid_argument(fmt::format("module '{}' has parameters", module.id));
    modules.push_back(frozen_module(module, none, module.id));
  }
  return library_of(library, std::move(modules));
}

}  // namespace modsearch
