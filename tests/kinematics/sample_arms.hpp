#pragma once

// Arms and scenes that several tests share: chains of the `seed` modules, written out by hand.

#include <algorithm>
#include <modsearch/kinematics/arm.hpp>
#include <modsearch/kinematics/scene.hpp>
#include <numbers>
#include <random>
#include <string>

namespace modsearch::sample {

constexpr double kPi = std::numbers::pi;
constexpr double kRadius = 0.055;  // of every cylinder [m]

inline Eigen::Isometry3d translation(double x, double y, double z) {
  return Eigen::Isometry3d{Eigen::Translation3d{x, y, z}};
}

inline Eigen::Isometry3d rotation_about_y(double angle) {
  return Eigen::Isometry3d{Eigen::AngleAxisd{angle, Eigen::Vector3d::UnitY()}};
}

/// The chain of the `seed` modules named by `types`, one letter each: h(inge), r(otary), l(ink), on the turning base.
/// Every module takes its lengths from x in turn: two for h and r (proximal, distal), one for l.
inline Chain seed_chain(const std::string& types, double limit = kPi) {
  const auto links = static_cast<int>(std::count(types.begin(), types.end(), 'l'));
  ChainBuilder builder{2 * static_cast<int>(types.size()) - links};
  const auto along_z = [](const AffineScalar& length) {
    return AffinePose{Eigen::Matrix3d::Identity(), AffineVector{0.0, 0.0, length}};
  };
  // A cylinder as long as parameter `length`, from `start` along z of the current frame.
  const auto cylinder = [&](const std::string& name, int module, int length, double start) {
    const AffineShape shape{AffineShape::Kind::kCylinder, {kRadius, AffineScalar::of_parameter(length)}, nullptr};
    return builder.body(name, module, AffineScalar::of_parameter(length),
                        {{shape, along_z(AffineScalar::of_parameter(length, 0.5, start))}});
  };
  builder.joint({.name = "base", .lower = -limit, .upper = limit});
  int parameter = 0;
  for (int module = 0; module < static_cast<int>(types.size()); ++module) {
    const char type = types[static_cast<std::size_t>(module)];
    std::string name{type};
    name += std::to_string(module);
    const int proximal = parameter++;
    const int inner = cylinder(name + " proximal", module, proximal, 0.0);
    builder.move(along_z(AffineScalar::of_parameter(proximal)));
    if (type == 'l') continue;
    const int distal = parameter++;
    const Joint joint{.name = name, .lower = -limit, .upper = limit};
    if (type == 'h') {
      builder.move(rotation_about_y(kPi / 2)).joint(joint, inner, inner + 1).move(rotation_about_y(-kPi / 2));
      cylinder(name + " distal", module, distal, 0.0);
      builder.move(along_z(AffineScalar::of_parameter(distal)));
    } else {
      builder.joint(joint, inner, inner + 1).move(translation(0, 0, kRadius));
      builder.move(Eigen::Isometry3d{Eigen::AngleAxisd{kPi / 2, Eigen::Vector3d::UnitX()}});
      cylinder(name + " distal", module, distal, -kRadius);
      builder.move(along_z(AffineScalar::of_parameter(distal, 1.0, -kRadius)));
    }
  }
  return builder.build();
}

inline Eigen::VectorXd random_joints(const Chain& chain, std::mt19937& generator) {
  Eigen::VectorXd q(chain.n_joints());
  for (Eigen::Index j = 0; j < q.size(); ++j) {
    const Joint& joint = chain.joints()[static_cast<std::size_t>(j)];
    q[j] = std::uniform_real_distribution<double>{joint.lower, joint.upper}(generator);
  }
  return q;
}

/// Three obstacles as in seed/random_obstacles, and one of every other shape but a mesh.
inline Scene mixed_scene() {
  const Eigen::Isometry3d leaning = translation(-0.8, -0.6, 1.0) * rotation_about_y(0.7);
  return Scene{{{"spheres", {{Sphere{0.3}, translation(-0.5, 0.5, 1.2)}, {Sphere{0.2}, translation(0.3, 0.3, 0.9)}}},
                {"box", {{Box{{0.3, 0.4, 0.5}}, translation(0.7, 0.6, 0.5)}}},
                {"pole", {{Cylinder{0.1, 1.0}, leaning}}},
                {"rail", {{Capsule{0.08, 1.2}, translation(0.6, -0.9, 0.8) * rotation_about_y(1.4)}}}}};
}

}  // namespace modsearch::sample
