#pragma once

#include <memory>
#include <modsearch/problem/design.hpp>

namespace modsearch {

/// A design whose parameters are fixed, with the library of the modules it then consists of.
struct FrozenDesign {
  std::shared_ptr<const ModuleLibrary> library;  ///< without parameters: what Timor calls a library
  Design design;
};

/// `design` as modules without parameters: lengths, masses and inertias as numbers, angles turned into poses. A module
/// that had parameters is named ID@PLACE (places from 1); one without keeps its ID and stands in the library once.
/// Throws std::invalid_argument if the design does not belong to the library.
[[nodiscard]] FrozenDesign frozen(const ModuleLibrary& library, const Design& design);

/// A library without parameters in Timor's words alone: inertias as numbers, angles turned into poses.
/// Throws std::invalid_argument, naming the module, if one has parameters.
[[nodiscard]] std::shared_ptr<const ModuleLibrary> frozen(const ModuleLibrary& library);

}  // namespace modsearch
