#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/format.h>

#include <assimp/Importer.hpp>
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

TriangleMesh load_by_assimp(const std::filesystem::path& file, const std::string& extension) {
  Assimp::Importer importer;
  if (!importer.IsExtensionSupported(extension)) {
    throw std::runtime_error(fmt::format("is of a kind that is not supported yet (\"{}\")", extension));
  }
  const aiScene* scene = importer.ReadFile(file.string(), aiProcess_Triangulate | aiProcess_JoinIdenticalVertices);
  if (scene == nullptr || scene->mRootNode == nullptr) {
    throw std::runtime_error(fmt::format("cannot be read: {}", importer.GetErrorString()));
  }
  TriangleMesh mesh;
  add_node(*scene, *scene->mRootNode, aiMatrix4x4{}, mesh);
  return mesh;
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

  const std::string extension = file.extension().string();
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
