#pragma once

#include <nanobind/nanobind.h>

#include <memory>
#include <modsearch/problem/files.hpp>
#include <modsearch/problem/robot_problem.hpp>
#include <optional>
#include <string>

namespace modsearch::python {

namespace nb = nanobind;

void bind_library(nb::module_& m);
void bind_design(nb::module_& m);
void bind_evaluation(nb::module_& m);
void bind_arm(nb::module_& m);
void bind_problem(nb::module_& m);
void bind_solver(nb::module_& m);
void bind_files(nb::module_& m);
void bind_environment(nb::module_& m);
void bind_vector_environment(nb::module_& m);

/// Where a problem was loaded from: what a solution file says of it.
struct Origin {
  std::string reference;             ///< file or ID, as given
  std::optional<Instance> instance;  ///< of a sampled problem
  std::optional<Sampling> sampling;
};
/// The origin of a problem that came from load_problem; nothing for another.
[[nodiscard]] std::optional<Origin> origin_of(nb::handle problem);

/// A library from Python: a library, a problem (its library), or an ID or file.
[[nodiscard]] std::shared_ptr<const ModuleLibrary> library_from(nb::handle object);

/// What is near a position [3] or a pose [4, 4]: within `tolerance` [m] and, of a pose, `angle` [rad].
/// Throws std::invalid_argument for anything else.
[[nodiscard]] PoseRegion region_about(nb::handle target, double tolerance, double angle);
/// (seed, index), or None. Throws std::invalid_argument for anything else.
[[nodiscard]] std::optional<Instance> instance_from(nb::handle object);
/// An ID or a path as text. Throws std::invalid_argument for anything else.
[[nodiscard]] std::string reference_from(nb::handle object);

}  // namespace modsearch::python
