#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <modsearch/study/iohprofiler.hpp>
#include <modsearch/study/study_runs.hpp>
#include <nlohmann/json.hpp>

namespace modsearch {
namespace {

// The first of their format that all readers take for it: IOHanalyzer compares it as text, with "0.3.3" or "1.0.0".
constexpr const char* kVersion = "1.0.0";
constexpr double kNothing = std::numeric_limits<double>::lowest();

// Of ASCII: what std::isalnum says depends on the locale.
bool is_letter_or_digit(char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }

// Part of a file's name: their readers cut names at dots.
std::string file_part(std::string text) {
  for (char& c : text) {
    if (!is_letter_or_digit(c) && c != '-') c = '_';
  }
  return text;
}

// The improvements of a run, the first evaluation and the last: what is best so far, which is what they draw.
std::vector<Improvement> history(const CellRecord& run) {
  std::vector<Improvement> points = run.trace;
  if (points.empty() || points.front().evaluations > 1) {
    points.insert(points.begin(), {.evaluations = 1, .score = kNothing});
  }
  const std::int64_t last = run.outcome ? run.outcome->spent.evaluations : 1;
  if (last > points.back().evaluations) {
    points.push_back(points.back());
    points.back().evaluations = last;
    points.back().seconds = run.outcome->spent.seconds;
  }
  // A design that achieves the task outranks one that scores more without: for them the score alone counts.
  for (std::size_t i = 1; i < points.size(); ++i) points[i].score = std::max(points[i].score, points[i - 1].score);
  return points;
}

// A problem's runs by one solver.
struct Runs {
  std::string data;
  nlohmann::ordered_json list = nlohmann::ordered_json::array();

  void add(const CellRecord& run, std::size_t instance) {
    const std::vector<Improvement> points = history(run);
    data += "evaluations raw_y seconds achieved modules mass_kg\n";
    for (const Improvement& point : points) {
      data += fmt::format("{} {} {} {} {} {}\n", point.evaluations, point.score, point.seconds, point.achieved ? 1 : 0,
                          point.modules, point.mass);
    }
    list.push_back(
        {{"instance", instance},
         {"evals", points.back().evaluations},
         {"best",
          {{"evals", points.back().evaluations}, {"y", points.back().score}, {"x", nlohmann::ordered_json::array()}}}});
  }
};

}  // namespace

std::vector<NamedText> iohprofiler_files(const StudyRecord& record) {
  std::vector<NamedText> files;
  for (std::size_t p = 0; p < record.study.problems.size(); ++p) {
    const std::string& problem = record.study.problems[p].name;
    const StudyRuns all = runs_of(record, problem);
    int dimension = 1;
    for (const InstanceFacts& instance : all.instances) dimension = std::max(dimension, instance.dimension());
    for (std::size_t s = 0; s < all.solvers.size(); ++s) {
      Runs runs;
      for (std::size_t i = 0; i < all.instances.size(); ++i) {
        for (const CellRecord* run : all.runs[s][i]) runs.add(*run, i + 1);
      }
      if (runs.list.empty()) continue;
      const std::string folder = fmt::format("{}_{}", s + 1, file_part(all.solvers[s].label));
      const std::string function = fmt::format("f{}_{}", p + 1, file_part(problem));
      const std::string data = fmt::format("data_{}/IOHprofiler_f{}_DIM{}.dat", function, p + 1, dimension);
      const nlohmann::ordered_json json{
          {"version", kVersion},
          {"suite", "modsearch"},
          {"function_id", p + 1},
          {"function_name", problem},
          {"maximization", true},
          {"algorithm", {{"name", all.solvers[s].label}, {"info", all.solvers[s].solver}}},
          {"attributes", {"evaluations", "raw_y", "seconds", "achieved", "modules", "mass_kg"}},
          {"scenarios", {{{"dimension", dimension}, {"path", data}, {"runs", runs.list}}}}};
      files.push_back({fmt::format("{}/IOHprofiler_{}.json", folder, function), json.dump(2) + "\n"});
      files.push_back({fmt::format("{}/{}", folder, data), runs.data});
    }
  }
  return files;
}

}  // namespace modsearch
