#pragma once

// Numbers affine in parameters, poses and shapes as files write them. Internal to the problem floor.

#include <modsearch/problem/json_internal.hpp>
#include <modsearch/problem/module_library.hpp>

namespace modsearch::detail {

/// The parameters that numbers of a module may refer to; none in a task.
using ParameterList = std::vector<ParameterRange>;

/// A number, or {"parameter": name, "scale": 1, "offset": 0} meaning offset + scale * value, never below `lower` within
/// the parameter's interval. `unit`: of the parameters that may stand here.
[[nodiscard]] AffineScalar read_affine(const JsonCursor& cursor, const ParameterList& parameters,
                                       double lower = -std::numeric_limits<double>::infinity(),
                                       std::string_view unit = "m");
/// [3] such numbers.
[[nodiscard]] AffineVector read_affine_vector(const JsonCursor& cursor, const ParameterList& parameters);
/// A 4x4 pose whose translation consists of such numbers.
[[nodiscard]] AffinePose read_affine_pose(const JsonCursor& cursor, const ParameterList& parameters);
/// {type, parameters, pose} of a box, cylinder, sphere or mesh.
[[nodiscard]] BodyGeometry read_geometry(const JsonCursor& cursor, const ParameterList& parameters);

/// The file of a mesh that a document names: below the mesh root if there is one, else beside the document or, as in
/// packages whose tasks name their files from the top, beside the nearest folder above it that has such a file. Where
/// there is none: beside the document. "package://" before a name says no more than that.
[[nodiscard]] std::filesystem::path mesh_path(const std::string& named, const JsonSource& source);

/// Triangles of a VRML 2.0 file that holds nothing but Shapes of IndexedFaceSets, which is how convex decompositions
/// are stored (Debian's assimp reads no .wrl). Throws std::runtime_error (line, what) for anything else.
[[nodiscard]] TriangleMesh load_vrml(const std::filesystem::path& file);
/// Triangles of `file` (.wrl, .dae, .glb, .gltf, .obj, .off, .ply, .stl) scaled by `scale` per axis: the coordinates as
/// they stand in the file, times its unit where it names one, whatever it says of the axis that is up. Throws
/// std::runtime_error (what, limit).
[[nodiscard]] std::shared_ptr<const TriangleMesh> load_mesh(const std::filesystem::path& file,
                                                            const Eigen::Vector3d& scale);

}  // namespace modsearch::detail
