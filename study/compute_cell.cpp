#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <modsearch/baselines/refined.hpp>
#include <modsearch/problem/robot_problem.hpp>
#include <modsearch/rl/saved_policy.hpp>
#include <modsearch/study/compute_cell.hpp>
#include <modsearch/study/text_hash.hpp>
#include <stdexcept>
#include <utility>

namespace modsearch {
namespace {

// Of this process so far, user and system.
double cpu_seconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

double mass_of(const DesignProblem& problem, const Design& design) {
  return problem.library().assemble(design.types()).mass(design.parameters());
}

// The base included: it is a module of the design itself where it may be placed.
int n_modules(const DesignProblem& problem, const Design& design) {
  if (const auto* robot = dynamic_cast<const RobotProblem*>(&problem)) return robot->n_modules(design);
  return static_cast<int>(design.modules.size()) + 1;
}

// Keeps the design behind each point of a meter's trace; what it weighs is looked up after the search.
class TraceDesigns {
 public:
  void look(const Meter& meter) {
    if (meter.trace().size() > designs_.size()) designs_.push_back(meter.best()->design);
  }
  [[nodiscard]] std::vector<Improvement> improvements(const DesignProblem& problem, const Meter& meter) const {
    std::vector<Improvement> result;
    for (std::size_t i = 0; i < designs_.size(); ++i) {
      const TracePoint& point = meter.trace()[i];
      result.push_back({.evaluations = point.evaluations,
                        .seconds = point.seconds,
                        .score = point.score,
                        .achieved = point.achieved,
                        .modules = n_modules(problem, designs_[i]),
                        .mass = mass_of(problem, designs_[i])});
    }
    return result;
  }

 private:
  std::vector<Design> designs_;
};

CellOutcome outcome_of(const DesignProblem& problem, const Solution& solution, bool evaluated) {
  CellOutcome outcome;
  outcome.design = record_of(problem.library(), solution.design);
  outcome.score = solution.evaluation.score;
  outcome.achieved = solution.evaluation.attempt.achieved;
  outcome.reached = solution.evaluation.attempt.reached;
  if (outcome.achieved) outcome.witness.postures = solution.evaluation.attempt.postures;
  if (!outcome.achieved) outcome.failure = name(solution.evaluation.attempt.why);
  outcome.goal_error = evaluated ? solution.evaluation.attempt.goal_error : std::numeric_limits<double>::infinity();
  outcome.modules = n_modules(problem, solution.design);
  outcome.mass = mass_of(problem, solution.design);
  for (const Term& term : solution.evaluation.terms.items()) {
    outcome.terms.push_back({std::string{name(term.id)}, term.value});
  }
  outcome.spent = solution.spent;
  outcome.stop = name(solution.stop);
  outcome.reason = solution.reason;
  outcome.bound = solution.bound;
  return outcome;
}

// A search with its clock readings.
struct TimedSearch {
  CellOutcome outcome;
  std::vector<Improvement> trace;
};

TimedSearch search(const DesignProblem& problem, const Solver& solver, const CellKey& key) {
  TraceDesigns designs;
  const double before = cpu_seconds();
  Meter meter{key.budget, [&](const Meter& m) { designs.look(m); }};
  const Solution solution = solver.solve(problem, meter, Rng{key.seed});
  const double spent = cpu_seconds() - before;
  TimedSearch result{outcome_of(problem, solution, meter.best().has_value()), designs.improvements(problem, meter)};
  result.outcome.cpu_seconds = spent;
  return result;
}

// The first search in a new process pays for page faults and cold caches, about 0.3 ms: many times what a policy or a
// small program takes. Short searches are therefore done again, and their clock readings are those of the median.
void solve(const StudyProblem& family, const Solver& solver, CellRecord& record) {
  constexpr double kShort = 0.005;  // [s]
  constexpr std::size_t kAgain = 5;
  const std::shared_ptr<const DesignProblem> problem = family.make(record.key.instance.value_or(Instance{}));
  TimedSearch first = search(*problem, solver, record.key);
  // By its CPU time too: what looks long may have waited for a busy core.
  if (!record.key.timed() && std::min(first.outcome.spent.seconds, first.outcome.cpu_seconds) < kShort) {
    std::vector<TimedSearch> again;
    for (std::size_t i = 0; i < kAgain; ++i) again.push_back(search(*problem, solver, record.key));
    std::nth_element(again.begin(), again.begin() + kAgain / 2, again.end(),
                     [](const auto& a, const auto& b) { return a.outcome.spent.seconds < b.outcome.spent.seconds; });
    const TimedSearch& median = again[kAgain / 2];
    first.outcome.spent.seconds = median.outcome.spent.seconds;
    first.outcome.cpu_seconds = median.outcome.cpu_seconds;
    for (std::size_t i = 0; i < std::min(first.trace.size(), median.trace.size()); ++i) {
      first.trace[i].seconds = median.trace[i].seconds;
    }
  }
  record.outcome = std::move(first.outcome);
  record.trace = std::move(first.trace);
}

std::string weights_hash(const Policy& policy) {
  std::string bytes;
  for (const auto& [name, values] : policy.tensors()) {
    bytes.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(float));
  }
  return text_hash(bytes);
}

bool has_finite_weights(const Policy& policy) {
  return std::all_of(policy.tensors().begin(), policy.tensors().end(), [](const auto& tensor) {
    return std::all_of(tensor.second.begin(), tensor.second.end(), [](float w) { return std::isfinite(w); });
  });
}

void train(const StudyTraining& plan, CellRecord& record, const std::filesystem::path& folder) {
  LearnerSettings settings = plan.settings;
  settings.training.final_episodes = 0;
  const double before = cpu_seconds();
  Meter meter{record.key.budget};
  const Training training = AgentLearner{settings}.train(plan.source, meter, Rng{record.key.seed});
  const auto& policy = dynamic_cast<const Policy&>(*training.policy);
  if (training.end == TrainingEnd::kDiverged || !has_finite_weights(policy)) {
    throw std::runtime_error(
        fmt::format("the training of '{}' diverged: smaller learning rates may help", record.key.label));
  }
  const double mean_return = training.history.empty() ? -std::numeric_limits<double>::infinity()
                                                      : training.history.back().evaluation.mean_return;
  CellOutcome& outcome = record.outcome.emplace();
  outcome.training = TrainingFacts{.episodes = training.episodes,
                                   .steps = training.steps,
                                   .updates = training.updates,
                                   .mean_return = mean_return,
                                   .policy = policy_path(record.id).string(),
                                   .weights = weights_hash(policy)};
  outcome.spent = training.spent;
  outcome.cpu_seconds = cpu_seconds() - before;
  outcome.stop = name(training.end);
  const std::filesystem::path file = folder / policy_path(record.id);
  std::filesystem::create_directories(file.parent_path());
  write_policy(file, describe(policy, *plan.library, plan.problem,
                              {.version = MODSEARCH_VERSION,
                               .preset = plan.preset,
                               .seed = record.key.seed,
                               .episodes = training.episodes,
                               .steps = training.steps,
                               .updates = training.updates,
                               .seconds = training.seconds}));
}

}  // namespace

std::filesystem::path policy_path(const std::string& training) {
  return std::filesystem::path{"policies"} / (training + ".json");
}

CellRecord compute(const Study& study, const PlannedCell& cell, const std::filesystem::path& folder) {
  CellRecord record = cell.record;
  const CellKey& key = record.key;
  switch (key.kind) {
    case CellKind::kTraining:
      train(study.solvers[cell.solver].trainings[cell.training], record, folder);
      break;
    case CellKind::kBound:
      solve(study.problems[cell.problem], *study.certification->solver, record);
      break;
    case CellKind::kRun: {
      const StudySolver& planned = study.solvers[cell.solver];
      std::shared_ptr<const Solver> solver = planned.solver;
      if (!key.training.empty()) solver = load_trained_policy(folder / policy_path(key.training));
      if (planned.refine) solver = std::make_shared<Refined>(std::move(solver));
      solve(study.problems[cell.problem], *solver, record);
      break;
    }
  }
  record.state = CellState::kDone;
  return record;
}

}  // namespace modsearch
