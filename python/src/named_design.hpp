#pragma once

#include <nanobind/nanobind.h>

#include <modsearch/problem/design.hpp>
#include <string>
#include <vector>

namespace modsearch::python {

/// A design as Python has it: types by their names, so that it is a value of its own and belongs to no library.
struct NamedDesign {
  struct Module {
    std::string type;
    Parameters parameters;

    friend bool operator==(const Module& a, const Module& b) {
      return a.type == b.type && a.parameters.size() == b.parameters.size() && a.parameters == b.parameters;
    }
  };
  std::vector<Module> modules;  ///< base to tip, without the base

  friend bool operator==(const NamedDesign&, const NamedDesign&) = default;
};

[[nodiscard]] NamedDesign named(const ModuleLibrary& library, const Design& design);
/// Throws std::invalid_argument, naming the module, for a type that the library does not have. The numbers are checked
/// by whoever evaluates the design.
[[nodiscard]] Design resolved(const ModuleLibrary& library, const NamedDesign& design);

/// A design from Python: a Design, or a sequence of (type, parameters) or of types alone.
/// Throws std::invalid_argument, naming the module, for anything else.
[[nodiscard]] NamedDesign design_from(nanobind::handle object);
[[nodiscard]] inline Design design_from(const ModuleLibrary& library, nanobind::handle object) {
  return resolved(library, design_from(object));
}

/// [('hinge', [0.5, 1.1])], as people write it.
[[nodiscard]] nanobind::list as_list(const NamedDesign& design);

}  // namespace modsearch::python
