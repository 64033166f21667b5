#pragma once

#include <Eigen/Core>
#include <modsearch/problem/module_library.hpp>
#include <string>
#include <vector>

namespace modsearch {

/// Parameters of one module; never on the heap.
using Parameters = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, ModuleLibrary::kMaxParameters, 1>;

/// A module of type k with its parameters x_k, in the units of the library.
struct Placement {
  int type = 0;
  Parameters parameters;

  friend bool operator==(const Placement& a, const Placement& b) {
    return a.type == b.type && a.parameters.size() == b.parameters.size() && a.parameters == b.parameters;
  }
};

/// A design: placements from base to tip, without the base itself. Every prefix of a design is a design.
struct Design {
  std::vector<Placement> modules;

  [[nodiscard]] std::vector<int> types() const;
  /// All parameters, base to tip: the x of the chain of `types()`.
  [[nodiscard]] Eigen::VectorXd parameters() const;
  /// The first `n` placements.
  [[nodiscard]] Design prefix(int n) const;

  friend bool operator==(const Design&, const Design&) = default;
};

/// The design with `types` whose parameters are the parts of `x`.
/// Throws std::invalid_argument if x has not as many entries as the types have parameters.
[[nodiscard]] Design make_design(const ModuleLibrary& library, std::span<const int> types, const Eigen::VectorXd& x);

/// Bounds of all parameters of a type sequence, base to tip.
struct ParameterBox {
  Eigen::VectorXd lower;
  Eigen::VectorXd upper;
};
[[nodiscard]] ParameterBox parameter_box(const ModuleLibrary& library, std::span<const int> types);

/// Throws std::invalid_argument (module, parameter, value, limit) unless every placement has a known type that fits the
/// one before, the right number of parameters, and all of them finite and within their intervals (1e-12 slack).
void check(const ModuleLibrary& library, const Design& design);

/// One line for people: "hinge(0.5, 1.117) link(0.8)".
[[nodiscard]] std::string to_string(const ModuleLibrary& library, const Design& design);

}  // namespace modsearch
