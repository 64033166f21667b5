#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <modsearch/kinematics/arm.hpp>
#include <modsearch/problem/files.hpp>
#include <nlohmann/json.hpp>

#include "places.hpp"
#include "problem/temporary_folder.hpp"

namespace modsearch {
namespace {

using nlohmann::json;
using test::TemporaryFolder;
using test::text_of;

const std::filesystem::path kSeed = test::source_folder() / "data/libraries/seed.json";

/// The recorded file, or an empty path where there is none.
std::filesystem::path recorded(const std::string& name) {
  const std::filesystem::path file = test::shared_folder() / "data/timor" / name;
  return std::filesystem::exists(file) ? file : std::filesystem::path{};
}

TEST(LibraryFile, IsBuiltInExactlyAsItLiesInTheDataFolder) {
  const auto built_in = load_library("seed");
  const auto file = load_library(kSeed.string());
  ASSERT_EQ(built_in->n_types(), file->n_types());
  const std::vector<int> types{0, 1, 2};
  Eigen::VectorXd x(5);
  x << 0.5, 0.7, 0.9, 1.1, 1.3;
  const Eigen::Vector3d q{0.1, 0.2, 0.3};
  const Chain a = built_in->assemble(types);
  const Chain b = file->assemble(types);
  EXPECT_EQ(a.at(x).forward(q).tip.matrix(), b.at(x).forward(q).tip.matrix());
  EXPECT_EQ(built_in->name(), "seed");
}

TEST(LibraryFile, ReadsGeometricPrimitivesWithBareInfinity) {
  const auto file = recorded("geometric_primitive_modules/modules.json");
  if (file.empty()) GTEST_SKIP() << "no recorded files under " << test::shared_folder();
  const auto library = load_library(file.string());
  ASSERT_EQ(library->n_types(), 9);
  const ModuleType& prismatic = library->type(*library->find("J1"));
  ASSERT_EQ(prismatic.joints.size(), 1U);
  EXPECT_EQ(prismatic.joints[0].joint.type, JointType::kPrismatic);
  EXPECT_EQ(prismatic.joints[0].joint.upper, 0.06);
  EXPECT_EQ(prismatic.joints[0].joint.velocity, std::numeric_limits<double>::infinity());
  EXPECT_EQ(library->type(*library->find("eef")).role(), ModuleRole::kEndEffector);
}

TEST(LibraryFile, AssemblesGeometricPrimitivesToTheLengthsTheyHave) {
  const auto file = recorded("geometric_primitive_modules/modules.json");
  if (file.empty()) GTEST_SKIP() << "no recorded files under " << test::shared_folder();
  // The slider moves by q, i_15 and i_30 differ by 0.15 m, and the tool ends 0.04 m on, in its eef connector.
  const auto library = load_library(file.string());
  const auto tip = [&](const std::vector<int>& types, double q) -> Eigen::Vector3d {
    const Chain chain = library->assemble(types);
    const Eigen::VectorXd posture = Eigen::VectorXd::Constant(chain.n_joints(), q);
    return chain.at(Eigen::VectorXd(0)).forward(posture).tip.translation();
  };
  const int j1 = *library->find("J1");
  const int i15 = *library->find("i_15");
  const int i30 = *library->find("i_30");
  const int eef = *library->find("eef");
  EXPECT_NEAR((tip({j1}, 0.05) - tip({j1}, 0.0)).norm(), 0.05, 1e-12);
  EXPECT_NEAR((tip({i30}, 0.0) - tip({i15}, 0.0)).norm(), 0.15, 1e-12);
  EXPECT_NEAR((tip({i15, eef}, 0.0) - tip({i15}, 0.0)).norm(), 0.04, 1e-12);
  const std::vector<int> unfinished{i15};
  EXPECT_FALSE(library->complete(unfinished));
}

TEST(LibraryFile, ReadsImprovWithTheConvexPiecesOfItsMeshes) {
  const auto file = recorded("IMPROV/modules.json");
  if (file.empty()) GTEST_SKIP() << "no recorded files under " << test::shared_folder();
  const auto library = load_library(file.string());
  EXPECT_EQ(library->n_types(), 16 - 1);
  EXPECT_EQ(library->neighbour_rule(), NeighbourRule::kRigidViaJoint);
  const ModuleType& l3 = library->type(*library->find("L3"));
  const TriangleMesh& mesh = *l3.bodies[0].collision[0].shape.mesh;
  // Every piece is a closed convex polyhedron of triangles: Euler's formula for p pieces is v - t / 2 = 2 p.
  const auto v = static_cast<int>(mesh.vertices.size());
  const auto t = static_cast<int>(mesh.triangles.size());
  EXPECT_EQ(t % 2, 0);
  EXPECT_EQ((v - t / 2) % 2, 0);
  EXPECT_EQ((v - t / 2) / 2, 4);  // the file has four Shapes
}

TEST(LibraryFile, ReadsASingleObjectWhereAListIsMeant) {
  const TemporaryFolder folder;
  json library = json::parse(text_of(kSeed));
  library["modules"][0]["joints"] = library["modules"][0]["joints"][0];
  for (json& body : library["modules"][1]["bodies"]) body["collision"] = body["collision"][0];
  EXPECT_EQ(load_library(folder.write("library.json", library.dump()).string())->n_types(), 3);
}

TEST(LibraryFile, ReadsABodyWithoutCollision) {
  const TemporaryFolder folder;
  json library = json::parse(text_of(kSeed));
  library["modules"][0]["bodies"][0].erase("collision");
  EXPECT_EQ(load_library(folder.write("library.json", library.dump()).string())->n_types(), 3);
}

TEST(LibraryFile, TakesAContinuousJointWithoutLimitsAndNoOther) {
  const TemporaryFolder folder;
  json library = json::parse(text_of(kSeed));
  json& joint = library["modules"][2]["joints"][0];
  joint.erase("limits");
  joint["type"] = "continuous";
  const auto read = load_library(folder.write("library.json", library.dump()).string());
  const Joint& turning = read->type(1).joints[0].joint;
  EXPECT_EQ(turning.lower, -std::numeric_limits<double>::infinity());
  EXPECT_EQ(turning.upper, std::numeric_limits<double>::infinity());
  EXPECT_EQ(turning.peak_torque, std::numeric_limits<double>::infinity());
  joint["type"] = "revolute";
  const std::string file = folder.write("other.json", library.dump()).string();
  EXPECT_THAT([&] { static_cast<void>(load_library(file)); },
              ::testing::ThrowsMessage<FileError>(::testing::HasSubstr("key \"limits\" is missing")));
}

TEST(LibraryFile, PutsARotationRightThatIsOffByAMillionth) {
  const TemporaryFolder folder;
  json library = json::parse(text_of(kSeed));
  library["modules"][1]["bodies"][0]["connectors"][1]["pose"][0][1] = 4e-7;
  const auto read = load_library(folder.write("library.json", library.dump()).string());
  const Eigen::Matrix3d R = read->type(0).bodies[0].connectors[1].X_BC.rotation;
  EXPECT_LT((R.transpose() * R - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff(), 1e-15);
  EXPECT_NEAR(R(0, 1), 2e-7, 1e-9);  // the nearest rotation shares the error between both entries
}

TEST(LibraryFile, TakesAMeshInAFolderBesideIt) {
  const TemporaryFolder folder;
  folder.write("meshes/corner.stl",
               "solid corner\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n"
               "endloop\nendfacet\nendsolid corner\n");
  json library = json::parse(text_of(kSeed));
  library["modules"][0]["bodies"][0]["collision"] =
      json::array({{{"type", "mesh"}, {"parameters", {{"file", "meshes/corner.stl"}, {"scale", {2.0, 3.0, 1.0}}}}}});
  const auto read = load_library(folder.write("library.json", library.dump()).string());
  const TriangleMesh& mesh = *read->base().bodies[0].collision[0].shape.mesh;
  ASSERT_EQ(mesh.triangles.size(), 1U);
  Eigen::Vector3d upper = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& vertex : mesh.vertices) upper = upper.cwiseMax(vertex);
  EXPECT_EQ(upper, (Eigen::Vector3d{2.0, 3.0, 0.0}));
}

TEST(LibraryFile, NeverOpensAVisualMesh) {
  const TemporaryFolder folder;
  json library = json::parse(text_of(kSeed));
  library["modules"][0]["bodies"][0]["visual"] =
      json::array({{{"type", "mesh"}, {"parameters", {{"file", "nowhere.stl"}, {"scale", 1.0}}}}});
  EXPECT_EQ(load_library(folder.write("library.json", library.dump()).string())->n_types(), 3);
}

TEST(LibraryFile, GivesAContinuousJointNoLimits) {
  const TemporaryFolder folder;
  json library = json::parse(text_of(kSeed));
  library["modules"][2]["joints"][0]["type"] = "continuous";
  library["modules"][2]["joints"][0]["limits"] = json::object();
  const auto read = load_library(folder.write("library.json", library.dump()).string());
  const std::vector<int> types{1};
  const Chain chain = read->assemble(types);
  EXPECT_EQ(chain.lower_limits()[1], -std::numeric_limits<double>::infinity());
  EXPECT_EQ(chain.upper_limits()[1], std::numeric_limits<double>::infinity());
}

TEST(LibraryFile, ReadsTheNeighbourRule) {
  const TemporaryFolder folder;
  json library = json::parse(text_of(kSeed));
  library["ignore_collisions"] = "rigid";
  EXPECT_EQ(load_library(folder.write("a.json", library.dump()).string())->neighbour_rule(), NeighbourRule::kRigid);
  library.erase("ignore_collisions");
  EXPECT_EQ(load_library(folder.write("b.json", library.dump()).string())->neighbour_rule(), NeighbourRule::kViaJoint);
}

// Timor's libraries once were the list alone.
TEST(LibraryFile, MayBeTheBareListOfItsModules) {
  const TemporaryFolder folder;
  const json list = json::parse(text_of(kSeed))["modules"];
  const auto library = load_library(folder.write("list.json", list.dump()).string());
  EXPECT_EQ(library->n_types(), load_library("seed")->n_types());
  json broken = list;
  broken[1]["bodies"][0]["mass"] = -1;
  try {
    static_cast<void>(load_library(folder.write("list.json", broken.dump()).string()));
    FAIL();
  } catch (const FileError& error) {
    EXPECT_NE(std::string{error.what()}.find("at /1/bodies/0/mass: -1 is not at least 0"), std::string::npos)
        << error.what();
  }
}

}  // namespace
}  // namespace modsearch
