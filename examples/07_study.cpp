// Step 7: a comparison, with what makes it one: the same instances and seeds for every solver, a journal that survives
// whatever happens, and an agent whose training is charged apart from its use.
#include <filesystem>
#include <iostream>
#include <map>
#include <modsearch/modsearch.hpp>

int main() {
  using namespace modsearch;

  // 1. What is compared: three targets that nobody was trained on, three solvers, two seeds.
  const std::string name = "seed/random_narrow";
  const ProblemFile family = load_problem_file(name);
  LearnerSettings settings = settings_of(AgentKind::kMpdqn, Preset::kBest, traits_of(family));
  settings.training.episodes = 1500;
  const Study study{.name = "example",
                    .problems = {study_problem(name, InstanceRange{.seed = 1, .count = 3})},
                    .solvers = {{.label = "random", .text = "random", .solver = std::make_shared<RandomSearch>()},
                                {.label = "per-sequence", .text = "per-sequence", .solver = std::make_shared<PerSequence>()},
                                {.label = "mpdqn",
                                 .text = "mpdqn:preset=best,episodes=1500",
                                 .trainings = {{.problem = name,
                                                .source = problem_source(family),
                                                .library = family.spec.library,
                                                .settings = settings}}}},
                    .seeds = {0, 1},
                    .budget = {.evaluations = 500}};

  // 2. Run it on two cores. What is in the folder already is not computed again.
  const std::filesystem::path folder = std::filesystem::temp_directory_path() / "modsearch_example_study";
  std::filesystem::remove_all(folder);
  const StudyRecord record = run(study, {.folder = folder, .jobs = 2});

  // 3. The journal has everything: here the runs that found a design of one module.
  std::map<std::string, int> one_module;
  for (const CellRecord& cell : record.cells) {
    if (cell.key.kind == CellKind::kTraining) {
      std::cout << cell.key.label << " trained for " << cell.outcome->training->episodes << " episodes, "
                << cell.outcome->spent.evaluations << " evaluations\n";
    } else {
      one_module[cell.key.label] += cell.outcome->achieved && cell.outcome->modules == 2;  // the base counts
    }
  }
  for (const auto& [label, n] : one_module) std::cout << label << ": one module in " << n << " of 6 runs\n";
  std::cout << runs_csv(record).substr(0, 40) << "..\n";
}
