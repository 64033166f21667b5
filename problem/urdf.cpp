#include <fmt/format.h>

#include <cmath>
#include <map>
#include <modsearch/kinematics/arm.hpp>
#include <modsearch/kinematics/inertial.hpp>
#include <modsearch/problem/markup.hpp>
#include <modsearch/problem/relative_path_internal.hpp>
#include <modsearch/problem/urdf.hpp>
#include <optional>
#include <stdexcept>

namespace modsearch {
namespace {

constexpr double kUnlimited = 1e9;  // URDF has no word for it

/// A name as an attribute has it. Throws std::invalid_argument for one that XML cannot hold.
std::string attribute(std::string_view what, const std::string& name) {
  if (const std::optional<std::string> character = not_in_markup(name)) {
    throw std::invalid_argument(fmt::format("the name of {} '{}' has the character {}, which XML cannot hold", what,
                                            markup_safe(name), *character));
  }
  return markup_safe(name);
}

/// Three numbers as attributes have them; -0 reads as a slip of the pen.
std::string triple(const Eigen::Vector3d& v) { return fmt::format("{} {} {}", v.x() + 0.0, v.y() + 0.0, v.z() + 0.0); }

/// Roll, pitch and yaw with R = Rz(yaw) Ry(pitch) Rx(roll). Pitch and yaw are those of what roll leaves, so that the
/// three fit together where roll and yaw turn about one line and neither is certain.
Eigen::Vector3d roll_pitch_yaw(const Eigen::Matrix3d& R) {
  const double roll = std::atan2(R(2, 1), R(2, 2));
  const double pitch = std::atan2(-R(2, 0), std::hypot(R(0, 0), R(1, 0)));
  const double s = std::sin(roll);
  const double c = std::cos(roll);
  const double yaw = std::atan2(s * R(0, 2) - c * R(0, 1), c * R(1, 1) - s * R(1, 2));
  return {roll, pitch, yaw};
}

std::string origin(const Eigen::Isometry3d& X) {
  return fmt::format("<origin xyz=\"{}\" rpy=\"{}\"/>", triple(X.translation()), triple(roll_pitch_yaw(X.linear())));
}

Eigen::Isometry3d along_z(double z) { return Eigen::Isometry3d{Eigen::Translation3d{0.0, 0.0, z}}; }

/// A shape in the words of URDF, with the pose that they have in the shape's frame.
struct Primitive {
  std::string text;
  Eigen::Isometry3d X_GP = Eigen::Isometry3d::Identity();
};

Primitive ball(double radius, double z) { return {fmt::format("<sphere radius=\"{}\"/>", radius), along_z(z)}; }

struct Primitives {
  const std::filesystem::path& folder;

  std::vector<Primitive> operator()(const Sphere& sphere) const { return {ball(sphere.radius, 0.0)}; }
  std::vector<Primitive> operator()(const Box& box) const {
    return {{fmt::format("<box size=\"{}\"/>", triple(box.size))}};
  }
  std::vector<Primitive> operator()(const Cylinder& cylinder) const {
    return {{fmt::format("<cylinder radius=\"{}\" length=\"{}\"/>", cylinder.radius, cylinder.length)}};
  }
  std::vector<Primitive> operator()(const Capsule& capsule) const {
    std::vector<Primitive> result = (*this)(Cylinder{capsule.radius, capsule.length});
    for (const double end : {-0.5, 0.5}) result.push_back(ball(capsule.radius, end * capsule.length));
    return result;
  }
  std::vector<Primitive> operator()(const Mesh& mesh) const {
    const std::string file = attribute("mesh", detail::relative_to(mesh.triangles->source, folder));
    return {{fmt::format("<mesh filename=\"{}\" scale=\"{}\"/>", file, triple(mesh.triangles->scale))}};
  }
};

/// The joints of the library by the names that they have in the chain of `design`.
std::map<std::string, const ModuleJoint*> joints_by_name(const ModuleLibrary& library, const Design& design) {
  std::map<std::string, const ModuleJoint*> result;
  const auto add = [&](std::size_t place, const ModuleType& module) {
    for (const ModuleJoint& joint : module.joints) {
      result[fmt::format("{}.{}.{}", place, module.id, joint.joint.name)] = &joint;
    }
  };
  add(0, library.base());
  for (std::size_t i = 0; i < design.modules.size(); ++i) add(i + 1, library.type(design.modules[i].type));
  return result;
}

std::string link_name(int frame) { return frame == 0 ? "base_link" : fmt::format("link_{}", frame); }

std::string inertial_element(const Chain& chain, const Eigen::VectorXd& x, int frame) {
  Inertial link;
  for (const Body& body : chain.bodies()) {
    if (body.frame == frame) link = link + physical_inertial(body, x);
  }
  if (!(link.mass > 0.0)) return {};
  const Eigen::Matrix3d& J = link.inertia;
  return fmt::format(
      "    <inertial>\n      <origin xyz=\"{}\" rpy=\"0 0 0\"/>\n      <mass value=\"{}\"/>\n"
      "      <inertia ixx=\"{}\" ixy=\"{}\" ixz=\"{}\" iyy=\"{}\" iyz=\"{}\" izz=\"{}\"/>\n    </inertial>\n",
      triple(link.p_FC), link.mass, J(0, 0), J(0, 1) + 0.0, J(0, 2) + 0.0, J(1, 1), J(1, 2) + 0.0, J(2, 2));
}

std::string link_element(const Arm& arm, int frame, const UrdfOptions& options) {
  const std::string inertial = inertial_element(arm.chain(), arm.parameters(), frame);
  std::string geometry;
  for (const ArmGeometry& each : arm.geometries()) {
    if (each.frame != frame) continue;
    const std::string name = attribute("body", arm.chain().bodies()[static_cast<std::size_t>(each.body)].name);
    for (const Primitive& primitive : std::visit(Primitives{options.folder}, each.shape)) {
      for (const char* use : {"visual", "collision"}) {
        geometry += fmt::format("    <{} name=\"{}\">\n      {}\n      <geometry>{}</geometry>\n    </{}>\n", use, name,
                                origin(each.X_FG * primitive.X_GP), primitive.text, use);
      }
    }
  }
  if (inertial.empty() && geometry.empty()) return fmt::format("  <link name=\"{}\"/>\n", link_name(frame));
  return fmt::format("  <link name=\"{}\">\n{}{}  </link>\n", link_name(frame), inertial, geometry);
}

std::string fixed_joint(const std::string& name, const std::string& parent, const std::string& child,
                        const Eigen::Isometry3d& X) {
  return fmt::format(
      "  <joint name=\"{}\" type=\"fixed\">\n    {}\n    <parent link=\"{}\"/>\n    <child link=\"{}\"/>\n  </joint>\n",
      name, origin(X), parent, child);
}

double finite(double limit) { return std::isfinite(limit) ? limit : kUnlimited; }

std::string limit_element(const Joint& joint) {
  std::string range;
  if (joint.type != JointType::kContinuous) range = fmt::format("lower=\"{}\" upper=\"{}\" ", joint.lower, joint.upper);
  return fmt::format("    <limit {}effort=\"{}\" velocity=\"{}\"/>\n", range, finite(joint.peak_torque),
                     finite(joint.velocity));
}

std::string type_name(JointType type) {
  switch (type) {
    case JointType::kRevolute:
      return "revolute";
    case JointType::kPrismatic:
      return "prismatic";
    case JointType::kContinuous:
      return "continuous";
  }
  return "";
}

std::string joint_element(const Arm& arm, int j, const ModuleJoint& source) {
  const Joint& joint = arm.chain().joints()[static_cast<std::size_t>(j)];
  std::string text = fmt::format(
      "  <joint name=\"{}\" type=\"{}\">\n    {}\n    <parent link=\"{}\"/>\n    <child link=\"{}\"/>\n"
      "    <axis xyz=\"0 0 1\"/>\n{}",
      attribute("joint", joint.name), type_name(joint.type), origin(arm.segment(j)), link_name(j), link_name(j + 1),
      limit_element(joint));
  if (source.friction_viscous > 0.0 || source.friction_coulomb > 0.0) {
    text += fmt::format("    <dynamics damping=\"{}\" friction=\"{}\"/>\n", source.friction_viscous,
                        source.friction_coulomb);
  }
  return text + "  </joint>\n";
}

}  // namespace

std::string to_urdf(const ModuleLibrary& library, const Design& design, const UrdfOptions& options) {
  check(library, design);
  const std::vector<int> types = design.types();
  const Chain chain = library.assemble(types);
  const Arm arm = chain.at(design.parameters());
  const std::map<std::string, const ModuleJoint*> sources = joints_by_name(library, design);

  std::string text = fmt::format("<?xml version=\"1.0\"?>\n<robot name=\"{}\">\n  <link name=\"world\"/>\n",
                                 attribute("robot", options.name));
  text += fixed_joint("world_to_base", "world", link_name(0), options.X_WB);
  text += link_element(arm, 0, options);
  for (int j = 0; j < chain.n_joints(); ++j) {
    text += joint_element(arm, j, *sources.at(chain.joints()[static_cast<std::size_t>(j)].name));
    text += link_element(arm, j + 1, options);
  }
  text += "  <link name=\"tcp\"/>\n";
  text += fixed_joint("tcp_joint", link_name(chain.n_joints()), "tcp", arm.segment(chain.n_joints()));
  return text + "</robot>\n";
}

}  // namespace modsearch
