#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <modsearch/baselines/certify/node_bound_parts_internal.hpp>

namespace modsearch::certify {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

}  // namespace

using node_bound::at;
using node_bound::greatest_chord;
using node_bound::grow;
using node_bound::n_pairs;
using node_bound::pair_of;

NodeBound::NodeBound(const SequenceModel& model, const Scenery& scenery)
    : model_{model},
      scenery_{scenery},
      n_goals_{static_cast<int>(scenery.targets.size())},
      n_lengths_{model.n_lengths()},
      n_joints_{model.n_joints()},
      n_corners_{std::size_t{1} << model.n_lengths()} {
  const auto frames = at(n_goals_ * (n_joints_ + 1));
  const auto joints = at(n_goals_ * n_joints_);
  delta_.resize(frames);
  turn_.resize(frames);
  axis_.resize(joints);
  origin_.resize(frames);
  tips_.resize(at(n_goals_));
  swing_.resize(frames);
  stretch_.assign(frames * at(n_lengths_), 0.0);
  corners_.resize(n_corners_ * at(n_lengths_ + 1));
  blocks_.resize(frames);
  groups_.resize(frames);
  pull_.resize(frames);
  rest_.resize(at(n_lengths_ + 1));
  slopes_.resize(joints * at(n_lengths_ + 1));
  slope_at_.resize(n_corners_ * joints);
  corner_value_.resize(n_corners_);
  for (int g = 0; g < n_goals_; ++g) {
    for (int j = 0; j <= n_joints_; ++j) {
      groups_[frame(g, j)].goal = g;
      groups_[frame(g, j)].frame = j;
      groups_[frame(g, j)].choices.resize(n_corners_);
    }
  }
}

void NodeBound::set_corners() {
  const auto stride = at(n_lengths_ + 1);
  for (std::size_t c = 0; c < n_corners_; ++c) {
    double* corner = &corners_[c * stride];
    corner[0] = 1.0;
    for (int k = 0; k < n_lengths_; ++k) corner[k + 1] = (c >> k) % 2 == 0 ? box_.lower[at(k)] : box_.upper[at(k)];
  }
}

void NodeBound::fill(Block& block, int g, int j, const AffineVector& b, int acting) const {
  block.acting = acting;
  block.n = static_cast<int>(b.terms.size()) + (b.offset.isZero(0.0) ? 0 : 1);
  const auto n = at(block.n);
  grow(block.form, n);
  grow(block.w, n);
  grow(block.first, n * at(acting));
  grow(block.second, n * at(n_pairs(acting)));
  grow(block.at_corner, n_corners_);
  grow(block.length, n_corners_);
  const Eigen::Matrix3d& R = turn_[frame(g, j)];
  std::size_t i = 0;
  if (!b.offset.isZero(0.0)) {
    block.form[i] = 0;
    block.w[i++] = R * b.offset;
  }
  for (const AffineVector::Term& term : b.terms) {
    block.form[i] = term.parameter + 1;
    block.w[i++] = R * term.direction;
  }
  for (int w = 0; w < acting; ++w) {
    const Eigen::Vector3d& axis_w = axis_[joint(g, w)];
    for (i = 0; i < n; ++i) block.first[at(w) * n + i] = axis_w.cross(block.w[i]);
    for (int v = 0; v <= w; ++v) {
      const Eigen::Vector3d& axis_v = axis_[joint(g, v)];
      for (i = 0; i < n; ++i) block.second[at(pair_of(v, w)) * n + i] = axis_v.cross(block.first[at(w) * n + i]);
    }
  }
  const auto stride = at(n_lengths_ + 1);
  for (std::size_t c = 0; c < n_corners_; ++c) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (i = 0; i < n; ++i) sum += corners_[c * stride + at(block.form[i])] * block.w[i];
    block.at_corner[c] = sum;
    block.length[c] = sum.norm();
  }
}

void NodeBound::set_box(const Box& box) {
  box_ = box;
  const auto n = at(box.size());
  middle_.resize(n);
  half_.resize(n);
  for (std::size_t v = 0; v < n; ++v) {
    middle_[v] = 0.5 * (box.lower[v] + box.upper[v]);
    half_[v] = std::max(box.upper[v] - middle_[v], middle_[v] - box.lower[v]);
  }
  set_corners();
  n_rows_ = 0;
  for (int g = 0; g < n_goals_; ++g) {
    Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
    double delta = 0.0;
    Eigen::Vector3d origin = Eigen::Vector3d::Zero();
    double swing = 0.0;
    for (int j = 0; j <= n_joints_; ++j) {
      const std::size_t f = frame(g, j);
      turn_[f] = R;
      delta_[f] = delta;
      origin_[f] = origin;
      swing_[f] = swing;
      const AffineVector& v = model_.frames[at(j)].v;
      Eigen::Vector3d at_centre = v.offset;
      for (const auto& term : v.terms) at_centre += middle_[at(term.parameter)] * term.direction;
      origin += R * at_centre;
      swing += at_centre.norm() * greatest_chord(delta_[frame(g, model_.frames[at(j)].acting)]);
      if (j == n_joints_) {
        tips_[at(g)] = origin;
        break;
      }
      double* stretch = stretch_.data() + frame(g, j + 1) * at(n_lengths_);
      std::copy_n(stretch_.data() + f * at(n_lengths_), n_lengths_, stretch);
      for (const auto& term : v.terms) stretch[term.parameter] += term.direction.norm();
      const Eigen::Matrix3d before = R * model_.frames[at(j)].turn;
      const std::size_t variable = at(n_lengths_ + g * n_joints_ + j);
      const double c = std::cos(middle_[variable]);
      const double s = std::sin(middle_[variable]);
      R.col(0) = c * before.col(0) + s * before.col(1);
      R.col(1) = c * before.col(1) - s * before.col(0);
      R.col(2) = before.col(2);
      axis_[joint(g, j)] = before.col(2);
      delta += half_[variable];
    }
    for (int j = 0; j <= n_joints_; ++j) {
      fill(blocks_[frame(g, j)], g, j, model_.frames[at(j)].v, model_.frames[at(j)].acting);
      Group& group = groups_[frame(g, j)];
      group.rows.clear();
      group.acting = model_.frames[at(j)].acting;
      group.delta = delta_[frame(g, group.acting)];
    }
  }
}

NodeBound::Ends NodeBound::ends(int v) const {
  Ends ends{kInfinity, kInfinity};
  const auto joints = at(n_goals_ * n_joints_);
  for (std::size_t c = 0; c < n_corners_; ++c) {
    if (v < n_lengths_) {
      double& end = (c >> v) % 2 == 0 ? ends.lower : ends.upper;
      end = std::min(end, corner_value_[c]);
      continue;
    }
    // F grows with the slope: at the upper end of the angle it is above its middle by slope * half-width.
    const double slope = slope_at_[c * joints + at(v - n_lengths_)];
    const double without = corner_value_[c] + std::abs(slope) * half_[at(v)];
    ends.lower = std::min(ends.lower, without + slope * half_[at(v)]);
    ends.upper = std::min(ends.upper, without - slope * half_[at(v)]);
  }
  ends.lower += constant_;
  ends.upper += constant_;
  return ends;
}

void NodeBound::losses(const double* multipliers, std::vector<double>& result) const {
  const auto stride = at(n_lengths_ + 1);
  const auto joints = at(n_goals_ * n_joints_);
  result.assign(middle_.size(), 0.0);
  for (std::size_t v = 0; v < joints; ++v) {
    const double h = half_[at(n_lengths_) + v];
    result[at(n_lengths_) + v] += std::abs(slope_at_[worst_ * joints + v]) * h;
    for (int k = 0; k < n_lengths_; ++k) {
      result[at(k)] += std::abs(slopes_[v * stride + at(k + 1)]) * h * half_[at(k)];
    }
  }
  for (const Group& group : groups_) {
    if (group.acting == 0 || group.delta <= 0.0) continue;
    std::array<double, 16> share{};
    const double bent = group.choice >= 2 ? curvature(group, worst_, share.data()) : 0.0;
    const double rest = group.choices[worst_][at(group.choice)] - bent;
    for (int v = 0; v < group.acting; ++v) {
      const std::size_t variable = at(n_lengths_ + group.goal * n_joints_ + v);
      result[variable] += share[at(v)] + rest * half_[variable] / group.delta;
    }
  }
  // What the reach of the body points takes off the rows.
  std::vector<double> shares;
  for (int r = 0; r < n_rows_; ++r) {
    const PlacedRow& placed = rows_[at(r)];
    const double mu = multipliers[3 * n_goals_ + r];
    if (mu <= 0.0 || !placed.row.ball) continue;
    const BodyPoint point = body_point(placed.row.goal, placed.row.run, placed.row.tau);
    reach_shares(placed.row.goal, placed.row.run, placed.row.tau, shares);
    double sum = 0.0;
    for (const double share : shares) sum += share;
    if (sum <= 0.0) continue;
    const double loss = mu * point.reach * point.reach / placed.length;
    for (std::size_t v = 0; v < shares.size(); ++v) result[v] += loss * shares[v] / sum;
  }
}

Eigen::Vector3d NodeBound::tip_derivative(int g, int v) const {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int j = 0; j <= n_joints_; ++j) {
    const Block& block = blocks_[frame(g, j)];
    const auto n = at(block.n);
    for (std::size_t i = 0; i < n; ++i) {
      if (v < n_lengths_) {
        if (block.form[i] == v + 1) sum += block.w[i];
        continue;
      }
      const int of_goal = v - n_lengths_ - g * n_joints_;
      if (of_goal < 0 || of_goal >= block.acting) continue;
      const double z = block.form[i] == 0 ? 1.0 : middle_[at(block.form[i] - 1)];
      sum += z * block.first[at(of_goal) * n + i];
    }
  }
  return sum;
}

}  // namespace modsearch::certify
