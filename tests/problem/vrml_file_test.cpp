#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <modsearch/problem/files.hpp>

#include "problem/temporary_folder.hpp"

namespace modsearch {
namespace {

using test::TemporaryFolder;
using ::testing::HasSubstr;

const std::string kHeader = "#VRML V2.0 utf8\n";

std::string shape(const std::string& faces) {
  return "Shape { geometry IndexedFaceSet { coord Coordinate { point [ 0 0 0, 1 0 0, 1 1 0, 0 1 0, 0 0 1 ] } " + faces +
         " } }\n";
}

/// A task whose one obstacle is the mesh, or what was said against it.
struct Reading {
  std::shared_ptr<const TriangleMesh> mesh;
  std::string refusal;
};

Reading read(const std::string& vrml) {
  const TemporaryFolder folder;
  folder.write("piece.wrl", vrml);
  const auto task = folder.write("task.json", R"({"header": {"ID": "t"}, "goals": [], "obstacles": [{"ID": "1",
    "collision": {"type": "mesh", "parameters": {"file": "piece.wrl", "scale": 2}}}]})");
  try {
    return {std::get<Mesh>(load_task(task).scene->obstacles()[0].shapes[0].shape).triangles, ""};
  } catch (const FileError& error) {
    return {nullptr, error.what()};
  }
}

TEST(VrmlFile, BecomesTheTrianglesOfAllItsShapes) {
  const Reading reading = read(kHeader + "# a comment { [\n" + shape("coordIndex [ 0 1 2 -1 ] solid TRUE") +
                               shape("coordIndex [ 0, 1, 4, -1, ]"));
  ASSERT_NE(reading.mesh, nullptr) << reading.refusal;
  ASSERT_EQ(reading.mesh->triangles.size(), 2U);
  EXPECT_EQ(reading.mesh->vertices.size(), 10U);
  EXPECT_EQ(reading.mesh->triangles[1], (Eigen::Vector3i{5, 6, 9}));  // points count from the start of their own shape
  EXPECT_EQ(reading.mesh->vertices[9], (Eigen::Vector3d{0.0, 0.0, 2.0}));  // scaled
}

TEST(VrmlFile, FansOutPolygonsAndTakesALastFaceWithoutItsEnd) {
  const Reading reading = read(kHeader + shape("coordIndex [ 0 1 2 3 ]"));
  ASSERT_NE(reading.mesh, nullptr) << reading.refusal;
  ASSERT_EQ(reading.mesh->triangles.size(), 2U);
  EXPECT_EQ(reading.mesh->triangles[0], (Eigen::Vector3i{0, 1, 2}));
  EXPECT_EQ(reading.mesh->triangles[1], (Eigen::Vector3i{0, 2, 3}));
}

TEST(VrmlFile, LeavesAppearancesAside) {
  const Reading reading = read(kHeader + "Shape { appearance Appearance { material Material { transparency 0.2 } } " +
                               shape("coordIndex [0 1 2 -1]").substr(8));
  ASSERT_NE(reading.mesh, nullptr) << reading.refusal;
  EXPECT_EQ(reading.mesh->triangles.size(), 1U);
}

TEST(VrmlFile, IsRefusedByLineAndReasonWhereItIsMoreThanFaceSets) {
  EXPECT_THAT(read("#VRML V1.0 ascii\n").refusal, HasSubstr("it does not begin with \"#VRML V2.0 utf8\""));
  EXPECT_THAT(read(kHeader + "\nTransform { }").refusal,
              HasSubstr("line 3: 'Transform' is not supported, only Shape nodes are"));
  EXPECT_THAT(read(kHeader + "Shape { geometry Box { } }").refusal,
              HasSubstr("line 2: 'Box' stands where 'IndexedFaceSet' is due"));
  EXPECT_THAT(read(kHeader + shape("convex FALSE")).refusal,
              HasSubstr("field 'convex' of an IndexedFaceSet is not supported"));
  EXPECT_THAT(read(kHeader + shape("coordIndex [0 1 5 -1]")).refusal, HasSubstr("point 5 is not in [0, 5)"));
  EXPECT_THAT(read(kHeader + shape("coordIndex [0 1 -1]")).refusal, HasSubstr("fewer than 3 points"));
  EXPECT_THAT(read(kHeader + shape("coordIndex [0 1 x]")).refusal, HasSubstr("'x' is not a number"));
  EXPECT_THAT(read(kHeader + "Shape { geometry IndexedFaceSet {").refusal, HasSubstr("the file ends too early"));
  EXPECT_THAT(read(kHeader).refusal, HasSubstr("holds no triangles"));
}

}  // namespace
}  // namespace modsearch
