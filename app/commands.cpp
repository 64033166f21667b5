#include "app/commands.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <modsearch/solvers/verification.hpp>

#include "app/page_of_solution.hpp"
#include "app/progress.hpp"
#include "app/report.hpp"
#include "app/solver_registry.hpp"

namespace modsearch::app {
namespace {

void print(const nlohmann::ordered_json& json) { fmt::print("{}\n", json.dump()); }

// A relative problem in a solution file is relative to that file; IDs of built-in problems stay as they are.
std::string problem_reference(const std::string& problem, const std::filesystem::path& folder) {
  const std::vector<std::string> builtin = builtin_problems();
  if (std::find(builtin.begin(), builtin.end(), problem) != builtin.end()) return problem;
  return std::filesystem::relative(std::filesystem::absolute(problem), std::filesystem::absolute(folder)).string();
}

std::optional<Eigen::Vector3d> sampled_target(const ProblemFile& file, const RobotProblem& problem) {
  if (!file.sampling) return std::nullopt;
  for (const Goal& goal : problem.task().goals()) {
    if (goal.id == file.sampling->goal) return goal.position();
  }
  return std::nullopt;
}

void make_folder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw FileError(fmt::format("{}: cannot make this folder: {}", folder.string(), error.message()));
}

std::string why_not(const Verification& verification) {
  return verification.findings.empty() ? std::string{} : verification.findings.front();
}

}  // namespace

Status solve(const SolveArguments& arguments, const CommonArguments& common, std::stop_token stop) {
  const ChosenSolver chosen = choose_solver(arguments.solver);
  const ProblemFile file = load_problem_file(arguments.problem);
  const std::optional<Instance> instance =
      file.sampling ? std::optional{arguments.instance.value_or(Instance{})} : std::nullopt;
  std::shared_ptr<const RobotProblem> problem = file.instance(instance.value_or(Instance{}));
  if (arguments.at_path_level) problem = std::make_shared<RobotProblem>(problem->with_level(Level::kPath));
  if (arguments.out) make_folder(*arguments.out);

  ProgressDisplay display{arguments.solver, common.quiet};
  Meter meter{budget_of(arguments), [&](const Meter& m) { display.update(m); }, stop};
  const Solution solution = chosen.solver->solve(*problem, meter, Rng{arguments.seed});
  display.finish();

  const Claims claims{.score = solution.evaluation.score, .achieved = solution.evaluation.attempt.achieved};
  std::optional<Verification> verification;
  if (solution.evaluation.attempt.achieved) verification = verify(*problem, solution.design, claims);

  SolutionRecord record;
  record.problem = arguments.problem;
  record.instance = instance;
  record.target = sampled_target(file, *problem);
  record.design = solution.design;
  record.X_WB = problem->spec().X_WB;
  record.evaluation = solution.evaluation;
  if (verification) record.verified = verification->level;
  if (verification && verification->path) {
    record.evaluation.attempt.path = verification->path;
    record.evaluation.attempt.goal_waypoints = verification->path_evaluation.attempt.goal_waypoints;
  }
  record.solver = chosen.name;
  record.solver_options = chosen.options;
  record.seed = arguments.seed;
  record.evaluations = solution.spent.evaluations;
  record.seconds = solution.spent.seconds;

  nlohmann::ordered_json json;
  json["problem"] = arguments.problem;
  json["solver"] = arguments.solver;
  json["seed"] = arguments.seed;
  json.update(evaluation_json(*problem, solution.design, solution.evaluation));
  json["verified"] = verification && verification->level == "path";
  json["evaluations"] = solution.spent.evaluations;
  json["programEvaluations"] = solution.spent.program_evaluations;
  json["seconds"] = solution.spent.seconds;
  json["stop"] = name(solution.stop);
  json["reason"] = solution.reason;
  if (record.target) json["target"] = {record.target->x(), record.target->y(), record.target->z()};

  std::vector<std::string> written;
  if (arguments.out) {
    SolutionRecord stored = record;
    stored.problem = problem_reference(arguments.problem, *arguments.out);
    const std::string reason = verification ? why_not(*verification) : solution.reason;
    const Page page = page_of_solution(*problem, record,
                                       {.path = record.evaluation.attempt.path,
                                        .sampling = file.sampling,
                                        .trace = meter.trace(),
                                        .command = common.command,
                                        .reason = reason});
    write_solution(*arguments.out / "solution.json", *problem, stored);
    write_file(*arguments.out / "trace.csv", trace_csv(meter.trace()));
    write_file(*arguments.out / "view.html", write_page(page));
    for (const char* name : {"solution.json", "trace.csv", "view.html"}) {
      written.push_back((*arguments.out / name).string());
    }
    json["files"] = written;
  }

  if (common.json) {
    print(json);
  } else {
    fmt::print("problem      {}{}\n", arguments.problem,
               instance ? fmt::format(", instance {}:{}", instance->seed, instance->index) : "");
    if (record.target) {
      fmt::print("target       ({:.4f}, {:.4f}, {:.4f})\n", record.target->x(), record.target->y(), record.target->z());
    }
    fmt::print("{}", evaluation_text(*problem, solution.design, solution.evaluation));
    if (verification) {
      fmt::print("verified     {}{}\n", verification->level,
                 verification->level == "path" ? ": a collision-free path from home through all goals"
                                               : fmt::format(" ({})", why_not(*verification)));
    }
    fmt::print("solver       {}, seed {}: {} evaluations, {:.3f} s\n", arguments.solver, arguments.seed,
               solution.spent.evaluations, solution.spent.seconds);
    fmt::print("ended        {}{}\n", name(solution.stop),
               solution.reason.empty() ? "" : fmt::format(": {}", solution.reason));
    for (const std::string& path : written) fmt::print("wrote        {}\n", path);
  }
  if (solution.stop == StopReason::kInterrupted) return Status::kInterrupted;
  return solution.evaluation.attempt.achieved ? Status::kSuccess : Status::kNegative;
}

Status evaluate(const EvaluateArguments& arguments, const CommonArguments& common) {
  const ProblemFile file = load_problem_file(arguments.problem);
  const std::shared_ptr<const RobotProblem> problem = file.instance(arguments.instance.value_or(Instance{}));
  const Design design = load_design(arguments.design, problem->library());
  const Evaluation evaluation = problem->evaluate(design);
  if (common.json) {
    print(evaluation_json(*problem, design, evaluation));
  } else {
    fmt::print("{}", evaluation_text(*problem, design, evaluation));
  }
  return Status::kSuccess;
}

Status verify_solution(const VerifyArguments& arguments, const CommonArguments& common) {
  const LoadedSolution loaded = load_solution(arguments.solution, arguments.problem);
  const Attempt& claimed = loaded.record.evaluation.attempt;
  Claims claims{.score = loaded.record.evaluation.score, .reached = claimed.reached, .achieved = claimed.achieved};
  if (claimed.postures.size() > 0) claims.postures = claimed.postures;
  if (claimed.path && claimed.path->waypoints.rows() > 0) claims.path = claimed.path;
  const Verification verification = verify(*loaded.problem, loaded.record.design, claims);
  if (common.json) {
    print(verification_json(verification));
  } else {
    fmt::print("{}", verification_text(verification));
  }
  return verification.verified ? Status::kSuccess : Status::kNegative;
}

Status render(const RenderArguments& arguments, const CommonArguments& common) {
  LoadedSolution loaded = load_solution(arguments.solution, arguments.problem);
  const std::optional<Path> path = loaded.record.evaluation.attempt.path;
  const std::string page =
      write_page(page_of_solution(*loaded.problem, loaded.record, {.path = path, .command = common.command}));
  if (!arguments.out) {
    fmt::print("{}", page);
    return Status::kSuccess;
  }
  make_folder(*arguments.out);
  const std::filesystem::path view = *arguments.out / "view.html";
  write_file(view, page);
  if (common.json) {
    print({{"files", {view.string()}}});
  } else {
    fmt::print("wrote        {}\n", view.string());
  }
  return Status::kSuccess;
}

Status list(const ListArguments& arguments, const CommonArguments& common) {
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  std::string text;
  if (arguments.what == "solvers") {
    for (const SolverEntry& entry : solver_entries()) {
      nlohmann::ordered_json options = nlohmann::ordered_json::array();
      text += fmt::format("{:<16}{}\n", entry.name, entry.meaning);
      for (const OptionEntry& option : entry.options) {
        options.push_back({{"key", option.key}, {"default", option.default_value}, {"meaning", option.meaning}});
        text += fmt::format("    {:<12}default {}: {}\n", option.key, option.default_value, option.meaning);
      }
      json.push_back({{"name", entry.name}, {"meaning", entry.meaning}, {"options", std::move(options)}});
    }
  } else if (arguments.what == "problems") {
    for (const std::string& id : builtin_problems()) {
      const ProblemFile file = load_problem_file(id);
      const std::string kind = file.sampling ? "sampled" : "fixed";
      text += fmt::format("{:<24}{:<9}level {}, library {}, at most {} modules\n", id, kind, name(file.spec.level),
                          file.spec.library->name(), file.spec.max_modules);
      json.push_back({{"id", id},
                      {"sampled", file.sampling.has_value()},
                      {"collision", name(file.spec.level)},
                      {"library", file.spec.library->name()},
                      {"maxModules", file.spec.max_modules}});
    }
  } else {
    text = "(no agents in this version)\n";
  }
  if (common.json) {
    print(json);
  } else {
    fmt::print("{}", text);
  }
  return Status::kSuccess;
}

}  // namespace modsearch::app
