#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <modsearch/kinematics/path_free.hpp>
#include <modsearch/problem/base_placement.hpp>
#include <modsearch/problem/completion_internal.hpp>
#include <modsearch/problem/completions_internal.hpp>
#include <modsearch/problem/end_proofs_internal.hpp>
#include <modsearch/problem/robot_problem.hpp>
#include <modsearch/problem/task_pose_program.hpp>
#include <modsearch/problem/task_program.hpp>
#include <mutex>
#include <shared_mutex>
#include <stdexcept>

namespace modsearch {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kProvedImpossible = -kInfinity;

// A motion of the planner may reach half its resolution into a body: what does so is none, as for `verify`.
void look_finer(const Arm& arm, const Scene& scene, const PlanOptions& planner, Attempt& attempt) {
  constexpr double kFiner = 10.0;  // as VerificationOptions::refinement
  if (!attempt.path || scene.any_moves()) return;
  const double resolution = planner.resolution / kFiner;
  if (path_is_free(arm, scene, *attempt.path, resolution, planner.self_collision, attempt.work)) return;
  attempt.achieved = false;
  attempt.collides = true;
  attempt.why = Failure::kNoPath;
  attempt.inconclusive = true;
}

// Why no arm of `n` modules can be completed.
std::string incompletable(int n, int least_joints) {
  const std::string joints = least_joints == 0   ? ""
                             : least_joints == 1 ? " and a joint"
                                                 : fmt::format(" and {} joints", least_joints);
  return fmt::format("no arm of {} has an end effector that may stand at the goals{}",
                     n == 1 ? "1 module" : fmt::format("{} modules", n), joints);
}

}  // namespace

// What follows from library and base pose alone: chains by type sequence, how far each module can carry the arm, and
// which types lead to an end effector.
class ChainCache {
 public:
  ChainCache(std::shared_ptr<const ModuleLibrary> library, const Eigen::Isometry3d& X_WB)
      : library_{std::move(library)}, X_WB_{X_WB}, base_span_{module_span(library_->base())}, completion_{*library_} {
    for (int k = 0; k < library_->n_types(); ++k) type_spans_.push_back(module_span(library_->type(k)));
  }

  [[nodiscard]] bool belongs_to(const RobotProblemSpec& spec) const {
    return library_ == spec.library && X_WB_.matrix() == spec.X_WB.matrix();
  }
  [[nodiscard]] const ModuleSpan& base_span() const { return base_span_; }
  [[nodiscard]] const std::vector<ModuleSpan>& type_spans() const { return type_spans_; }
  [[nodiscard]] const detail::Completion& completion() const { return completion_; }

  /// Built when it is first asked for: most problems have no obstacles at their goals.
  [[nodiscard]] const detail::RigidEnds& rigid_ends() {
    std::call_once(ends_built_, [&] { ends_ = detail::rigid_ends(*library_); });
    return ends_;
  }

  // Readers share the lock: all but the first evaluation of a sequence only look.
  [[nodiscard]] std::shared_ptr<const Chain> chain(std::span<const int> types) {
    thread_local std::vector<int> key;  // keeps its memory between calls
    key.assign(types.begin(), types.end());
    {
      const std::shared_lock lock{mutex_};
      if (const auto found = chains_.find(key); found != chains_.end()) return found->second;
    }
    auto built = std::make_shared<const Chain>(library_->assemble(types, X_WB_));
    const std::unique_lock lock{mutex_};
    if (chains_.size() >= kKept) chains_.clear();
    return chains_.try_emplace(key, std::move(built)).first->second;
  }

 private:
  // A search of millions of sequences must not keep them all (some kilobytes each); building one anew takes
  // microseconds.
  static constexpr std::size_t kKept = 16384;

  std::shared_ptr<const ModuleLibrary> library_;
  Eigen::Isometry3d X_WB_;
  ModuleSpan base_span_;
  std::vector<ModuleSpan> type_spans_;
  detail::Completion completion_;
  std::once_flag ends_built_;
  detail::RigidEnds ends_;
  std::shared_mutex mutex_;
  std::map<std::vector<int>, std::shared_ptr<const Chain>> chains_;
};

// What is proved about the arms of a problem, once somebody asks.
class TaskProofs {
 public:
  struct Facts {
    std::optional<detail::EndProofs> ends;
    std::optional<detail::Completions> completions;
    int least_joints = 0;
  };

  [[nodiscard]] static bool worth_having(const RobotProblemSpec& spec) {
    // A task that is more than its goals may not even look at the obstacles.
    const bool goals_only = dynamic_cast<const GoalTask*>(spec.task.get()) != nullptr;
    return goals_only && (spec.library->has_end_effectors() || looks_at_obstacles(spec));
  }

  [[nodiscard]] const Facts& facts(const RobotProblemSpec& spec) {
    std::call_once(proved_, [&] { prove(spec); });
    return facts_;
  }

 private:
  [[nodiscard]] static bool looks_at_obstacles(const RobotProblemSpec& spec) {
    return spec.level != Level::kNone && spec.scene->any_rests();
  }

  // The reference scenarios, in a tenth of a microsecond: a base without a body, and targets whatever the direction, of
  // which none is inside an obstacle.
  [[nodiscard]] static bool nothing_near(const RobotProblemSpec& spec) {
    const std::vector<detail::RigidModule>& heads = spec.chains->rigid_ends().heads;
    if (heads.size() > 1 || !heads.front().parts.empty()) return false;
    const std::span<const Goal> goals = spec.task->goals();
    return std::all_of(goals.begin(), goals.end(), [&](const Goal& goal) {
      return goal.region.is_ball() && spec.scene->clearance(goal.position()) >= 0.0;
    });
  }

  void prove(const RobotProblemSpec& spec) {
    const ModuleLibrary& library = *spec.library;
    const bool overlaps_matter = looks_at_obstacles(spec) && !nothing_near(spec);
    if (!overlaps_matter && !library.has_end_effectors()) return;
    const std::vector<std::optional<detail::PoseEnclosure>> goals = detail::enclosures(*spec.task);
    if (overlaps_matter) {
      facts_.ends.emplace(library, spec.chains->rigid_ends(), *spec.task, *spec.scene, spec.X_WB, goals);
    }
    // Without end effectors nothing is known of what an arm must end with, and joints may be anywhere.
    if (!library.has_end_effectors()) return;
    facts_.least_joints = detail::least_joints(goals);
    std::vector<bool> may_end;
    for (int k = 0; k < library.n_types(); ++k) {
      const bool ruled_out = facts_.ends && facts_.ends->rules_out_end(k);
      may_end.push_back(!ruled_out && library.complete(std::span{&k, 1}));
    }
    facts_.completions.emplace(library, spec.chains->type_spans(), may_end, facts_.least_joints,
                               spec.max_modules - (spec.placed_base ? 0 : 1));
  }

  std::once_flag proved_;
  Facts facts_;
};

RobotProblem::RobotProblem(RobotProblemSpec spec) : spec_{std::move(spec)} {
  const auto refuse = [&](const std::string& what) {
    throw std::invalid_argument(fmt::format("problem '{}': {}", spec_.name, what));
  };
  if (!spec_.library) refuse("no module library");
  if (!spec_.task) refuse("no task");
  if (!spec_.scene) refuse("no scene");
  if (!spec_.scoring) refuse("no scoring");
  if (spec_.task->goals().empty()) refuse("a task without goals, at least one is needed");
  if (spec_.max_modules < 1 || spec_.max_modules > 64) {
    refuse(fmt::format("at most {} modules, not in [1, 64]", spec_.max_modules));
  }
  if (!spec_.chains || !spec_.chains->belongs_to(spec_)) {
    spec_.chains = std::make_shared<ChainCache>(spec_.library, spec_.X_WB);
  }
  if (TaskProofs::worth_having(spec_)) proofs_ = std::make_shared<TaskProofs>();
}

RobotProblem RobotProblem::with_level(Level level) const {
  RobotProblemSpec spec = spec_;
  spec.level = level;
  return RobotProblem{std::move(spec)};
}

int RobotProblem::n_modules(const Design& design) const {
  const auto placed = static_cast<int>(design.modules.size());
  return spec_.placed_base ? std::max(1, placed) : placed + 1;
}

Eigen::Isometry3d RobotProblem::base_pose(const Design& design) const {
  if (!spec_.placed_base || design.modules.empty()) return spec_.X_WB;
  return spec_.X_WB * placement_of(library().type(design.modules.front().type), design.modules.front().parameters);
}

std::vector<Fidelity> RobotProblem::stages() const {
  switch (spec_.level) {
    case Level::kNone:
      return {Fidelity::kFull};
    case Level::kPosture:
      if (!scene().any_rests()) return {Fidelity::kFull};
      return {Fidelity::kPoses, Fidelity::kFull};
    case Level::kPostureSelf:
      return {Fidelity::kPoses, Fidelity::kFull};
    case Level::kPath:
      return {Fidelity::kPoses, Fidelity::kScreen, Fidelity::kFull};
  }
  return {Fidelity::kFull};
}

Eigen::VectorXd RobotProblem::context() const {
  // Per obstacle shape: centre and radius of its bounding ball, in the scale of the goals' features; of one that moves
  // where it begins, and where it ends behind that.
  constexpr double kScale = 0.5;
  const Eigen::VectorXd goals = task().features();
  std::vector<double> numbers(goals.begin(), goals.end());
  for (const Obstacle& obstacle : scene().obstacles()) {
    for (const PlacedShape& placed : obstacle.shapes) {
      const auto show_centre = [&](const Eigen::Isometry3d& X_WO) {
        const Eigen::Vector3d centre = kScale * (X_WO * placed.X_FG.translation());
        numbers.insert(numbers.end(), centre.begin(), centre.end());
      };
      show_centre(obstacle.moves() ? obstacle.motion.X_WO.front() : Eigen::Isometry3d::Identity());
      numbers.push_back(kScale * bounding_radius(placed.shape));
      if (obstacle.moves()) show_centre(obstacle.motion.X_WO.back());
    }
  }
  return Eigen::Map<Eigen::VectorXd>(numbers.data(), static_cast<Eigen::Index>(numbers.size()));
}

std::shared_ptr<const Chain> RobotProblem::chain(std::span<const int> types) const {
  return spec_.chains->chain(types);
}

std::vector<int> RobotProblem::do_successors(std::span<const int> types) const {
  return spec_.chains->completion().successors(types, max_modules() - 1 - static_cast<int>(types.size()));
}

Evaluation RobotProblem::do_evaluate(const Design& design, Fidelity fidelity) const {
  return do_evaluate_with(design, fidelity, {});
}

Evaluation RobotProblem::do_evaluate_with(const Design& design, Fidelity fidelity, const Witness& witness) const {
  const std::vector<int> types = design.types();
  const std::shared_ptr<const Chain> chain_of_types = chain(types);
  const Arm arm = chain_of_types->at(design.parameters());

  AttemptOptions options{.level = spec_.level,
                         .ik = spec_.ik,
                         .planner = spec_.planner,
                         .follow = {},
                         .p_WB = base_pose(design).translation(),
                         .time_step = spec_.time_step,
                         .witness = witness};
  if (!witness.empty()) {
    options.planner.max_iterations =
        std::max<std::int64_t>(1, std::llround(witness.patience * static_cast<double>(options.planner.max_iterations)));
  }
  if (fidelity == Fidelity::kScreen && options.level == Level::kPath) options.level = Level::kPostureSelf;
  if (fidelity == Fidelity::kPoses) options.level = Level::kNone;

  Evaluation evaluation;
  evaluation.attempt = task().attempt(arm, scene(), options);
  Attempt& attempt = evaluation.attempt;
  if (witness.only && attempt.achieved) look_finer(arm, scene(), spec_.planner, attempt);
  if (!library().complete(types)) {
    attempt.achieved = false;
    attempt.why = Failure::kIncomplete;
    attempt.inconclusive = false;
  }

  double cost = library().base().cost;
  for (const int k : types) cost += library().type(k).cost;
  evaluation.terms = spec_.scoring->terms({.modules = n_modules(design),
                                           .mass = arm.mass(),
                                           .cost = cost,
                                           .reached = attempt.reached,
                                           .achieved = attempt.achieved,
                                           .collides = attempt.collides,
                                           .relative_error = attempt.relative_error});
  evaluation.score = evaluation.terms.sum();
  return evaluation;
}

std::unique_ptr<SmoothProgram> RobotProblem::relax(std::span<const int> types, const Relaxation& relaxation) const {
  return std::make_unique<TaskProgram>(*this, types, relaxation);
}

std::unique_ptr<PoseProgram> RobotProblem::pose_program(std::span<const int> types) const {
  if (!TaskPoseProgram::covers(task())) return nullptr;
  return std::make_unique<TaskPoseProgram>(*this, types);
}

double RobotProblem::farthest_goal() const {
  double distance = 0.0;
  for (const Goal& goal : task().goals()) {
    distance = std::max(distance, (goal.position() - spec_.X_WB.translation()).norm() - position_slack(goal.region));
  }
  return distance;
}

std::optional<Infeasibility> RobotProblem::infeasible() const {
  if (!proofs_) return std::nullopt;
  const TaskProofs::Facts& facts = proofs_->facts(spec_);
  return facts.ends ? facts.ends->infeasible() : std::nullopt;
}

Optimism RobotProblem::optimism(std::span<const int> types) const {
  if (!library().complete(types)) return {kProvedImpossible, "the design does not end in an end effector"};
  return optimism_of_prefix(types, static_cast<int>(types.size()));
}

Optimism RobotProblem::optimism_of_length(int n) const { return optimism_of_prefix({}, n); }

Optimism RobotProblem::optimism_of_prefix(std::span<const int> types, int n) const {
  const std::vector<ModuleSpan>& all = spec_.chains->type_spans();
  const int more = n - static_cast<int>(types.size());
  const TaskProofs::Facts* facts = proofs_ ? &proofs_->facts(spec_) : nullptr;
  if (facts != nullptr && facts->ends) {
    std::string why = facts->ends->ruled_out(types, more == 0);
    if (!why.empty()) return {kProvedImpossible, std::move(why)};
  }
  const bool knows_endings = facts != nullptr && facts->completions;
  const Continuation rest = knows_endings ? facts->completions->completion(types, more) : any_of_types(all, more);
  if (!rest.possible) return {kProvedImpossible, incompletable(n, facts->least_joints)};
  std::vector<const ModuleSpan*> modules{&spec_.chains->base_span()};
  for (const int k : types) modules.push_back(&all[static_cast<std::size_t>(k)]);
  double cost = 0.0;
  for (const ModuleSpan* module : modules) cost += module->cost;
  cost += rest.cost;
  return judged(reach_bound(modules, rest, farthest_goal()), n, cost);
}

Optimism RobotProblem::judged(const ReachBound& bound, int n, double least_cost) const {
  if (bound.possible)
    return {spec_.scoring->bound(spec_.placed_base ? std::max(1, n) : n + 1, bound.least_mass, least_cost), ""};
  return {kProvedImpossible,
          fmt::format("a goal is {:.4g} m away from the base, and {} reach at most {:.4g} m", farthest_goal(),
                      n == 1 ? "1 module" : fmt::format("{} modules", n), bound.span)};
}

}  // namespace modsearch
