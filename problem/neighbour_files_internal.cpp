#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <modsearch/problem/library_write_internal.hpp>
#include <modsearch/problem/neighbour_files_internal.hpp>
#include <numbers>
#include <set>

namespace modsearch::detail {
namespace {

using nlohmann::ordered_json;
using Keys = std::initializer_list<std::string_view>;

bool among(std::string_view key, Keys keys) { return std::find(keys.begin(), keys.end(), key) != keys.end(); }

void keep_only(ordered_json& object, Keys keys) {
  for (auto entry = object.begin(); entry != object.end();) {
    entry = among(entry.key(), keys) ? std::next(entry) : object.erase(entry);
  }
}

/// Our free texts in a part of a file in which Timor's readers take none.
void drop_free_texts(ordered_json& value) {
  if (!value.is_structured()) return;
  for (auto entry = value.begin(); entry != value.end();) {
    const bool text = value.is_object() && among(entry.key(), {"author", "email", "affiliation", "acknowledgement",
                                                               "notes", "tags", "publication", "date"});
    if (!text) drop_free_texts(*entry);
    entry = text ? value.erase(entry) : std::next(entry);
  }
}

/// A list, where one object may stand for a list of one.
ordered_json& as_list(ordered_json& value) {
  if (value.is_object()) value = ordered_json::array({value});
  return value;
}

/// `name`, made one that `taken` does not hold with the help of `id`.
std::string unique_name(std::string name, const std::string& id, std::set<std::string>& taken) {
  while (!taken.insert(name).second) name += fmt::format(" {}", id);
  return name;
}

/// A joint has limits in Timor's files, a fixed one too; one that turns without end has none that are finite.
void settle_limits(ordered_json& joint) {
  const std::string type = joint.value("type", std::string{});
  const double infinity = std::numeric_limits<double>::infinity();
  if (type != "fixed" && type != "continuous") return;
  if (!joint.contains("limits")) joint["limits"] = ordered_json::object();
  joint["limits"]["positionLower"] = infinity_mark(-infinity);
  joint["limits"]["positionUpper"] = infinity_mark(infinity);
}

void settle_module(ordered_json& module, std::set<std::string>& names) {
  ordered_json& header = module["header"];
  const auto id = header.at("ID").get<std::string>();
  keep_only(header, {"ID", "name", "date", "author", "email", "affiliation", "cost"});
  const bool named = header.contains("name") && header["name"].is_string();
  header["name"] = unique_name(named ? header["name"].get<std::string>() : id, id, names);
  drop_free_texts(as_list(module["bodies"]));
  if (!module.contains("joints")) return;
  for (ordered_json& joint : as_list(module["joints"])) settle_limits(joint);
  drop_free_texts(module["joints"]);
}

/// Timor takes a list of frames by their names, one for each projection.
void settle_tolerance_frames(ordered_json& value) {
  if (!value.is_structured()) return;
  if (value.is_object() && value.contains("frame") && value.contains("nominal")) {
    value["toleranceFrame"] = value["frame"];
    value.erase("frame");
  }
  if (value.is_object() && value.contains("toleranceProjection") && value.contains("toleranceFrame") &&
      value["toleranceFrame"].is_string()) {
    const ordered_json frame = value["toleranceFrame"];
    value["toleranceFrame"] = ordered_json(value["toleranceProjection"].size(), frame);
  }
  for (ordered_json& entry : value) settle_tolerance_frames(entry);
}

/// Refuses frames of tolerances that are given as matrices anywhere below `cursor`.
void require_named_frames(const JsonCursor& cursor) {
  const Json& value = cursor.value();
  if (value.is_array()) {
    for (const JsonCursor& entry : cursor.items()) {
      if (entry.value().is_structured()) require_named_frames(entry);
    }
  }
  if (!value.is_object()) return;
  for (const auto& [key, entry] : cursor.members()) {
    const bool frames = key == "toleranceFrame" || key == "frame";
    const auto nameless = [](const Json& each) { return !each.is_string(); };
    if (frames && entry.value().is_array() && std::any_of(entry.value().begin(), entry.value().end(), nameless)) {
      entry.fail("a frame given as a matrix cannot be written as cobra: name it in \"frames\"");
    }
    if (entry.value().is_structured()) require_named_frames(entry);
  }
}

/// A pose with its tolerances, and nothing that only looks like one, say in a free text.
bool is_tolerated_pose(const Json& value) {
  if (!value.is_object() || !value.contains("toleranceProjection") || !value.contains("tolerance")) return false;
  const Json& intervals = value["tolerance"];
  const auto is_interval = [](const Json& each) {
    return each.is_array() && each.size() == 2 && each[0].is_number() && each[1].is_number();
  };
  return value["toleranceProjection"].is_array() && intervals.is_array() &&
         intervals.size() == value["toleranceProjection"].size() &&
         std::all_of(intervals.begin(), intervals.end(), is_interval);
}

/// "cyc", "mass_0.5,numJ", ..: names of CoBRA's with weights.
bool is_cobras_cost(const ordered_json& function) {
  if (!function.is_string()) return false;
  std::string_view rest = function.get_ref<const std::string&>();
  for (bool more = true; more;) {
    const std::size_t end = rest.find(',');
    const std::string_view term = rest.substr(0, end);
    if (!among(term.substr(0, term.find('_')),
               {"cyc", "mechEnergy", "linkMechEnergy", "qDist", "effort", "mass", "numJ", "fulfillN", "fulfillP"})) {
      return false;
    }
    more = end != std::string_view::npos;
    if (more) rest.remove_prefix(end + 1);
  }
  return true;
}

}  // namespace

void settle_for_timor(ordered_json& library) {
  keep_only(library, {"ignore_collisions", "modules"});
  std::set<std::string> names;
  for (ordered_json& module : as_list(library["modules"])) settle_module(module, names);
}

void settle_for_cobra(ordered_json& task) {
  keep_only(task, {"header", "obstacles", "constraints", "goals", "objects", "frames"});
  keep_only(task["header"],
            {"ID", "version", "taskName", "tags", "date", "timeStepSize", "gravity", "author", "email", "affiliation"});
  for (const char* key : {"obstacles", "constraints", "goals"}) {
    if (!task.contains(key)) task[key] = ordered_json::array();
    drop_free_texts(as_list(task[key]));
    settle_tolerance_frames(task[key]);
  }
  for (ordered_json& constraint : task["constraints"]) {
    if (constraint.contains("pose") && constraint["pose"].is_array()) {
      constraint["pose"] = {{"nominal", ordered_json(constraint["pose"])}};
    }
  }
}

void require_date(const JsonCursor& header, std::string_view format) {
  const std::optional<JsonCursor> date = header.find("date");
  if (!date) return;
  const std::string text = date->value().is_string() ? date->text() : "";
  constexpr std::string_view kPattern = "0000-00-00";
  const auto matches = [](char given, char pattern) {
    return pattern == '0' ? given >= '0' && given <= '9' : given == '-' || given == '/';
  };
  if (!std::equal(text.begin(), text.end(), kPattern.begin(), kPattern.end(), matches)) {
    date->fail_value(fmt::format("a date that can be written as {} (limit: YYYY-MM-DD)", format));
  }
}

void require_cobras_task(const JsonCursor& task) {
  const auto refuse = [](const JsonCursor& place, std::string_view what, std::string_view why) {
    place.fail(fmt::format("{} cannot be written as cobra: {}", what, why));
  };
  for (const char* ours : {"home", "payload"}) {
    if (task.has(ours)) refuse(task.at(ours), fmt::format("\"{}\"", ours), "CoBRA's tasks have none");
  }
  if (const std::optional<JsonCursor> obstacles = task.find("obstacles")) {
    for (const JsonCursor& obstacle : obstacles->items_or_single()) {
      if (obstacle.has("motion")) {
        refuse(obstacle.at("motion"), "a moving obstacle", "CoBRA's obstacles stand still");
      }
    }
  }
  require_date(task.at("header"), "cobra");
  require_named_frames(task);
}

std::filesystem::path package_root(const std::string& id, const std::filesystem::path& folder) {
  std::filesystem::path below = std::filesystem::path{id}.parent_path();
  std::error_code failed;
  std::filesystem::path root = std::filesystem::weakly_canonical(std::filesystem::absolute(folder), failed);
  for (; !below.empty() && below != below.root_path(); below = below.parent_path()) {
    if (failed || root.filename() != below.filename()) return folder;
    root = root.parent_path();
  }
  return root;
}

void drop_free_tolerances(Json& value) {
  if (!value.is_structured()) return;
  for (Json& entry : value) drop_free_tolerances(entry);
  if (!is_tolerated_pose(value)) return;
  Json& projections = value["toleranceProjection"];
  Json& intervals = value["tolerance"];
  const bool had_some = !projections.empty();
  for (std::size_t i = projections.size(); i-- > 0;) {
    const bool radius = projections[i] == "r_sph" || projections[i] == "r_cyl";
    const auto lower = intervals[i][0].get<double>();
    const auto upper = intervals[i][1].get<double>();
    if (!std::isinf(upper) || (!std::isinf(lower) && !(radius && lower <= 0.0))) continue;
    for (const char* frames : {"toleranceFrame", "frame"}) {
      const bool beside =
          value.contains(frames) && value[frames].is_array() && value[frames].size() == projections.size();
      if (beside) value[frames].erase(i);
    }
    projections.erase(i);
    intervals.erase(i);
  }
  if (!had_some || !projections.empty()) return;
  // Empty lists would stand for the default tolerances; every rotation is at most half a turn.
  projections.push_back("Theta_R");
  intervals.push_back({0.0, std::numbers::pi});
  for (const char* frames : {"toleranceFrame", "frame"}) value.erase(frames);
}

void settle_solution_for_cobra(ordered_json& solution, const ModuleLibrary& library, double mass) {
  const ordered_json no_name = ordered_json::array({""});
  const std::pair<const char*, ordered_json> fixed[] = {
      {"version", "2022"},
      {"author", no_name},
      {"email", no_name},
      {"affiliation", no_name},
      {"date", "1970-01-01"},
      {"computationTime", -1.0},
      {"processorName", ""},
      {"moduleSet", module_set(library)},
      {"trajectory",
       {{"t", ordered_json::array()}, {"q", ordered_json::array()}, {"goal2time", ordered_json::object()}}}};
  for (const auto& [key, value] : fixed) {
    if (!solution.contains(key) || solution[key].is_null()) solution[key] = value;
  }
  if (!solution.contains("costFunction") || !is_cobras_cost(solution["costFunction"])) {
    solution["costFunction"] = "mass";
    solution["cost"] = mass;
  }
}

std::string module_set(const ModuleLibrary& library) {
  const std::filesystem::path file{library.name()};
  if (file.filename() == "modules.json") return std::filesystem::absolute(file).parent_path().filename().string();
  return file.stem().string();
}

}  // namespace modsearch::detail
