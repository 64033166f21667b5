#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <assimp/Importer.hpp>
#include <cstdint>
#include <cstring>
#include <modsearch/problem/child_process_internal.hpp>
#include <modsearch/problem/geometry_internal.hpp>

namespace modsearch::detail {
namespace {

// A mesh of a million triangles is far beyond what a collision check can use.
constexpr std::uintmax_t kLargestMeshFile = 256U << 20U;
constexpr std::size_t kMostTriangles = 1'000'000;

/// Adds the meshes of `node` and of the nodes below it, in the frame of the file.
void add_node(const aiScene& scene, const aiNode& node, const aiMatrix4x4& X_parent, TriangleMesh& mesh) {
  const aiMatrix4x4 X = X_parent * node.mTransformation;
  for (unsigned i = 0; i < node.mNumMeshes; ++i) {
    const aiMesh& part = *scene.mMeshes[node.mMeshes[i]];
    const auto first = static_cast<int>(mesh.vertices.size());
    for (unsigned v = 0; v < part.mNumVertices; ++v) {
      const aiVector3D p = X * part.mVertices[v];
      mesh.vertices.emplace_back(p.x, p.y, p.z);
    }
    for (unsigned f = 0; f < part.mNumFaces; ++f) {
      const aiFace& face = part.mFaces[f];
      if (face.mNumIndices != 3) continue;  // points and lines have no surface
      mesh.triangles.emplace_back(first + static_cast<int>(face.mIndices[0]),
                                  first + static_cast<int>(face.mIndices[1]),
                                  first + static_cast<int>(face.mIndices[2]));
    }
  }
  for (unsigned i = 0; i < node.mNumChildren; ++i) add_node(scene, *node.mChildren[i], X, mesh);
}

// Kinds of files of which the coordinates are known to come through as they stand in the file. Others would have to be
// looked at one by one: assimp turns some (3ds, md2), mirrors some (x) and leaves the unit of some aside (3mf, amf).
constexpr std::array<std::string_view, 7> kKinds{".dae", ".glb", ".gltf", ".obj", ".off", ".ply", ".stl"};

TriangleMesh read_by_assimp(const std::filesystem::path& file) {
  Assimp::Importer importer;
  // The unit of a COLLADA file counts, its up axis is a hint for viewers: assimp would turn the mesh until y is up.
  importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, true);
  const aiScene* scene = importer.ReadFile(file.string(), aiProcess_Triangulate | aiProcess_JoinIdenticalVertices);
  if (scene == nullptr || scene->mRootNode == nullptr) {
    throw std::runtime_error(fmt::format("cannot be read: {}", importer.GetErrorString()));
  }
  TriangleMesh mesh;
  add_node(*scene, *scene->mRootNode, aiMatrix4x4{}, mesh);
  return mesh;
}

template <typename Vector>
std::string to_bytes(const std::vector<Vector>& vectors) {
  return {reinterpret_cast<const char*>(vectors.data()), vectors.size() * sizeof(Vector)};
}

template <typename Vector>
std::vector<Vector> from_bytes(std::string_view bytes) {
  std::vector<Vector> vectors(bytes.size() / sizeof(Vector));
  if (!vectors.empty()) std::memcpy(vectors.front().data(), bytes.data(), vectors.size() * sizeof(Vector));
  return vectors;
}

/// A process of its own reads the file: assimp runs away on some that are damaged (docs/fuzzing.md), in places that no
/// look at the file beforehand would find, short of reading it.
TriangleMesh load_by_assimp(const std::filesystem::path& file, const std::string& extension) {
  if (std::find(kKinds.begin(), kKinds.end(), extension) == kKinds.end()) {
    throw std::runtime_error(fmt::format("is of a kind that is not supported yet (\"{}\"); limit: .wrl, {}", extension,
                                         fmt::join(kKinds, ", ")));
  }
  const std::string bytes = in_child_process([&] {
    const TriangleMesh mesh = read_by_assimp(file);
    const std::uint64_t n_vertices = mesh.vertices.size();
    std::string image{reinterpret_cast<const char*>(&n_vertices), sizeof n_vertices};
    return image + to_bytes(mesh.vertices) + to_bytes(mesh.triangles);
  });
  std::uint64_t n_vertices = 0;
  std::memcpy(&n_vertices, bytes.data(), sizeof n_vertices);
  const std::string_view numbers = std::string_view{bytes}.substr(sizeof n_vertices);
  if (n_vertices > numbers.size() / sizeof(Eigen::Vector3d)) throw std::runtime_error("cannot be read: half an answer");
  const std::size_t end = n_vertices * sizeof(Eigen::Vector3d);
  TriangleMesh mesh;
  mesh.vertices = from_bytes<Eigen::Vector3d>(numbers.substr(0, end));
  mesh.triangles = from_bytes<Eigen::Vector3i>(numbers.substr(end));
  return mesh;
}

/// ".stl" of "PART.STL".
std::string kind_of(const std::filesystem::path& file) {
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  return extension;
}

}  // namespace

std::shared_ptr<const TriangleMesh> load_mesh(const std::filesystem::path& file, const Eigen::Vector3d& scale) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(file, error);
  if (status.type() == std::filesystem::file_type::not_found)
    throw std::runtime_error("is missing: there is no such file");
  if (!std::filesystem::is_regular_file(status)) throw std::runtime_error("is not a regular file");
  const std::uintmax_t size = std::filesystem::file_size(file, error);
  if (!error && size > kLargestMeshFile) {
    throw std::runtime_error(fmt::format("has {} bytes, which is too many (limit {})", size, kLargestMeshFile));
  }

  const std::string extension = kind_of(file);
  auto mesh = std::make_shared<TriangleMesh>(extension == ".wrl" ? load_vrml(file) : load_by_assimp(file, extension));
  if (mesh->triangles.empty()) throw std::runtime_error("holds no triangles (limit: at least 1)");
  if (mesh->triangles.size() > kMostTriangles) {
    throw std::runtime_error(fmt::format("holds {} triangles (limit {})", mesh->triangles.size(), kMostTriangles));
  }
  for (Eigen::Vector3d& vertex : mesh->vertices) {
    vertex = vertex.cwiseProduct(scale);
    if (!vertex.allFinite()) throw std::runtime_error("holds a vertex that is not finite");
  }
  mesh->source = file.string();
  mesh->scale = scale;
  return mesh;
}

}  // namespace modsearch::detail
