#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <urdf_parser/urdf_parser.h>

#include <Eigen/Eigenvalues>
#include <modsearch/kinematics/arm.hpp>
#include <modsearch/problem/files.hpp>
#include <modsearch/problem/urdf.hpp>
#include <nlohmann/json.hpp>

#include "places.hpp"
#include "problem/temporary_folder.hpp"

// Arms written as URDF, read back by urdfdom and moved by the rules of URDF, against our own kinematics.

namespace modsearch {
namespace {

using ::testing::HasSubstr;

Eigen::Isometry3d pose(const urdf::Pose& given) {
  const urdf::Rotation& r = given.rotation;
  Eigen::Isometry3d X{Eigen::Quaterniond{r.w, r.x, r.y, r.z}.normalized()};
  X.translation() = Eigen::Vector3d{given.position.x, given.position.y, given.position.z};
  return X;
}

Eigen::Isometry3d moved(const urdf::Joint& joint, double q) {
  const Eigen::Vector3d axis{joint.axis.x, joint.axis.y, joint.axis.z};
  if (joint.type == urdf::Joint::FIXED) return Eigen::Isometry3d::Identity();
  if (joint.type == urdf::Joint::PRISMATIC) return Eigen::Isometry3d{Eigen::Translation3d{q * axis}};
  return Eigen::Isometry3d{Eigen::AngleAxisd{q, axis}};
}

/// Pose of `link` in the root when the joints named stand at q.
Eigen::Isometry3d pose_of(const urdf::ModelInterface& model, const std::string& link,
                          const std::map<std::string, double>& q) {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  for (auto each = model.getLink(link); each->parent_joint;
       each = model.getLink(each->parent_joint->parent_link_name)) {
    const urdf::Joint& joint = *each->parent_joint;
    const auto at = q.find(joint.name);
    X = pose(joint.parent_to_joint_origin_transform) * moved(joint, at == q.end() ? 0.0 : at->second) * X;
  }
  return X;
}

double difference(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  return (a.matrix() - b.matrix()).cwiseAbs().maxCoeff();
}

Design random_design(const ModuleLibrary& library, int most, Rng& rng) {
  Design design;
  const int n = rng.index(most) + 1;
  while (static_cast<int>(design.modules.size()) < n) {
    const std::vector<int> next = library.successors(design.types());
    if (next.empty()) break;
    const int type = next[static_cast<std::size_t>(rng.index(static_cast<int>(next.size())))];
    Parameters parameters(library.type(type).n_parameters());
    for (int i = 0; i < parameters.size(); ++i) {
      const ParameterRange& range = library.type(type).parameters[static_cast<std::size_t>(i)];
      parameters[i] = rng.uniform(range.lower, range.upper);
    }
    design.modules.push_back({type, parameters});
  }
  return design;
}

Eigen::Isometry3d some_base() {
  Eigen::Isometry3d X{Eigen::AngleAxisd{0.7, Eigen::Vector3d{1.0, -2.0, 0.5}.normalized()}};
  X.translation() = Eigen::Vector3d{0.3, -1.2, 0.4};
  return X;
}

/// A rigid body can have this inertia: positive moments, none larger than the sum of the others.
void expect_physical(const urdf::Inertial& inertial) {
  Eigen::Matrix3d J;
  J << inertial.ixx, inertial.ixy, inertial.ixz, inertial.ixy, inertial.iyy, inertial.iyz, inertial.ixz, inertial.iyz,
      inertial.izz;
  const Eigen::Vector3d moments = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>{J}.eigenvalues();
  EXPECT_GT(inertial.mass, 0.0);
  EXPECT_GT(moments[0], 0.0);
  EXPECT_LE(moments[2], (moments[0] + moments[1]) * (1.0 + 1e-9));
}

/// Links, shapes, limits, masses and the poses of everything at random postures.
void expect_same_arm(const ModuleLibrary& library, const Design& design, Rng& rng) {
  const std::vector<int> types = design.types();
  const Chain chain = library.assemble(types, some_base());
  const Arm arm = chain.at(design.parameters());
  const auto model = urdf::parseURDF(to_urdf(library, design, {.X_WB = some_base()}));
  ASSERT_TRUE(model) << to_string(library, design);
  EXPECT_EQ(model->getRoot()->name, "world");

  double mass = 0.0;
  for (const auto& [name, link] : model->links_) {
    if (!link->inertial) continue;
    mass += link->inertial->mass;
    expect_physical(*link->inertial);
  }
  EXPECT_NEAR(mass, arm.mass(), 1e-9);

  for (const Joint& joint : chain.joints()) {
    const auto written = model->getJoint(joint.name);
    ASSERT_TRUE(written) << joint.name;
    EXPECT_EQ(written->type == urdf::Joint::PRISMATIC, joint.type == JointType::kPrismatic);
    ASSERT_TRUE(written->limits);
    EXPECT_EQ(written->limits->lower, joint.type == JointType::kContinuous ? 0.0 : joint.lower);
    EXPECT_EQ(written->limits->upper, joint.type == JointType::kContinuous ? 0.0 : joint.upper);
    EXPECT_EQ(written->limits->effort, std::min(joint.peak_torque, 1e9));
    EXPECT_EQ(written->limits->velocity, std::min(joint.velocity, 1e9));
  }

  for (int i = 0; i < 10; ++i) {
    std::map<std::string, double> named;
    Eigen::VectorXd q(chain.n_joints());
    for (int j = 0; j < chain.n_joints(); ++j) {
      const Joint& joint = chain.joints()[static_cast<std::size_t>(j)];
      q[j] = rng.uniform(std::max(joint.lower, -10.0), std::min(joint.upper, 10.0));
      named[joint.name] = q[j];
    }
    const Posture posture = arm.forward(q);
    EXPECT_LE(difference(pose_of(*model, "tcp", named), posture.tip), 1e-9) << to_string(library, design);
    std::vector<std::size_t> seen(posture.frames.size(), 0);
    for (const ArmGeometry& geometry : arm.geometries()) {
      const auto frame = static_cast<std::size_t>(geometry.frame);
      const std::string link = frame == 0 ? "base_link" : "link_" + std::to_string(frame);
      const auto& collisions = model->getLink(link)->collision_array;
      ASSERT_LT(seen[frame], collisions.size());
      const Eigen::Isometry3d X_WG = pose_of(*model, link, named) * pose(collisions[seen[frame]++]->origin);
      EXPECT_LE(difference(X_WG, posture.frames[frame] * geometry.X_FG), 1e-9);
    }
  }
}

TEST(Urdf, OfRandomDesignsMovesAsTheyDo) {
  Rng rng{11};
  for (const char* name : {"seed", "workshop"}) {
    const auto library = load_library(name);
    for (int i = 0; i < 60; ++i) expect_same_arm(*library, random_design(*library, 9, rng), rng);
  }
}

TEST(Urdf, OfTimorsLibrariesMovesAsTheirArmsDo) {
  Rng rng{12};
  for (const char* name : {"geometric_primitive_modules", "IMPROV"}) {
    const std::filesystem::path file = test::shared_folder() / "data/timor" / name / "modules.json";
    if (!std::filesystem::exists(file)) GTEST_SKIP() << "no recorded files under " << test::shared_folder();
    const auto library = load_library(file.string());
    for (int i = 0; i < 20; ++i) expect_same_arm(*library, random_design(*library, 8, rng), rng);
  }
}

Design design_of(const ModuleLibrary& library,
                 const std::vector<std::pair<std::string, std::vector<double>>>& modules) {
  Design design;
  for (const auto& [id, numbers] : modules) {
    design.modules.push_back({*library.find(id), Eigen::Map<const Eigen::VectorXd>(
                                                     numbers.data(), static_cast<Eigen::Index>(numbers.size()))});
  }
  return design;
}

TEST(Urdf, PutsTheMassOfALinkWhereItsBodiesHaveIt) {
  // A link of 0.7 m and the near tube of a hinge, 0.5 m, turn with the base: 1 kg/m, centre at 0.6 m, a thin rod's
  // moment with its radius of 0.055 m.
  const auto library = load_library("seed");
  const auto model = urdf::parseURDF(to_urdf(*library, design_of(*library, {{"link", {0.7}}, {"hinge", {0.5, 1.0}}})));
  const urdf::Inertial& first = *model->getLink("link_1")->inertial;
  EXPECT_NEAR(first.mass, 1.2, 1e-12);
  EXPECT_NEAR(first.origin.position.z, 0.6, 1e-12);
  EXPECT_NEAR(first.ixx, 1.2 * (3.0 * 0.055 * 0.055 + 1.44) / 12.0, 1e-12);
  EXPECT_NEAR(first.izz, 1.2 * 0.055 * 0.055 / 2.0, 1e-12);
  EXPECT_FALSE(model->getLink("base_link")->inertial);  // weighs nothing
}

TEST(Urdf, KeepsDampingAndFrictionOfTheDrives) {
  const auto library = load_library("workshop");
  const auto model = urdf::parseURDF(to_urdf(*library, design_of(*library, {{"drive_120_bent", {}}})));
  const auto joint = model->getJoint("1.drive_120_bent.joint");
  ASSERT_TRUE(joint->dynamics);
  EXPECT_EQ(joint->dynamics->damping, 5.0);
  EXPECT_EQ(joint->dynamics->friction, 5.0);
  EXPECT_EQ(joint->limits->effort, 330.0);
}

TEST(Urdf, NamesMeshesRelativeToItsFolderAtTheirScale) {
  nlohmann::json library = nlohmann::json::parse(test::text_of(test::source_folder() / "data/libraries/seed.json"));
  library["modules"][1]["bodies"][0]["collision"][0] = {{"type", "mesh"},
                                                        {"parameters", {{"file", "a&b.stl"}, {"scale", 0.001}}}};
  const test::TemporaryFolder folder;
  folder.write("lib/a&b.stl",
               "solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 100 0 0\nvertex 0 100 0\nendloop\n"
               "endfacet\nendsolid s\n");
  const auto loaded = load_library(folder.write("lib/library.json", library.dump()).string());
  const Design design = design_of(*loaded, {{"link", {0.7}}});
  const auto model = urdf::parseURDF(to_urdf(*loaded, design, {.folder = folder.path() / "out"}));
  const auto& collisions = model->getLink("link_1")->collision_array;
  ASSERT_EQ(collisions.size(), 1U);
  const auto mesh = std::dynamic_pointer_cast<urdf::Mesh>(collisions[0]->geometry);
  ASSERT_TRUE(mesh);
  EXPECT_EQ(mesh->filename, "../lib/a&b.stl");
  EXPECT_EQ(mesh->scale.y, 0.001);
}

TEST(Urdf, EscapesWhatXmlTakesForItsOwn) {
  const auto library = load_library("seed");
  EXPECT_THAT(to_urdf(*library, Design{}, {.name = "a<b> & \"c\""}),
              HasSubstr("<robot name=\"a&lt;b&gt; &amp; &quot;c&quot;\">"));
}

TEST(Urdf, RefusesADesignOfAnotherLibrary) {
  const auto library = load_library("seed");
  EXPECT_THROW(static_cast<void>(to_urdf(*library, Design{{{7, Parameters(0)}}})), std::invalid_argument);
}

/// seed with a hinge named `name`.
std::shared_ptr<const ModuleLibrary> with_hinge_named(const std::string& name, const test::TemporaryFolder& folder) {
  nlohmann::json library = nlohmann::json::parse(test::text_of(test::source_folder() / "data/libraries/seed.json"));
  library["modules"][2]["header"]["ID"] = name;
  return load_library(folder.write("library.json", library.dump()).string());
}

TEST(Urdf, KeepsTabsAndLineBreaksOfNames) {
  const test::TemporaryFolder folder;
  const auto library = with_hinge_named("a\tb\nc", folder);
  const Design design = make_design(*library, std::vector<int>{1}, Eigen::Vector2d{0.5, 0.6});
  const auto model = urdf::parseURDF(to_urdf(*library, design));
  ASSERT_TRUE(model);
  EXPECT_TRUE(model->getJoint("1.a\tb\nc.joint"));
}

TEST(Urdf, RefusesNamesThatXmlCannotHold) {
  const test::TemporaryFolder folder;
  const auto library = with_hinge_named("a\ab", folder);
  const Design design = make_design(*library, std::vector<int>{1}, Eigen::Vector2d{0.5, 0.6});
  const auto refusal = [&](const ModuleLibrary& modules, const std::string& robot) -> std::string {
    try {
      static_cast<void>(to_urdf(modules, design, {.name = robot}));
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(refusal(*library, "arm"), HasSubstr("has the character U+0007, which XML cannot hold"));
  EXPECT_THAT(refusal(*load_library("seed"), "r\x1b"),
              HasSubstr("the name of robot 'r\xEF\xBF\xBD' has the character U+001B"));
}

}  // namespace
}  // namespace modsearch
