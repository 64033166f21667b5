#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <modsearch/problem/nearest_miss.hpp>
#include <modsearch/study/solution_page.hpp>

namespace modsearch {
namespace {

PagePose page_pose(const Eigen::Isometry3d& X) {
  PagePose pose{};
  Eigen::Map<Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>{pose.data()} = X.matrix();
  return pose;
}

PagePoint page_point(const Eigen::Vector3d& p) { return {p.x(), p.y(), p.z()}; }

PageShape page_shape(const Shape& shape, const Eigen::Isometry3d& X_BG) {
  PageShape result;
  result.X_BG = page_pose(X_BG);
  struct Visitor {
    PageShape& result;
    void operator()(const Sphere& s) const {
      result.kind = PageShapeKind::kSphere;
      result.size = {s.radius};
    }
    void operator()(const Box& b) const {
      result.kind = PageShapeKind::kBox;
      result.size = {b.size.x(), b.size.y(), b.size.z()};
    }
    void operator()(const Cylinder& c) const {
      result.kind = PageShapeKind::kCylinder;
      result.size = {c.radius, c.length};
    }
    void operator()(const Capsule& c) const {
      result.kind = PageShapeKind::kCapsule;
      result.size = {c.radius, c.length};
    }
    void operator()(const Mesh& m) const {
      result.kind = PageShapeKind::kMesh;
      for (const Eigen::Vector3d& vertex : m.triangles->vertices) result.vertices.push_back(page_point(vertex));
      for (const Eigen::Vector3i& t : m.triangles->triangles) result.triangles.push_back({t.x(), t.y(), t.z()});
    }
  };
  std::visit(Visitor{result}, shape);
  return result;
}

// The path as joint configurations, evenly spaced in time where it has times, with the sample at which each waypoint is
// passed.
struct Samples {
  std::vector<Eigen::VectorXd> q;
  std::vector<double> t;  // [s]; empty where the path has no times
  std::vector<int> waypoint_sample;
};

Samples sampled(const Path& path) {
  Samples samples;
  const Eigen::MatrixXd& rows = path.waypoints;
  const bool timed = !path.times.empty();
  const auto length = [&](Eigen::Index i) {
    const auto k = static_cast<std::size_t>(i);
    return timed ? path.times[k] - path.times[k - 1] : (rows.row(i) - rows.row(i - 1)).norm();
  };
  double total = 0.0;
  for (Eigen::Index i = 1; i < rows.rows(); ++i) total += length(i);
  constexpr double kSamples = 160.0;  // smooth at 40 pictures a second for four seconds
  const double step = std::max(total / kSamples, 1e-6);
  samples.q.emplace_back(rows.row(0).transpose());
  if (timed) samples.t.push_back(path.times.front());
  samples.waypoint_sample.push_back(0);
  for (Eigen::Index i = 1; i < rows.rows(); ++i) {
    const Eigen::VectorXd from = rows.row(i - 1).transpose();
    const Eigen::VectorXd to = rows.row(i).transpose();
    const int pieces = std::max(1, static_cast<int>(std::ceil(length(i) / step)));
    for (int k = 1; k <= pieces; ++k) {
      samples.q.emplace_back(from + (to - from) * k / pieces);
      if (timed) samples.t.push_back(path.times[static_cast<std::size_t>(i)] - length(i) * (pieces - k) / pieces);
    }
    samples.waypoint_sample.push_back(static_cast<int>(samples.q.size()) - 1);
  }
  return samples;
}

// Samples at which each goal is passed for the first time, in order.
std::vector<PageMilestone> milestones(const RobotProblem& problem, const Arm& arm, const Path& path,
                                      const Samples& samples) {
  std::vector<PageMilestone> result{{"home", 0}};
  Eigen::Index row = 0;
  for (const Goal& goal : problem.task().goals()) {
    if (goal.type == GoalType::kFollow) continue;  // too many to name
    if (problem.task().any_order()) row = 0;
    for (; row < path.waypoints.rows(); ++row) {
      const Posture posture = arm.forward(path.waypoints.row(row).transpose());
      // A region without tolerances has no violations at all: it contains every pose.
      if (!(goal.region.violations(posture.tip).array().abs() <= 1e-6).all()) continue;
      result.push_back({"goal " + goal.id, samples.waypoint_sample[static_cast<std::size_t>(row)]});
      break;
    }
  }
  return result;
}

void add_robot(Page& page, const Chain& chain, const Arm& arm, const std::vector<Eigen::VectorXd>& q) {
  std::vector<Posture> postures;
  for (const Eigen::VectorXd& sample : q) postures.push_back(arm.forward(sample));
  for (std::size_t b = 0; b < chain.bodies().size(); ++b) {
    const Body& body = chain.bodies()[b];
    PageBody shown{.name = body.name, .module = body.module + 1};
    for (const ArmGeometry& geometry : arm.geometries()) {
      if (geometry.body == static_cast<int>(b)) shown.shapes.push_back(page_shape(geometry.shape, geometry.X_FG));
    }
    for (const Posture& posture : postures) {
      shown.keyframes.push_back(page_pose(posture.frames[static_cast<std::size_t>(body.frame)]));
    }
    page.bodies.push_back(std::move(shown));
  }
  for (int j = 0; j < chain.n_joints(); ++j) {
    const Joint& joint = chain.joints()[static_cast<std::size_t>(j)];
    PageBody carrier{.name = joint.name};
    carrier.joints.push_back(
        {.name = joint.name, .kind = joint.rotates() ? PageJointKind::kRevolute : PageJointKind::kPrismatic});
    for (const Posture& posture : postures) {
      carrier.keyframes.push_back(page_pose(posture.frames[static_cast<std::size_t>(j) + 1]));
    }
    page.bodies.push_back(std::move(carrier));
  }
  if (postures.size() > 1) {
    for (const Posture& posture : postures) page.tip.push_back(page_point(posture.tip.translation()));
  }
}

// `times` [s] of the samples: where the obstacles that move are then; without times where they begin.
void add_scene(Page& page, const RobotProblem& problem, const std::optional<Sampling>& sampling,
               const std::vector<double>& times) {
  for (const Obstacle& obstacle : problem.scene().obstacles()) {
    PageBody shown{.name = obstacle.name};
    for (const PlacedShape& placed : obstacle.shapes) shown.shapes.push_back(page_shape(placed.shape, placed.X_FG));
    if (!obstacle.moves()) shown.keyframes.push_back(kPageIdentity);
    if (obstacle.moves() && times.empty()) shown.keyframes.push_back(page_pose(obstacle.motion.X_WO.front()));
    for (const double t : times) {
      if (obstacle.moves()) shown.keyframes.push_back(page_pose(obstacle.motion.at(t)));
    }
    page.obstacles.push_back(std::move(shown));
  }
  for (const Goal& goal : problem.task().goals()) {
    PageTarget target{.name = "goal " + goal.id, .position = page_point(goal.position())};
    const double slack = position_slack(goal.region);
    target.tolerance = std::isfinite(slack) ? slack : 0.0;
    if (goal.region.constrains_orientation()) target.frame = page_pose(goal.region.nominal());
    page.targets.push_back(std::move(target));
  }
  if (sampling) page.region = PageRegion{page_point(sampling->lower), page_point(sampling->upper)};
}

// The posture to show of a design that has no motion: where it first misses something, else at the first goal.
Eigen::VectorXd telling_posture(const RobotProblem& problem, const Arm& arm, const Attempt& attempt,
                                const NearestMiss& missed) {
  const bool has_postures = attempt.postures.rows() > 0 && attempt.postures.cols() == arm.n_joints();
  const bool at_home = !missed.misses.empty() && missed.misses.front().why == Failure::kHomeInCollision;
  if (!has_postures || at_home) return home_posture(problem.task(), arm, problem.scene());
  const auto first = std::find_if(missed.misses.begin(), missed.misses.end(), [&](const Miss& miss) {
    return miss.goal >= 0 && miss.goal < attempt.postures.rows();
  });
  return attempt.postures.row(first == missed.misses.end() ? 0 : first->goal).transpose();
}

// What is missed, beside its goal; and what overlaps in the posture of the first miss, which is the one shown.
void add_misses(Page& page, const NearestMiss& missed) {
  for (const Miss& miss : missed.misses) {
    if (miss.goal < 0) continue;
    const std::string place = miss.place + ": ";
    page.targets[static_cast<std::size_t>(miss.goal)].miss =
        miss.words.starts_with(place) ? miss.words.substr(place.size()) : miss.words;
  }
  const auto placed = std::find_if(missed.misses.begin(), missed.misses.end(),
                                   [](const Miss& miss) { return miss.goal >= 0 || miss.touch; });
  if (placed == missed.misses.end() || !placed->touch) return;
  const Touch& touch = *placed->touch;
  page.touches.push_back({.body = touch.body,
                          .obstacle = touch.obstacle,
                          .other = touch.other,
                          .position = page_point(0.5 * (touch.p_WA + touch.p_WB)),
                          .depth = touch.depth});
}

void add_modules(Page& page, const ModuleLibrary& library, const Design& design) {
  page.modules.push_back({library.base().id, {}});
  for (const Placement& placement : design.modules) {
    const ModuleType& type = library.type(placement.type);
    PageModule shown{type.id, {}};
    for (int i = 0; i < type.n_parameters(); ++i) {
      const ParameterRange& range = type.parameters[static_cast<std::size_t>(i)];
      shown.parameters.push_back({range.name, placement.parameters[i], range.unit});
    }
    page.modules.push_back(std::move(shown));
  }
}

}  // namespace

Page page_of_solution(const RobotProblem& problem, const SolutionRecord& record, const PageContext& context) {
  const Attempt& attempt = record.evaluation.attempt;
  const std::vector<int> types = record.design.types();
  const std::shared_ptr<const Chain> kept = problem.chain(types);
  const Chain& chain = *kept;
  const Arm arm = chain.at(record.design.parameters());

  Page page;
  page.title = fmt::format("{} by {}", record.problem, record.solver);
  page.problem = record.instance
                     ? fmt::format("{}, instance {}:{}", record.problem, record.instance->seed, record.instance->index)
                     : record.problem;
  std::vector<std::string> options;
  for (const auto& [key, value] : record.solver_options) options.push_back(key + "=" + value);
  page.solver = options.empty() ? record.solver : fmt::format("{}:{}", record.solver, fmt::join(options, ","));
  page.seed = std::to_string(record.seed);
  page.command = context.command;
  page.score = record.evaluation.score;
  page.achieved = attempt.achieved;
  page.verified = record.verified;
  page.reason = context.reason;
  for (const Term& term : record.evaluation.terms.items()) {
    page.terms.push_back({std::string{name(term.id)}, term.value});
  }
  page.mass = arm.mass();
  page.evaluations = record.evaluations;
  page.seconds = record.seconds;
  if (std::isfinite(attempt.clearance)) page.clearance = attempt.clearance;
  page.goal_error = attempt.goal_error;
  add_modules(page, problem.library(), record.design);
  page.base = page_pose(problem.base_pose(record.design));
  const bool moves = context.path && context.path->waypoints.rows() > 1;
  const Samples samples = moves ? sampled(*context.path) : Samples{};
  add_scene(page, problem, context.sampling, samples.t);

  if (moves) {
    add_robot(page, chain, arm, samples.q);
    page.milestones = milestones(problem, arm, *context.path, samples);
  } else {
    const NearestMiss missed = nearest_miss(problem, record.design, record.evaluation);
    add_robot(page, chain, arm, {telling_posture(problem, arm, attempt, missed)});
    add_misses(page, missed);
  }
  for (const TracePoint& point : context.trace) {
    page.trace.push_back({point.evaluations, point.seconds, point.score, point.achieved});
  }
  return page;
}

}  // namespace modsearch
