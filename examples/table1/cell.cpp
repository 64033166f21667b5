#include "table1/cell.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <fstream>
#include <limits>
#include <map>
#include <modsearch/rl/learner.hpp>
#include <sstream>
#include <stdexcept>

namespace table1 {

using namespace modsearch;

namespace {

ProblemFile file_of(const CellRequest& request) {
  ProblemFile file = load_problem_file(request.problem);
  if (request.tolerance) {
    for (Goal& goal : file.goals) goal.region = PoseRegion::ball(goal.position(), *request.tolerance);
    file.spec.task = std::make_shared<GoalTask>(std::string{file.spec.task->name()}, file.goals);
  }
  if (!request.types.empty()) {
    const ModuleLibrary& library = *file.spec.library;
    std::vector<ModuleType> modules{library.base()};
    for (const std::string& id : request.types) {
      const std::optional<int> k = library.find(id);
      if (!k) throw std::invalid_argument(fmt::format("there is no module '{}'", id));
      modules.push_back(library.type(*k));
    }
    file.spec.library = std::make_shared<ModuleLibrary>(library.name(), std::move(modules), library.neighbour_rule());
    file.spec.chains = nullptr;
  }
  return file;
}

std::optional<std::int64_t> optional_number(const std::string& text) {
  return text.empty() ? std::nullopt : std::optional{std::stoll(text)};
}
std::string text(const std::optional<std::int64_t>& number) { return number ? fmt::format("{}", *number) : ""; }

// A column: how a result becomes text, and back.
struct Column {
  std::string name;
  std::string (*write)(const CellResult&);
  void (*read)(CellResult&, const std::string&);
};

const std::vector<Column>& columns() {
  using R = CellResult;
  using S = std::string;
  static const std::vector<Column> table{
      {"row", [](const R& r) { return r.row; }, [](R& r, const S& s) { r.row = s; }},
      {"agent", [](const R& r) { return r.agent; }, [](R& r, const S& s) { r.agent = s; }},
      {"seed", [](const R& r) { return fmt::format("{}", r.seed); }, [](R& r, const S& s) { r.seed = std::stoull(s); }},
      {"end", [](const R& r) { return r.end; }, [](R& r, const S& s) { r.end = s; }},
      {"episodes", [](const R& r) { return fmt::format("{}", r.episodes); },
       [](R& r, const S& s) { r.episodes = std::stoll(s); }},
      {"stabilised_after", [](const R& r) { return text(r.stabilised_after); },
       [](R& r, const S& s) { r.stabilised_after = optional_number(s); }},
      {"first_one_step", [](const R& r) { return text(r.first_one_step); },
       [](R& r, const S& s) { r.first_one_step = optional_number(s); }},
      {"one_step_evaluations", [](const R& r) { return fmt::format("{}", r.one_step_evaluations); },
       [](R& r, const S& s) { r.one_step_evaluations = std::stoll(s); }},
      {"best_return", [](const R& r) { return fmt::format("{:.4f}", r.best_return); },
       [](R& r, const S& s) { r.best_return = std::stod(s); }},
      {"final_return", [](const R& r) { return fmt::format("{:.4f}", r.final_return); },
       [](R& r, const S& s) { r.final_return = std::stod(s); }},
      {"final_deviation", [](const R& r) { return fmt::format("{:.4f}", r.final_deviation); },
       [](R& r, const S& s) { r.final_deviation = std::stod(s); }},
      {"final_one_step", [](const R& r) { return fmt::format("{:.4f}", r.final_one_step); },
       [](R& r, const S& s) { r.final_one_step = std::stod(s); }},
      {"types", [](const R& r) { return r.types; }, [](R& r, const S& s) { r.types = s; }},
      {"design", [](const R& r) { return r.design; }, [](R& r, const S& s) { r.design = s; }},
      {"exact_score", [](const R& r) { return fmt::format("{:.4f}", r.exact_score); },
       [](R& r, const S& s) { r.exact_score = std::stod(s); }},
      {"exact_reached", [](const R& r) { return S{r.exact_reached ? "true" : "false"}; },
       [](R& r, const S& s) { r.exact_reached = s == "true"; }},
      {"training_s", [](const R& r) { return fmt::format("{:.3f}", r.seconds); },
       [](R& r, const S& s) { r.seconds = std::stod(s); }},
      {"s_per_1000_episodes", [](const R& r) { return fmt::format("{:.4f}", r.seconds_per_1000); },
       [](R& r, const S& s) { r.seconds_per_1000 = std::stod(s); }},
  };
  return table;
}

}  // namespace

ProblemSource source_of(const CellRequest& request) {
  ProblemFile file = file_of(request);
  if (!request.ik) return problem_source(std::move(file));
  if (file.sampling) throw std::invalid_argument("the fallible inverse kinematics is for problems of one target");
  const RobotProblemSpec exact = file.instance()->spec();  // with its chains, so that all instances share them
  if (!request.ik->per_episode) {
    const auto problem = std::make_shared<const RobotProblem>(with_fallible_ik(exact, *request.ik));
    return [problem](Rng) { return problem; };
  }
  return [exact, ik = *request.ik](Rng rng) {
    FallibleIk fresh = ik;
    fresh.salt = rng.bits();
    return std::make_shared<const RobotProblem>(with_fallible_ik(exact, fresh));
  };
}

LearnerSettings settings_of(const CellRequest& request) {
  const ProblemFile file = file_of(request);
  LearnerSettings settings = modsearch::settings_of(request.agent, request.preset,
                                                    {file.sampling.has_value(), !file.spec.scene->obstacles().empty()});
  settings.environment.hindsight_region = file.sampling;
  for (const auto& [key, value] : request.settings) apply_setting(settings, key, value);
  return settings;
}

CellResult run_cell(const CellRequest& request, std::vector<EvaluationPoint>& history) {
  const ProblemSource source = source_of(request);
  Meter meter{{.evaluations = std::numeric_limits<std::int64_t>::max()}};  // the training has its own protocol
  const Training training = AgentLearner{settings_of(request)}.train(source, meter, Rng{request.seed});
  history = training.history;

  CellResult result{.row = request.row,
                    .agent = std::string{name(request.agent)},
                    .seed = request.seed,
                    .end = std::string{name(training.end)},
                    .stabilised_after = stabilised_after(history)};
  if (history.empty()) throw std::invalid_argument("a training without evaluations shows nothing");
  result.best_return = history.front().evaluation.mean_return;
  for (const EvaluationPoint& point : history) {
    result.best_return = std::max(result.best_return, point.evaluation.mean_return);
    if (point.evaluation.one_step_share < 1.0) continue;
    if (!result.first_one_step) result.first_one_step = point.episode;
    ++result.one_step_evaluations;
  }
  result.episodes = history.back().episode;
  result.final_return = training.final_evaluation.mean_return;
  result.final_deviation = training.final_evaluation.deviation;
  result.final_one_step = training.final_evaluation.one_step_share;
  result.seconds = history.back().seconds;
  result.seconds_per_1000 = 1000.0 * result.seconds / static_cast<double>(result.episodes);

  const std::shared_ptr<const DesignProblem> problem = source(Rng{request.seed});
  Meter acting;
  const Design design = training.policy->solve(*problem, acting, Rng{request.seed}).design;
  std::vector<std::string> types;
  for (const int k : design.types()) types.push_back(problem->library().type(k).id);
  result.types = fmt::format("{}", fmt::join(types, " "));
  result.design = to_string(problem->library(), design);
  std::replace(result.design.begin(), result.design.end(), ',', ';');
  // The problem as it is, but for the library: a type has another number in a smaller one.
  CellRequest exact = request;
  exact.tolerance.reset();
  exact.ik.reset();
  const Evaluation evaluation = source_of(exact)(Rng{request.seed})->evaluate(design);
  result.exact_score = evaluation.score;
  result.exact_reached = evaluation.attempt.reached;
  return result;
}

std::string csv_columns() {
  std::vector<std::string> names;
  for (const Column& column : columns()) names.push_back(column.name);
  return fmt::format("{}\n", fmt::join(names, ","));
}

std::string csv_row(const CellResult& result) {
  std::vector<std::string> values;
  for (const Column& column : columns()) values.push_back(column.write(result));
  return fmt::format("{}\n", fmt::join(values, ","));
}

std::vector<CellResult> load_cells(const std::string& file) {
  std::ifstream in{file};
  std::string line;
  if (!std::getline(in, line) || line + '\n' != csv_columns()) {
    throw std::runtime_error(fmt::format("{}: no table of results", file));
  }
  std::vector<CellResult> results;
  for (int number = 2; std::getline(in, line); ++number) {
    CellResult result;
    std::istringstream row{line};
    for (const Column& column : columns()) {
      std::string value;
      if (!std::getline(row, value, ',')) throw std::runtime_error(fmt::format("{}:{}: too short", file, number));
      column.read(result, value);
    }
    results.push_back(std::move(result));
  }
  return results;
}

}  // namespace table1
