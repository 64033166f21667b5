#include <gtest/gtest.h>

#include <kdl/chain.hpp>
#include <kdl/chainfksolverpos_recursive.hpp>
#include <modsearch/kinematics/scene.hpp>
#include <modsearch/problem/files.hpp>
#include <nlohmann/json.hpp>
#include <regex>

#include "problem/temporary_folder.hpp"
#include "places.hpp"

// Arms of Timor's own libraries against KDL, which gets them from the same JSON by rules written down here again.

namespace modsearch {
namespace {

using nlohmann::json;

json library_json(const std::filesystem::path& file) {
  return json::parse(std::regex_replace(test::text_of(file), std::regex{"\\bInfinity\\b"}, "1e300"));
}

KDL::Frame frame(const json& rows) {
  const auto at = [&](std::size_t i, std::size_t j) { return rows[i][j].get<double>(); };
  return {KDL::Rotation{at(0, 0), at(0, 1), at(0, 2), at(1, 0), at(1, 1), at(1, 2), at(2, 0), at(2, 1), at(2, 2)},
          KDL::Vector{at(0, 3), at(1, 3), at(2, 3)}};
}

const json& by_id(const json& list, const std::string& id) {
  for (const json& entry : list) {
    if ((entry.contains("header") ? entry["header"]["ID"] : entry["ID"]) == id) return entry;
  }
  throw std::out_of_range(id);
}

/// What stands between the connector of `gender` that is no base and leaves a body, and the body's frame.
const json& connector(const json& body, const std::string& gender) {
  for (const json& entry : body["connectors"]) {
    if (entry["gender"] == gender) return entry;
  }
  throw std::out_of_range(gender);
}

/// Modules are entered by their female connector and left by the male one; their joints point outwards.
KDL::Chain kdl_chain(const json& library, const std::vector<std::string>& ids) {
  KDL::Chain chain;
  KDL::Frame X = KDL::Frame::Identity();
  const KDL::Frame facing{KDL::Rotation::RotX(KDL::PI)};
  for (const std::string& id : ids) {
    const json& module = by_id(library["modules"], id);
    const auto has_entry = [](const json& body) {
      for (const json& entry : body["connectors"]) {
        if (entry["gender"] == "f") return true;
      }
      return false;
    };
    const json* body = nullptr;
    for (const json& each : module["bodies"]) {
      if (has_entry(each)) body = &each;
    }
    X = X * facing * frame(connector(*body, "f")["pose"]).Inverse();
    const json joints = module.value("joints", json::array());
    for (std::size_t crossed = 0; crossed < joints.size(); ++crossed) {
      for (const json& joint : joints) {
        if (joint["parent"] != (*body)["ID"]) continue;
        chain.addSegment(KDL::Segment{KDL::Joint{KDL::Joint::None}, X * frame(joint["poseParent"])});
        const auto type = joint["type"] == "prismatic" ? KDL::Joint::TransZ : KDL::Joint::RotZ;
        chain.addSegment(KDL::Segment{KDL::Joint{type}});
        X = frame(joint["poseChild"]);
        body = &by_id(module["bodies"], joint["child"]);
        break;
      }
    }
    X = X * frame(connector(*body, "m")["pose"]);
  }
  chain.addSegment(KDL::Segment{KDL::Joint{KDL::Joint::None}, X});
  return chain;
}

struct Arms {
  std::shared_ptr<const ModuleLibrary> library;
  std::vector<int> types;
  Chain chain;
  KDL::Chain kdl;
};

Arms arms(const std::string& name, const std::vector<std::string>& ids) {
  const std::filesystem::path file = test::shared_folder() / "data/timor" / name / "modules.json";
  const auto library = load_library(file.string());
  std::vector<int> types;
  for (std::size_t i = 1; i < ids.size(); ++i) types.push_back(*library->find(ids[i]));
  return {library, types, library->assemble(types), kdl_chain(library_json(file), ids)};
}

/// Largest difference of any entry of the tip's pose over 1000 postures within the limits.
double worst_difference(const Arms& arms, int expected_joints) {
  EXPECT_EQ(arms.chain.n_joints(), expected_joints);
  EXPECT_EQ(arms.kdl.getNrOfJoints(), static_cast<unsigned>(expected_joints));
  const Arm arm = arms.chain.at(Eigen::VectorXd(0));
  KDL::ChainFkSolverPos_recursive solver{arms.kdl};
  Rng rng{7};
  double worst = 0.0;
  for (int i = 0; i < 1000; ++i) {
    KDL::JntArray q{static_cast<unsigned>(expected_joints)};
    for (int j = 0; j < expected_joints; ++j) {
      q.data[j] = rng.uniform(arms.chain.lower_limits()[j], arms.chain.upper_limits()[j]);
    }
    KDL::Frame expected;
    solver.JntToCart(q, expected);
    const Eigen::Isometry3d tip = arm.forward(q.data).tip;
    for (int r = 0; r < 3; ++r) {
      worst = std::max(worst, std::abs(tip.translation()[r] - expected.p[r]));
      for (int c = 0; c < 3; ++c) worst = std::max(worst, std::abs(tip.linear()(r, c) - expected.M(r, c)));
    }
  }
  return worst;
}

class TimorAssembly : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(test::shared_folder() / "data/timor")) {
      GTEST_SKIP() << "no recorded files under " << test::shared_folder();
    }
  }
};

TEST_F(TimorAssembly, OfSixAxesMovesAsKdlMovesItOnAThousandPostures) {
  const Arms six =
      arms("geometric_primitive_modules", {"base", "J2", "J2", "l_45", "J2", "l_30", "J2", "J2", "J2", "eef"});
  EXPECT_LT(worst_difference(six, 6), 1e-9);
}

TEST_F(TimorAssembly, WithASliderMovesAsKdlMovesIt) {
  const Arms slider = arms("geometric_primitive_modules", {"base", "J2", "J1", "l_15", "J2", "i_45", "eef"});
  EXPECT_LT(worst_difference(slider, 3), 1e-9);
}

TEST_F(TimorAssembly, OfImprovModulesMovesAsKdlMovesIt) {
  const Arms improv = arms("IMPROV", {"1", "21", "4", "22", "5", "23", "12"});
  EXPECT_LT(worst_difference(improv, 6), 1e-9);
}

TEST_F(TimorAssembly, JoinsOnlyWhatFits) {
  const Arms six = arms("IMPROV", {"1", "21", "4"});
  const int tool = *six.library->find("L3");
  const int drive = *six.library->find("PB23");
  std::vector<int> types = six.types;
  types.push_back(tool);
  EXPECT_TRUE(six.library->complete(types));
  EXPECT_TRUE(six.library->successors(types).empty());  // nothing can be joined to a tool
  types.push_back(drive);
  EXPECT_FALSE(six.library->fits_together(types));
}

TEST_F(TimorAssembly, OfMeshesKeepsItsDistanceAndTouches) {
  // L1 stands on the base as it lies in its file. Its surface reaches up to the highest vertex of its mesh, so a ball
  // of 0.1 m whose centre is 0.3 m above that vertex is 0.2 m away, and one on the vertex touches.
  const Arms link = arms("IMPROV", {"1", "4"});
  const Arm arm = link.chain.at(Eigen::VectorXd(0));
  const Posture posture = arm.forward(Eigen::VectorXd(0));
  ASSERT_EQ(arm.geometries().size(), 1U);
  const TriangleMesh& mesh = *std::get<Mesh>(arm.geometries()[0].shape).triangles;
  Eigen::Vector3d top{0.0, 0.0, -1.0};
  for (const Eigen::Vector3d& vertex : mesh.vertices) {
    const Eigen::Vector3d p_W = arm.geometries()[0].X_FG * vertex;
    if (p_W.z() > top.z()) top = p_W;
  }
  const auto scene = [](const Eigen::Vector3d& p_W) {
    Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
    X.translation() = p_W;
    return Scene{{Obstacle{"ball", {{Sphere{0.1}, X}}}}};
  };
  Work work;
  EXPECT_NEAR(scene(top + Eigen::Vector3d{0.0, 0.0, 0.3}).clearance(arm, posture, work), 0.2, 1e-9);
  EXPECT_FALSE(scene(top + Eigen::Vector3d{0.0, 0.0, 0.3}).collides(arm, posture, work));
  EXPECT_TRUE(scene(top).collides(arm, posture, work));
}

}  // namespace
}  // namespace modsearch
