#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <modsearch/problem/files.hpp>
#include <modsearch/problem/reach_bound.hpp>
#include <nlohmann/json.hpp>
#include <numbers>

#include "places.hpp"
#include "problem/temporary_folder.hpp"

// A link whose angular parameter turns its far end about its axis, as a fixed joint with an angle.

namespace modsearch {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

const std::filesystem::path kSeed = test::source_folder() / "data/libraries/seed.json";

json height(const json& z) { return {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, z}, {0, 0, 0, 1}}; }

/// The seed library whose link has a second body, turned by "twist" against the first at the link's far end.
json twisted_seed() {
  json library = json::parse(test::text_of(kSeed));
  json& link = library["modules"][1];
  link["parameters"].push_back({{"name", "twist"}, {"unit", "rad"}, {"lower", -1.5}, {"upper", 1.5}});
  json far = link["bodies"][0];
  far["ID"] = "far";
  far["mass"] = 0.1;
  far["inertia"] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  far["r_com"] = {0, 0, 0};
  far["collision"] = {{{"type", "box"}, {"parameters", {{"x", 0.2}, {"y", 0.1}, {"z", 0.1}}}, {"pose", height(0)}}};
  json& connectors = link["bodies"][0]["connectors"];
  far["connectors"] = json::array({connectors[1]});  // {one} is no list to clang
  far["connectors"][0]["pose"] = height(0);
  connectors.erase(1);
  link["bodies"].push_back(far);
  link["joints"] = {{{"ID", "twist"},
                     {"parent", link["bodies"][0]["ID"]},
                     {"child", "far"},
                     {"type", "fixed"},
                     {"poseParent", height({{"parameter", "length"}})},
                     {"angle", {{"parameter", "twist"}, {"scale", 1.0}}},
                     {"poseChild", height(0)}}};
  return library;
}

std::shared_ptr<const ModuleLibrary> load(const json& library) {
  const test::TemporaryFolder folder;
  return load_library(folder.write("library.json", library.dump()).string());
}

std::string refusal(const json& library) {
  try {
    static_cast<void>(load(library));
  } catch (const FileError& error) {
    return error.what();
  }
  return "";
}

TEST(TwistedLink, IsALinkThatTurnsWhatFollows) {
  const auto library = load(twisted_seed());
  const int link = *library->find("link");
  const int hinge = *library->find("hinge");
  EXPECT_EQ(library->type(link).role(), ModuleRole::kLink);
  // base at q = 0, link of 0.7 m twisted by 0.4 rad, hinge 0.5 + 0.6 m bent by a right angle about its x axis: the far
  // tube of the hinge points along -y of the twisted frame.
  const std::vector<int> types{link, hinge};
  const Chain chain = library->assemble(types);
  EXPECT_FALSE(chain.segment(1).affine());
  const Arm arm = chain.at((Eigen::VectorXd(4) << 0.7, 0.4, 0.5, 0.6).finished());
  const Eigen::Vector3d tip = arm.forward(Eigen::Vector2d{0.0, std::numbers::pi / 2.0}).tip.translation();
  EXPECT_LE((tip - Eigen::Vector3d{0.6 * std::sin(0.4), -0.6 * std::cos(0.4), 1.2}).norm(), 1e-12);
  // The box at the far end turns as well.
  const ArmGeometry& box = arm.geometries()[1];
  EXPECT_LE((box.X_FG.linear().col(0) - Eigen::Vector3d{std::cos(0.4), std::sin(0.4), 0.0}).norm(), 1e-12);
}

TEST(TwistedLink, EnteredFromItsFarEndTurnsTheOtherWay) {
  json turned = twisted_seed();
  json& joint = turned["modules"][1]["joints"][0];
  std::swap(joint["parent"], joint["child"]);
  joint["poseParent"] = height(0);
  joint["poseChild"] = height({{"parameter", "length"}, {"scale", -1.0}});
  const auto library = load(turned);
  const std::vector<int> types{*library->find("link")};
  const Chain chain = library->assemble(types);
  const Eigen::Isometry3d tip = chain.at(Eigen::Vector2d{0.7, 0.4}).forward(Eigen::VectorXd::Zero(1)).tip;
  EXPECT_LE((tip.translation() - Eigen::Vector3d{0.0, 0.0, 0.7}).norm(), 1e-12);
  EXPECT_LE((tip.linear().col(0) - Eigen::Vector3d{std::cos(0.4), -std::sin(0.4), 0.0}).norm(), 1e-12);
}

TEST(TwistedLink, ReachesNoFartherForItsTwist) {
  const auto library = load(twisted_seed());
  const ModuleSpan span = module_span(library->type(*library->find("link")));
  EXPECT_DOUBLE_EQ(span.greatest_length(), 1.5);  // the length's upper bound
  EXPECT_EQ(span.stretches[1].length_rate, 0.0);
}

TEST(TwistedLink, IsRefusedWhereAnglesAndLengthsAreMixedUp) {
  json library = twisted_seed();
  library["modules"][1]["joints"][0]["angle"]["parameter"] = "length";
  EXPECT_THAT(refusal(library),
              HasSubstr("at /modules/1/joints/0/angle/parameter: \"length\" is not an angle, its unit "
                        "is \"m\" (limit: \"rad\")"));
  library = twisted_seed();
  library["modules"][1]["joints"][0]["poseParent"][2][3]["parameter"] = "twist";
  EXPECT_THAT(refusal(library), HasSubstr("\"twist\" is not a length, its unit is \"rad\""));
  library = json::parse(test::text_of(kSeed));
  library["modules"][2]["joints"][0]["angle"] = 0.1;
  EXPECT_THAT(refusal(library), HasSubstr("at /modules/2/joints/0/angle: only a joint of type \"fixed\""));
}

}  // namespace
}  // namespace modsearch
