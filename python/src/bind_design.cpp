#include <fmt/format.h>
#include <nanobind/make_iterator.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <modsearch/problem/files.hpp>
#include <modsearch/problem/readers_internal.hpp>

#include "arrays.hpp"
#include "bindings.hpp"
#include "named_design.hpp"

namespace modsearch::python {
namespace {

using namespace nb::literals;

Parameters parameters_from(nb::handle object, std::size_t place) {
  const Eigen::VectorXd values = to_vector(object, "the parameters of a module");
  if (values.size() > ModuleLibrary::kMaxParameters) {
    throw std::invalid_argument(fmt::format("module {} of the design: {} parameters given, no type has more than {}",
                                            place, values.size(), ModuleLibrary::kMaxParameters));
  }
  return values;
}

NamedDesign::Module module_from(nb::handle item, std::size_t place) {
  if (nb::isinstance<nb::str>(item)) return {nb::cast<std::string>(item), Parameters(0)};
  if (nb::isinstance<nb::sequence>(item) && nb::len(item) == 2 && nb::isinstance<nb::str>(item[0])) {
    return {nb::cast<std::string>(item[0]), parameters_from(item[1], place)};
  }
  throw std::invalid_argument(
      fmt::format("module {} of the design: {} is neither (type, parameters) nor the name of a type", place,
                  nb::cast<std::string>(nb::repr(item))));
}

std::pair<nb::str, nb::object> item(const NamedDesign::Module& module) {
  const std::span<const double> values{module.parameters.data(), static_cast<std::size_t>(module.parameters.size())};
  return {nb::str(module.type.c_str(), module.type.size()), nb::cast(to_array(values))};
}

const NamedDesign::Module& module_at(const NamedDesign& design, std::ptrdiff_t i) {
  const auto n = static_cast<std::ptrdiff_t>(design.modules.size());
  if (i < -n || i >= n) throw nb::index_error(fmt::format("module {} of a design of {}", i, n).c_str());
  return design.modules[static_cast<std::size_t>(i < 0 ? i + n : i)];
}

Eigen::VectorXd all_parameters(const NamedDesign& design) {
  std::vector<double> x;
  for (const NamedDesign::Module& module : design.modules) {
    x.insert(x.end(), module.parameters.data(), module.parameters.data() + module.parameters.size());
  }
  return Eigen::Map<Eigen::VectorXd>(x.data(), static_cast<Eigen::Index>(x.size()));
}

NamedDesign from_json(const std::string& text, nb::handle library) {
  const std::shared_ptr<const ModuleLibrary> known = library_from(library);
  const detail::JsonDocument document = detail::parse_json(text, {.label = "design", .directory = "."});
  const detail::JsonCursor root = document.cursor();
  return named(*known, detail::read_design(document.root.is_object() ? root.at("design") : root, *known));
}

}  // namespace

NamedDesign named(const ModuleLibrary& library, const Design& design) {
  NamedDesign result;
  for (const Placement& placement : design.modules) {
    result.modules.push_back({library.type(placement.type).id, placement.parameters});
  }
  return result;
}

Design resolved(const ModuleLibrary& library, const NamedDesign& design) {
  Design result;
  result.modules.reserve(design.modules.size());
  for (std::size_t i = 0; i < design.modules.size(); ++i) {
    const NamedDesign::Module& module = design.modules[i];
    const std::optional<int> k = library.find(module.type);
    if (!k) {
      std::string types;
      for (int other = 0; other < library.n_types(); ++other) {
        types += (other == 0 ? "" : ", ") + library.type(other).id;
      }
      throw std::invalid_argument(fmt::format("module {} of the design: '{}' is no type of library '{}', which has {}",
                                              i, module.type, library.name(), types));
    }
    result.modules.push_back({*k, module.parameters});
  }
  return result;
}

NamedDesign design_from(nb::handle object) {
  const NamedDesign* known = nullptr;
  if (nb::try_cast(object, known, false) && known != nullptr) return *known;
  // A text is a sequence of texts, too, and never a design.
  if (nb::isinstance<nb::str>(object) || !nb::isinstance<nb::iterable>(object)) {
    throw std::invalid_argument(fmt::format("{} is no design: a list of (type, parameters) is needed",
                                            nb::cast<std::string>(nb::repr(object))));
  }
  NamedDesign design;
  for (const nb::handle each : object) design.modules.push_back(module_from(each, design.modules.size()));
  return design;
}

nb::list as_list(const NamedDesign& design) {
  nb::list list;
  for (const NamedDesign::Module& module : design.modules) {
    nb::list parameters;
    for (const double value : module.parameters) parameters.append(value);
    list.append(nb::make_tuple(module.type, parameters));
  }
  return list;
}

void bind_design(nb::module_& m) {
  nb::class_<NamedDesign>(m, "Design",
                          "A design: modules from base to tip, without the base itself, as (type, parameters).\n\n"
                          "A value: it can be compared, hashed, pickled and copied, and belongs to no library, so "
                          "nothing is checked\nbefore somebody evaluates it. It acts as a sequence of (type, array "
                          "of parameters [m or rad]).")
      .def(
          "__init__", [](NamedDesign* self, nb::handle modules) { new (self) NamedDesign(design_from(modules)); },
          "modules"_a = nb::tuple(), nb::sig("def __init__(self, modules: DesignLike = ()) -> None"),
          "`modules`: (type, parameters) for each module, base to tip, or the type alone where it has no parameters;\n"
          "parameters in the order and units of the library. Raises ValueError for anything else.")
      .def("__len__", [](const NamedDesign& self) { return self.modules.size(); })
      .def(
          "__getitem__", [](const NamedDesign& self, std::ptrdiff_t i) { return item(module_at(self, i)); }, "index"_a,
          nb::sig("def __getitem__(self, index: int) -> tuple[str, numpy.typing.NDArray[numpy.float64]]"))
      .def(
          "__iter__",
          [](const NamedDesign& self) {
            nb::list list;
            for (const NamedDesign::Module& module : self.modules) list.append(nb::cast(item(module)));
            return nb::iter(list);
          },
          nb::sig("def __iter__(self) -> collections.abc.Iterator[tuple[str, "
                  "numpy.typing.NDArray[numpy.float64]]]"))
      .def(
          "__eq__",
          [](const NamedDesign& self, nb::handle other) {
            const NamedDesign* known = nullptr;
            return nb::try_cast(other, known, false) && known != nullptr && *known == self;
          },
          nb::sig("def __eq__(self, other: object, /) -> bool"), "other"_a.none())
      .def("__hash__",
           [](const NamedDesign& self) {
             nb::list hashable;
             for (const NamedDesign::Module& module : self.modules) {
               hashable.append(module.type);
               for (const double value : module.parameters) hashable.append(value);
             }
             return nb::hash(nb::tuple(hashable));
           })
      .def("__repr__",
           [](const NamedDesign& self) {
             return fmt::format("Design({})", nb::cast<std::string>(nb::repr(as_list(self))));
           })
      .def_prop_ro(
          "types",
          [](const NamedDesign& self) {
            std::vector<std::string> types;
            for (const NamedDesign::Module& module : self.modules) types.push_back(module.type);
            return types;
          },
          "Names of the types, base to tip.")
      .def_prop_ro(
          "parameters", [](const NamedDesign& self) { return to_array(all_parameters(self)); }, kFresh,
          "All parameters, base to tip [n_parameters], m or rad.")
      .def(
          "prefix",
          [](const NamedDesign& self, std::size_t n) {
            if (n > self.modules.size()) {
              throw std::invalid_argument(fmt::format("prefix of {} modules of {}", n, self.modules.size()));
            }
            return NamedDesign{{self.modules.begin(), self.modules.begin() + static_cast<std::ptrdiff_t>(n)}};
          },
          "n"_a, "The first `n` modules: a design, too.")
      .def(
          "to_json",
          [](const NamedDesign& self, nb::handle library) {
            const std::shared_ptr<const ModuleLibrary> known = library_from(library);
            return design_to_json(*known, resolved(*known, self));
          },
          "library"_a, nb::sig("def to_json(self, library: LibraryLike) -> str"),
          "The design as the JSON text of a design file, with its parameters by name. `library`: a library, a "
          "problem,\n"
          "or the ID or file of a library. Raises ValueError if the design does not belong to it.")
      .def_static("from_json", &from_json, "text"_a, "library"_a,
                  nb::sig("def from_json(text: str, library: LibraryLike) -> Design"),
                  "The design in `text`, that of a design file or of a solution file. Raises FileError.")
      .def("__getstate__", [](const NamedDesign& self) { return nb::make_tuple(as_list(self)); })
      .def(
          "__setstate__",
          [](NamedDesign& self, const nb::tuple& state) { new (&self) NamedDesign(design_from(state[0])); },
          nb::sig("def __setstate__(self, state: tuple[typing.Any, ...], /) -> None"));
}

}  // namespace modsearch::python
