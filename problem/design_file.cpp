#include <fmt/format.h>

#include <algorithm>
#include <modsearch/problem/readers_internal.hpp>

namespace modsearch {
namespace detail {
namespace {

Parameters read_parameters(const JsonCursor& cursor, const ModuleType& module) {
  Parameters parameters(module.n_parameters());
  if (!cursor.value().is_object()) cursor.fail_value("an object");
  for (const auto& [name, value] : cursor.members()) {
    const auto same = [&name = name](const ParameterRange& range) { return range.name == name; };
    if (std::none_of(module.parameters.begin(), module.parameters.end(), same)) {
      value.fail(fmt::format("module \"{}\" has no such parameter (it has {})", module.id, module.n_parameters()));
    }
  }
  for (int i = 0; i < module.n_parameters(); ++i) {
    const ParameterRange& range = module.parameters[static_cast<std::size_t>(i)];
    const JsonCursor value = cursor.at(range.name);
    constexpr double kSlack = 1e-12;
    parameters[i] = value.number();
    if (parameters[i] < range.lower - kSlack || parameters[i] > range.upper + kSlack) {
      value.fail_value(fmt::format("in [{}, {}]", range.lower, range.upper));
    }
  }
  return parameters;
}

}  // namespace

Design read_design(const JsonCursor& cursor, const ModuleLibrary& library) {
  Design design;
  std::vector<int> types;
  for (const JsonCursor& entry : cursor.items()) {
    entry.expect_keys({"type", "parameters"});
    const JsonCursor type = entry.at("type");
    const std::optional<int> k = library.find(type.text());
    if (!k) {
      std::string known;
      for (int i = 0; i < std::min(library.n_types(), 12); ++i) known += (i == 0 ? "" : ", ") + library.type(i).id;
      type.fail_value(fmt::format("a module of library '{}' (known: {}{})", library.name(), known,
                                  library.n_types() > 12 ? ", ..." : ""));
    }
    types.push_back(*k);
    if (!library.fits_together(types)) type.fail_value("a module that fits the one before it");
    const ModuleType& module = library.type(*k);
    const std::optional<JsonCursor> parameters = entry.find("parameters");
    if (!parameters && module.n_parameters() > 0) entry.fail("key \"parameters\" is missing");
    design.modules.push_back({*k, parameters ? read_parameters(*parameters, module) : Parameters(0)});
  }
  return design;
}

nlohmann::ordered_json to_json(const ModuleLibrary& library, const Design& design) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const Placement& placement : design.modules) {
    const ModuleType& module = library.type(placement.type);
    nlohmann::ordered_json parameters = nlohmann::ordered_json::object();
    for (int i = 0; i < module.n_parameters(); ++i) {
      parameters[module.parameters[static_cast<std::size_t>(i)].name] = placement.parameters[i];
    }
    list.push_back({{"type", module.id}, {"parameters", std::move(parameters)}});
  }
  return list;
}

}  // namespace detail

Design load_design(const std::filesystem::path& file, const ModuleLibrary& library) {
  const detail::JsonDocument document = detail::load_json(file);
  const detail::JsonCursor root = document.cursor();
  if (document.root.is_object()) return detail::read_design(root.at("design"), library);
  if (!document.root.is_array()) root.fail_value("a design: a list of {\"type\", \"parameters\"}, or a solution");
  return detail::read_design(root, library);
}

Witness load_witness(const std::filesystem::path& file) {
  const detail::JsonDocument document = detail::load_json(file);
  Witness witness;
  if (!document.root.is_object() || !document.root.contains("postures")) return witness;
  const std::vector<detail::JsonCursor> rows = document.cursor().at("postures").items();
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const Eigen::VectorXd q =
        i == 0 ? rows[i].vector() : rows[i].vector(static_cast<std::size_t>(witness.postures.cols()));
    if (i == 0) witness.postures.resize(static_cast<Eigen::Index>(rows.size()), q.size());
    witness.postures.row(static_cast<Eigen::Index>(i)) = q.transpose();
  }
  return witness;
}

std::string design_to_json(const ModuleLibrary& library, const Design& design) {
  check(library, design);
  return detail::to_text(detail::to_json(library, design));
}

}  // namespace modsearch
