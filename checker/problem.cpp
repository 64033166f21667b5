#include <checker/builtin.hpp>
#include <checker/problem.hpp>
#include <filesystem>
#include <optional>

namespace modsearch_check {
namespace {

/// A document and the path that others are relative to.
struct Document {
  Json json;
  std::string path;
};

/// A document that is given in place, by the ID of one that is embedded, or by a path relative to the folder of `near`.
Document fetch(const Json& given, std::span<const BuiltinFile> builtin, const std::string& near) {
  if (!given.is_string()) return {given, near};
  const std::string name = given.get<std::string>();
  const Rounding nearest{FE_TONEAREST};  // decimal numbers mean the double next to them
  for (const BuiltinFile& file : builtin) {
    if (file.id == name) return {parse(std::string{file.text}, name), ""};
  }
  const std::string path = (std::filesystem::path{near}.parent_path() / name).string();
  return {parse(read_file(path), path), path};
}

Scoring read_scoring(const Value& value) {
  Scoring scoring;
  if (value["type"].choice({"algorithm1", "weighted"}) == 0) {
    value.only({"type"});
    return scoring;
  }
  value.only({"type", "reached", "distance", "module", "mass", "cost", "collision"});
  for (const auto& [key, weight] : value.members()) {
    if (weight.json().is_number() && !(weight.number() >= 0.0)) weight.fail("a weight is negative");
  }
  return {false, value.number_or("reached", 0.0), value.number_or("module", 0.0), value.number_or("cost", 0.0),
          value.number_or("mass", 0.0)};
}

}  // namespace

Interval Scoring::head(std::size_t n, const Interval& costs) const {
  const auto modules = static_cast<double>(n);
  if (!algorithm1) return Interval{reached} - Interval{module} * (modules - 1.0) - Interval{cost} * costs;
  return Interval{50.0} + std::ldexp(300.0, 2 - static_cast<int>(n)) - 2.0 * (modules - 2.0);
}

Problem read_problem(const std::string& file_or_id, const std::string& near, std::uint64_t seed, std::uint64_t index) {
  const Document document = fetch(file_or_id, kBuiltinProblems, near);
  const Value value{document.json, file_or_id};
  value.only({"modsearch", "task", "library", "maxModules", "collision", "scoring", "sampling"});
  if (value["modsearch"].natural(1) != 1) value["modsearch"].fail("is not 1");
  const Document library = fetch(value["library"].json(), kBuiltinLibraries, document.path);
  const Document task = fetch(value["task"].json(), {}, document.path);

  Problem problem;
  problem.library = read_library(Value{library.json, file_or_id + ": library"});
  problem.task = read_task(Value{task.json, file_or_id + ": task"});
  problem.max_modules = value["maxModules"].natural(64);
  if (problem.max_modules < 1) value["maxModules"].fail("is not at least 1");
  static_cast<void>(value["collision"].choice({"none", "posture", "posture+self", "path"}));
  problem.level = value["collision"].text();
  problem.scoring = read_scoring(value["scoring"]);
  problem.scoring_text = value["scoring"].json();
  problem.sampled = value.has("sampling");
  if (problem.sampled) {
    const Value sampling = value["sampling"];
    sampling.only({"goal", "box", "minClearance"});
    sampling["box"].only({"lower", "upper"});
    const std::string id = sampling["goal"].text();
    const Numbers lower = sampling["box"]["lower"].numbers3();
    const Numbers upper = sampling["box"]["upper"].numbers3();
    const double clearance = sampling.number_or("minClearance", 0.0);
    bool found = false;
    for (Goal& goal : problem.task.goals) {
      if (goal.id != id) continue;
      const Rounding nearest{FE_TONEAREST};
      goal.position = draw_target(lower, upper, clearance, problem.task, seed, index);
      found = true;
    }
    if (!found) sampling["goal"].fail("there is no such goal");
  }
  return problem;
}

}  // namespace modsearch_check
