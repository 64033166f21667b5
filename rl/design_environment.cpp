#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <modsearch/problem/robot_problem.hpp>
#include <modsearch/rl/design_environment.hpp>
#include <numbers>
#include <stdexcept>

namespace modsearch {
namespace {

HybridSpace space_of(const ModuleLibrary& library) {
  std::vector<int> counts;
  for (int k = 0; k < library.n_types(); ++k) counts.push_back(library.type(k).n_parameters());
  return HybridSpace{std::move(counts)};
}

ProblemSource checked(ProblemSource source) {
  if (!source) throw std::invalid_argument("DesignEnvironment: no source of problems");
  return source;
}

DesignEnvironmentOptions with_region(DesignEnvironmentOptions options, const ProblemFile& file) {
  if (!options.hindsight_region) options.hindsight_region = file.sampling;
  return options;
}

// The same problem with its only goal elsewhere.
RobotProblem with_goal_at(const RobotProblem& problem, const Eigen::Vector3d& p_W) {
  RobotProblemSpec spec = problem.spec();
  Goal goal = spec.task->goals().front();
  Eigen::Isometry3d X_WN = goal.region.nominal();
  X_WN.translation() = p_W;
  goal.region = PoseRegion{X_WN, goal.region.tolerances()};
  GoalTaskSpec task = dynamic_cast<const GoalTask&>(*spec.task).spec();
  task.goals = {std::move(goal)};
  spec.task = std::make_shared<const GoalTask>(std::move(task));
  return RobotProblem{std::move(spec)};
}

Eigen::VectorXd random_posture(const Chain& chain, Rng& rng) {
  Eigen::VectorXd q(chain.n_joints());
  for (int j = 0; j < chain.n_joints(); ++j) {
    const Joint& joint = chain.joints()[static_cast<std::size_t>(j)];
    const bool limited = std::isfinite(joint.lower) && std::isfinite(joint.upper);
    q[j] = limited ? rng.uniform(joint.lower, joint.upper) : rng.uniform(-std::numbers::pi, std::numbers::pi);
  }
  return chain.clamped(q);
}

}  // namespace

DesignEnvironment::DesignEnvironment(ProblemSource source, DesignEnvironmentOptions options)
    : source_{checked(std::move(source))},
      options_{std::move(options)},
      problem_{drawn(0)},
      family_{std::dynamic_pointer_cast<const RobotProblem>(problem_)},
      space_{space_of(problem_->library())},
      encoder_{options_.encoder = with_whitening(options_.encoder), *problem_},
      targets_{targets(*problem_)},
      instance_{encoder_.instance(*problem_)} {
  if (mask_after(*problem_, design_) == 0) {
    throw std::invalid_argument(fmt::format("problem '{}': no module may be placed (at most {} with the base)",
                                            problem_->name(), problem_->max_modules()));
  }
}

DesignEnvironment::DesignEnvironment(const ProblemFile& file, DesignEnvironmentOptions options)
    : DesignEnvironment{problem_source(file), with_region(std::move(options), file)} {}

void DesignEnvironment::set_source(ProblemSource source) { source_ = checked(std::move(source)); }

void DesignEnvironment::set_evaluate(Evaluate evaluate) { evaluate_ = std::move(evaluate); }

std::unique_ptr<Environment> DesignEnvironment::clone() const {
  auto copy = std::make_unique<DesignEnvironment>(source_, options_);
  copy->set_evaluate(evaluate_);
  return copy;
}

std::shared_ptr<const DesignProblem> DesignEnvironment::drawn(std::uint64_t seed) const {
  std::shared_ptr<const DesignProblem> problem = source_(Rng{seed});
  if (!problem) throw std::invalid_argument("DesignEnvironment: the source gave no problem");
  if (!options_.level) return problem;
  const auto* robot = dynamic_cast<const RobotProblem*>(problem.get());
  if (robot == nullptr) {
    throw std::invalid_argument(fmt::format("problem '{}': has no collision level to replace by '{}'", problem->name(),
                                            modsearch::name(*options_.level)));
  }
  if (robot->spec().level == *options_.level) return problem;
  return std::make_shared<const RobotProblem>(robot->with_level(*options_.level));
}

EncoderOptions DesignEnvironment::with_whitening(EncoderOptions encoder) const {
  if (options_.whiten <= 0 || !encoder.whitening.empty()) return encoder;
  const ObservationEncoder plain{encoder, *problem_};
  const Rng rng = Rng{0}.fork("whitening");
  Eigen::MatrixXd samples;
  for (int i = 0; i < options_.whiten; ++i) {
    const Eigen::VectorXd sample =
        plain.instance(*drawn(rng.fork(static_cast<std::uint64_t>(i)).bits())).cast<double>();
    if (i == 0) samples.resize(options_.whiten, sample.size());
    samples.row(i) = sample.transpose();
  }
  encoder.whitening = numbers_of(whitening_of(samples));
  return encoder;
}

Placement DesignEnvironment::placement(int k, std::span<const float> x_k) const {
  const std::vector<ParameterRange>& ranges = problem_->library().type(k).parameters;
  Placement result{k, Parameters(static_cast<Eigen::Index>(ranges.size()))};
  for (std::size_t p = 0; p < ranges.size(); ++p) {
    result.parameters[static_cast<Eigen::Index>(p)] = from_unit(ranges[p], std::clamp(x_k[p], -1.0F, 1.0F));
  }
  return result;
}

std::optional<Evaluation> DesignEnvironment::evaluated(const DesignProblem& problem, const Design& design) const {
  std::optional<Evaluation> result =
      evaluate_ ? evaluate_(problem, design, options_.fidelity) : problem.evaluate(design, options_.fidelity);
  if (result) work_ += result->attempt.work;
  return result;
}

ActionMask DesignEnvironment::mask_after(const DesignProblem& problem, const Design& design) const {
  ActionMask mask = 0;
  for (const int k : problem.successors(design.types())) mask |= ActionMask{1} << k;
  return mask;
}

bool DesignEnvironment::ends(const Evaluation& evaluation) const {
  const Attempt& attempt = evaluation.attempt;
  if (options_.end_on == EndOn::kAchieved) return attempt.achieved;
  return attempt.reached && attempt.why != Failure::kIncomplete;
}

Environment::View DesignEnvironment::do_reset(Rng rng) {
  // All that may throw comes first: a failed reset leaves no half of a new episode behind.
  std::shared_ptr<const DesignProblem> problem = drawn(rng.bits());
  Eigen::VectorXf instance = encoder_.instance(*problem);
  View first{encoder_.encode(problem->library(), {}, instance), mask_after(*problem, {})};
  if (first.mask == 0)
    throw std::invalid_argument(fmt::format("problem '{}': no module may be placed", problem->name()));

  if (problem != problem_) targets_ = targets(*problem);
  problem_ = std::move(problem);
  instance_ = std::move(instance);
  design_.modules.clear();
  evaluation_.reset();
  score_.reset();
  return first;
}

std::optional<double> DesignEnvironment::paid_before() const {
  if (options_.reward == RewardKind::kScore) return 0.0;
  if (!score_) {
    if (const std::optional<Evaluation> now = evaluated(*problem_, design_)) score_ = now->score;
  }
  return score_;
}

Step DesignEnvironment::do_step(int k, std::span<const float> x_k, View& next) {
  const std::optional<double> before = paid_before();
  std::optional<Evaluation> evaluation;
  design_.modules.push_back(placement(k, x_k));
  try {
    if (before) evaluation = evaluated(*problem_, design_);
    next = {encoder_.encode(problem_->library(), design_, instance_), mask_after(*problem_, design_)};
  } catch (...) {
    design_.modules.pop_back();  // nothing has happened
    throw;
  }
  evaluation_ = std::move(evaluation);

  Step step;
  if (!evaluation_ || !std::isfinite(evaluation_->score)) {
    step.truncated = step.unpaid = true;
    return step;
  }
  score_ = evaluation_->score;
  step.reward = *score_ - *before;
  step.terminated = step.success = ends(*evaluation_);
  step.truncated = !step.terminated && next.mask == 0;
  return step;
}

std::optional<std::vector<DesignModel::Target>> DesignEnvironment::targets(const DesignProblem& problem) const {
  const auto* robot = dynamic_cast<const RobotProblem*>(&problem);
  if (robot == nullptr || family_ == nullptr || robot->spec().library != family_->spec().library ||
      robot->spec().X_WB.matrix() != family_->spec().X_WB.matrix()) {
    return std::nullopt;
  }
  return DesignModel::targets_of(*robot);
}

std::shared_ptr<const ActionModel> DesignEnvironment::model() const {
  if (!targets_) return nullptr;
  return std::make_shared<const DesignModel>(family_, *targets_, design_, options_.model_joints);
}

std::shared_ptr<const ActionModel> DesignEnvironment::restore_model(std::span<const double> key) const {
  if (!family_) return Environment::restore_model(key);
  return DesignModel::restore(family_, key, options_.model_joints);
}

std::optional<double> DesignEnvironment::preview(int k, std::span<const float> x_k) const {
  const std::optional<double> before = paid_before();
  if (!before) return std::nullopt;
  Design design = design_;
  design.modules.push_back(placement(k, x_k));
  const std::optional<Evaluation> evaluation = evaluated(*problem_, design);
  return evaluation ? std::optional{evaluation->score - *before} : std::nullopt;
}

std::optional<Eigen::Vector3d> DesignEnvironment::hindsight_target(const RobotProblem& problem, Rng& rng) const {
  const std::shared_ptr<const Chain> chain = problem.chain(design_.types());
  const Eigen::Vector3d p_W = chain->at(design_.parameters()).forward(random_posture(*chain, rng)).tip.translation();
  if (const std::optional<Sampling>& region = options_.hindsight_region) {
    const bool inside = (p_W.array() >= region->lower.array()).all() && (p_W.array() <= region->upper.array()).all();
    if (!inside || problem.scene().clearance(p_W) < region->min_clearance) return std::nullopt;
  }
  return p_W;
}

std::optional<Transition> DesignEnvironment::relabelled(const RobotProblem& problem, const Eigen::Vector3d& p_W) const {
  const RobotProblem other = with_goal_at(problem, p_W);
  const Design before = design_.prefix(static_cast<int>(design_.modules.size()) - 1);
  const Placement& placed = design_.modules.back();
  const auto evaluate = [&](const Design& design) {
    Evaluation evaluation = other.evaluate(design, options_.fidelity);
    work_ += evaluation.attempt.work;
    return evaluation;
  };
  double paid = 0.0;
  if (options_.reward == RewardKind::kDifference || !before.modules.empty()) {
    const Evaluation evaluation = evaluate(before);
    if (!before.modules.empty() && ends(evaluation)) return std::nullopt;  // the episode would have ended there
    if (options_.reward == RewardKind::kDifference) paid = evaluation.score;
  }
  const Evaluation evaluation = evaluate(design_);
  if (!std::isfinite(evaluation.score - paid)) return std::nullopt;

  Transition transition;
  const Eigen::VectorXf instance = encoder_.instance(other);
  transition.s = encoder_.encode(other.library(), before, instance);
  transition.s_next = encoder_.encode(other.library(), design_, instance);
  transition.action = {placed.type, Eigen::VectorXf::Zero(space_.n_parameters()), {}};
  for (int p = 0; p < space_.count(placed.type); ++p) {
    const ParameterRange& range = other.library().type(placed.type).parameters[static_cast<std::size_t>(p)];
    transition.action.x[space_.offset(placed.type) + p] = static_cast<float>(to_unit(range, placed.parameters[p]));
  }
  transition.reward = static_cast<float>(evaluation.score - paid);
  transition.next_mask = mask_after(other, design_);
  transition.terminated = ends(evaluation);
  transition.truncated = !transition.terminated && transition.next_mask == 0;
  transition.model = std::make_shared<const DesignModel>(
      family_, std::vector{DesignModel::Target{p_W, targets_->front().tolerance}}, before, options_.model_joints);
  return transition;
}

std::vector<Transition> DesignEnvironment::hindsight(int n, Rng& rng) const {
  constexpr int kMostPostures = 16;
  if (n <= 0 || !evaluation_ || !targets_ || targets_->size() != 1) return {};
  const auto& problem = dynamic_cast<const RobotProblem&>(*problem_);
  if (dynamic_cast<const GoalTask*>(&problem.task()) == nullptr)
    return {};  // more than its goals may depend on the goal
  std::vector<Transition> result;
  for (int i = 0; i < n; ++i) {
    std::optional<Transition> transition;
    for (int posture = 0; posture < kMostPostures && !transition; ++posture) {
      if (const std::optional<Eigen::Vector3d> target = hindsight_target(problem, rng)) {
        transition = relabelled(problem, *target);
      }
    }
    if (transition) result.push_back(*std::move(transition));
  }
  return result;
}

}  // namespace modsearch
