#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <modsearch/problem/geometry_internal.hpp>

namespace modsearch::detail {
namespace {

/// Index of the parameter that `cursor` names, which has to be of `unit`.
int parameter_index(const JsonCursor& cursor, const ParameterList& parameters, std::string_view unit) {
  const std::string name = cursor.text();
  const auto found = std::find_if(parameters.begin(), parameters.end(),
                                  [&](const ParameterRange& range) { return range.name == name; });
  if (found == parameters.end()) {
    std::string known;
    for (const ParameterRange& range : parameters) known += (known.empty() ? "" : ", ") + range.name;
    cursor.fail_value(fmt::format("a parameter of this module (known: {})", known.empty() ? "none" : known));
  }
  if (found->unit != unit) {
    cursor.fail_value(fmt::format("{}, its unit is \"{}\" (limit: \"{}\")", unit == "m" ? "a length" : "an angle",
                                  found->unit, unit));
  }
  return static_cast<int>(found - parameters.begin());
}

std::string where_it_was_sought(const JsonSource& source) {
  if (source.mesh_root) return fmt::format(", nor in a folder above, nor below {}", source.mesh_root->string());
  return ", nor in a folder above (--mesh-root says where else)";
}

std::shared_ptr<const TriangleMesh> read_mesh(const JsonCursor& parameters) {
  parameters.expect_keys({"file", "scale"});
  const JsonCursor file = parameters.at("file");
  Eigen::Vector3d scale = Eigen::Vector3d::Ones();
  constexpr NumberLimits kPositive{.lower = 0.0, .above_lower = true};
  if (const std::optional<JsonCursor> given = parameters.find("scale")) {
    if (given->value().is_array()) {
      const std::vector<JsonCursor> entries = given->items(3);
      for (std::size_t i = 0; i < 3; ++i) scale[static_cast<Eigen::Index>(i)] = entries[i].number(kPositive);
    } else {
      scale.setConstant(given->number(kPositive));
    }
  }
  const std::filesystem::path path = mesh_path(file.text(), file.source());
  if (!file.source().open_meshes) {
    const std::vector<Eigen::Vector3d> corners{{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}};
    return std::make_shared<const TriangleMesh>(TriangleMesh{corners, {{0, 1, 2}}, path.string(), scale});
  }
  std::error_code none;
  if (!std::filesystem::exists(path, none)) {
    file.fail(fmt::format("mesh {} ({}) is missing: there is no such file{}", preview(file.value()), path.string(),
                          where_it_was_sought(file.source())));
  }
  try {
    return load_mesh(path, scale);
  } catch (const std::runtime_error& error) {
    file.fail(fmt::format("mesh {} ({}) {}", preview(file.value()), path.string(), error.what()));
  }
}

}  // namespace

std::filesystem::path mesh_path(const std::string& named, const JsonSource& source) {
  constexpr std::string_view kPackage = "package://";
  const std::filesystem::path name = named.starts_with(kPackage) ? named.substr(kPackage.size()) : named;
  std::error_code none;
  if (source.mesh_root && std::filesystem::exists(*source.mesh_root / name, none)) return *source.mesh_root / name;
  const std::filesystem::path beside = source.directory / name;
  if (name.is_absolute() || std::filesystem::exists(beside, none)) return beside;
  // Above the real folder, not above a link to it.
  std::filesystem::path folder = std::filesystem::weakly_canonical(std::filesystem::absolute(source.directory), none);
  while (folder.has_relative_path()) {
    folder = folder.parent_path();
    if (std::filesystem::is_regular_file(folder / name, none)) return folder / name;
  }
  return beside;
}

AffineScalar read_affine(const JsonCursor& cursor, const ParameterList& parameters, double lower,
                         std::string_view unit) {
  if (!cursor.value().is_object()) return cursor.number({.lower = lower});
  cursor.expect_keys({"parameter", "scale", "offset"});
  const int index = parameter_index(cursor.at("parameter"), parameters, unit);
  const double scale = cursor.number_or("scale", 1.0);
  const double offset = cursor.number_or("offset", 0.0);
  const ParameterRange& range = parameters[static_cast<std::size_t>(index)];
  const double least = offset + scale * (scale > 0.0 ? range.lower : range.upper);
  if (least < lower) {
    cursor.fail(fmt::format("{} becomes {} within {} in [{}, {}] (limit: at least {})", preview(cursor.value()), least,
                            range.name, range.lower, range.upper, lower));
  }
  return AffineScalar::of_parameter(index, scale, offset);
}

AffineVector read_affine_vector(const JsonCursor& cursor, const ParameterList& parameters) {
  const std::vector<JsonCursor> entries = cursor.items(3);
  return {read_affine(entries[0], parameters), read_affine(entries[1], parameters),
          read_affine(entries[2], parameters)};
}

AffinePose read_affine_pose(const JsonCursor& cursor, const ParameterList& parameters) {
  const std::vector<JsonCursor> rows = cursor.items(4);
  Eigen::Matrix3d rotation;
  std::vector<AffineScalar> translation;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::vector<JsonCursor> entries = rows[i].items(4);
    for (std::size_t j = 0; j < 3; ++j) {
      rotation(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) = entries[j].number();
    }
    translation.push_back(read_affine(entries[3], parameters));
  }
  if (!rows[3].vector(4).isApprox(Eigen::Vector4d::UnitW(), 1e-6)) {
    rows[3].fail_value("[0, 0, 0, 1], the last row of a pose");
  }
  const std::optional<Eigen::Matrix3d> nearest = nearest_rotation(rotation);
  if (!nearest) cursor.fail("the upper left 3x3 of the pose is not a rotation (limit: within 1e-6)");
  return {*nearest, AffineVector{translation[0], translation[1], translation[2]}};
}

BodyGeometry read_geometry(const JsonCursor& cursor, const ParameterList& parameters) {
  cursor.expect_keys({"type", "parameters", "pose"});
  const JsonCursor sizes = cursor.at("parameters");
  const auto size = [&](const char* key) { return read_affine(sizes.at(key), parameters, 0.0); };
  AffineShape shape;
  switch (cursor.at("type").choice({"box", "cylinder", "sphere", "mesh"})) {
    case 0:
      sizes.expect_keys({"x", "y", "z"});
      shape = {AffineShape::Kind::kBox, {size("x"), size("y"), size("z")}, nullptr};
      break;
    case 1:
      sizes.expect_keys({"r", "z"});
      shape = {AffineShape::Kind::kCylinder, {size("r"), size("z")}, nullptr};
      break;
    case 2:
      sizes.expect_keys({"r"});
      shape = {AffineShape::Kind::kSphere, {size("r")}, nullptr};
      break;
    default:
      shape = {AffineShape::Kind::kMesh, {}, read_mesh(sizes)};
  }
  const std::optional<JsonCursor> pose = cursor.find("pose");
  return {std::move(shape), pose ? read_affine_pose(*pose, parameters) : AffinePose{}};
}

}  // namespace modsearch::detail
