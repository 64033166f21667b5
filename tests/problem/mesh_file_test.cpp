#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <modsearch/problem/files.hpp>
#include <nlohmann/json.hpp>

#include "problem/temporary_folder.hpp"

// Meshes as obstacles of tasks: where their files are found and what their coordinates mean.

namespace modsearch {
namespace {

using nlohmann::json;
using test::TemporaryFolder;
using ::testing::AllOf;
using ::testing::HasSubstr;

/// A task among one obstacle, the mesh `file`.
std::string task_with_mesh(const std::string& file) {
  const json identity = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}};
  const json mesh = {{"type", "mesh"}, {"parameters", {{"file", file}}}};
  return json{{"header", {{"ID", "set/one"}}},
              {"obstacles", {{{"ID", "part"}, {"collision", {mesh}}}}},
              {"goals", {{{"ID", "1"}, {"type", "reach"}, {"goalPose", {{"nominal", identity}}}}}}}
      .dump();
}

Eigen::AlignedBox3d box_of(const TaskFile& task) {
  Eigen::AlignedBox3d box;
  const auto& mesh = std::get<Mesh>(task.scene->obstacles()[0].shapes[0].shape);
  for (const Eigen::Vector3d& vertex : mesh.triangles->vertices) box.extend(vertex);
  return box;
}

/// One triangle with the corners (1, 0, 0), (0, 2, 0) and (0, 0, 3) as a COLLADA file.
std::string collada(const std::string& up, const std::string& meter) {
  return R"(<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
 <asset><unit name="u" meter=")" +
         meter + R"("/><up_axis>)" + up + R"(</up_axis></asset>
 <library_geometries><geometry id="m"><mesh>
  <source id="p"><float_array id="a" count="9">1 0 0 0 2 0 0 0 3</float_array><technique_common>
   <accessor source="#a" count="3" stride="3"><param name="X" type="float"/><param name="Y" type="float"/>
    <param name="Z" type="float"/></accessor></technique_common></source>
  <vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
  <triangles count="1"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2</p></triangles>
 </mesh></geometry></library_geometries>
 <library_visual_scenes><visual_scene id="s"><node id="n"><instance_geometry url="#m"/></node></visual_scene></library_visual_scenes>
 <scene><instance_visual_scene url="#s"/></scene>
</COLLADA>
)";
}

// The corners span a box of 1 x 2 x 3 units: whatever axis is said to be up, x stays x, and the unit scales all of
// them.
TEST(ColladaMesh, KeepsTheAxesOfItsFileAndCountsItsUnit) {
  const TemporaryFolder folder;
  for (const char* up : {"X_UP", "Y_UP", "Z_UP"}) {
    for (const auto& [written, meter] : {std::pair{"1", 1.0}, std::pair{"0.01", 0.01}}) {
      folder.write("part.dae", collada(up, written));
      const TaskFile task = load_task(folder.write("task.json", task_with_mesh("part.dae")));
      const Eigen::AlignedBox3d box = box_of(task);
      EXPECT_LT((box.max() - meter * Eigen::Vector3d{1.0, 2.0, 3.0}).norm(), 1e-6 * meter) << up << ' ' << meter;
      EXPECT_LT(box.min().norm(), 1e-6 * meter) << up << ' ' << meter;
    }
  }
}

// The corner (0, 2, 0) is the point of the triangle that is nearest to (0, 2.5, 0), (0, 0, 3) that to (0, 0, 3.5).
TEST(ColladaMesh, IsAsFarFromAPointAsItsNearestCorner) {
  const TemporaryFolder folder;
  folder.write("part.dae", collada("Z_UP", "1"));
  const TaskFile task = load_task(folder.write("task.json", task_with_mesh("part.dae")));
  EXPECT_NEAR(task.scene->clearance({0.0, 2.5, 0.0}), 0.5, 1e-6);
  EXPECT_NEAR(task.scene->clearance({0.0, 0.0, 3.5}), 0.5, 1e-6);
}

/// The same triangle in the kinds of files that are read beside COLLADA.
const std::pair<const char*, const char*> kSameTriangle[] = {
    {"part.obj", "v 1 0 0\nv 0 2 0\nv 0 0 3\nf 1 2 3\n"},
    {"part.off", "OFF\n3 1 0\n1 0 0\n0 2 0\n0 0 3\n3 0 1 2\n"},
    {"part.ply",
     "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
     "element face 1\nproperty list uchar int vertex_indices\nend_header\n1 0 0\n0 2 0\n0 0 3\n3 0 1 2\n"},
    {"PART.STL",
     "solid a\nfacet normal 0 0 1\nouter loop\nvertex 1 0 0\nvertex 0 2 0\nvertex 0 0 3\nendloop\nendfacet\n"
     "endsolid a\n"},
    {"part.gltf",
     R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
"meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
"accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "max": [1, 2, 3], "min": [0, 0, 0]}],
"bufferViews": [{"buffer": 0, "byteLength": 36}],
"buffers": [{"byteLength": 36, "uri": "data:application/octet-stream;base64,AACAPwAAAAAAAAAAAAAAAAAAAEAAAAAAAAAAAAAAAAAAAEBA"}]})"}};

TEST(MeshFile, OfEveryKindKeepsTheCoordinatesOfItsFile) {
  const TemporaryFolder folder;
  for (const auto& [name, text] : kSameTriangle) {
    folder.write(name, text);
    const Eigen::AlignedBox3d box = box_of(load_task(folder.write("task.json", task_with_mesh(name))));
    EXPECT_LT((box.max() - Eigen::Vector3d{1.0, 2.0, 3.0}).norm(), 1e-6) << name;
    EXPECT_LT(box.min().norm(), 1e-6) << name;
  }
}

std::string refusal(const std::filesystem::path& file, const FileOptions& options = {}) {
  try {
    static_cast<void>(load_task(file, options));
  } catch (const FileError& error) {
    return error.what();
  }
  return "";
}

TEST(MeshFile, OfAKindWhoseAxesOrUnitsGetLostIsRefusedByName) {
  const TemporaryFolder folder;
  for (const char* name : {"part.3ds", "part.x", "part.3mf", "part.md2"}) {
    folder.write(name, "anything");
    EXPECT_THAT(refusal(folder.write("task.json", task_with_mesh(name))),
                AllOf(HasSubstr("is of a kind that is not supported yet"), HasSubstr("limit: .wrl, .dae")));
  }
}

const char* const kTriangle = kSameTriangle[0].second;

TEST(MeshFile, IsFoundInTheFoldersAboveTheTask) {
  const TemporaryFolder folder;
  const auto task = folder.write("package/set/one.json", task_with_mesh("assets/part.obj"));
  EXPECT_THAT(refusal(task), AllOf(HasSubstr("is missing"), HasSubstr("nor in a folder above")));
  folder.write("package/assets/part.obj", kTriangle);
  EXPECT_EQ(box_of(load_task(task)).max().z(), 3.0);
}

TEST(MeshFile, BesideTheTaskCountsBeforeOneAbove) {
  const TemporaryFolder folder;
  const auto task = folder.write("package/set/one.json", task_with_mesh("part.obj"));
  folder.write("package/part.obj", kTriangle);
  folder.write("package/set/part.obj", "v 1 0 0\nv 0 2 0\nv 0 0 7\nf 1 2 3\n");
  EXPECT_EQ(box_of(load_task(task)).max().z(), 7.0);
}

TEST(MeshFile, BelowTheMeshRootCountsBeforeAllOthers) {
  const TemporaryFolder folder;
  const auto task = folder.write("here/one.json", task_with_mesh("part.obj"));
  const FileOptions there{folder.path() / "there"};
  folder.write("there/part.obj", kTriangle);
  EXPECT_EQ(box_of(load_task(task, there)).max().z(), 3.0);
  folder.write("here/part.obj", "v 1 0 0\nv 0 2 0\nv 0 0 7\nf 1 2 3\n");
  EXPECT_EQ(box_of(load_task(task, there)).max().z(), 3.0);
  EXPECT_EQ(box_of(load_task(task)).max().z(), 7.0);
  std::filesystem::remove(folder.path() / "there/part.obj");
  EXPECT_EQ(box_of(load_task(task, there)).max().z(), 7.0) << "what the root does not hold is looked for as ever";
}

TEST(MeshFile, MayBeNamedWithTheWordPackage) {
  const TemporaryFolder folder;
  const auto task = folder.write("package/set/one.json", task_with_mesh("package://assets/part.obj"));
  folder.write("package/assets/part.obj", kTriangle);
  EXPECT_EQ(box_of(load_task(task)).max().z(), 3.0);
}

}  // namespace
}  // namespace modsearch
