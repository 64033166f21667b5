#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <modsearch/kinematics/arm.hpp>
#include <modsearch/problem/files.hpp>
#include <modsearch/problem/module_library.hpp>
#include <numbers>
#include <random>

namespace modsearch {
namespace {

using Eigen::AngleAxisd;
using Eigen::Isometry3d;
using Eigen::Translation3d;
using Eigen::Vector3d;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr double kRadius = 0.055;  // of the seed library, PROBLEM 2
constexpr double kTolerance = 1e-12;

Isometry3d tz(double z) { return Isometry3d{Translation3d{0.0, 0.0, z}}; }
Isometry3d rx(double angle) { return Isometry3d{AngleAxisd{angle, Vector3d::UnitX()}}; }
Isometry3d rz(double angle) { return Isometry3d{AngleAxisd{angle, Vector3d::UnitZ()}}; }

Connector connector(const std::string& id, const Isometry3d& X_BC, Gender gender, const std::string& type = "t") {
  return {id, AffinePose{X_BC}, gender, type, {1.0}};
}

/// One body with two connectors, `in` below and `out` at height `length`.
ModuleType rigid(const std::string& id, double length, const std::string& out_type = "t") {
  ModuleType module;
  module.id = id;
  module.name = id;
  module.bodies.push_back({});
  module.bodies[0].id = "body";
  module.bodies[0].connectors = {connector("in", rx(std::numbers::pi), Gender::kFemale),
                                 connector("out", tz(length), Gender::kMale, out_type)};
  return module;
}

ModuleType base() {
  ModuleType module = rigid("base", 0.0);
  module.bodies[0].connectors[0].type = "base";
  return module;
}

/// Two bodies with a revolute joint between them about z at `height`; lower body first.
ModuleType turning(const std::string& id, double height) {
  ModuleType module;
  module.id = id;
  module.name = id;
  module.bodies.resize(2);
  module.bodies[0].id = "lower";
  module.bodies[0].connectors = {connector("in", rx(std::numbers::pi), Gender::kFemale)};
  module.bodies[1].id = "upper";
  module.bodies[1].connectors = {connector("out", tz(0.2), Gender::kMale)};
  ModuleJoint joint;
  joint.joint.name = "joint";
  joint.joint.lower = -1.0;
  joint.joint.upper = 2.0;
  joint.parent = 0;
  joint.child = 1;
  joint.X_PJ = AffinePose{tz(height) * rx(0.3)};
  joint.X_JC = AffinePose{rx(0.4)};
  module.joints = {joint};
  return module;
}

std::string refusal(std::vector<ModuleType> modules) {
  try {
    const ModuleLibrary library{"test", std::move(modules)};
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

class SeedLibrary : public ::testing::Test {
 protected:
  std::shared_ptr<const ModuleLibrary> library_ = load_library("seed");
  std::mt19937 generator_{7};
  double draw(double lower, double upper) { return std::uniform_real_distribution<double>{lower, upper}(generator_); }
};

TEST_F(SeedLibrary, HasLinkHingeAndRotaryInThisOrder) {
  ASSERT_EQ(library_->n_types(), 3);
  EXPECT_EQ(library_->type(0).id, "link");
  EXPECT_EQ(library_->type(1).id, "hinge");
  EXPECT_EQ(library_->type(2).id, "rotary");
  EXPECT_EQ(library_->base().role(), ModuleRole::kBase);
  EXPECT_EQ(library_->type(0).role(), ModuleRole::kLink);
  EXPECT_EQ(library_->type(1).role(), ModuleRole::kJoint);
  EXPECT_EQ(library_->max_parameters(), 2);
  EXPECT_EQ(library_->neighbour_rule(), NeighbourRule::kViaJoint);
}

TEST_F(SeedLibrary, AllowsEveryLengthFromHalfAMetreToOneAndAHalf) {
  for (int k = 0; k < 3; ++k) {
    for (const ParameterRange& range : library_->type(k).parameters) {
      EXPECT_EQ(range.lower, 0.5);
      EXPECT_EQ(range.upper, 1.5);
      EXPECT_EQ(range.unit, "m");
    }
  }
  EXPECT_EQ(library_->type(0).parameters[0].name, "length");
  EXPECT_EQ(library_->type(1).parameters[0].name, "proximal");
  EXPECT_EQ(library_->type(1).parameters[1].name, "distal");
}

TEST_F(SeedLibrary, LimitsEveryJointToExactlyHalfATurnEitherWay) {
  const std::vector<int> types{1, 2, 1};
  const Chain chain = library_->assemble(types);
  ASSERT_EQ(chain.n_joints(), 4);
  EXPECT_TRUE((chain.lower_limits().array() == -std::numbers::pi).all());
  EXPECT_TRUE((chain.upper_limits().array() == std::numbers::pi).all());
}

// The chain maps of PROBLEM 2, multiplied by hand.
TEST_F(SeedLibrary, MapsLengthsAndAnglesAsWrittenByHand) {
  for (int trial = 0; trial < 200; ++trial) {
    const Isometry3d X_WB = Translation3d{draw(-1, 1), draw(-1, 1), draw(-1, 1)} * rx(draw(-3, 3)) * rz(draw(-3, 3));
    std::vector<int> types;
    std::vector<double> x;
    std::vector<double> q{draw(-3, 3)};
    Isometry3d expected = X_WB * rz(q[0]);
    const int n = 1 + trial % 5;
    for (int i = 0; i < n; ++i) {
      const int k = static_cast<int>(generator_() % 3);
      types.push_back(k);
      const double proximal = draw(0.5, 1.5);
      x.push_back(proximal);
      if (k == 0) {
        expected = expected * tz(proximal);
        continue;
      }
      const double distal = draw(0.5, 1.5);
      x.push_back(distal);
      q.push_back(draw(-3, 3));
      expected = k == 1 ? expected * tz(proximal) * rx(q.back()) * tz(distal)
                        : expected * tz(proximal) * rz(q.back()) * tz(kRadius) * rx(std::numbers::pi / 2.0) *
                              tz(distal - kRadius);
    }
    const Chain chain = library_->assemble(types, X_WB);
    ASSERT_EQ(chain.n_parameters(), static_cast<int>(x.size()));
    ASSERT_EQ(chain.n_joints(), static_cast<int>(q.size()));
    const Arm arm = chain.at(Eigen::Map<Eigen::VectorXd>(x.data(), static_cast<Eigen::Index>(x.size())));
    const Posture posture = arm.forward(Eigen::Map<Eigen::VectorXd>(q.data(), static_cast<Eigen::Index>(q.size())));
    EXPECT_LT((posture.tip.matrix() - expected.matrix()).cwiseAbs().maxCoeff(), kTolerance) << "trial " << trial;
  }
}

TEST_F(SeedLibrary, PlacesItsCylindersAlongTheArm) {
  const double p = 0.7;
  const double d = 1.2;
  const Eigen::Vector3d q{0.4, -0.9, 1.3};
  const std::vector<int> types{1, 2};
  const Chain chain = library_->assemble(types);
  const Arm arm = chain.at(Eigen::Vector4d{p, d, p, d});
  const Posture posture = arm.forward(q);
  // hinge: proximal from 0 to p, distal from the joint outwards; rotary: its distal cylinder begins r before the bend.
  const Isometry3d start = rz(q[0]);
  const Isometry3d hinge = start * tz(p) * rx(q[1]);
  const Isometry3d bend = hinge * tz(d) * tz(p) * rz(q[2]) * tz(kRadius) * rx(std::numbers::pi / 2.0);
  const Isometry3d expected[] = {start * tz(p / 2.0), hinge * tz(d / 2.0), hinge * tz(d) * tz(p / 2.0),
                                 bend * tz((d - kRadius - kRadius) / 2.0)};
  const double lengths[] = {p, d, p, d};
  ASSERT_EQ(arm.geometries().size(), 4U);  // the base has none
  for (std::size_t i = 0; i < 4; ++i) {
    const ArmGeometry& geometry = arm.geometries()[i];
    const auto& cylinder = std::get<Cylinder>(geometry.shape);
    EXPECT_NEAR(cylinder.radius, kRadius, kTolerance);
    EXPECT_NEAR(cylinder.length, lengths[i], kTolerance);
    const Isometry3d X_WG = posture.frames[static_cast<std::size_t>(geometry.frame)] * geometry.X_FG;
    EXPECT_LT((X_WG.translation() - expected[i].translation()).norm(), kTolerance) << i;
    EXPECT_LT((X_WG.linear().col(2) - expected[i].linear().col(2)).norm(), kTolerance) << i;
  }
}

TEST_F(SeedLibrary, WeighsOneKilogramPerMetreOfCylinder) {
  const std::vector<int> types{0, 1, 2};
  Eigen::VectorXd x(5);
  x << 0.6, 0.7, 0.8, 0.9, 1.0;
  EXPECT_NEAR(library_->assemble(types).mass(x), x.sum(), kTolerance);
  EXPECT_EQ(library_->assemble({}).mass(Eigen::VectorXd(0)), 0.0);
}

TEST_F(SeedLibrary, ExemptsOnlyTheTwoBodiesOfAJointFromSelfCollision) {
  // Bodies: 0 ground, 1 turntable, 2 and 3 the hinge, 4 and 5 the rotary. Groups: {0}, {1, 2}, {3, 4}, {5}.
  const std::vector<int> types{1, 2};
  const Chain chain = library_->assemble(types);
  ASSERT_EQ(chain.bodies().size(), 6U);
  const auto compared = [&](int a, int b) {
    return std::find(chain.self_pairs().begin(), chain.self_pairs().end(), std::pair{a, b}) != chain.self_pairs().end();
  };
  EXPECT_FALSE(compared(1, 2));  // rigidly joined
  EXPECT_FALSE(compared(2, 3));  // the hinge's own joint
  EXPECT_FALSE(compared(3, 4));
  EXPECT_TRUE(compared(2, 4));  // body-joint-body-rigid: not a neighbour
  EXPECT_TRUE(compared(3, 5));
  EXPECT_TRUE(compared(2, 5));
}

TEST_F(SeedLibrary, IsAlwaysCompleteAndLetsEveryModuleFollowEveryOther) {
  EXPECT_THAT(library_->successors({}), ElementsAre(0, 1, 2));
  const std::vector<int> types{2, 0, 1};
  EXPECT_THAT(library_->successors(types), ElementsAre(0, 1, 2));
  EXPECT_TRUE(library_->complete(types));
  EXPECT_TRUE(library_->complete({}));
}

TEST_F(SeedLibrary, FindsAModuleByIdOrElseByName) {
  EXPECT_EQ(library_->find("hinge"), 1);
  EXPECT_EQ(library_->find("Straight link"), 0);
  EXPECT_EQ(library_->find("base"), std::nullopt);
}

TEST_F(SeedLibrary, RefusesATypeThatItDoesNotHave) {
  EXPECT_THROW(static_cast<void>(library_->type(3)), std::invalid_argument);
  EXPECT_THROW(static_cast<void>(library_->type(-1)), std::invalid_argument);
  const std::vector<int> types{0, 7};
  EXPECT_THROW(static_cast<void>(library_->assemble(types)), std::invalid_argument);
  EXPECT_THROW(static_cast<void>(library_->successors(types)), std::invalid_argument);
}

TEST(Connector, FitsByTypeSizeAndGender) {
  const Connector female = connector("a", Isometry3d::Identity(), Gender::kFemale);
  const Connector male = connector("b", Isometry3d::Identity(), Gender::kMale);
  const Connector both = connector("c", Isometry3d::Identity(), Gender::kHermaphroditic);
  EXPECT_TRUE(female.fits(male));
  EXPECT_TRUE(male.fits(female));
  EXPECT_TRUE(both.fits(both));
  EXPECT_FALSE(female.fits(female));
  EXPECT_FALSE(both.fits(male));
  Connector other_type = male;
  other_type.type = "u";
  EXPECT_FALSE(female.fits(other_type));
  Connector other_size = male;
  other_size.size = {2.0};
  EXPECT_FALSE(female.fits(other_size));
}

TEST(ModuleLibrary, PutsTheTipInTheEefConnectorElseInTheLastFreeOne) {
  ModuleType tool = rigid("tool", 0.3, "eef");
  const ModuleLibrary library{"test", {base(), rigid("link", 1.0), tool}};
  const std::vector<int> unfinished{0};
  const std::vector<int> finished{0, 1};
  const auto tip = [&](const std::vector<int>& types) {
    return library.assemble(types).at(Eigen::VectorXd(0)).forward(Eigen::VectorXd(0)).tip;
  };
  EXPECT_NEAR(tip(unfinished).translation().z(), 1.0, kTolerance);
  EXPECT_NEAR(tip(finished).translation().z(), 1.3, kTolerance);
  EXPECT_FALSE(library.complete(unfinished));
  EXPECT_TRUE(library.complete(finished));
  EXPECT_FALSE(library.complete({}));
  EXPECT_THAT(library.successors(finished), IsEmpty());  // nothing joins an end effector
  const std::vector<int> beyond{1, 0};
  EXPECT_FALSE(library.fits_together(beyond));
  EXPECT_THROW(static_cast<void>(library.assemble(beyond)), std::invalid_argument);
}

TEST(ModuleLibrary, StandsOnTheBaseConnectorTurnedOver) {
  // The base's connector points down, 0.1 m below its body: the body ends up 0.1 m above the base pose.
  ModuleType standing = base();
  standing.bodies[0].connectors[0].X_BC = AffinePose{tz(-0.1) * rx(std::numbers::pi)};
  const ModuleLibrary library{"test", {rigid("link", 1.0), standing}};
  const std::vector<int> types{0};
  const Isometry3d X_WB = Translation3d{1.0, 2.0, 3.0} * rz(0.5);
  const Isometry3d tip = library.assemble(types, X_WB).at(Eigen::VectorXd(0)).forward(Eigen::VectorXd(0)).tip;
  EXPECT_LT((tip.matrix() - (X_WB * tz(1.1)).matrix()).cwiseAbs().maxCoeff(), kTolerance);
}

TEST(ModuleLibrary, EntersAModuleThatFitsBothWaysByItsFirstConnector) {
  ModuleType start = base();
  start.bodies[0].connectors[1].gender = Gender::kHermaphroditic;
  ModuleType link = rigid("link", 1.0);
  for (Connector& each : link.bodies[0].connectors) each.gender = Gender::kHermaphroditic;
  ModuleType reversed = link;
  reversed.id = "reversed";
  std::swap(reversed.bodies[0].connectors[0], reversed.bodies[0].connectors[1]);
  const ModuleLibrary library{"test", {start, link, reversed}};
  const std::vector<int> types{0, 1};
  const auto connections = library.connections(types);
  ASSERT_EQ(connections.size(), 2U);
  EXPECT_EQ(connections[0], (std::pair<std::string, std::string>{"out", "in"}));
  EXPECT_EQ(connections[1], (std::pair<std::string, std::string>{"out", "out"}));
}

TEST(ModuleLibrary, TurnsAJointTheSameWayWhenTheModuleIsEnteredFromItsChild) {
  // Entered from its upper body, the same module runs backwards: q keeps its sign and its limits.
  ModuleType forward = turning("forward", 0.5);
  ModuleType backward = turning("backward", 0.5);
  backward.bodies[0].connectors[0].gender = Gender::kMale;
  backward.bodies[1].connectors[0].gender = Gender::kFemale;
  const ModuleLibrary library{"test", {base(), forward, backward}};
  std::mt19937 generator{3};
  std::uniform_real_distribution<double> angle{-1.0, 2.0};
  for (int trial = 0; trial < 50; ++trial) {
    const double q = angle(generator);
    const std::vector<int> types{1};
    const Chain chain = library.assemble(types);
    ASSERT_EQ(chain.n_joints(), 1);
    EXPECT_EQ(chain.lower_limits()[0], -1.0);
    EXPECT_EQ(chain.upper_limits()[0], 2.0);
    // upper body -> lower body is the inverse of tz(0.5) rx(0.3) rz(q) rx(0.4).
    const Isometry3d lower_to_upper = tz(0.5) * rx(0.3) * rz(q) * rx(0.4);
    const Isometry3d expected =
        rx(std::numbers::pi) * tz(0.2).inverse() * lower_to_upper.inverse() * rx(std::numbers::pi);
    const Isometry3d tip = chain.at(Eigen::VectorXd(0)).forward(Eigen::VectorXd::Constant(1, q)).tip;
    EXPECT_LT((tip.matrix() - expected.matrix()).cwiseAbs().maxCoeff(), kTolerance);
  }
}

TEST(ModuleLibrary, CarriesBodiesOnFixedJointsAlong) {
  // A bracket hangs on the link by a fixed joint, named from the bracket to the link.
  ModuleType link = rigid("link", 1.0);
  link.bodies.push_back({});
  link.bodies[1].id = "bracket";
  link.bodies[1].collision.push_back({{AffineShape::Kind::kSphere, {0.1}, nullptr}, AffinePose{tz(0.05)}});
  ModuleJoint fixed;
  fixed.joint.name = "weld";
  fixed.fixed = true;
  fixed.parent = 1;
  fixed.child = 0;
  fixed.X_PJ = AffinePose{rx(0.7)};
  fixed.X_JC = AffinePose{tz(0.4)};
  link.joints = {fixed};
  const ModuleLibrary library{"test", {base(), link}};
  const std::vector<int> types{0};
  const Chain chain = library.assemble(types);
  EXPECT_EQ(chain.n_joints(), 0);
  const Arm arm = chain.at(Eigen::VectorXd(0));
  ASSERT_EQ(arm.geometries().size(), 1U);
  const Isometry3d expected = (rx(0.7) * tz(0.4)).inverse() * tz(0.05);
  EXPECT_LT((arm.geometries()[0].X_FG.matrix() - expected.matrix()).cwiseAbs().maxCoeff(), kTolerance);
}

TEST(ModuleLibrary, RefusesALibraryWithoutExactlyOneBase) {
  EXPECT_THAT(refusal({rigid("link", 1.0)}), HasSubstr("no module has a connector of type 'base'"));
  ModuleType second = base();
  second.id = "second";
  EXPECT_THAT(refusal({base(), second}), HasSubstr("module 'second': is a second base"));
}

TEST(ModuleLibrary, RefusesABaseWithParameters) {
  ModuleType turned = base();
  turned.parameters = {{"yaw", "rad", -1.0, 1.0}};
  EXPECT_THAT(refusal({turned}), HasSubstr("base with parameters"));
}

TEST(ModuleLibrary, RefusesAModuleWithThreeConnectors) {
  ModuleType fork = rigid("fork", 1.0);
  fork.bodies[0].connectors.push_back(connector("third", tz(0.5), Gender::kMale));
  EXPECT_THAT(refusal({base(), fork}), HasSubstr("module 'fork': has 3 connectors"));
}

TEST(ModuleLibrary, RefusesAJointBesideTheChain) {
  ModuleType gripper = rigid("gripper", 1.0);
  gripper.bodies.push_back({});
  gripper.bodies[1].id = "finger";
  ModuleJoint joint;
  joint.joint.name = "grip";
  joint.child = 1;
  gripper.joints = {joint};
  EXPECT_THAT(refusal({base(), gripper}), HasSubstr("joint 'grip' is not between the two connectors"));
}

TEST(ModuleLibrary, RefusesBodiesThatNothingHoldsTogether) {
  ModuleType broken = rigid("broken", 1.0);
  broken.bodies.push_back({});
  broken.bodies[1].id = "loose";
  EXPECT_THAT(refusal({base(), broken}), HasSubstr("0 joints between 2 bodies"));
}

TEST(ModuleLibrary, RefusesAMassThatCanBecomeNegative) {
  ModuleType light = rigid("light", 1.0);
  light.parameters = {{"length", "m", 0.0, 1.0}};
  light.bodies[0].mass = AffineScalar::of_parameter(0, -1.0, 0.5);
  EXPECT_THAT(refusal({base(), light}), HasSubstr("the mass of body 'body' can become -0.5"));
}

TEST(ModuleLibrary, RefusesMoreThanEightParameters) {
  ModuleType rich = rigid("rich", 1.0);
  for (int i = 0; i < 9; ++i) rich.parameters.push_back({"p" + std::to_string(i), "m", 0.0, 1.0});
  EXPECT_THAT(refusal({base(), rich}), HasSubstr("has 9 parameters (limit 8)"));
}

}  // namespace
}  // namespace modsearch
