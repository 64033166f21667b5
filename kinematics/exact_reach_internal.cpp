#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <modsearch/kinematics/exact_reach_internal.hpp>
#include <modsearch/kinematics/reach_closed_forms_internal.hpp>
#include <modsearch/kinematics/reach_minima_internal.hpp>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <tuple>

namespace modsearch::internal {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;
// Families narrower than this are single postures [rad] or [m].
constexpr double kNarrow = 1e-5;

// The turn nearest to zero of a full circle; infinite slides are cut where no shortest motion goes beyond.
void make_finite(ReachLink& link, double span) {
  if (link.full_circle) {
    if (link.lower <= -0.5 * kTurn && link.upper >= 0.5 * kTurn) {
      link.lower = -0.5 * kTurn;
    } else if (!std::isfinite(link.lower)) {
      link.lower = link.upper - kTurn;
    }
    link.upper = link.lower + kTurn;
  } else {
    if (!std::isfinite(link.lower)) link.lower = std::min(-span, link.upper - span);
    if (!std::isfinite(link.upper)) link.upper = std::max(span, link.lower + span);
  }
}

// Whether every posture of a one-joint chain is within `tie` of the least distance: target or tip on the axis.
bool all_equal_1(const ReachProblem& problem, double tie) {
  const ReachLink& link = problem.links[0];
  if (!link.rotates || link.upper - link.lower <= kNarrow) return false;
  const double rho = std::hypot(link.p.x(), link.p.y());
  const double rho_t = std::hypot(problem.target.x(), problem.target.y());
  const double dz = link.p.z() - problem.target.z();
  return std::hypot(rho + rho_t, dz) - std::hypot(rho - rho_t, dz) <= tie;
}

struct Transform {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  Eigen::Vector3d p = Eigen::Vector3d::Zero();
};

// Lets the fixed transform X come right before joint `k` (the tip, for k = n).
void insert_before(ReachProblem& problem, int k, const Transform& X) {
  if (k == 0) {
    problem.target = X.R.transpose() * (problem.target - X.p);
  } else {
    ReachLink& link = problem.links[static_cast<std::size_t>(k) - 1];
    link.p += link.R * X.p;
    link.R = (link.R * X.R).eval();
  }
}

void remove_joint(ReachProblem& problem, int k) {
  for (int j = k; j + 1 < problem.n; ++j) {
    problem.links[static_cast<std::size_t>(j)] = problem.links[static_cast<std::size_t>(j) + 1];
  }
  --problem.n;
}

// Two neighbouring revolute joints `first`, `first` + 1 about one line: only sign * q_first + q_(first + 1) matters.
struct Coaxial {
  int first = 0;
  double sign = 1.0;
  ReachLink inner, outer;
};

std::optional<Coaxial> find_coaxial(const ReachProblem& problem) {
  constexpr double kRounding = 1e-13;
  for (int j = 0; j + 1 < problem.n; ++j) {
    const ReachLink& inner = problem.links[static_cast<std::size_t>(j)];
    const ReachLink& outer = problem.links[static_cast<std::size_t>(j) + 1];
    if (!inner.rotates || !outer.rotates) continue;
    const double tilt = std::max(std::abs(inner.R(0, 2)), std::abs(inner.R(1, 2)));
    const double offset = std::max(std::abs(inner.p.x()), std::abs(inner.p.y()));
    if (tilt > kRounding || offset > kRounding) continue;
    return Coaxial{j, inner.R(2, 2) > 0.0 ? 1.0 : -1.0, inner, outer};
  }
  return std::nullopt;
}

// [least, greatest] of sign * q_first + q_(first + 1), turns not taken off.
std::pair<double, double> sum_range(const Coaxial& pair) {
  const double a = pair.sign > 0.0 ? pair.inner.lower : -pair.inner.upper;
  const double b = pair.sign > 0.0 ? pair.inner.upper : -pair.inner.lower;
  return {a + pair.outer.lower, b + pair.outer.upper};
}

// Rz(a) F Rz(b) = F Rz(sign a + b), where F leads along (or against) the common axis.
ReachProblem merged(const ReachProblem& problem, const Coaxial& pair) {
  ReachProblem result = problem;
  remove_joint(result, pair.first);
  insert_before(result, pair.first, {pair.inner.R, pair.inner.p});
  ReachLink& link = result.links[static_cast<std::size_t>(pair.first)];
  std::tie(link.lower, link.upper) = sum_range(pair);
  link.full_circle = link.upper - link.lower >= kTurn * (1.0 - 1e-12);
  if (link.full_circle) {
    link.lower = -0.5 * kTurn;
    link.upper = 0.5 * kTurn;
  }
  return result;
}

// Values of the inner joint of a coaxial pair for which the outer one can make up the sum.
struct Interval {
  double lower = 0.0;
  double upper = 0.0;
  double sum = 0.0;
};

std::vector<Interval> splits(const Coaxial& pair, double sum) {
  const auto [least, greatest] = sum_range(pair);
  std::vector<Interval> result;
  const double slack = 1e-11;  // the sum may stand at its limit, or in the gap of an almost full circle
  for (double turn = std::ceil((least - slack - sum) / kTurn); sum + turn * kTurn <= greatest + slack; turn += 1.0) {
    const double s = sum + turn * kTurn;
    double lower = pair.sign * (s - pair.outer.upper);
    double upper = pair.sign * (s - pair.outer.lower);
    if (lower > upper) std::swap(lower, upper);
    lower = std::max(lower, pair.inner.lower);
    upper = std::min(upper, pair.inner.upper);
    if (upper < lower && lower - upper <= 2.0 * slack) {
      lower = upper = std::clamp(lower, pair.inner.lower, pair.inner.upper);
    }
    if (lower <= upper) result.push_back({lower, upper, s});
  }
  return result;
}

// Puts the inner joint back at `value`.
Nearest split(const Coaxial& pair, const Nearest& item, double value, double sum) {
  Nearest result{with_joint_inserted(item.q, pair.first, value), item.distance};
  result.q[pair.first + 1] = std::clamp(sum - pair.sign * value, pair.outer.lower, pair.outer.upper);
  return result;
}

// The split with the outer joint nearest to zero.
Nearest plain_split(const Coaxial& pair, const Nearest& item) {
  Nearest best = item;
  double least = std::numeric_limits<double>::infinity();
  for (const Interval& interval : splits(pair, item.q[pair.first])) {
    const Nearest candidate =
        split(pair, item, std::clamp(pair.sign * interval.sum, interval.lower, interval.upper), interval.sum);
    if (std::abs(candidate.q[pair.first + 1]) < least) {
      least = std::abs(candidate.q[pair.first + 1]);
      best = candidate;
    }
  }
  return best;
}

// Two-parameter families are sampled at about this many points per parameter.
int per_parameter(int family_points) { return std::max(1, static_cast<int>(std::lround(std::sqrt(family_points)))); }

// All ways to share the turns of `items` between the two joints; or one way each, if no other is asked for.
std::vector<Nearest> all_splits(const Coaxial& pair, const std::vector<Nearest>& items, const FamilyOptions& options) {
  const int family_points = options.points;
  const int few = per_parameter(family_points);
  const int points = static_cast<int>(items.size()) < few ? family_points : few;
  std::vector<Nearest> result;
  for (const Nearest& item : items) {
    result.push_back(plain_split(pair, item));
    if (!options.shared_turns) continue;
    const std::vector<Interval> intervals = splits(pair, item.q[pair.first]);
    double length = 0.0;
    for (const Interval& interval : intervals) length += interval.upper - interval.lower;
    if (length <= kNarrow) continue;
    for (int i = 0; i < points; ++i) {
      double along = (i + 0.5) / points * length;
      std::size_t k = 0;
      while (k + 1 < intervals.size() && along > intervals[k].upper - intervals[k].lower) {
        along -= intervals[k].upper - intervals[k].lower;
        ++k;
      }
      result.push_back(split(pair, item, std::min(intervals[k].lower + along, intervals[k].upper), intervals[k].sum));
    }
  }
  return result;
}

}  // namespace

ReachProblem reach_problem(const Arm& arm, const Eigen::Vector3d& target) {
  const int n = arm.n_joints();
  if (n > kMaxReachJoints) throw std::invalid_argument(fmt::format("reach_problem: {} joints, at most 3", n));
  ReachProblem problem;
  problem.n = n;
  problem.target = arm.segment(0).linear().transpose() * (target - arm.segment(0).translation());
  double span = 1.0 + problem.target.norm();
  for (int j = 0; j < n; ++j) {
    const Joint& joint = arm.chain().joints()[static_cast<std::size_t>(j)];
    ReachLink& link = problem.links[static_cast<std::size_t>(j)];
    link.rotates = joint.rotates();
    link.full_circle = joint.full_circle();
    link.lower = joint.lower;
    link.upper = joint.upper;
    link.R = arm.segment(j + 1).linear();
    link.p = arm.segment(j + 1).translation();
    span += link.p.norm();
    if (!link.rotates && std::isfinite(link.lower)) span += std::abs(link.lower);
    if (!link.rotates && std::isfinite(link.upper)) span += std::abs(link.upper);
  }
  for (ReachLink& link : problem.links) make_finite(link, 4.0 * span);
  return problem;
}

ReachProblem with_joint_fixed(const ReachProblem& problem, int k, double value) {
  const ReachLink& link = problem.links[static_cast<std::size_t>(k)];
  Transform X;
  if (link.rotates) {
    X.R = Eigen::AngleAxisd{value, Eigen::Vector3d::UnitZ()}.toRotationMatrix();
    X.p = X.R * link.p;
  } else {
    X.p = link.p + value * Eigen::Vector3d::UnitZ();
  }
  X.R = (X.R * link.R).eval();
  ReachProblem result = problem;
  remove_joint(result, k);
  insert_before(result, k, X);
  return result;
}

ReachJoints with_joint_inserted(const ReachJoints& q, int k, double value) {
  ReachJoints result = q;
  for (int j = kMaxReachJoints - 1; j > k; --j) result[j] = q[j - 1];
  result[k] = value;
  return result;
}

Nearest nearest(const ReachProblem& problem, ReachWork& work) {
  if (problem.n == 0) return {ReachJoints::Zero(), problem.target.norm()};
  if (problem.n == 1) return one_joint_minima(problem)[0];
  if (const std::optional<Coaxial> pair = find_coaxial(problem)) {
    return plain_split(*pair, nearest(merged(problem, *pair), work));
  }
  if (const std::optional<ClosedForm> closed = closed_form(problem, 0.0)) return closed->minima[0];
  return minima(problem, false, work).front().nearest;
}

namespace {

// All joints but `k` are solved for at each of the values; what comes within `limit` is kept.
std::vector<Nearest> slice(const ReachProblem& problem, int k, const std::vector<double>& values, double limit,
                           const FamilyOptions& options, ReachWork& work, std::vector<int>* hits = nullptr) {
  std::vector<Nearest> result;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const std::size_t before = result.size();
    for (const Nearest& item : all_nearest(with_joint_fixed(problem, k, values[i]), options, work)) {
      if (item.distance <= limit) result.push_back({with_joint_inserted(item.q, k, values[i]), item.distance});
    }
    if (hits != nullptr && result.size() > before) hits->push_back(static_cast<int>(i));
  }
  return result;
}

void append(std::vector<Nearest>& list, const std::vector<Nearest>& more) {
  list.insert(list.end(), more.begin(), more.end());
}

std::vector<double> midpoints(double lower, double upper, int count) {
  std::vector<double> result;
  for (int i = 0; i < count; ++i) result.push_back(lower + (upper - lower) * (i + 0.5) / count);
  return result;
}

// The family of minima along which joint `k` moves. Joints that only share an axis once `k` is fixed share their turns in
// every way: what `options` says of shared turns is meant for neighbours of the arm itself.
std::vector<Nearest> family(const ReachProblem& problem, int k, double limit, const FamilyOptions& options,
                            ReachWork& work) {
  const ReachLink& link = problem.links[static_cast<std::size_t>(k)];
  const int few = per_parameter(options.points);
  // First coarsely: if other joints can move on as well, this is a family of two parameters and the grid stays coarse.
  std::vector<Nearest> coarse =
      slice(problem, k, midpoints(link.lower, link.upper, few), limit, {options.tie, few, true}, work);
  if (static_cast<int>(coarse.size()) > 8 * few) return coarse;

  std::vector<int> hits;
  const FamilyOptions single{options.tie, 1, true};
  const std::vector<double> values = midpoints(link.lower, link.upper, options.points);
  std::vector<Nearest> fine = slice(problem, k, values, limit, single, work, &hits);
  if (hits.empty() || static_cast<int>(hits.size()) > options.points / 2) return fine;
  // The joint moves over a small part of its range only: spend the points there.
  const double step = (link.upper - link.lower) / options.points;
  std::vector<double> closer;
  for (const int hit : hits) {
    const double middle = values[static_cast<std::size_t>(hit)];
    const int count = options.points / static_cast<int>(hits.size());
    for (const double value : midpoints(middle - 0.5 * step, middle + 0.5 * step, count)) closer.push_back(value);
  }
  return slice(problem, k, closer, limit, single, work);
}

}  // namespace

std::vector<Nearest> all_nearest(const ReachProblem& problem, const FamilyOptions& options, ReachWork& work) {
  const double tie = options.tie;
  if (problem.n == 0) return {{ReachJoints::Zero(), problem.target.norm()}};
  if (problem.n == 1) {
    const NearestList list = one_joint_minima(problem);
    std::vector<Nearest> result;
    for (const Nearest& item : list) {
      if (item.distance <= list[0].distance + tie) result.push_back(item);
    }
    if (!all_equal_1(problem, tie)) return result;
    for (const double q : midpoints(problem.links[0].lower, problem.links[0].upper, options.points)) {
      result.push_back({{q, 0.0, 0.0}, with_joint_fixed(problem, 0, q).target.norm()});
    }
    return result;
  }
  if (const std::optional<Coaxial> pair = find_coaxial(problem)) {
    // A family of the merged arm makes this one of two parameters: few points along either.
    const FamilyOptions few{tie, per_parameter(options.points), options.shared_turns};
    return all_splits(*pair, all_nearest(merged(problem, *pair), few, work), options);
  }

  if (const std::optional<ClosedForm> closed = closed_form(problem, tie); closed && closed->complete) {
    const NearestList& list = closed->minima;
    std::vector<Nearest> result;
    std::copy_if(list.begin(), list.end(), std::back_inserter(result),
                 [&](const Nearest& item) { return item.distance <= list[0].distance + tie; });
    if (closed->family_joint >= 0) {
      append(result, family(problem, closed->family_joint, list[0].distance + tie, options, work));
    }
    return result;
  }
  const std::vector<Minimum> found = minima(problem, true, work);
  const double limit = found[0].nearest.distance + tie;
  std::vector<Nearest> result;
  std::array<bool, kMaxReachJoints> moves{};
  for (const Minimum& minimum : found) {
    if (minimum.nearest.distance > limit) break;
    result.push_back(minimum.nearest);
    if (!minimum.flat) continue;
    Eigen::Index k = 0;
    minimum.direction.cwiseAbs().maxCoeff(&k);
    moves[static_cast<std::size_t>(k)] = true;
  }
  for (int k = 0; k < problem.n; ++k) {
    if (!moves[static_cast<std::size_t>(k)]) continue;
    append(result, family(problem, k, limit, options, work));
  }
  return result;
}

}  // namespace modsearch::internal
