#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <limits>
#include <modsearch/study/run_matrix.hpp>
#include <modsearch/study/targets.hpp>
#include <set>

#include "csv_fields_internal.hpp"

namespace modsearch {
namespace {

using Value = std::function<double(const CellRecord&, const InstanceFacts&)>;

std::string matrix_csv(const StudyRecord& record, const Value& value) {
  const StudyRuns runs = runs_of(record);
  std::string text = "solver,seed";
  for (const InstanceFacts& instance : runs.instances) text += fmt::format(",{}", csv_field(instance.name()));
  text += "\n";
  for (std::size_t s = 0; s < runs.solvers.size(); ++s) {
    std::set<std::uint64_t> seeds;
    for (const auto& of_instance : runs.runs[s]) {
      for (const CellRecord* run : of_instance) seeds.insert(run->key.seed);
    }
    for (const std::uint64_t seed : seeds) {
      text += fmt::format("{},{}", csv_field(runs.solvers[s].label), seed);
      for (std::size_t i = 0; i < runs.instances.size(); ++i) {
        const auto& cells = runs.runs[s][i];
        const auto run =
            std::find_if(cells.begin(), cells.end(), [&](const CellRecord* cell) { return cell->key.seed == seed; });
        const double number =
            run == cells.end() ? std::numeric_limits<double>::quiet_NaN() : value(**run, runs.instances[i]);
        text += fmt::format(",{}", csv_field(number));
      }
      text += "\n";
    }
  }
  return text;
}

}  // namespace

std::string score_matrix_csv(const StudyRecord& record) {
  return matrix_csv(record, [](const CellRecord& run, const InstanceFacts&) {
    return run.outcome && run.outcome->achieved ? run.outcome->score : -std::numeric_limits<double>::infinity();
  });
}

std::string regret_matrix_csv(const StudyRecord& record) { return matrix_csv(record, regret); }

}  // namespace modsearch
