#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <modsearch/kinematics/interruption.hpp>
#include <modsearch/kinematics/processor_internal.hpp>
#include <modsearch/kinematics/simultaneous_ik.hpp>
#include <modsearch/kinematics/simultaneous_ik_kernel_internal.hpp>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <vector>

namespace modsearch {
namespace {

using detail::IkLink;
using detail::IkModel;
using detail::IkTarget;
using detail::IkTerm;
using detail::kIkLanes;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

void write(const Eigen::Matrix3d& R, double* rows) {
  Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>{rows} = R;
}

// The chain as a list of links for the kernel.
class LinkList {
 public:
  explicit LinkList(const Chain& chain) {
    for (int j = 0; j <= chain.n_joints(); ++j) {
      add(chain.segment(j));
      if (j == chain.n_joints()) break;
      IkLink link;
      link.kind = chain.joints()[static_cast<std::size_t>(j)].rotates() ? IkLink::Kind::kTurn : IkLink::Kind::kSlide;
      link.joint = j;
      links.push_back(link);
    }
  }

  std::vector<IkLink> links;
  std::vector<IkTerm> terms;

 private:
  void add(const ParametricPose& pose) {
    add(pose.head);
    for (const ParametricPose::Turn& turn : pose.turns) {
      IkLink link;
      link.kind = IkLink::Kind::kTwist;
      link.offset[0] = turn.angle.offset;
      link.first_term = static_cast<int>(terms.size());
      link.n_terms = static_cast<int>(turn.angle.terms.size());
      for (const AffineScalar::Term& term : turn.angle.terms) {
        terms.push_back({.parameter = term.parameter, .scale = term.scale});
      }
      links.push_back(link);
      add(turn.after);
    }
  }

  void add(const AffinePose& pose) {
    IkLink link;
    link.rotates = pose.rotation != Eigen::Matrix3d::Identity();
    if (!link.rotates && pose.translation.terms.empty() && pose.translation.offset.isZero(0.0)) return;
    write(pose.rotation, link.rotation);
    Eigen::Map<Eigen::Vector3d>{link.offset} = pose.translation.offset;
    link.first_term = static_cast<int>(terms.size());
    link.n_terms = static_cast<int>(pose.translation.terms.size());
    for (const AffineVector::Term& term : pose.translation.terms) {
      IkTerm& added = terms.emplace_back();
      added.parameter = term.parameter;
      Eigen::Map<Eigen::Vector3d>{added.direction} = term.direction;
    }
    links.push_back(link);
  }
};

// Which of a target's rows a tolerance speaks of; none: it cannot be aimed at.
std::vector<int> rows_of(Projection projection) {
  switch (projection) {
    case Projection::kX:
      return {0};
    case Projection::kY:
      return {1};
    case Projection::kZ:
      return {2};
    case Projection::kRCyl:
      return {0, 1};
    case Projection::kRSph:
      return {0, 1, 2};
    case Projection::kNx:
      return {3};
    case Projection::kNy:
      return {4};
    case Projection::kNz:
      return {5};
    case Projection::kThetaR:
      return {3, 4, 5};
    case Projection::kPhiCyl:
    case Projection::kTheta:
    case Projection::kPhiSph:
      return {};
  }
  return {};
}

// A norm: its interval begins at 0, and the nominal is its middle.
bool is_norm(Projection projection) {
  return projection == Projection::kRCyl || projection == Projection::kRSph || projection == Projection::kThetaR;
}

// What a region asks for, and how close is close enough.
struct Aim {
  IkTarget target;
  double position = kInfinity;  // [m] within which the lanes count as arrived
  double rotation = kInfinity;  // [rad]
};

std::optional<Aim> aim_at(const PoseRegion& region) {
  constexpr double kSafely = 0.3;       // of a tolerance: what a lane has to come within
  constexpr double kNarrow = 5e-3;      // [m] half widths below this are aimed at in their middle
  constexpr double kNarrowTurn = 0.05;  // [rad]
  constexpr double kWideShare = 0.8;    // of a wide interval: what costs nothing
  // Less where the tip may turn about another axis meanwhile, for the sines are smaller than the angles then.
  constexpr double kWideTurnShare = 0.3;
  Aim aim;
  IkTarget& target = aim.target;
  const Eigen::Isometry3d& X_WN = region.nominal();
  Eigen::Map<Eigen::Vector3d>{target.position} = X_WN.translation();
  write(X_WN.linear(), target.rotation);
  std::array<std::optional<Eigen::Matrix3d>, 2> frames;  // of the position, of the rotation
  std::array<bool, 2> moved{};                           // an interval that does not lie about the nominal
  for (const Tolerance& tolerance : region.tolerances()) {
    const std::vector<int> rows = rows_of(tolerance.projection);
    if (rows.empty()) return std::nullopt;
    const bool turns = rows.front() >= 3;
    std::optional<Eigen::Matrix3d>& frame = frames[turns ? 1 : 0];
    const bool whole = rows.size() == 3;  // any frame will do
    if (!whole && frame && *frame != tolerance.R_TN) return std::nullopt;
    if (!whole) frame = tolerance.R_TN;
    if (is_norm(tolerance.projection) && tolerance.lower > 0.0) return std::nullopt;  // a shell
    const double lower = is_norm(tolerance.projection) ? -tolerance.upper : tolerance.lower;
    const double half = 0.5 * (tolerance.upper - lower);
    const double middle = 0.5 * (tolerance.upper + lower);
    const bool narrow = half <= (turns ? kNarrowTurn : kNarrow);
    // The rows of a rotation are sines: half a turn and more is all there is.
    if (turns && half >= std::numbers::pi) continue;
    for (const int row : rows) {
      target.weight[row] = 1.0;
      const double slack =
          narrow ? 0.0 : (turns ? kWideTurnShare : kWideShare) * half / std::sqrt(static_cast<double>(rows.size()));
      target.lower[row] = turns ? std::sin(std::max(middle - slack, -0.5 * std::numbers::pi)) : middle - slack;
      target.upper[row] = turns ? std::sin(std::min(middle + slack, 0.5 * std::numbers::pi)) : middle + slack;
    }
    moved[turns ? 1 : 0] = moved[turns ? 1 : 0] || middle != 0.0 || !narrow;
    double& close = turns ? aim.rotation : aim.position;
    close = std::min(close, narrow ? kSafely * half : 0.1 * half);
  }
  const auto all_of = [&](int first) {
    return target.weight[first] == 1.0 && target.weight[first + 1] == 1.0 && target.weight[first + 2] == 1.0;
  };
  target.whole_position = all_of(0) && !moved[0];
  target.whole_rotation = all_of(3) && !moved[1];
  const Eigen::Matrix3d R_NW = X_WN.linear().transpose();
  write(frames[0].value_or(Eigen::Matrix3d::Identity()) * R_NW, target.R_TW);
  write(frames[1].value_or(Eigen::Matrix3d::Identity()) * R_NW, target.R_SW);
  return aim;
}

const detail::IkKernel& best_kernel() {
  static const detail::IkKernel& best = detail::processor_has_v4()   ? detail::kIkKernelAvx512
                                        : detail::processor_has_v3() ? detail::kIkKernelAvx2
                                                                     : detail::kIkKernelSse2;
  return best;
}

struct alignas(8 * kIkLanes) LaneVector {
  double lane[kIkLanes];
};

}  // namespace

struct SimultaneousIk::Impl {
  Impl(const Chain& c, std::span<const PoseRegion> regions, const SimultaneousIkOptions& o)
      : chain{&c}, goals{regions.begin(), regions.end()}, options{o}, list{c} {}

  const Chain* chain;
  std::vector<PoseRegion> goals;
  SimultaneousIkOptions options;
  LinkList list;
  std::vector<IkTarget> targets;
  std::vector<double> close_position;  // squared [m^2]
  std::vector<double> close_rotation;  // 1 - cos
  Eigen::VectorXd lower, upper;
  IkModel model;
  std::vector<LaneVector> memory;
  detail::IkLanes lanes;

  // What is known of the start in a lane.
  struct Lane {
    int start = -1;  // none
    int steps = 0;   // since it was begun or begun anew
    int again = 0;   // times that it was begun anew
    double cost = kInfinity;
  };
  std::array<Lane, kIkLanes> state;
  Eigen::VectorXd v;
  Posture posture;

  static constexpr double kFirstDamping = 1e-2;

  void lay_out() {
    const auto n = static_cast<std::size_t>(lower.size());
    const std::size_t goals_size = goals.size();
    memory.assign(n + 2 + 2 * goals_size + detail::ik_normal_size(model) + detail::ik_work_size(model), LaneVector{});
    LaneVector* next = memory.data();
    const auto take = [&](std::size_t vectors) {
      double* const here = next->lane;
      next += vectors;
      return here;
    };
    lanes.v = take(n);
    lanes.cost = take(1);
    lanes.damping = take(1);
    lanes.position = take(goals_size);
    lanes.rotation = take(goals_size);
    lanes.normal = take(detail::ik_normal_size(model));
    lanes.work = take(detail::ik_work_size(model));
  }

  void begin(int lane, int start, const Start& source) {
    state[static_cast<std::size_t>(lane)] = {.start = start, .steps = 0, .again = 0, .cost = kInfinity};
    source(start, v);
    v = v.cwiseMax(lower).cwiseMin(upper);
    for (Eigen::Index i = 0; i < v.size(); ++i) lanes.v[i * kIkLanes + lane] = v[i];
    lanes.cost[lane] = kInfinity;
    lanes.damping[lane] = kFirstDamping;
  }

  [[nodiscard]] bool meets(int lane, std::size_t goal) const {
    const std::size_t at = goal * kIkLanes + static_cast<std::size_t>(lane);
    return lanes.position[at] <= close_position[goal] && lanes.rotation[at] <= close_rotation[goal];
  }

  [[nodiscard]] bool close(int lane) const {
    for (std::size_t g = 0; g < goals.size(); ++g) {
      if (!meets(lane, g)) return false;
    }
    return true;
  }

  // Where the lane is stuck with some goals met and others not, the postures of the others are drawn anew: what is met
  // stays. Without this a start would have to be lucky with all goals at once. False: there is nothing to keep, or it
  // was done often enough.
  [[nodiscard]] bool begin_anew(int lane, const Start& source) {
    constexpr double kNear = 100.0;  // times the squared distance that counts as met: it will be once the others are
    Lane& s = state[static_cast<std::size_t>(lane)];
    if (s.again >= options.restarts) return false;
    std::vector<std::size_t> missed;
    for (std::size_t g = 0; g < goals.size(); ++g) {
      const std::size_t at = g * kIkLanes + static_cast<std::size_t>(lane);
      const bool near =
          lanes.position[at] <= kNear * close_position[g] && lanes.rotation[at] <= kNear * close_rotation[g];
      if (!near) missed.push_back(g);
    }
    if (missed.empty() || missed.size() == goals.size()) return false;
    source(s.start, v);
    v = v.cwiseMax(lower).cwiseMin(upper);
    for (const std::size_t g : missed) {
      const Eigen::Index first = model.n_parameters + static_cast<Eigen::Index>(g) * model.n_joints;
      for (Eigen::Index i = first; i < first + model.n_joints; ++i) lanes.v[i * kIkLanes + lane] = v[i];
    }
    s = {.start = s.start, .steps = 0, .again = s.again + 1, .cost = kInfinity};
    lanes.cost[lane] = kInfinity;
    lanes.damping[lane] = kFirstDamping;
    return true;
  }

  // Nothing more is to be expected of the lane.
  [[nodiscard]] bool stuck(int lane) {
    constexpr int kSoonest = 10;  // steps
    constexpr double kMostDamping = 1e6;
    Lane& s = state[static_cast<std::size_t>(lane)];
    const double before = s.cost;
    s.cost = lanes.cost[lane];
    ++s.steps;
    if (s.steps >= options.iterations || !(s.cost < kInfinity) || lanes.damping[lane] > kMostDamping) return true;
    const bool taken = s.cost < before;
    return taken && s.steps > kSoonest && before - s.cost < options.least_gain * before;
  }

  [[nodiscard]] Eigen::VectorXd at(int lane) const {
    Eigen::VectorXd point(lower.size());
    for (Eigen::Index i = 0; i < point.size(); ++i) point[i] = lanes.v[i * kIkLanes + lane];
    return point;
  }

  // The regions' own word on where the lane is; `v` becomes that point.
  [[nodiscard]] bool arrived(int lane) {
    v = at(lane);
    const Eigen::Index n_x = model.n_parameters;
    const Arm arm{*chain, v.head(n_x)};
    for (std::size_t g = 0; g < goals.size(); ++g) {
      arm.forward(v.data() + n_x + static_cast<Eigen::Index>(g) * model.n_joints, posture);
      if (!goals[g].contains(posture.tip)) return false;
    }
    return true;
  }
};

bool SimultaneousIk::covers(const PoseRegion& region) { return aim_at(region).has_value(); }

SimultaneousIk::SimultaneousIk(const Chain& chain, std::span<const PoseRegion> goals, const Eigen::VectorXd& x_lower,
                               const Eigen::VectorXd& x_upper, const SimultaneousIkOptions& options)
    : impl_{std::make_unique<Impl>(chain, goals, options)} {
  const Eigen::Index n_x = chain.n_parameters();
  const Eigen::Index n_q = chain.n_joints();
  const auto n_goals = static_cast<Eigen::Index>(goals.size());
  if (goals.empty()) throw std::invalid_argument("SimultaneousIk: no goals, at least one is needed");
  if (x_lower.size() != n_x || x_upper.size() != n_x) {
    throw std::invalid_argument(fmt::format("SimultaneousIk: {} and {} bounds given, the chain has {} parameters",
                                            x_lower.size(), x_upper.size(), n_x));
  }
  Impl& m = *impl_;
  for (const PoseRegion& region : goals) {
    const std::optional<Aim> aim = aim_at(region);
    if (!aim) {
      throw std::invalid_argument(
          fmt::format("SimultaneousIk: the tolerances of goal {} cannot be aimed at", m.targets.size()));
    }
    m.targets.push_back(aim->target);
    m.close_position.push_back(aim->position * aim->position);
    m.close_rotation.push_back(aim->rotation < kInfinity ? 0.5 * aim->rotation * aim->rotation : kInfinity);
  }
  m.lower.resize(n_x + n_goals * n_q);
  m.upper.resize(m.lower.size());
  m.lower.head(n_x) = x_lower;
  m.upper.head(n_x) = x_upper;
  for (Eigen::Index g = 0; g < n_goals; ++g) {
    m.lower.segment(n_x + g * n_q, n_q) = chain.lower_limits().cwiseMax(-std::numbers::pi);
    m.upper.segment(n_x + g * n_q, n_q) = chain.upper_limits().cwiseMin(std::numbers::pi);
  }
  m.v.resize(m.lower.size());
  m.model = {.n_parameters = static_cast<int>(n_x),
             .n_joints = static_cast<int>(n_q),
             .n_goals = static_cast<int>(n_goals),
             .n_links = static_cast<int>(m.list.links.size()),
             .links = m.list.links.data(),
             .terms = m.list.terms.data(),
             .targets = m.targets.data(),
             .lower = m.lower.data(),
             .upper = m.upper.data(),
             .length = options.length};
  m.lay_out();
}

SimultaneousIk::~SimultaneousIk() = default;
SimultaneousIk::SimultaneousIk(SimultaneousIk&&) noexcept = default;
SimultaneousIk& SimultaneousIk::operator=(SimultaneousIk&&) noexcept = default;

const Eigen::VectorXd& SimultaneousIk::lower() const { return impl_->lower; }
const Eigen::VectorXd& SimultaneousIk::upper() const { return impl_->upper; }

bool SimultaneousIk::generic() const {
  // Full rank at one point is full rank at almost all, for what is analytic; this one is in no special place.
  constexpr double kThreshold = 1e-6;  // of the largest pivot
  Impl& m = *impl_;
  Eigen::VectorXd at(m.lower.size());
  for (Eigen::Index i = 0; i < at.size(); ++i) {
    const double share = std::fmod(0.5 + 0.7548776662466927 * static_cast<double>(i + 1), 1.0);  // Roberts' sequence
    at[i] = m.lower[i] + (0.1 + 0.8 * share) * (m.upper[i] - m.lower[i]);
  }
  const Eigen::Index n_x = m.model.n_parameters;
  const Eigen::Index n_q = m.model.n_joints;
  const Arm arm{*m.chain, at.head(n_x)};
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(6 * static_cast<Eigen::Index>(m.goals.size()), at.size());
  Eigen::Index rows = 0;
  for (std::size_t g = 0; g < m.goals.size(); ++g) {
    const Eigen::Index q_at = n_x + static_cast<Eigen::Index>(g) * n_q;
    arm.forward(at.data() + q_at, m.posture);
    const Eigen::Matrix<double, 6, Eigen::Dynamic> J_q = arm.tip_jacobian_q(m.posture);
    const Eigen::Matrix<double, 6, Eigen::Dynamic> J_x = arm.tip_jacobian_x(m.posture);
    const IkTarget& target = m.targets[g];
    for (int row = 0; row < 6; ++row) {
      if (target.weight[row] == 0.0) continue;
      const double* R = (row < 3 ? target.R_TW : target.R_SW) + 3 * (row % 3);
      const Eigen::RowVector3d axis{R[0], R[1], R[2]};
      const Eigen::Index first = row < 3 ? 0 : 3;
      J.row(rows).segment(q_at, n_q) = axis * J_q.middleRows<3>(first);
      J.row(rows).head(n_x) = axis * J_x.middleRows<3>(first);
      ++rows;
    }
  }
  if (rows > at.size()) return false;
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr{J.topRows(rows).transpose()};
  qr.setThreshold(kThreshold);
  return qr.rank() == rows;
}

SimultaneousIk::Outcome SimultaneousIk::solve(int n_starts, const Start& start, const Arrival& arrival) {
  Impl& m = *impl_;
  const detail::IkKernel& kernel = best_kernel();
  Outcome outcome;
  int next = 0;
  int working = 0;
  const auto refill = [&](int lane) {
    const bool more = next < n_starts;
    if (more) m.begin(lane, next++, start);
    if (!more) m.state[static_cast<std::size_t>(lane)].start = -1;  // it goes on with what it has, unheeded
    working += more ? 1 : 0;
  };
  for (int lane = 0; lane < kIkLanes; ++lane) refill(lane);
  while (working > 0) {
    interruption_point();
    kernel.step(m.model, m.lanes);
    for (int lane = 0; lane < kIkLanes; ++lane) {
      const int which = m.state[static_cast<std::size_t>(lane)].start;
      if (which < 0) continue;
      ++outcome.steps;
      const bool close = m.close(lane);
      if (!close && (!m.stuck(lane) || m.begin_anew(lane, start))) continue;
      --working;
      if (close && m.arrived(lane)) {
        if (!arrival(which, m.v)) return outcome;
      } else if (m.lanes.cost[lane] < outcome.least_cost) {
        outcome.least_cost = m.lanes.cost[lane];
        outcome.nearest = m.at(lane);
      }
      refill(lane);
    }
  }
  return outcome;
}

}  // namespace modsearch
