#include <gtest/gtest.h>

#include <modsearch/kinematics/arm.hpp>
#include <modsearch/kinematics/inertial.hpp>
#include <modsearch/problem/convert.hpp>
#include <modsearch/problem/files.hpp>
#include <modsearch/problem/frozen_design.hpp>
#include <nlohmann/json.hpp>

#include "places.hpp"
#include "problem/temporary_folder.hpp"

namespace modsearch {
namespace {

Design some_arm(const ModuleLibrary& library) {
  const auto type = [&](const char* id) { return *library.find(id); };
  Design design;
  design.modules.push_back({type("drive_120_inline"), Parameters(0)});
  design.modules.push_back({type("link_120"), Eigen::Vector2d{0.43, 0.8}});
  design.modules.push_back({type("drive_120_bent"), Parameters(0)});
  design.modules.push_back({type("link_120"), Eigen::Vector2d{0.21, -1.9}});
  design.modules.push_back({type("drive_120_bent"), Parameters(0)});
  design.modules.push_back({type("adapter_120_60"), Parameters(0)});
  design.modules.push_back({type("elbow_60"), Eigen::Vector2d{0.17, 0.9}});
  design.modules.push_back({type("gripper_60"), Parameters(0)});
  return design;
}

/// Tip, shapes, masses and inertias of both arms at a posture.
void expect_same(const Chain& a, const Eigen::VectorXd& x, const Chain& b, double tolerance) {
  const Arm moving = a.at(x);
  const Arm frozen_arm = b.at(Eigen::VectorXd(0));
  ASSERT_EQ(a.n_joints(), b.n_joints());
  ASSERT_EQ(a.bodies().size(), b.bodies().size());
  EXPECT_EQ(a.self_pairs(), b.self_pairs());
  const Eigen::VectorXd q = Eigen::VectorXd::LinSpaced(a.n_joints(), -0.7, 1.1);
  EXPECT_LE((moving.forward(q).tip.matrix() - frozen_arm.forward(q).tip.matrix()).cwiseAbs().maxCoeff(), tolerance);
  ASSERT_EQ(moving.geometries().size(), frozen_arm.geometries().size());
  for (std::size_t i = 0; i < moving.geometries().size(); ++i) {
    EXPECT_LE((moving.geometries()[i].X_FG.matrix() - frozen_arm.geometries()[i].X_FG.matrix()).norm(), tolerance);
    EXPECT_NEAR(moving.geometries()[i].bounding_radius, frozen_arm.geometries()[i].bounding_radius, tolerance);
  }
  for (std::size_t i = 0; i < a.bodies().size(); ++i) {
    const Inertial before = inertial(a.bodies()[i], x);
    const Inertial after = inertial(b.bodies()[i], Eigen::VectorXd(0));
    EXPECT_NEAR(before.mass, after.mass, tolerance);
    EXPECT_LE((before.p_FC - after.p_FC).norm(), tolerance);
    EXPECT_LE((before.inertia - after.inertia).norm(), tolerance);
  }
  for (int j = 0; j < a.n_joints(); ++j) {
    const auto at = static_cast<std::size_t>(j);
    EXPECT_EQ(a.joints()[at].peak_torque, b.joints()[at].peak_torque);
    EXPECT_EQ(a.joints()[at].upper, b.joints()[at].upper);
  }
}

TEST(FrozenDesign, IsTheSameArmOfModulesWithoutParameters) {
  const auto library = load_library("workshop");
  const Design design = some_arm(*library);
  const FrozenDesign ice = frozen(*library, design);
  EXPECT_EQ(ice.library->max_parameters(), 0);
  EXPECT_EQ(ice.library->n_types(), 7);  // two links differ, the bent drives do not
  EXPECT_EQ(ice.library->type(ice.design.modules[1].type).id, "link_120@2");
  EXPECT_EQ(ice.design.modules[2].type, ice.design.modules[4].type);
  expect_same(library->assemble(design.types()), design.parameters(), ice.library->assemble(ice.design.types()), 1e-12);
  EXPECT_TRUE(ice.library->complete(ice.design.types()));
}

TEST(FrozenDesign, WrittenAsTimorJsonReadsBackEqual) {
  const auto library = load_library("workshop");
  const Design design = some_arm(*library);
  const test::TemporaryFolder folder;
  const std::string file = folder.write("design.json", design_to_json(*library, design)).string();
  const std::string text = convert(file, {.to = FileFormat::kTimor, .library = "workshop"});
  for (const char* ours : {"\"parameter\"", "\"uniform\"", "\"angle\""}) {
    EXPECT_EQ(text.find(ours), std::string::npos) << ours;
  }
  const auto read = load_library(folder.write("modules.json", text).string());
  std::vector<int> types;
  for (const Placement& placement : frozen(*library, design).design.modules) types.push_back(placement.type);
  expect_same(library->assemble(design.types()), design.parameters(), read->assemble(types), 1e-9);
}

}  // namespace
}  // namespace modsearch
