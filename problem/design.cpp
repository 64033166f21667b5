#include <modsearch/problem/design.hpp>

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

namespace modsearch {

std::vector<int> Design::types() const {
  std::vector<int> result;
  result.reserve(modules.size());
  for (const Placement& placement : modules) result.push_back(placement.type);
  return result;
}

Eigen::VectorXd Design::parameters() const {
  Eigen::Index n = 0;
  for (const Placement& placement : modules) n += placement.parameters.size();
  Eigen::VectorXd x(n);
  Eigen::Index at = 0;
  for (const Placement& placement : modules) {
    x.segment(at, placement.parameters.size()) = placement.parameters;
    at += placement.parameters.size();
  }
  return x;
}

Design Design::prefix(int n) const { return {{modules.begin(), modules.begin() + n}}; }

Design make_design(const ModuleLibrary& library, std::span<const int> types, const Eigen::VectorXd& x) {
  Design design;
  Eigen::Index at = 0;
  for (const int k : types) {
    const Eigen::Index n = library.type(k).n_parameters();
    if (at + n > x.size()) break;
    design.modules.push_back({k, x.segment(at, n)});
    at += n;
  }
  if (design.modules.size() != types.size() || at != x.size()) {
    throw std::invalid_argument(
        fmt::format("make_design: {} parameters given, the sequence has {}", x.size(),
                    parameter_box(library, types).lower.size()));
  }
  return design;
}

ParameterBox parameter_box(const ModuleLibrary& library, std::span<const int> types) {
  std::vector<double> lower;
  std::vector<double> upper;
  for (const int k : types) {
    for (const ParameterRange& range : library.type(k).parameters) {
      lower.push_back(range.lower);
      upper.push_back(range.upper);
    }
  }
  const auto n = static_cast<Eigen::Index>(lower.size());
  return {Eigen::Map<Eigen::VectorXd>(lower.data(), n), Eigen::Map<Eigen::VectorXd>(upper.data(), n)};
}

void check(const ModuleLibrary& library, const Design& design) {
  constexpr double kSlack = 1e-12;  // rounding of a number that was written and read back
  for (std::size_t i = 0; i < design.modules.size(); ++i) {
    const Placement& placement = design.modules[i];
    if (placement.type < 0 || placement.type >= library.n_types()) {
      throw std::invalid_argument(fmt::format("module {} of the design: type {} is not in [0, {})", i, placement.type,
                                              library.n_types()));
    }
    const ModuleType& type = library.type(placement.type);
    if (placement.parameters.size() != type.n_parameters()) {
      throw std::invalid_argument(fmt::format("module {} of the design ({}): {} parameters given, the type has {}", i,
                                              type.id, placement.parameters.size(), type.n_parameters()));
    }
    for (int p = 0; p < type.n_parameters(); ++p) {
      const ParameterRange& range = type.parameters[static_cast<std::size_t>(p)];
      const double value = placement.parameters[p];
      if (!(value >= range.lower - kSlack && value <= range.upper + kSlack)) {  // refuses NaN too
        throw std::invalid_argument(fmt::format("module {} of the design ({}): {} is {} {}, not in [{}, {}]", i,
                                                type.id, range.name, value, range.unit, range.lower, range.upper));
      }
    }
  }
  const std::vector<int> types = design.types();
  for (std::size_t i = 0; i < types.size(); ++i) {
    if (!library.fits_together(std::span{types}.first(i + 1))) {
      throw std::invalid_argument(fmt::format("module {} of the design ({}): its connectors do not fit the {} before it",
                                              i, library.type(types[i]).id,
                                              i == 0 ? library.base().id : library.type(types[i - 1]).id));
    }
  }
}

std::string to_string(const ModuleLibrary& library, const Design& design) {
  if (design.modules.empty()) return "(empty)";
  std::string text;
  for (const Placement& placement : design.modules) {
    if (!text.empty()) text += ' ';
    text += library.type(placement.type).id;
    if (placement.parameters.size() == 0) continue;
    text += '(';
    for (Eigen::Index p = 0; p < placement.parameters.size(); ++p) {
      text += fmt::format("{}{:.4g}", p == 0 ? "" : ", ", placement.parameters[p]);
    }
    text += ')';
  }
  return text;
}

}  // namespace modsearch
