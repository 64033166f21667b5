#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <modsearch/baselines/certify/sequence_model_internal.hpp>
#include <numbers>

namespace modsearch::certify {
namespace {

constexpr double kRounding =
    1e-12;  // of what was computed in two ways: axes, columns, places; as the checker has it [m]

std::size_t at(int i) { return static_cast<std::size_t>(i); }

bool along_z(const Eigen::Vector3d& v) { return v.x() == 0.0 && v.y() == 0.0; }
bool along_z(const AffineVector& v) {
  return along_z(v.offset) &&
         std::all_of(v.terms.begin(), v.terms.end(), [](const auto& term) { return along_z(term.direction); });
}

Eigen::Vector3d column(const AffineVector& v, int parameter) {
  for (const AffineVector::Term& term : v.terms) {
    if (term.parameter == parameter) return term.direction;
  }
  return Eigen::Vector3d::Zero();
}

// `vector`, affine in the parameters, as one in the lengths; none if the parameters of a length move it differently.
std::optional<AffineVector> in_lengths(const AffineVector& vector, const SequenceModel& model) {
  AffineVector result{vector.offset};
  std::vector<std::optional<Eigen::Vector3d>> columns(model.lower.size());
  for (std::size_t i = 0; i < model.length_of.size(); ++i) {
    std::optional<Eigen::Vector3d>& known = columns[at(model.length_of[i])];
    const Eigen::Vector3d direction = column(vector, static_cast<int>(i));
    if (known && (*known - direction).norm() > 4.0 * kRounding) return std::nullopt;
    if (!known) known = direction;
  }
  for (std::size_t k = 0; k < columns.size(); ++k) {
    if (columns[k] && !columns[k]->isZero(0.0)) result.terms.push_back({static_cast<int>(k), *columns[k]});
  }
  return result;
}

// Cylinders of a frame, one after the other where each begins on the axis and at the end of the one before; affine in
// the parameters.
std::vector<StraightRun> find_runs(const Chain& chain, const Eigen::VectorXd& most) {
  const auto same = [&](const AffineVector& a, const AffineVector& b) {
    double away = (a.offset - b.offset).norm();
    for (int i = 0; i < most.size(); ++i) away += most[i] * (column(a, i) - column(b, i)).norm();
    return away <= kRounding;
  };
  std::vector<StraightRun> runs;
  for (const Body& body : chain.bodies()) {
    for (const BodyGeometry& geometry : body.geometries) {
      if (geometry.shape.kind != AffineShape::Kind::kCylinder) continue;
      const AffinePose& pose = geometry.X_FG.head;
      const AffineScalar& height = geometry.shape.size[1];
      StraightRun run;
      run.frame = body.frame;
      run.axis = pose.rotation.col(2);
      run.radius = geometry.shape.size[0].offset;
      run.usable = geometry.X_FG.affine() && geometry.shape.size[0].terms.empty();
      const auto shifted = [&](double sign) {
        AffineVector half{Eigen::Vector3d{sign * 0.5 * height.offset * run.axis}};
        for (const auto& term : height.terms)
          half.terms.push_back({term.parameter, sign * 0.5 * term.scale * run.axis});
        return pose.translation + half;
      };
      run.start = shifted(-1.0);
      run.end = shifted(1.0);
      const auto continues = [&](StraightRun& before) {
        if (before.frame != run.frame || !before.usable || !run.usable || before.radius != run.radius) return false;
        if ((before.axis - run.axis).norm() <= kRounding && same(before.end, run.start)) {
          before.end = run.end;
          return true;
        }
        if ((before.axis + run.axis).norm() <= kRounding && same(before.end, run.end)) {
          before.end = run.start;
          return true;
        }
        return false;
      };
      if (std::none_of(runs.begin(), runs.end(), continues)) runs.push_back(std::move(run));
    }
  }
  return runs;
}

// Joint j may stand still if joint j + 1 turns about a parallel axis and nothing between the two lies beside it.
bool stands_still(const SequenceModel& model, int j) {
  if (j + 1 >= model.n_joints()) return false;
  const ModelFrame& between = model.frames[at(j + 1)];
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) {
      const double size = std::abs(between.turn(i, k));
      if (size != 0.0 && size != 1.0) return false;
      if ((i == 2) != (k == 2) && size != 0.0) return false;
    }
  }
  return along_z(between.v) && std::all_of(model.runs.begin(), model.runs.end(), [&](const StraightRun& run) {
           return run.frame != j + 1 || !run.usable || (along_z(run.start) && along_z(run.end));
         });
}

int acting_on(const SequenceModel& model, int j, Eigen::Vector3d vector) {
  for (; j > 0; --j) {
    if (!along_z(vector)) return j;
    vector = model.frames[at(j - 1)].turn * vector;
  }
  return 0;
}

void merge_parameters(SequenceModel& model, const Chain& chain) {
  const int n = static_cast<int>(model.parameter_lower.size());
  const Eigen::VectorXd masses = chain.mass().gradient(n);
  std::vector<int> leader;  // of each length
  for (int i = 0; i < n; ++i) {
    const auto alike = [&](int m) {
      const bool same_mass = std::abs(masses[m] - masses[i]) <= kRounding;
      return same_mass && std::all_of(model.frames.begin(), model.frames.end(), [&](const ModelFrame& frame) {
               return (column(frame.v, m) - column(frame.v, i)).cwiseAbs().maxCoeff() <= kRounding;
             });
    };
    const auto k = static_cast<std::size_t>(std::find_if(leader.begin(), leader.end(), alike) - leader.begin());
    if (k == leader.size()) {
      leader.push_back(i);
      model.lower.push_back(0.0);
      model.upper.push_back(0.0);
      model.masses.push_back(masses[i]);
    }
    model.lower[k] += model.parameter_lower[i] - kSlack;
    model.upper[k] += model.parameter_upper[i] + kSlack;
    model.length_of.push_back(static_cast<int>(k));
  }
}

std::optional<std::string> why_not_covered(const ModuleType& module) {
  for (const ParameterRange& range : module.parameters) {
    if (range.unit != "m") return fmt::format("parameter {} of module {} is an angle", range.name, module.id);
  }
  for (const ModuleJoint& joint : module.joints) {
    if (!joint.fixed && !joint.joint.rotates()) return fmt::format("a joint of module {} slides", module.id);
  }
  return std::nullopt;
}

}  // namespace

std::optional<std::string> why_not_covered(const RobotProblem& problem) {
  if (problem.spec().placed_base) return "the place of the base is part of the design";
  if (dynamic_cast<const GoalTask*>(&problem.task()) == nullptr) return "its task may be more than goals to reach";
  if (!problem.task().steps().empty()) return "its task has trajectories, pauses or returns";
  if (problem.task().statics().limited) return "joint torques are limited";
  if (problem.scene().any_moves()) return "an obstacle moves";
  for (const Goal& goal : problem.task().goals()) {
    if (!goal.region.is_ball()) return fmt::format("goal {} is not a ball about a position", goal.id);
  }
  for (int k = -1; k < problem.library().n_types(); ++k) {
    if (auto why = why_not_covered(k < 0 ? problem.library().base() : problem.library().type(k))) return why;
  }
  if (problem.task().goals().size() > 4) return "there are more than four goals";
  return std::nullopt;
}

Scenery scenery_of(const RobotProblem& problem) {
  Scenery scenery;
  for (const Goal& goal : problem.task().goals()) {
    scenery.targets.push_back({goal.position(), goal.region.tolerances()[0].upper});
  }
  if (problem.spec().level == Level::kNone) return scenery;
  for (const Obstacle& obstacle : problem.scene().obstacles()) {
    scenery.obstacles.insert(scenery.obstacles.end(), obstacle.shapes.begin(), obstacle.shapes.end());
  }
  return scenery;
}

SequenceModel::SequenceModel(const RobotProblem& problem, std::span<const int> of_types)
    : types{of_types.begin(), of_types.end()} {
  const std::shared_ptr<const Chain> kept = problem.chain(of_types);
  const Chain& chain = *kept;
  const ParameterBox box = parameter_box(problem.library(), of_types);
  parameter_lower = box.lower;
  parameter_upper = box.upper;
  for (int j = 0; j <= chain.n_joints(); ++j)
    frames.push_back({chain.segment(j).head.translation, chain.segment(j).head.rotation, 0});
  for (const Joint& joint : chain.joints()) {
    const bool endless = joint.type == JointType::kContinuous;
    joint_lower.push_back(endless ? -std::numbers::pi : joint.lower);
    joint_upper.push_back(endless ? std::numbers::pi : joint.upper);
  }
  merge_parameters(*this, chain);
  mass = chain.mass().offset;
  runs = find_runs(chain, parameter_lower.cwiseAbs().cwiseMax(parameter_upper.cwiseAbs()));
  for (StraightRun& run : runs) {
    const std::optional<AffineVector> start_in_lengths = in_lengths(run.start, *this);
    const std::optional<AffineVector> end_in_lengths = in_lengths(run.end, *this);
    run.usable = run.usable && start_in_lengths && end_in_lengths;
    if (!run.usable) continue;
    run.start = *start_in_lengths;
    run.end = *end_in_lengths;
  }
  for (int j = 0; j < static_cast<int>(frames.size()); ++j) {
    frames[at(j)].v = *in_lengths(frames[at(j)].v, *this);
    frames[at(j)].acting = acting(j, frames[at(j)].v);
  }
  for (StraightRun& run : runs) {
    if (!run.usable) continue;
    run.acting = std::max({acting(run.frame, run.start), acting(run.frame, run.end),
                           acting(run.frame, AffineVector{Eigen::Vector3d{run.radius * run.axis}})});
  }
  for (int j = 0; j < n_joints(); ++j) idle.push_back(stands_still(*this, j));
}

int SequenceModel::acting(int frame, const AffineVector& vector) const {
  int most = acting_on(*this, frame, vector.offset);
  for (const AffineVector::Term& term : vector.terms) most = std::max(most, acting_on(*this, frame, term.direction));
  return most;
}

Eigen::VectorXd SequenceModel::parameters(const std::vector<double>& lengths) const {
  std::vector<double> shortest(lower.size()), range(lower.size());
  for (std::size_t i = 0; i < length_of.size(); ++i) {
    const auto p = static_cast<Eigen::Index>(i);
    shortest[at(length_of[i])] += parameter_lower[p];
    range[at(length_of[i])] += parameter_upper[p] - parameter_lower[p];
  }
  Eigen::VectorXd x = parameter_lower;
  for (std::size_t i = 0; i < length_of.size(); ++i) {
    const std::size_t k = at(length_of[i]);
    const auto p = static_cast<Eigen::Index>(i);
    const double share = range[k] > 0.0 ? std::clamp((lengths[k] - shortest[k]) / range[k], 0.0, 1.0) : 0.0;
    x[p] += share * (parameter_upper[p] - parameter_lower[p]);
  }
  return x.cwiseMin(parameter_upper);
}

Box root_box(const SequenceModel& model, int n_goals) {
  Box box{model.lower, model.upper};
  for (int g = 0; g < n_goals; ++g) {
    for (std::size_t j = 0; j < model.joint_lower.size(); ++j) {
      const bool takes_over = j > 0 && model.idle[j - 1];
      box.lower.push_back(model.idle[j] ? 0.0 : takes_over ? -std::numbers::pi : model.joint_lower[j] - kSlack);
      box.upper.push_back(model.idle[j] ? 0.0 : takes_over ? std::numbers::pi : model.joint_upper[j] + kSlack);
    }
  }
  return box;
}

double least_mass(const SequenceModel& model, const Box& box) {
  double sum = model.mass;
  for (std::size_t k = 0; k < model.masses.size(); ++k) {
    sum += std::min(model.masses[k] * box.lower[k], model.masses[k] * box.upper[k]);
  }
  return sum;
}

double greatest_mass(const SequenceModel& model, const Box& box) {
  double sum = model.mass;
  for (std::size_t k = 0; k < model.masses.size(); ++k) {
    sum += std::max(model.masses[k] * box.lower[k], model.masses[k] * box.upper[k]);
  }
  return sum;
}

}  // namespace modsearch::certify
