#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <modsearch/problem/convert.hpp>
#include <modsearch/problem/frozen_design.hpp>
#include <modsearch/problem/geometry_internal.hpp>
#include <modsearch/problem/library_write_internal.hpp>
#include <modsearch/problem/neighbour_files_internal.hpp>
#include <modsearch/problem/readers_internal.hpp>
#include <modsearch/problem/relative_path_internal.hpp>
#include <modsearch/problem/urdf.hpp>

namespace modsearch {
namespace detail {
namespace {

using nlohmann::ordered_json;

constexpr std::array<std::pair<FileFormat, std::string_view>, 4> kFormats{{{FileFormat::kModsearch, "modsearch"},
                                                                           {FileFormat::kTimor, "timor"},
                                                                           {FileFormat::kCobra, "cobra"},
                                                                           {FileFormat::kUrdf, "urdf"}}};

[[noreturn]] void refuse(const JsonCursor& place, std::string_view what, FileFormat to, std::string_view why) {
  place.fail(fmt::format("{} cannot be written as {}: {}", what, name(to), why));
}

/// Keys as people write them; the others follow in the order of their names.
ordered_json in_usual_order(const Json& value) {
  static const std::vector<std::string> kOrder{"modsearch",
                                               "header",
                                               "ID",
                                               "name",
                                               "version",
                                               "taskID",
                                               "problem",
                                               "instance",
                                               "type",
                                               "task",
                                               "library",
                                               "maxModules",
                                               "collision",
                                               "scoring",
                                               "sampling",
                                               "parameters",
                                               "mass",
                                               "inertia",
                                               "r_com",
                                               "parent",
                                               "child",
                                               "ignore_collisions",
                                               "modules",
                                               "obstacles",
                                               "constraints",
                                               "goals",
                                               "moduleSet",
                                               "moduleOrder",
                                               "moduleConnection",
                                               "baseConnection",
                                               "basePose",
                                               "design",
                                               "parts",
                                               "order",
                                               "pose",
                                               "nominal",
                                               "toleranceProjection",
                                               "tolerance",
                                               "bodies",
                                               "joints"};
  if (value.is_array()) {
    ordered_json list = ordered_json::array();
    for (const Json& entry : value) list.push_back(in_usual_order(entry));
    return list;
  }
  if (!value.is_object()) return ordered_json(value);
  const auto rank = [](const std::string& key) {
    return std::find(kOrder.begin(), kOrder.end(), key) - kOrder.begin();
  };
  std::vector<std::string> keys;
  for (const auto& entry : value.items()) keys.push_back(entry.key());
  std::stable_sort(keys.begin(), keys.end(), [&](const auto& a, const auto& b) { return rank(a) < rank(b); });
  ordered_json object = ordered_json::object();
  for (const std::string& key : keys) object[key] = in_usual_order(value.at(key));
  return object;
}

/// Names a file that a document in `from` refers to for one in `to`.
void rename_file(Json& name, const std::filesystem::path& from, const std::filesystem::path& to) {
  name = relative_to(from / name.get<std::string>(), to);
}

/// Every mesh of a document from `from`, collision and visual, for one in `to`.
void rename_meshes(Json& value, const JsonSource& from, const std::filesystem::path& to) {
  if (value.is_object() && value.value("type", Json{}) == "mesh" && value.contains("parameters") &&
      value["parameters"].is_object() && value["parameters"].value("file", Json{}).is_string()) {
    Json& file = value["parameters"]["file"];
    file = relative_to(mesh_path(file.get<std::string>(), from), to);
  }
  if (!value.is_structured()) return;
  for (Json& entry : value) rename_meshes(entry, from, to);
}

/// Infinite limits, for which JSON has no word: marked for Timor, whose files say Infinity all the same, and left out
/// in our format, where a limit that is missing is infinite.
void settle_infinity(Json& value, bool marked) {
  if (!value.is_structured()) return;
  for (auto entry = value.begin(); entry != value.end();) {
    const bool infinite = value.is_object() && entry->is_number_float() && !std::isfinite(entry->get<double>());
    if (infinite && marked) *entry = infinity_mark(entry->get<double>());
    if (!infinite) settle_infinity(*entry, marked);
    entry = infinite && !marked ? value.erase(entry) : std::next(entry);
  }
}

/// The module says something that Timor's format has no word for.
bool only_ours(const ModuleType& module) {
  return std::any_of(module.bodies.begin(), module.bodies.end(),
                     [](const auto& body) { return body.uniform_inertia; }) ||
         std::any_of(module.joints.begin(), module.joints.end(),
                     [](const auto& joint) { return joint.angle.offset != 0.0; });
}

/// Converts one document.
class Converter {
 public:
  Converter(JsonDocument document, ConvertOptions options)
      : document_{std::move(document)}, options_{std::move(options)} {}

  [[nodiscard]] std::string text() const {
    const Json& root = document_.root;
    if (is_list_of_modules(root)) return library();
    if (root.is_array()) return design();
    if (!root.is_object()) cursor().fail_value("a library, a task, a problem, a solution or a design");
    if (root.contains("modules")) return library();
    if (root.contains("task") || root.contains("sampling")) return problem();
    if (root.contains("goals")) return task();
    if (root.contains("taskID")) return solution();
    if (root.contains("moduleOrder") || root.contains("design")) return design();
    cursor().fail(
        "is no library (\"modules\"), task (\"goals\"), problem (\"task\"), solution (\"taskID\") or design "
        "(\"moduleOrder\", or a list)");
  }

 private:
  [[nodiscard]] JsonCursor cursor() const { return document_.cursor(); }

  /// The document itself, with what it refers to named from the new folder.
  [[nodiscard]] Json moved() const { return moved(options_.folder); }
  [[nodiscard]] Json moved(const std::filesystem::path& folder) const {
    Json copy = document_.root;
    rename_meshes(copy, *document_.source, folder);
    drop_free_tolerances(copy);
    settle_infinity(copy, options_.to == FileFormat::kTimor);
    return copy;
  }

  /// A library in its older form of a bare list gets the name that its list has today.
  [[nodiscard]] Json moved_library() const {
    Json copy = moved();
    return copy.is_array() ? Json{{"modules", std::move(copy)}} : copy;
  }

  [[nodiscard]] std::string library() const {
    const auto read = read_library(cursor(), document_.source->label);
    switch (options_.to) {
      case FileFormat::kModsearch:
        return to_text(in_usual_order(moved_library()));
      case FileFormat::kTimor:
        return timor(*read, cursor());
      case FileFormat::kCobra:
      case FileFormat::kUrdf:
        break;
    }
    refuse(cursor(), "a library", options_.to, "it is no single arm (limit: modsearch, timor)");
  }

  [[nodiscard]] std::string timor(const ModuleLibrary& given, const JsonCursor& place) const {
    for (int k = 0; k < given.n_types(); ++k) {
      const ModuleType& module = given.type(k);
      if (module.n_parameters() > 0) {
        refuse(place, "the library", options_.to,
               fmt::format("module \"{}\" has parameters, which only a design fixes", module.id));
      }
    }
    bool as_it_is = !only_ours(given.base());
    for (int k = 0; k < given.n_types(); ++k) as_it_is = as_it_is && !only_ours(given.type(k));
    require_dates();
    if (as_it_is) return timor_text(in_usual_order(moved_library()));
    // An inertia may have to be worked out from meshes, which were not opened.
    JsonSource source = *document_.source;
    source.open_meshes = true;
    const JsonDocument opened{std::make_shared<const JsonSource>(source), document_.root};
    return timor_text(*place.guard([&] { return frozen(*read_library(opened.cursor(), source.label)); }));
  }

  /// Of the headers of a library's modules.
  void require_dates() const {
    const JsonCursor list = document_.root.is_array() ? cursor() : cursor().at("modules");
    for (const JsonCursor& module : list.items_or_single()) require_date(module.at("header"), "timor");
  }

  [[nodiscard]] std::string task() const {
    const TaskFile read = read_task(cursor());
    if (options_.to == FileFormat::kTimor || options_.to == FileFormat::kUrdf) {
      refuse(cursor(), "a task", options_.to, "it holds no modules (limit: modsearch, cobra)");
    }
    if (options_.to != FileFormat::kCobra) return to_text(in_usual_order(moved()));
    require_cobras_task(cursor());
    const std::string id = cursor().at("header").at("ID").text();
    ordered_json theirs = in_usual_order(moved(package_root(id, options_.folder)));
    settle_for_cobra(theirs);
    return to_text(theirs);
  }

  [[nodiscard]] std::string problem() const {
    const std::filesystem::path& from = document_.source->directory;
    switch (options_.to) {
      case FileFormat::kModsearch: {
        Json copy = moved();
        if (copy.contains("task") && copy["task"].is_string()) rename_file(copy["task"], from, options_.folder);
        const bool named = copy.contains("library") && copy["library"].is_string();
        if (named && !builtin_library(copy["library"].get<std::string>())) {
          rename_file(copy["library"], from, options_.folder);
        }
        return to_text(in_usual_order(copy));
      }
      case FileFormat::kTimor:
        return part("library");
      case FileFormat::kCobra:
        if (cursor().has("sampling")) {
          refuse(cursor().at("sampling"), "a sampled problem", options_.to, "CoBRA's tasks have fixed goals");
        }
        return part("task");
      case FileFormat::kUrdf:
        break;
    }
    refuse(cursor(), "a problem", options_.to, "it holds no design (limit: modsearch, timor, cobra)");
  }

  /// What a problem holds or names, converted by itself.
  [[nodiscard]] std::string part(const char* key) const {
    const JsonCursor named = cursor().at(key);
    if (!named.value().is_string()) {
      return Converter{{document_.source, named.value()}, options_}.text();
    }
    const std::string file = named.text();
    if (builtin_library(file)) return convert(file, options_);
    const JsonSource& source = *document_.source;
    return Converter{load_json(source.directory / file, source.label, source.mesh_root), options_}.text();
  }

  /// One of CoBRA's own claims no score and becomes its design.
  [[nodiscard]] std::string solution() const {
    if (options_.to != FileFormat::kModsearch || !cursor().has("modsearch")) return design();
    Json copy = moved();
    const auto problem = copy.value("problem", std::string{});
    if (!problem.empty() && !builtin_problem(problem)) {
      rename_file(copy["problem"], document_.source->directory, options_.folder);
    }
    return to_text(in_usual_order(copy));
  }

  /// The library that a design is read with: as its problem names it, whether its base may be placed or not.
  [[nodiscard]] std::shared_ptr<const ModuleLibrary> library_of_design() const {
    if (options_.library) {
      return load_library_from(*options_.library, {.label = {}, .directory = {}, .mesh_root = options_.mesh_root});
    }
    const Json& root = document_.root;
    const bool placements = !root.is_array() || root.empty() || (root[0].is_object() && root[0].contains("type"));
    if (!placements) {
      cursor().items()[0].fail_value(
          "the placement of a module, a \"type\", as in a design, nor a module with a \"header\", as in a library");
    }
    const std::optional<JsonCursor> named = document_.root.is_object() ? cursor().find("problem") : std::nullopt;
    if (!named) cursor().fail("the design names no library: give one with --library");
    const std::string problem = named->text();
    const std::optional<std::string_view> builtin = builtin_problem(problem);
    const JsonDocument document = builtin ? parse_json(std::string{*builtin}, {"built-in problem " + problem, {}})
                                          : load_json(document_.source->directory / problem, document_.source->label,
                                                      document_.source->mesh_root);
    const JsonCursor library = document.cursor().at("library");
    if (!library.value().is_string()) return read_library(library, problem);
    return load_library_from(library.text(), *document.source);
  }

  /// The design without its base, which stands in it where the problem lets it be placed.
  [[nodiscard]] Design read(const ModuleLibrary& modules) const {
    if (document_.root.is_object() && !cursor().has("design")) {
      return read_module_order(cursor().at("moduleOrder"), modules);
    }
    Json list = document_.root.is_object() ? document_.root.at("design") : document_.root;
    const bool placed =
        list.is_array() && !list.empty() && list[0].is_object() && list[0].value("type", Json{}) == modules.base().id;
    if (placed) list.erase(0);
    return read_design({list, document_.source, document_.root.is_object() ? "/design" : ""}, modules);
  }

  [[nodiscard]] Eigen::Isometry3d base_pose() const {
    if (!document_.root.is_object() || !cursor().has("basePose")) return Eigen::Isometry3d::Identity();
    const JsonCursor pose = cursor().at("basePose");
    const bool listed = pose.value().is_array() && pose.value().size() == 1;  // CoBRA lists one pose per base
    return (listed ? pose.items()[0] : pose).pose();
  }

  [[nodiscard]] std::string design() const {
    const std::shared_ptr<const ModuleLibrary> modules = library_of_design();
    const Design given = read(*modules);
    switch (options_.to) {
      case FileFormat::kModsearch:
        return to_text(to_json(*modules, given));
      case FileFormat::kTimor:
        return timor_text(*frozen_here(*modules, given).library);
      case FileFormat::kCobra:
        return cobra_solution(frozen_here(*modules, given));
      case FileFormat::kUrdf:
        return cursor().guard([&] {
          return to_urdf(*modules, given,
                         {.name = std::filesystem::path{document_.source->label}.stem().string(),
                          .folder = options_.folder,
                          .X_WB = base_pose()});
        });
    }
    return {};
  }

  [[nodiscard]] FrozenDesign frozen_here(const ModuleLibrary& modules, const Design& given) const {
    return cursor().guard([&] { return frozen(modules, given); });
  }

  [[nodiscard]] std::string timor_text(const ModuleLibrary& modules) const {
    return timor_text(to_json(modules, {.folder = options_.folder, .bare_infinity = true}));
  }

  [[nodiscard]] static std::string timor_text(ordered_json library) {
    settle_for_timor(library);
    return with_bare_infinity(to_text(library));
  }

  [[nodiscard]] static double mass_of(const FrozenDesign& design) {
    return design.library->assemble(design.design.types()).at(design.design.parameters()).mass();
  }

  /// CoBRA's keys of a solution, the assembly by the names of the frozen modules.
  [[nodiscard]] std::string cobra_solution(const FrozenDesign& design) const {
    static const std::vector<std::string> kKept{
        "version",    "taskID", "author",       "email",           "affiliation",  "publication",
        "date",       "notes",  "tags",         "acknowledgement", "moduleSet",    "basePose",
        "trajectory", "cost",   "costFunction", "computationTime", "processorName"};
    ordered_json out = ordered_json::object();
    for (const std::string& key : kKept) {
      if (document_.root.is_object() && document_.root.contains(key)) out[key] = in_usual_order(document_.root.at(key));
    }
    out["basePose"] = ordered_json::array({to_json(base_pose())});
    if (document_.root.is_object()) require_date(cursor(), "cobra");
    settle_solution_for_cobra(out, *design.library, mass_of(design));
    if (!out.contains("taskID")) out.erase("trajectory");  // an assembly, which solves nothing
    add_assembly(*design.library, design.design, false, out);
    return to_text(out);
  }

  JsonDocument document_;
  ConvertOptions options_;
};

JsonDocument document_of(const std::string& file, const std::optional<std::filesystem::path>& mesh_root) {
  for (const auto& text : {builtin_library(file), builtin_problem(file)}) {
    if (text) return parse_json(std::string{*text}, {"built-in " + file, {}});
  }
  const std::string text = read_text(file, file);
  const std::size_t first = text.find_first_not_of(" \t\r\n\xEF\xBB\xBF");
  if (first != std::string::npos && text[first] == '<') {
    throw FileError(fmt::format("{}: is XML: URDF can be written, not read (limit: JSON)", file));
  }
  return parse_json(text, {.label = file,
                           .directory = std::filesystem::path{file}.parent_path(),
                           .open_meshes = false,
                           .mesh_root = mesh_root});
}

}  // namespace
}  // namespace detail

std::string_view name(FileFormat format) {
  return std::find_if(detail::kFormats.begin(), detail::kFormats.end(),
                      [&](const auto& entry) { return entry.first == format; })
      ->second;
}

std::optional<FileFormat> file_format_from_name(std::string_view name) {
  const auto found = std::find_if(detail::kFormats.begin(), detail::kFormats.end(),
                                  [&](const auto& entry) { return entry.second == name; });
  return found == detail::kFormats.end() ? std::nullopt : std::optional{found->first};
}

std::string convert(const std::string& file, const ConvertOptions& options) {
  return detail::Converter{detail::document_of(file, options.mesh_root), options}.text();
}

}  // namespace modsearch
