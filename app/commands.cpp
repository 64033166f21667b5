#include "app/commands.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <modsearch/rl/settings.hpp>
#include <modsearch/solvers/verification.hpp>
#include <modsearch/study/solution_page.hpp>
#include <modsearch/study/study_file.hpp>
#include <nlohmann/json.hpp>
#include <optional>

#include "app/chosen_problem_internal.hpp"
#include "app/output_internal.hpp"
#include "app/report_internal.hpp"
#include "app/solver_registry.hpp"
#include "app/study_names.hpp"

namespace modsearch::app {
namespace {

// What other presets set otherwise, by the kind of problem.
std::string presets_text(const LearnerSettings& defaults) {
  struct Case {
    const char* what;
    Preset preset;
    ProblemTraits traits;
  };
  const Case cases[] = {{"report-code", Preset::kReportCode, {}},
                        {"best, one target", Preset::kBest, {}},
                        {"best, drawn targets", Preset::kBest, {.sampled = true}},
                        {"best, drawn targets among obstacles", Preset::kBest, {.sampled = true, .obstacles = true}}};
  std::string text;
  for (const Case& each : cases) {
    const LearnerSettings settings = settings_of(AgentKind::kMpdqn, each.preset, each.traits);
    std::vector<std::string> changes;
    for (const Setting& setting : setting_table()) {
      const std::string value = setting.get(settings);
      if (value != setting.get(defaults)) changes.push_back(fmt::format("{}={}", setting.key, value));
    }
    text += fmt::format("what preset={} sets otherwise\n    {}\n", each.what, fmt::join(changes, " "));
  }
  return text;
}

// The instance that a solution file names; none where it names none, or is no solution.
std::optional<Instance> instance_of_solution(const std::string& file) {
  std::ifstream stream{file};
  const nlohmann::json json = nlohmann::json::parse(stream, nullptr, false);
  if (!json.is_object() || !json.contains("instance")) return std::nullopt;
  const nlohmann::json& instance = json.at("instance");
  const auto is_number = [&](const char* key) {
    return instance.is_object() && instance.contains(key) && instance.at(key).is_number_unsigned();
  };
  if (!is_number("seed") || !is_number("index")) return std::nullopt;
  return Instance{instance.at("seed").get<std::uint64_t>(), instance.at("index").get<std::uint64_t>()};
}

// The problem that a design is evaluated on: the instance that is asked for, else that which its file names.
ChosenProblem problem_for(const EvaluateArguments& arguments, const FileOptions& files) {
  ChosenProblem chosen = choose_problem(arguments.problem, arguments.instance, files);
  if (arguments.instance || !chosen.instance) return chosen;
  const std::optional<Instance> named = instance_of_solution(arguments.design);
  return named ? choose_problem(arguments.problem, named, files) : chosen;
}

}  // namespace

Status evaluate(const EvaluateArguments& arguments, const CommonArguments& common) {
  const auto [file, instance, problem] = problem_for(arguments, common.files);
  const Design design = load_design(arguments.design, problem->library());
  const Evaluation evaluation = problem->evaluate(design, Fidelity::kFull, load_witness(arguments.design));
  if (common.json) {
    nlohmann::ordered_json json;
    if (instance) json["instance"] = nlohmann::ordered_json{{"seed", instance->seed}, {"index", instance->index}};
    json.update(evaluation_json(*problem, design, evaluation));
    print(json);
  } else {
    if (instance) say("instance     {}:{}\n", instance->seed, instance->index);
    write_out(evaluation_text(*problem, design, evaluation));
  }
  return Status::kSuccess;
}

Status verify_solution(const VerifyArguments& arguments, const CommonArguments& common) {
  const LoadedSolution loaded = load_solution(arguments.solution, arguments.problem, common.files);
  const Attempt& claimed = loaded.record.evaluation.attempt;
  Claims claims;
  if (loaded.claims) {
    claims = {.score = loaded.record.evaluation.score,
              .reached = claimed.reached,
              .achieved = claimed.achieved,
              .goal_error = claimed.goal_error,
              .clearance = claimed.clearance};
  }
  if (claimed.postures.size() > 0) claims.postures = claimed.postures;
  if (claimed.path && claimed.path->waypoints.rows() > 0) claims.path = claimed.path;
  const Verification verification = verify(*loaded.problem, loaded.record.design, claims);
  if (common.json) {
    print(verification_json(*loaded.problem, loaded.record.design, verification));
  } else {
    write_out(verification_text(*loaded.problem, loaded.record.design, verification));
    write_out(home_text(*loaded.problem, verification.path));
  }
  return verification.verified ? Status::kSuccess : Status::kNegative;
}

namespace {

// The problem that a solution file belongs to, as it can be named from here.
std::string named_problem(const RenderArguments& arguments, const SolutionRecord& record) {
  if (arguments.problem) return *arguments.problem;
  if (is_builtin(record.problem)) return record.problem;
  return (std::filesystem::path{arguments.solution}.parent_path() / record.problem).lexically_normal().string();
}

// What finds the same solution again; nothing where the file does not say which solver it is from.
std::optional<std::string> solve_command(const std::string& problem, const SolutionRecord& record) {
  const std::vector<SolverEntry>& known = solver_entries();
  const bool solvable =
      std::any_of(known.begin(), known.end(), [&](const SolverEntry& entry) { return entry.name == record.solver; });
  if (!solvable) return std::nullopt;
  std::string solver = record.solver;
  for (const auto& [key, value] : record.solver_options) {
    solver += fmt::format("{}{}={}", solver == record.solver ? ':' : ',', key, value);
  }
  std::string text = fmt::format("modsearch solve {}", shell_word(problem));
  if (record.instance) text += fmt::format(" --instance {}:{}", record.instance->seed, record.instance->index);
  return text +
         fmt::format(" --solver {} --seed {} --evaluations {}", shell_word(solver), record.seed, record.evaluations);
}

}  // namespace

Status render(const RenderArguments& arguments, const CommonArguments& common) {
  std::optional<OutputLock> lock;
  if (arguments.out) lock.emplace(claim_folder(*arguments.out));
  LoadedSolution loaded = load_solution(arguments.solution, arguments.problem, common.files);
  if (!loaded.claims) {
    // Nothing to show but the design and its motion: how good they are has to be found out.
    const Attempt given = loaded.record.evaluation.attempt;
    loaded.record.evaluation = loaded.problem->evaluate(loaded.record.design);
    loaded.record.evaluation.attempt.path = given.path;
    loaded.record.evaluation.attempt.goal_waypoints = given.goal_waypoints;
    loaded.record.evaluation.attempt.step_waypoints = given.step_waypoints;
  }
  const Attempt& attempt = loaded.record.evaluation.attempt;
  const NearestMiss missed = nearest_miss(*loaded.problem, loaded.record.design, loaded.record.evaluation);
  const std::string problem = named_problem(arguments, loaded.record);
  const std::string page =
      write_page(page_of_solution(*loaded.problem, loaded.record,
                                  {.path = attempt.path,
                                   .sampling = load_problem_file(problem, common.files).sampling,
                                   .command = solve_command(problem, loaded.record).value_or(common.command),
                                   .reason = missed.words()}));
  if (!arguments.out) {
    write_out(page);
    return Status::kSuccess;
  }
  const std::filesystem::path view = *arguments.out / "view.html";
  write_file(view, page);
  if (common.json) {
    print({{"files", {view.string()}}});
  } else {
    say("wrote        {}\n", view.string());
  }
  return Status::kSuccess;
}

Status list(const ListArguments& arguments, const CommonArguments& common) {
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  std::string text;
  if (arguments.what == "solvers") {
    for (const SolverEntry& entry : solver_entries()) {
      nlohmann::ordered_json options = nlohmann::ordered_json::array();
      text += fmt::format("{:<18}{}\n", entry.name, entry.meaning);
      for (const OptionEntry& option : entry.options) {
        options.push_back({{"key", option.key}, {"default", option.default_value}, {"meaning", option.meaning}});
        text += fmt::format("    {:<12}default {}: {}\n", option.key, option.default_value, option.meaning);
      }
      json.push_back({{"name", entry.name}, {"meaning", entry.meaning}, {"options", std::move(options)}});
    }
    constexpr const char* kPolicy = "a trained agent, from the policy.json that `modsearch train` leaves";
    text += fmt::format("{:<18}{}\n", "policy:FILE", kPolicy);
    json.push_back({{"name", "policy:FILE"}, {"meaning", kPolicy}, {"options", nlohmann::ordered_json::array()}});
  } else if (arguments.what == "libraries") {
    for (const std::string& id : builtin_libraries()) {
      const std::shared_ptr<const ModuleLibrary> library = load_library(id);
      text += fmt::format("{:<12}{} module types\n", id, library->n_types());
      json.push_back({{"id", id}, {"types", library->n_types()}});
    }
  } else if (arguments.what == "problems") {
    for (const std::string& id : builtin_problems()) {
      const ProblemFile file = load_problem_file(id);
      const std::string kind = file.sampled() ? "sampled" : "fixed";
      text += fmt::format("{:<24}{:<9}level {}, library {}, at most {} modules\n", id, kind, name(file.spec.level),
                          file.spec.library->name(), file.spec.max_modules);
      json.push_back({{"id", id},
                      {"sampled", file.sampled()},
                      {"collision", name(file.spec.level)},
                      {"library", file.spec.library->name()},
                      {"maxModules", file.spec.max_modules}});
    }
  } else if (arguments.what == "studies") {
    for (const std::string& id : builtin_studies()) {
      const Study study = load_study(id, study_names());
      const std::size_t n_cells = cells_of(study).size();
      text += fmt::format("{:<12}{} problems, {} solvers, {} seeds: {} cells\n", id, study.problems.size(),
                          study.solvers.size(), study.seeds.size(), n_cells);
      json.push_back({{"id", id},
                      {"problems", study.problems.size()},
                      {"solvers", study.solvers.size()},
                      {"seeds", study.seeds.size()},
                      {"cells", n_cells}});
    }
  } else {
    const LearnerSettings defaults = settings_of(AgentKind::kMpdqn, Preset::kReport);
    nlohmann::ordered_json options = nlohmann::ordered_json::array();
    std::string option_text =
        fmt::format("    {:<30}{:<12}{}\n", "preset", "report", "settings to begin with (report|report-code|best)");
    for (const Setting& setting : setting_table()) {
      const std::string value = setting.get(defaults);
      options.push_back({{"key", setting.key}, {"default", value}, {"meaning", setting.meaning}});
      option_text += fmt::format("    {:<30}{:<12}{}\n", setting.key, value, setting.meaning);
    }
    for (const AgentKind kind : agent_kinds()) {
      text += fmt::format("{:<12}{}\n", name(kind), meaning(kind));
      json.push_back({{"name", name(kind)}, {"meaning", meaning(kind)}, {"options", options}});
    }
    text += "options of all agents, with their defaults for mpdqn:preset=report\n" + option_text;
    text += presets_text(defaults);
  }
  if (common.json) {
    print(json);
  } else {
    write_out(text);
  }
  return Status::kSuccess;
}

}  // namespace modsearch::app
