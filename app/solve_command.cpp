#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <exception>
#include <limits>
#include <modsearch/baselines/refined.hpp>
#include <modsearch/kinematics/interruption.hpp>
#include <modsearch/solvers/checkpoint.hpp>
#include <modsearch/solvers/verification.hpp>
#include <modsearch/study/solution_page.hpp>

#include "app/chosen_problem_internal.hpp"
#include "app/commands.hpp"
#include "app/output_internal.hpp"
#include "app/progress.hpp"
#include "app/report_internal.hpp"
#include "app/solver_registry.hpp"

namespace modsearch::app {
namespace {

std::optional<Eigen::Vector3d> sampled_target(const ProblemFile& file, const RobotProblem& problem) {
  if (!file.sampling) return std::nullopt;
  for (const Goal& goal : problem.task().goals()) {
    if (goal.id == file.sampling->goal) return goal.position();
  }
  return std::nullopt;
}

constexpr std::string_view kNothingEvaluated = "nothing was evaluated";

std::string why_not(const Verification& verification) {
  return verification.findings.empty() ? std::string{} : verification.findings.front();
}

// Runs the solver, with checkpoints where they are asked for.
Solution search(const ChosenSolver& chosen, const SolveArguments& arguments, const DesignProblem& problem,
                Meter& meter) {
  const Rng rng{arguments.seed};
  if (!arguments.checkpoint) return chosen.solver->solve(problem, meter, rng);
  const auto* stepped = dynamic_cast<const SteppedSolver*>(chosen.solver.get());
  if (stepped == nullptr) {
    throw std::invalid_argument(arguments.refine ? std::string{"--checkpoint: a search with --refine "
                                                               "cannot be kept in a file"}
                                                 : fmt::format("--checkpoint: the searches of solver "
                                                               "'{}' cannot be kept in a file",
                                                               chosen.name));
  }
  if (!arguments.resume && std::filesystem::exists(*arguments.checkpoint)) {
    throw std::invalid_argument(
        fmt::format("--checkpoint {}: is there already; --resume goes on with it", arguments.checkpoint->string()));
  }
  return modsearch::solve(*stepped, problem, meter, rng,
                          {.file = *arguments.checkpoint,
                           .period = arguments.checkpoint_seconds,
                           .resume = arguments.resume,
                           .identity = fmt::format("{}, seed {}", arguments.solver, arguments.seed)});
}

// What follows a search, for a time of its own: long enough for what the search has found to be looked at again, and
// not so long that a budget of seconds means nothing.
class Aftermath {
 public:
  Aftermath(double seconds, std::stop_token stop)
      : seconds_{stop.stop_requested() ? std::min(seconds, kAfterInterrupt) : seconds},
        stop_{stop.stop_requested() ? std::stop_token{} : std::move(stop)} {}

  /// What `work` gives, or nothing where the time was up in the middle of it.
  template <typename Work>
  [[nodiscard]] auto within_time(Work&& work) -> std::optional<decltype(work())> {
    try {
      const Interruptible scope{[this] { return stop_.stop_requested() || watch_.seconds() >= seconds_; }};
      return work();
    } catch (const Interrupted&) {
      return std::nullopt;
    }
  }
  [[nodiscard]] double seconds() const { return seconds_; }

 private:
  static constexpr double kAfterInterrupt = 1.0;  // somebody waits

  struct Watch {
    std::chrono::steady_clock::time_point start = std::chrono::steady_clock::now();
    [[nodiscard]] double seconds() const {
      return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    }
  };

  double seconds_;
  std::stop_token stop_;
  Watch watch_;
};

// Seconds for what follows the search. With a budget of seconds: what the search has left of it and one more.
double seconds_after(const SolveArguments& arguments, double spent) {
  constexpr double kPatience = 60.0;
  if (arguments.verify_seconds) return *arguments.verify_seconds;
  return arguments.seconds ? std::max(0.0, *arguments.seconds - spent) + 1.0 : kPatience;
}

}  // namespace

Status solve(const SolveArguments& arguments, const CommonArguments& common, std::stop_token stop) {
  ChosenSolver chosen = choose_solver(arguments.solver);
  if (arguments.refine) {
    chosen.solver = std::make_unique<Refined>(std::move(chosen.solver));
    chosen.options.emplace_back("refine", "true");
  }
  const auto [file, instance, as_given] = choose_problem(arguments.problem, arguments.instance, common.files);
  const std::optional<Sampling>& sampling = file.sampling;
  std::shared_ptr<const RobotProblem> problem = as_given;
  if (arguments.at_path_level) problem = std::make_shared<RobotProblem>(problem->with_level(Level::kPath));
  std::optional<OutputLock> lock;
  if (arguments.out) lock.emplace(claim_folder(*arguments.out));

  // Where only time ends the search, somebody waits: the first achieved design
  // is told as soon as there is one.
  const bool open_ended = !arguments.evaluations && !arguments.seconds && !arguments.until_achieved;
  ProgressDisplay display{arguments.solver, common.quiet, open_ended ? &problem->library() : nullptr};
  Meter meter{budget_of(arguments), [&](const Meter& m) { display.update(m); }, stop};
  Solution solution = search(chosen, arguments, *problem, meter);
  display.finish();
  const bool evaluated = meter.best().has_value();
  if (!evaluated) solution.evaluation.attempt.goal_error = std::numeric_limits<double>::infinity();  // not known

  Aftermath aftermath{seconds_after(arguments, solution.spent.seconds), stop};
  std::optional<Incumbent> nearest = solution.nearest;  // perhaps screened only
  if (nearest) {
    const Witness witness{.postures = nearest->evaluation.attempt.postures};
    std::optional<Evaluation> whole =
        aftermath.within_time([&] { return problem->evaluate(nearest->design, Fidelity::kFull, witness); });
    if (whole) nearest->evaluation = *std::move(whole);
  }

  const bool achieved = solution.evaluation.attempt.achieved;
  std::optional<Verification> verification;
  if (achieved) {
    Claims claims{.score = solution.evaluation.score, .achieved = true};
    if (solution.evaluation.attempt.postures.rows() > 0) claims.postures = solution.evaluation.attempt.postures;
    verification = aftermath.within_time([&] { return verify(*problem, solution.design, claims); });
    if (verification) solution.evaluation = with_path(std::move(solution.evaluation), *verification);
  }
  const std::string not_in_time =
      fmt::format("the {:.3g} s for it were up; `modsearch verify` takes as long as it needs", aftermath.seconds());

  SolutionRecord record;
  record.problem = arguments.problem;
  record.instance = instance;
  record.target = sampled_target(file, *problem);
  record.design = solution.design;
  record.X_WB = problem->base_pose(solution.design);
  record.evaluation = solution.evaluation;
  if (verification) record.verified = verification->level;
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
  if (!evaluated) {
    json["why"] = kNothingEvaluated;
    json.erase("misses");
  }
  if (nearest) json["nearest"] = evaluation_json(*problem, nearest->design, nearest->evaluation);
  json["verified"] = verification && verification->level == "path";
  if (achieved && !verification) json["notVerified"] = not_in_time;
  json["evaluations"] = solution.spent.evaluations;
  json["programEvaluations"] = solution.spent.program_evaluations;
  json["seconds"] = solution.spent.seconds;
  json["outcomes"] = outcomes_json(solution.spent);
  json["stop"] = name(solution.stop);
  if (arguments.until_achieved && solution.stop == StopReason::kTargetScore) {
    solution.reason = "the first achieved design, as asked";
  }
  json["reason"] = solution.reason;
  if (solution.bound && std::isfinite(solution.bound->score)) {
    json["bound"] = {{"score", solution.bound->score}, {"reason", solution.bound->reason}};
  }
  if (const std::optional<Infeasibility> infeasible = problem->infeasible()) {
    json["infeasible"] = infeasibility_json(*infeasible);
  }
  for (const Tally& tally : solution.tallies) json["tallies"][tally.what] = tally.count;
  if (record.target) json["target"] = {record.target->x(), record.target->y(), record.target->z()};

  std::vector<std::string> written;
  const auto write_files = [&] {
    SolutionRecord stored = record;
    stored.problem = problem_reference(arguments.problem, *arguments.out);
    const std::string missed =
        nearest ? nearest_miss(*problem, nearest->design, nearest->evaluation).words() : std::string{};
    const std::string reason =
        verification ? why_not(*verification)
        : achieved   ? "not verified: " + not_in_time
                     : fmt::format("{}; the search ended: {}{}", missed.empty() ? kNothingEvaluated : missed,
                                   name(solution.stop), solution.reason.empty() ? "" : ", " + solution.reason);
    // The file keeps to the rule of comparisons, standing then score; the page
    // shows what there is to learn from.
    SolutionRecord shown = record;
    if (nearest) {
      shown.design = nearest->design;
      shown.X_WB = problem->base_pose(nearest->design);
      shown.evaluation = nearest->evaluation;
    }
    const Page page = page_of_solution(*problem, shown,
                                       {.path = record.evaluation.attempt.path,
                                        .sampling = sampling,
                                        .trace = meter.trace(),
                                        .command = common.command,
                                        .reason = reason});
    const std::pair<const char*, std::string> texts[] = {{"solution.json", solution_to_json(*problem, stored)},
                                                         {"trace.csv", trace_csv(meter.trace())},
                                                         {"view.html", write_page(page)}};
    for (const auto& [file_name, text] : texts) {
      write_file(*arguments.out / file_name, text);
      written.push_back((*arguments.out / file_name).string());
    }
  };
  // What was found is told even where it cannot be written.
  std::exception_ptr not_written;
  if (arguments.out) {
    try {
      write_files();
    } catch (const FileError&) {
      not_written = std::current_exception();
    }
    json["files"] = written;
  }

  if (common.json) {
    print(json);
  } else {
    say("problem      {}{}\n", arguments.problem,
        instance ? fmt::format(", instance {}:{}", instance->seed, instance->index) : "");
    if (record.target) {
      say("target       ({:.4f}, {:.4f}, {:.4f})\n", record.target->x(), record.target->y(), record.target->z());
    }
    if (!evaluated) {
      say("design       none: {}\n", kNothingEvaluated);
    } else if (problem->infeasible()) {
      say("design       none: the task is proved infeasible\n");
    } else if (nearest && nearest->design != solution.design) {
      write_out(evaluation_text(*problem, nearest->design, nearest->evaluation, "nearest"));
      say("best score   {:.6f}   {}: {}\n", solution.evaluation.score, standing(solution.evaluation.attempt),
          to_string(problem->library(), solution.design));
    } else {
      write_out(evaluation_text(*problem, solution.design, solution.evaluation));
    }
    if (verification) {
      say("verified     {}{}\n", verification->level,
          verification->level == "path" ? ": a collision-free path from home through all goals"
                                        : fmt::format(" ({})", why_not(*verification)));
      write_out(home_text(*problem, verification->path));
    } else if (achieved) {
      say("verified     no: {}\n", not_in_time);
    }
    say("solver       {}, seed {}: {} evaluations, {:.3f} s\n", arguments.solver, arguments.seed,
        solution.spent.evaluations, solution.spent.seconds);
    say("outcomes     {}\n", outcomes_text(solution.spent));
    say("ended        {}{}\n", name(solution.stop),
        solution.reason.empty() ? "" : fmt::format(": {}", solution.reason));
    for (const std::string& path : written) say("wrote        {}\n", path);
  }
  if (not_written) {
    flush_output();
    std::rethrow_exception(not_written);
  }
  if (solution.stop == StopReason::kInterrupted) return Status::kInterrupted;
  return solution.evaluation.attempt.achieved ? Status::kSuccess : Status::kNegative;
}

}  // namespace modsearch::app
