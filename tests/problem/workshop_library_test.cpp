#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <modsearch/kinematics/inertial.hpp>
#include <modsearch/problem/files.hpp>
#include <modsearch/problem/sequence_count.hpp>
#include <nlohmann/json.hpp>
#include <numbers>
#include <set>

#include "places.hpp"
#include "problem/temporary_folder.hpp"

namespace modsearch {
namespace {

using ::testing::UnorderedElementsAre;

class Workshop : public ::testing::Test {
 protected:
  [[nodiscard]] int type(const std::string& id) const { return library_->find(id).value(); }
  [[nodiscard]] std::vector<int> types(const std::vector<std::string>& ids) const {
    std::vector<int> result;
    for (const std::string& id : ids) result.push_back(type(id));
    return result;
  }
  [[nodiscard]] std::vector<std::string> after(const std::vector<std::string>& ids) const {
    std::vector<std::string> result;
    for (const int k : library_->successors(types(ids))) result.push_back(library_->type(k).id);
    return result;
  }

  std::shared_ptr<const ModuleLibrary> library_ = load_library("workshop");
};

TEST_F(Workshop, HasDrivesInThreeSizesInLineAndBentThatGrowWeakerLighterAndFaster) {
  for (const char* form : {"inline", "bent"}) {
    const ModuleType* larger = nullptr;
    for (const char* size : {"120", "90", "60"}) {
      const ModuleType& drive = library_->type(type(std::string{"drive_"} + size + "_" + form));
      EXPECT_EQ(drive.role(), ModuleRole::kJoint);
      ASSERT_EQ(drive.joints.size(), 1U);
      const auto mass = [](const ModuleType& module) {
        return module.bodies[0].mass.offset + module.bodies[1].mass.offset;
      };
      if (larger != nullptr) {
        EXPECT_LT(drive.joints[0].joint.peak_torque, larger->joints[0].joint.peak_torque);
        EXPECT_GT(drive.joints[0].joint.velocity, larger->joints[0].joint.velocity);
        EXPECT_LT(mass(drive), mass(*larger));
        EXPECT_LT(drive.cost, larger->cost);
      }
      larger = &drive;
    }
  }
}

TEST_F(Workshop, GoesFromLargeToSmallThroughAdaptersAndNeverBack) {
  EXPECT_THAT(after({}), UnorderedElementsAre("drive_120_inline", "drive_120_bent", "lift_120", "link_120", "elbow_120",
                                              "adapter_120_90", "adapter_120_60", "gripper_120"));
  EXPECT_THAT(after({"adapter_120_90"}), UnorderedElementsAre("drive_90_inline", "drive_90_bent", "link_90", "elbow_90",
                                                              "adapter_90_60", "gripper_90"));
  EXPECT_THAT(after({"adapter_120_90", "adapter_90_60"}),
              UnorderedElementsAre("drive_60_inline", "drive_60_bent", "link_60", "elbow_60", "gripper_60"));
  EXPECT_THAT(after({"gripper_120"}), UnorderedElementsAre());
}

TEST_F(Workshop, EndsInAGripper) {
  EXPECT_FALSE(library_->complete(types({"drive_120_inline", "link_120"})));
  EXPECT_TRUE(library_->complete(types({"drive_120_inline", "link_120", "gripper_120"})));
}

TEST_F(Workshop, StretchesAsTheLengthsOfItsModulesSay) {
  // Straight up: plate 0.1, drive in line 0.2, lift 0.5 + q, link 0.7, bent drive 0.15 + 0.15, gripper 0.22.
  const std::vector<int> all = types({"drive_120_inline", "lift_120", "link_120", "drive_120_bent", "gripper_120"});
  const Chain chain = library_->assemble(all);
  ASSERT_EQ(chain.n_joints(), 3);
  EXPECT_EQ(chain.joints()[1].type, JointType::kPrismatic);
  const Arm arm = chain.at(Eigen::Vector2d{0.7, 0.3});
  const Eigen::Isometry3d tip = arm.forward(Eigen::Vector3d{0.2, 0.15, 0.0}).tip;
  EXPECT_LE((tip.translation() - Eigen::Vector3d{0.0, 0.0, 0.1 + 0.2 + 0.65 + 0.7 + 0.3 + 0.22}).norm(), 1e-12);
  // The drive and the twist turn about one line.
  EXPECT_LE((tip.linear().col(0) - Eigen::Vector3d{std::cos(0.5), std::sin(0.5), 0.0}).norm(), 1e-12);
}

TEST_F(Workshop, BendsALinkByItsParameter) {
  // Near arm 1.2 x 0.06 up, bent about x, then 0.2 m and the gripper's 0.14 m along -y and up.
  const std::vector<int> all = types({"adapter_120_60", "elbow_60", "gripper_60"});
  const Chain chain = library_->assemble(all);
  for (const double bend : {0.3, std::numbers::pi / 2.0}) {
    const Eigen::Vector3d tip = chain.at(Eigen::Vector2d{0.2, bend}).forward(Eigen::VectorXd(0)).tip.translation();
    const Eigen::Vector3d expected{0.0, -0.34 * std::sin(bend), 0.1 + 0.1 + 0.072 + 0.34 * std::cos(bend)};
    EXPECT_LE((tip - expected).norm(), 1e-12);
  }
}

TEST_F(Workshop, HasBodiesThatExist) {
  // Every module at the ends and the middle of its parameters; what weighs can be a rigid body, and its inertia is
  // about that of its solid shapes where the file gives it as numbers.
  for (int k = 0; k < library_->n_types(); ++k) {
    const ModuleType& module = library_->type(k);
    for (const double share : {0.0, 0.5, 1.0}) {
      Eigen::VectorXd x(module.n_parameters());
      for (int i = 0; i < module.n_parameters(); ++i) {
        const ParameterRange& range = module.parameters[static_cast<std::size_t>(i)];
        x[i] = range.lower + share * (range.upper - range.lower);
      }
      for (const ModuleBody& each : module.bodies) {
        const Body body{each.id,
                        0,
                        0,
                        each.mass,
                        each.collision,
                        {ParametricPose{}, each.r_com, each.uniform_inertia, each.inertia}};
        const Inertial given = inertial(body, x);
        EXPECT_TRUE(physical(given)) << module.id << "." << each.id;
        std::vector<PlacedShape> shapes;
        for (const BodyGeometry& geometry : each.collision)
          shapes.push_back({geometry.shape.at(x), geometry.X_FG.at(x)});
        const Inertial even = evenly_spread(given.mass, shapes).value();
        if (each.uniform_inertia) continue;
        EXPECT_LE((given.p_FC - even.p_FC).norm(), 1e-5) << module.id << "." << each.id;
        EXPECT_LE((given.inertia - even.inertia).cwiseAbs().maxCoeff(),
                  1e-5 * even.inertia.cwiseAbs().maxCoeff() + 1e-8)
            << module.id << "." << each.id;
      }
    }
  }
}

TEST_F(Workshop, DoesNotTouchItselfWhileEachBentDriveTurnsAlone) {
  // Limits of 2.3 rad: the two tubes at a bent drive stay apart.
  for (const auto& ids :
       std::vector<std::vector<std::string>>{{"link_120", "drive_120_bent", "link_120", "gripper_120"},
                                             {"adapter_120_90", "link_90", "drive_90_bent", "link_90", "gripper_90"},
                                             {"adapter_120_60", "link_60", "drive_60_bent", "link_60", "gripper_60"}}) {
    const Chain chain = library_->assemble(types(ids));
    const ParameterBox box = parameter_box(*library_, types(ids));
    const Arm arm = chain.at(box.upper);
    ASSERT_EQ(arm.n_joints(), 1);
    Work work;
    for (int i = 0; i <= 100; ++i) {
      const double q = chain.lower_limits()[0] + i / 100.0 * (chain.upper_limits()[0] - chain.lower_limits()[0]);
      const Posture posture = arm.forward(Eigen::VectorXd::Constant(1, q));
      EXPECT_GT(self_clearance(arm, posture, work), 0.0) << ids[1] << " at " << q;
    }
  }
}

TEST_F(Workshop, IsBuiltInExactlyAsItLiesInTheDataFolder) {
  const auto file = load_library((test::source_folder() / "data/libraries/workshop.json").string());
  ASSERT_EQ(library_->n_types(), file->n_types());
  EXPECT_EQ(library_->n_types(), 19);
  for (int k = 0; k < file->n_types(); ++k) EXPECT_EQ(library_->type(k).id, file->type(k).id);
}

}  // namespace
}  // namespace modsearch
