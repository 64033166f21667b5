#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <modsearch/problem/readers_internal.hpp>

namespace modsearch {
namespace detail {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr double kSameNumber = 1e-6;  // between a number of the file and what it has to equal [m, rad, relative score]

double number_or_null(const JsonCursor& cursor, double null_means, NumberLimits limits = {}) {
  return cursor.value().is_null() ? null_means : cursor.number(limits);
}

/// The problem that `record` names, relative to the solution's own folder, or the one that is given instead.
std::shared_ptr<const RobotProblem> problem_of(const JsonCursor& root, const std::optional<std::string>& instead,
                                               SolutionRecord& record) {
  if (const std::optional<JsonCursor> instance = root.find("instance")) {
    instance->expect_keys({"seed", "index", "target"});
    record.instance = Instance{instance->at("seed").unsigned_integer(), instance->at("index").unsigned_integer()};
    if (const std::optional<JsonCursor> target = instance->find("target")) record.target = target->vector(3);
  }
  record.problem = root.text_or("problem", "");
  const FileOptions options{root.source().mesh_root};
  if (instead) return load_problem(*instead, record.instance.value_or(Instance{}), options);
  const JsonCursor named = root.at("problem");
  const bool builtin = builtin_problem(record.problem).has_value();
  const std::string file = builtin ? record.problem : (root.source().directory / record.problem).string();
  try {
    return load_problem(file, record.instance.value_or(Instance{}), options);
  } catch (const FileError& error) {
    named.fail(fmt::format("{} cannot be used: {}", preview(named.value()), error.what()));
  }
}

void check_target(const JsonCursor& root, const SolutionRecord& record, const RobotProblem& problem) {
  if (!record.target) return;
  const std::span<const Goal> goals = problem.task().goals();
  const bool known = std::any_of(goals.begin(), goals.end(), [&](const Goal& goal) {
    return (goal.position() - *record.target).norm() <= kSameNumber;
  });
  if (!known) {
    root.at("instance")
        .at("target")
        .fail_value(fmt::format("the target of instance {}:{} of '{}' (limit: within {} m)", record.instance->seed,
                                record.instance->index, problem.name(), kSameNumber));
  }
}

void check_module_order(const JsonCursor& order, const RobotProblem& problem, const Design& design) {
  const ModuleLibrary& library = problem.library();
  std::vector<std::string> ids;
  if (!problem.spec().placed_base) ids.push_back(library.base().id);  // a placed one is among the modules
  for (const int k : design.types()) ids.push_back(library.type(k).id);
  const std::vector<JsonCursor> entries = order.items();
  if (entries.size() != ids.size()) {
    order.fail(fmt::format("has {} modules where the design has {} with its base", entries.size(), ids.size()));
  }
  for (std::size_t i = 0; i < entries.size(); ++i) {
    if (entries[i].text() != ids[i]) entries[i].fail_value(fmt::format("\"{}\", the module of the design", ids[i]));
  }
}

/// [module, connector, module, connector] by numbers and IDs: each module hangs on the one before it.
void check_connections(const JsonCursor& list, const RobotProblem& problem, const Design& design) {
  auto expected = problem.library().connections(design.types());
  if (problem.spec().placed_base && !expected.empty()) expected.erase(expected.begin());  // the base's with the ground
  const std::vector<JsonCursor> entries = list.items();
  if (entries.size() != expected.size()) {
    list.fail(fmt::format("has {} connections where the design has {}", entries.size(), expected.size()));
  }
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const Json connection = {i, expected[i].first, i + 1, expected[i].second};
    if (entries[i].value() != connection) {
      entries[i].fail_value(fmt::format("{}, the connection of the design", preview(connection)));
    }
  }
}

}  // namespace

Design read_module_order(const JsonCursor& order, const ModuleLibrary& library) {
  const std::vector<JsonCursor> entries = order.items();
  if (entries.empty() || entries[0].text() != library.base().id) {
    order.fail(fmt::format("does not begin with \"{}\", the base of library '{}'", library.base().id, library.name()));
  }
  Design design;
  for (std::size_t i = 1; i < entries.size(); ++i) {
    const std::optional<int> k = library.find(entries[i].text());
    if (!k) entries[i].fail_value(fmt::format("a module of library '{}'", library.name()));
    if (library.type(*k).n_parameters() > 0)
      entries[i].fail("the module has parameters, which only \"design\" can give");
    design.modules.push_back({*k, Parameters(0)});
    if (!library.fits_together(design.types())) entries[i].fail_value("a module that fits the one before it");
  }
  return design;
}

namespace {

Eigen::Isometry3d read_base_pose(const JsonCursor& cursor, const RobotProblem& problem, const Design& design) {
  // CoBRA lists one pose per base.
  const Json& value = cursor.value();
  const bool listed = value.is_array() && value.size() == 1;
  const JsonCursor pose = listed ? cursor.items()[0] : cursor;
  const Eigen::Isometry3d X_WB = pose.pose();
  if (!X_WB.isApprox(problem.base_pose(design), kSameNumber)) {
    pose.fail(fmt::format("is not where '{}' places the base (limit: within {})", problem.name(), kSameNumber));
  }
  return X_WB;
}

Terms read_terms(const JsonCursor& cursor, const JsonCursor& score) {
  constexpr TermId kIds[] = {TermId::kReached, TermId::kDistance, TermId::kModules,
                             TermId::kMass,    TermId::kCost,     TermId::kCollision};
  Terms terms;
  std::vector<std::string> seen;
  for (const JsonCursor& entry : cursor.items()) {
    entry.expect_keys({"name", "value"});
    const std::string term_name = entry.at("name").text();
    const auto id =
        std::find_if(std::begin(kIds), std::end(kIds), [&](TermId each) { return name(each) == term_name; });
    if (id == std::end(kIds)) entry.at("name").fail_value("the name of a term of the score");
    if (std::find(seen.begin(), seen.end(), term_name) != seen.end()) {
      entry.at("name").fail_value("given once (limit 1)");
    }
    seen.push_back(term_name);
    terms.add(*id, number_or_null(entry.at("value"), -kInf));
  }
  const double claimed = number_or_null(score, -kInf);
  const double sum = terms.sum();
  if (score.value().is_null() && !terms.items().empty() && std::isfinite(sum)) {
    score.fail_value(fmt::format("the sum of the terms, {}", sum));
  }
  if (std::isfinite(claimed) && !(std::abs(sum - claimed) <= kSameNumber * std::max(1.0, std::abs(claimed)))) {
    score.fail_value(fmt::format("the sum of the terms, {}", sum));
  }
  return terms;
}

Eigen::MatrixXd read_rows(const JsonCursor& cursor, std::size_t n_columns) {
  const std::vector<JsonCursor> rows = cursor.items();
  Eigen::MatrixXd result(static_cast<Eigen::Index>(rows.size()), static_cast<Eigen::Index>(n_columns));
  for (std::size_t i = 0; i < rows.size(); ++i) result.row(static_cast<Eigen::Index>(i)) = rows[i].vector(n_columns);
  return result;
}

/// Times of `n` rows: a list, or the step between them.
std::vector<double> read_times(const JsonCursor& cursor, std::size_t n) {
  std::vector<double> times;
  if (cursor.value().is_number()) {
    const double step = cursor.number({.lower = 0.0, .above_lower = true});
    for (std::size_t i = 0; i < n; ++i) times.push_back(step * static_cast<double>(i));
    return times;
  }
  for (const JsonCursor& entry : cursor.items()) {
    times.push_back(entry.number({.lower = 0.0}));
    if (times.size() > 1 && !(times.back() > times[times.size() - 2])) {
      entry.fail_value(fmt::format("later than the time before it, {}", times[times.size() - 2]));
    }
  }
  return times;
}

/// The row of `times` at which each goal is passed.
std::vector<int> read_goal_rows(const JsonCursor& cursor, const std::vector<double>& times, const Task& task) {
  constexpr double kSameTime = 1e-9;
  const std::vector<TaskStep> goals = steps_of(task);
  for (const auto& [id, value] : cursor.members()) {
    const bool known =
        std::any_of(goals.begin(), goals.end(), [&id = id](const TaskStep& goal) { return goal.id == id; });
    if (!known) value.fail("the task has no goal with this ID");
  }
  std::vector<int> rows;
  for (const TaskStep& goal : goals) {
    const JsonCursor time = cursor.at(goal.id);
    const double seconds = time.number({.lower = 0.0});
    const auto after = std::lower_bound(times.begin(), times.end(), seconds - kSameTime);
    if (after == times.end() || std::abs(*after - seconds) > kSameTime) time.fail_value("one of the times in t");
    rows.push_back(static_cast<int>(after - times.begin()));
    if (!task.any_order() && rows.size() > 1 && rows.back() < rows[rows.size() - 2])
      time.fail_value("after the goal before it");
  }
  return rows;
}

bool has_rows(const JsonCursor& trajectory) {
  return !trajectory.at("q").value().empty() || !trajectory.at("t").value().empty();
}

void read_trajectory(const JsonCursor& cursor, const RobotProblem& problem, std::size_t n_joints, Attempt& attempt) {
  cursor.expect_keys({"t", "q", "dq", "ddq", "goal2time"});
  const JsonCursor q = cursor.at("q");
  const std::vector<double> times = read_times(cursor.at("t"), q.items().size());
  attempt.path = Path{read_rows(q, n_joints)};
  const auto n_rows = static_cast<std::size_t>(attempt.path->waypoints.rows());
  if (n_rows != times.size() || n_rows == 0)
    q.fail(fmt::format("has {} rows for {} times (limit: as many, at least 1)", n_rows, times.size()));
  for (const char* derivative : {"dq", "ddq"}) {  // not used: they follow from q and t
    const std::optional<JsonCursor> found = cursor.find(derivative);
    if (found && static_cast<std::size_t>(read_rows(*found, n_joints).rows()) != n_rows) {
      found->fail(fmt::format("has another number of rows than q (limit {})", n_rows));
    }
  }
  if (is_timed(problem.task(), problem.scene())) attempt.path->times = times;
  attempt.step_waypoints = read_goal_rows(cursor.at("goal2time"), times, problem.task());
  // Only visits say at which row a goal is passed.
  if (problem.task().steps().empty()) attempt.goal_waypoints = attempt.step_waypoints;
}

/// The path has to lead through the postures that the file claims for the goals.
void check_path_against_postures(const JsonCursor& root, const Attempt& attempt) {
  for (std::size_t i = 0; i < attempt.goal_waypoints.size(); ++i) {
    const Eigen::RowVectorXd row = attempt.path->waypoints.row(attempt.goal_waypoints[i]);
    const Eigen::RowVectorXd posture = attempt.postures.row(static_cast<Eigen::Index>(i));
    if (row.size() > 0 && (row - posture).cwiseAbs().maxCoeff() > kSameNumber) {
      root.at("trajectory")
          .at("q")
          .items()[static_cast<std::size_t>(attempt.goal_waypoints[i])]
          .fail_value(
              fmt::format("posture {} of \"postures\", which is due at this time (limit: within {})", i, kSameNumber));
    }
  }
}

Failure failure_from(const JsonCursor& cursor) {
  const std::string text = cursor.text();
  for (std::size_t i = 0; i < kFailures; ++i) {
    const auto each = static_cast<Failure>(i);
    if (each != Failure::kNone && name(each) == text) return each;
  }
  cursor.fail_value("the name of a reason for failure");
}

void read_claims(const JsonCursor& root, const RobotProblem& problem, std::size_t n_joints, Evaluation& evaluation) {
  Attempt& attempt = evaluation.attempt;
  evaluation.terms = read_terms(root.at("terms"), root.at("score"));
  evaluation.score = number_or_null(root.at("score"), -kInf);
  attempt.reached = root.at("reached").boolean();
  attempt.achieved = root.at("achieved").boolean();
  if (attempt.achieved && !attempt.reached) root.at("achieved").fail_value("possible where \"reached\" is false");
  const std::optional<JsonCursor> failure = root.find("failure");
  if (failure && attempt.achieved) failure->fail_value("possible where \"achieved\" is true");
  attempt.why = attempt.achieved ? Failure::kNone : (failure ? failure_from(*failure) : Failure::kUnreachable);
  for (const Term& term : evaluation.terms.items()) {
    if (term.id == TermId::kCollision && term.value != 0.0) attempt.collides = true;
  }
  attempt.goal_error = number_or_null(root.at("goalError_m"), kInf, {.lower = 0.0});
  attempt.clearance = number_or_null(root.at("clearance_m"), kInf);
  const JsonCursor postures = root.at("postures");
  attempt.postures = read_rows(postures, n_joints);
  const auto n_goals = static_cast<Eigen::Index>(problem.task().goals().size());
  if (attempt.postures.rows() != n_goals && (attempt.reached || attempt.postures.rows() != 0)) {
    postures.fail(fmt::format("has {} rows for {} goals", attempt.postures.rows(), n_goals));
  }
}

void read_solver(const JsonCursor& cursor, SolutionRecord& record) {
  cursor.expect_keys({"name", "options", "seed", "evaluations", "seconds"});
  record.solver = cursor.at("name").text();
  if (const std::optional<JsonCursor> options = cursor.find("options")) {
    for (const auto& [key, value] : options->members()) record.solver_options.emplace_back(key, value.text());
  }
  record.seed = cursor.at("seed").unsigned_integer();
  record.evaluations = cursor.at("evaluations").integer(0, std::numeric_limits<std::int64_t>::max());
  record.seconds = cursor.at("seconds").number({.lower = 0.0});
}

void check_rest(const JsonCursor& root, const RobotProblem& problem) {
  if (root.at("taskID").text() != problem.task().name()) {
    root.at("taskID").fail_value(fmt::format("\"{}\", the task of '{}'", problem.task().name(), problem.name()));
  }
  if (const std::optional<JsonCursor> cost = root.find("cost")) static_cast<void>(number_or_null(*cost, kInf));
  if (const std::optional<JsonCursor> function = root.find("costFunction")) static_cast<void>(function->text());
  if (const std::optional<JsonCursor> seconds = root.find("computationTime")) {
    static_cast<void>(seconds->number({.lower = 0.0}));
  }
  if (const std::optional<JsonCursor> processor = root.find("processorName")) static_cast<void>(processor->text());
  if (const std::optional<JsonCursor> set = root.find("moduleSet")) static_cast<void>(set->text());
  for (const char* list : {"moduleConnection", "baseConnection"}) {
    if (const std::optional<JsonCursor> found = root.find(list)) static_cast<void>(found->items());
  }
  if (const std::optional<JsonCursor> bound = root.find("bound")) {
    bound->expect_keys({"score", "gap", "certificate"});
    static_cast<void>(bound->at("score").number());
  }
}

LoadedSolution read_solution(const JsonCursor& root, const std::optional<std::string>& instead) {
  root.expect_keys(
      {"modsearch",    "version",         "taskID",        "problem",     "instance", "moduleOrder", "moduleConnection",
       "moduleSet",    "baseConnection",  "basePose",      "design",      "score",    "terms",       "reached",
       "achieved",     "failure",         "goalError_m",   "clearance_m", "postures", "trajectory",  "cost",
       "costFunction", "computationTime", "processorName", "verified",    "solver",   "bound"});
  LoadedSolution result;
  SolutionRecord& record = result.record;
  const bool ours = root.has("modsearch");
  if (ours) static_cast<void>(root.at("modsearch").integer(1, 1));
  result.problem = problem_of(root, instead, record);
  const RobotProblem& problem = *result.problem;
  const ModuleLibrary& library = problem.library();
  check_target(root, record, problem);
  check_rest(root, problem);

  const bool has_design = ours || root.has("design");
  record.design =
      has_design ? read_design(root.at("design"), library) : read_module_order(root.at("moduleOrder"), library);
  if (static_cast<int>(record.design.modules.size()) + 1 > problem.max_modules()) {
    root.at(has_design ? "design" : "moduleOrder")
        .fail(fmt::format("has {} modules with the base (limit {})", record.design.modules.size() + 1,
                          problem.max_modules()));
  }
  if (has_design && root.has("moduleOrder")) check_module_order(root.at("moduleOrder"), problem, record.design);
  if (ours && root.has("moduleConnection")) {
    check_connections(root.at("moduleConnection"), problem, record.design);
  }
  record.X_WB = root.has("basePose") ? read_base_pose(root.at("basePose"), problem, record.design)
                                     : problem.base_pose(record.design);

  const auto n_joints = static_cast<std::size_t>(problem.chain(record.design.types())->n_joints());
  result.claims = ours;
  if (ours) read_claims(root, problem, n_joints, record.evaluation);
  Attempt& attempt = record.evaluation.attempt;
  // One without rows says that there is no motion yet: Timor reads no solution without the key.
  if (const std::optional<JsonCursor> trajectory = root.find("trajectory"); trajectory && has_rows(*trajectory)) {
    read_trajectory(*trajectory, problem, n_joints, attempt);
    if (attempt.postures.rows() > 0) check_path_against_postures(root, attempt);
  }
  if (!ours) return result;
  record.verified = root.at("verified").text();
  static_cast<void>(root.at("verified").choice({"none", "posture", "path"}));
  read_solver(root.at("solver"), record);
  return result;
}

}  // namespace
}  // namespace detail

LoadedSolution load_solution(const std::filesystem::path& file, const std::optional<std::string>& problem,
                             const FileOptions& options) {
  const detail::JsonDocument document = detail::load_json(file, {}, options.mesh_root);
  return detail::read_solution(document.cursor(), problem);
}

}  // namespace modsearch
