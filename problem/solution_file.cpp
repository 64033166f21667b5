#include <fmt/format.h>

#include <cmath>
#include <modsearch/problem/neighbour_files_internal.hpp>
#include <modsearch/problem/readers_internal.hpp>
#include <modsearch/problem/timed_path_internal.hpp>

namespace modsearch {
namespace {

using nlohmann::ordered_json;

/// A number, or null where it is infinite or NaN, which JSON cannot say.
ordered_json finite_or_null(double number) {
  return std::isfinite(number) ? ordered_json(number) : ordered_json(nullptr);
}

ordered_json rows(const Eigen::MatrixXd& matrix) {
  ordered_json list = ordered_json::array();
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) list.push_back(detail::to_json(Eigen::VectorXd(matrix.row(i))));
  return list;
}

}  // namespace

void detail::add_assembly(const ModuleLibrary& library, const Design& design, bool placed, ordered_json& out) {
  const std::vector<int> types = design.types();
  const auto connections = library.connections(types);
  const std::size_t first = placed ? 1 : 0;
  out["moduleOrder"] = ordered_json::array();
  if (!placed) out["moduleOrder"].push_back(library.base().id);
  for (const int k : types) out["moduleOrder"].push_back(library.type(k).id);
  out["moduleConnection"] = ordered_json::array();
  for (std::size_t i = first; i < connections.size(); ++i) {
    out["moduleConnection"].push_back({i - first, connections[i].first, i + 1 - first, connections[i].second});
  }
  const bool stands = !placed || !connections.empty();
  out["baseConnection"] = ordered_json::array();
  if (stands) out["baseConnection"].push_back({0, placed ? connections[0].second : library.ground_connector()});
}

namespace {

/// The motion home -> goals, sampled at the task's time step.
ordered_json trajectory(const RobotProblem& problem, const SolutionRecord& record) {
  const Attempt& attempt = record.evaluation.attempt;
  const std::shared_ptr<const Chain> chain = problem.chain(record.design.types());
  const detail::TimedPath timed = detail::timed(*chain, *attempt.path, problem.spec().time_step);
  ordered_json goal_times = ordered_json::object();
  const std::vector<TaskStep> steps = steps_of(problem.task());
  const std::vector<int>& done = attempt.step_waypoints.empty() ? attempt.goal_waypoints : attempt.step_waypoints;
  for (std::size_t i = 0; i < steps.size() && i < done.size(); ++i) {
    goal_times[steps[i].id] = timed.times[timed.rows_of_waypoints[static_cast<std::size_t>(done[i])]];
  }
  return {{"t", timed.times}, {"q", rows(timed.q)}, {"goal2time", std::move(goal_times)}};
}

/// Refuses a record that could not be read back. The design is checked first: the rest depends on it.
void check(const RobotProblem& problem, const SolutionRecord& record) {
  check(problem.library(), record.design);
  const Attempt& attempt = record.evaluation.attempt;
  const int n_joints = problem.chain(record.design.types())->n_joints();
  const auto refuse = [&](const std::string& what) {
    throw std::invalid_argument(fmt::format("solution of '{}': {}", problem.name(), what));
  };
  if (attempt.postures.rows() > 0 && attempt.postures.cols() != n_joints) {
    refuse(fmt::format("postures of {} joints for an arm with {}", attempt.postures.cols(), n_joints));
  }
  if (!attempt.path) return;
  if (attempt.path->waypoints.rows() < 1 || attempt.path->waypoints.cols() != n_joints) {
    refuse(fmt::format("a path of {} rows and {} joints for an arm with {} joints", attempt.path->waypoints.rows(),
                       attempt.path->waypoints.cols(), n_joints));
  }
  for (const int row : attempt.goal_waypoints) {
    if (row < 0 || row >= attempt.path->waypoints.rows()) {
      refuse(fmt::format("a goal is passed at row {} of a path of {}", row, attempt.path->waypoints.rows()));
    }
  }
}

}  // namespace

std::string solution_to_json(const RobotProblem& problem, const SolutionRecord& record) {
  check(problem, record);
  const Evaluation& evaluation = record.evaluation;
  const Attempt& attempt = evaluation.attempt;
  ordered_json out;
  out["modsearch"] = 1;
  out["version"] = "2022";
  out["taskID"] = problem.task().name();
  out["problem"] = record.problem;
  if (record.instance) {
    out["instance"] = {{"seed", record.instance->seed}, {"index", record.instance->index}};
    if (record.target) out["instance"]["target"] = detail::to_json(Eigen::VectorXd(*record.target));
  }
  out["moduleSet"] = detail::module_set(problem.library());
  detail::add_assembly(problem.library(), record.design, problem.spec().placed_base, out);
  out["basePose"] = ordered_json::array({detail::to_json(record.X_WB)});
  out["design"] = detail::to_json(problem.library(), record.design);
  out["score"] = finite_or_null(evaluation.score);
  out["terms"] = ordered_json::array();
  for (const Term& term : evaluation.terms.items()) {
    out["terms"].push_back({{"name", name(term.id)}, {"value", finite_or_null(term.value)}});
  }
  out["reached"] = attempt.reached;
  out["achieved"] = attempt.achieved;
  if (!attempt.achieved) out["failure"] = name(attempt.why);
  out["goalError_m"] = finite_or_null(attempt.goal_error);
  out["clearance_m"] = finite_or_null(attempt.clearance);
  out["postures"] = rows(attempt.postures);
  if (attempt.path) out["trajectory"] = trajectory(problem, record);
  // CoBRA's words for what a solution costs; the score stands above.
  out["cost"] = problem.chain(record.design.types())->at(record.design.parameters()).mass();
  out["costFunction"] = "mass";
  out["computationTime"] = record.seconds;
  out["verified"] = record.verified;
  ordered_json options = ordered_json::object();
  for (const auto& [key, value] : record.solver_options) options[key] = value;
  out["solver"] = {{"name", record.solver},
                   {"options", std::move(options)},
                   {"seed", record.seed},
                   {"evaluations", record.evaluations},
                   {"seconds", record.seconds}};
  return detail::to_text(out);
}

void write_solution(const std::filesystem::path& file, const RobotProblem& problem, const SolutionRecord& record) {
  write_file(file, solution_to_json(problem, record));
}

}  // namespace modsearch
