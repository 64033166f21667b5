#include <fmt/format.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/string_view.h>
#include <nanobind/stl/vector.h>

#include "arrays.hpp"
#include "bindings.hpp"
#include "named_design.hpp"
#include "placed_arm.hpp"

namespace modsearch::python {
namespace {

using namespace nb::literals;

const ModuleType& type_named(const ModuleLibrary& library, const std::string& type) {
  const std::optional<int> k = library.find(type);
  if (!k) throw std::invalid_argument(fmt::format("'{}' is no type of library '{}'", type, library.name()));
  return library.type(*k);
}

std::string_view role_name(ModuleRole role) {
  switch (role) {
    case ModuleRole::kBase:
      return "base";
    case ModuleRole::kLink:
      return "link";
    case ModuleRole::kJoint:
      return "joint";
    case ModuleRole::kEndEffector:
      return "end effector";
  }
  return "";
}

}  // namespace

std::vector<int> types_from(const ModuleLibrary& library, nb::handle design) {
  return design_from(library, design).types();
}

std::vector<std::string> type_names(const ModuleLibrary& library, std::span<const int> types) {
  std::vector<std::string> names;
  for (const int k : types) names.push_back(library.type(k).id);
  return names;
}

std::shared_ptr<const ModuleLibrary> library_from(nb::handle object) {
  std::shared_ptr<const ModuleLibrary> library;
  if (nb::try_cast(object, library) && library != nullptr) return library;
  const DesignProblem* problem = nullptr;
  if (nb::try_cast(object, problem) && problem != nullptr) {
    return nb::cast<std::shared_ptr<const ModuleLibrary>>(object.attr("library"));
  }
  return load_library(reference_from(object));
}

void bind_library(nb::module_& m) {
  nb::class_<ModuleLibrary>(m, "ModuleLibrary",
                            "A set of module types and the rules by which they join. Made by load_library.")
      .def_prop_ro("name", &ModuleLibrary::name, "ID or file.")
      .def_prop_ro(
          "types",
          [](const ModuleLibrary& self) {
            std::vector<std::string> names;
            for (int k = 0; k < self.n_types(); ++k) names.push_back(self.type(k).id);
            return names;
          },
          "Names of the types that a design chooses from; the base is none of them.")
      .def("__len__", &ModuleLibrary::n_types)
      .def(
          "parameters",
          [](const ModuleLibrary& self, const std::string& type) {
            nb::list list;
            for (const ParameterRange& range : type_named(self, type).parameters) {
              list.append(nb::make_tuple(range.name, range.unit, range.lower, range.upper));
            }
            return list;
          },
          "type"_a, nb::sig("def parameters(self, type: str) -> list[tuple[str, str, float, float]]"),
          "The parameters of a type: (name, unit 'm' or 'rad', lower end, upper end) each. Raises ValueError for a "
          "type\n"
          "that the library does not have.")
      .def(
          "role",
          [](const ModuleLibrary& self, const std::string& type) { return role_name(type_named(self, type).role()); },
          "type"_a, nb::sig("def role(self, type: str) -> str"), "'link', 'joint' or 'end effector'.")
      .def(
          "successors",
          [](const ModuleLibrary& self, nb::handle design) {
            const std::vector<int> next = self.successors(types_from(self, design));
            return type_names(self, next);
          },
          "design"_a = nb::tuple(), nb::sig("def successors(self, design: DesignLike = ()) -> list[str]"),
          "Types whose connectors fit the free end of `design`. A problem may allow fewer.")
      .def(
          "arm",
          [](const ModuleLibrary& self, nb::handle design, nb::handle X_WB) {
            const Eigen::Isometry3d base =
                X_WB.is_none() ? Eigen::Isometry3d::Identity() : to_pose(numbers(X_WB), "X_WB");
            return placed_arm(self, design_from(self, design), base);
          },
          "design"_a, "X_WB"_a = nb::none(),
          nb::sig("def arm(self, design: DesignLike, X_WB: numpy.typing.ArrayLike | None = None) -> Arm"),
          "The arm of `design` with nothing around it. `X_WB`: pose of the base [4, 4] (default: the world's frame).\n"
          "Raises ValueError for a design that does not belong to the library.")
      .def(
          "describe",
          [](const ModuleLibrary& self, nb::handle design) { return to_string(self, design_from(self, design)); },
          "design"_a, nb::sig("def describe(self, design: DesignLike) -> str"),
          "One line for people: 'hinge(0.5, 1.117) link(0.8)'.")
      .def("__repr__", [](const ModuleLibrary& self) {
        return fmt::format("ModuleLibrary('{}', {} types)", self.name(), self.n_types());
      });
  m.def(
      "load_library", [](nb::handle file) { return load_library(reference_from(file)); }, "id_or_file"_a,
      nb::sig("def load_library(id_or_file: str | os.PathLike[str]) -> ModuleLibrary"),
      "Reads a module library: one of Timor's with or without parameters, or a built-in one by its ID ('seed').\n"
      "Raises FileError.");
  m.def("list_libraries", &builtin_libraries, "IDs of the built-in libraries.");
}

}  // namespace modsearch::python
