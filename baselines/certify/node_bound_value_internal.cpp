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
using node_bound::grow;
using node_bound::kHalfTurn;
using node_bound::n_pairs;
using node_bound::pair_of;
using node_bound::unit_or_zero;

void NodeBound::pulls(const double* multipliers) {
  for (int g = 0; g < n_goals_; ++g) {
    const Eigen::Map<const Eigen::Vector3d> y{multipliers + 3 * g};
    for (int j = 0; j <= n_joints_; ++j) pull_[frame(g, j)] = y;
  }
  for (int r = 0; r < n_rows_; ++r) {
    const PlacedRow& placed = rows_[at(r)];
    const Eigen::Vector3d push = multipliers[3 * n_goals_ + r] * placed.n;
    for (int j = 0; j < model_.runs[at(placed.row.run)].frame; ++j) pull_[frame(placed.row.goal, j)] += push;
  }
}

double NodeBound::constant(const double* multipliers, double* gradient) const {
  double sum = 0.0;
  for (int g = 0; g < n_goals_; ++g) {
    const Eigen::Map<const Eigen::Vector3d> y{multipliers + 3 * g};
    const Target& target = scenery_.targets[at(g)];
    sum += y.dot(target.position) - (target.radius + kSlack) * y.norm();
    if (gradient != nullptr) {
      Eigen::Map<Eigen::Vector3d>{gradient + 3 * g} = target.position - (target.radius + kSlack) * unit_or_zero(y);
    }
  }
  for (int r = 0; r < n_rows_; ++r) {
    sum += multipliers[3 * n_goals_ + r] * rows_[at(r)].beta;
    if (gradient != nullptr) gradient[3 * n_goals_ + r] = rows_[at(r)].beta;
  }
  return sum;
}

const NodeBound::Block& NodeBound::block_of(const Group& group, int term) const {
  return term < 0 ? blocks_[frame(group.goal, group.frame)] : rows_[at(group.rows[at(term)])].block;
}

Eigen::Vector3d NodeBound::weight_of(const Group& group, int term, const double* multipliers) const {
  if (term < 0) return pull_[frame(group.goal, group.frame)];
  const int r = group.rows[at(term)];
  return multipliers[3 * n_goals_ + r] * rows_[at(r)].n;
}

// Half the greatest value of the second-order part; `share` [acting], if not null: of each joint.
double NodeBound::curvature(const Group& group, std::size_t corner, double* share) const {
  std::array<double, 16> rows{};
  const double* h = &half_[at(n_lengths_ + group.goal * n_joints_)];
  for (int w = 0; w < group.acting; ++w) {
    for (int v = 0; v <= w; ++v) {
      const double entry = form_at(&group.forms[at(pair_of(v, w) * (n_lengths_ + 1))], corner) * h[v] * h[w];
      rows[at(v)] += v == w ? entry : std::abs(entry);
      if (v != w) rows[at(w)] += std::abs(entry);
    }
  }
  double sum = 0.0;
  for (int v = 0; v < group.acting; ++v) {
    sum += std::max(0.0, rows[at(v)]);
    if (share != nullptr) share[v] = 0.5 * std::max(0.0, rows[at(v)]);
  }
  return 0.5 * sum;
}

double NodeBound::value(const double* multipliers, bool cap, Objective objective, double* gradient) {
  pulls(multipliers);
  return cap ? cap_order(multipliers, objective, gradient) : second_order(multipliers, objective, gradient);
}

double NodeBound::second_order(const double* multipliers, Objective objective, double* gradient) {
  const auto stride = at(n_lengths_ + 1);
  constant_ = constant(multipliers, gradient);
  std::fill(rest_.begin(), rest_.end(), 0.0);
  if (objective == Objective::kMass) {
    rest_[0] = model_.mass;
    std::copy(model_.masses.begin(), model_.masses.end(), rest_.begin() + 1);
  }
  std::fill(slopes_.begin(), slopes_.end(), 0.0);
  for (Group& group : groups_) {
    const int pairs = n_pairs(group.acting);
    grow(group.forms, at(pairs) * stride);
    std::fill_n(group.forms.begin(), at(pairs) * stride, 0.0);
    for (int term = -1; term < static_cast<int>(group.rows.size()); ++term) {
      const Block& block = block_of(group, term);
      const Eigen::Vector3d a = weight_of(group, term, multipliers);
      const auto n = at(block.n);
      for (std::size_t i = 0; i < n; ++i) {
        const auto form = at(block.form[i]);
        rest_[form] -= a.dot(block.w[i]);
        for (int v = 0; v < block.acting; ++v) {
          slopes_[joint(group.goal, v) * stride + form] += a.dot(block.first[at(v) * n + i]);
        }
        for (int p = 0; p < n_pairs(block.acting); ++p) {
          group.forms[at(p) * stride + form] += a.dot(block.second[at(p) * n + i]);
        }
      }
    }
  }

  const auto joints = at(n_goals_ * n_joints_);
  double least = kInfinity;
  worst_ = 0;
  for (std::size_t c = 0; c < n_corners_; ++c) {
    double value = form_at(rest_.data(), c);
    for (std::size_t v = 0; v < joints; ++v) {
      const double slope = form_at(&slopes_[v * stride], c);
      slope_at_[c * joints + v] = slope;
      value -= std::abs(slope) * half_[at(n_lengths_) + v];
    }
    corner_value_[c] = value;
    for (Group& group : groups_) {
      if (group.acting == 0) continue;
      double products = 0.0;
      for (int term = -1; term < static_cast<int>(group.rows.size()); ++term) {
        products += weight_of(group, term, multipliers).norm() * block_of(group, term).length[c];
      }
      double columns = products;  // of one term no other norm is less
      if (!group.rows.empty()) {
        Eigen::Matrix3d M = Eigen::Matrix3d::Zero();  // a b', b in the frame's own axes
        const Eigen::Matrix3d& R = turn_[frame(group.goal, group.frame)];
        for (int term = -1; term < static_cast<int>(group.rows.size()); ++term) {
          M += weight_of(group, term, multipliers) * (R.transpose() * block_of(group, term).at_corner[c]).transpose();
        }
        columns = M.col(0).norm() + M.col(1).norm() + M.col(2).norm();
      }
      const double square = 0.5 * group.delta * group.delta;
      const double cube = group.delta * group.delta * group.delta / 6.0;
      const double bent = curvature(group, c, nullptr);
      group.choices[c] = {square * products, square * columns, bent + cube * products, bent + cube * columns};
      value -= *std::min_element(group.choices[c].begin(), group.choices[c].end());
    }
    if (value < least) {
      least = value;
      worst_ = c;
    }
  }
  for (Group& group : groups_) {
    if (group.acting == 0) continue;
    const auto& there = group.choices[worst_];
    group.choice = static_cast<int>(std::min_element(there.begin(), there.end()) - there.begin());
    for (std::size_t c = 0; c < n_corners_; ++c) corner_value_[c] -= group.choices[c][at(group.choice)];
  }
  worst_ =
      static_cast<std::size_t>(std::min_element(corner_value_.begin(), corner_value_.end()) - corner_value_.begin());
  const double bound = constant_ + corner_value_[worst_];
  if (gradient != nullptr) second_order_gradient(multipliers, gradient);
  return bound;
}

double NodeBound::cap_order(const double* multipliers, Objective objective, double* gradient) {
  constant_ = constant(multipliers, gradient);
  std::fill(rest_.begin(), rest_.end(), 0.0);
  if (objective == Objective::kMass) {
    rest_[0] = model_.mass;
    std::copy(model_.masses.begin(), model_.masses.end(), rest_.begin() + 1);
  }
  for (std::size_t c = 0; c < n_corners_; ++c) corner_value_[c] = form_at(rest_.data(), c);
  const auto each_term = [&](auto&& visit) {
    for (const Group& group : groups_) {
      for (int term = -1; term < static_cast<int>(group.rows.size()); ++term) {
        const Block& block = block_of(group, term);
        const double delta = delta_[frame(group.goal, block.acting)];
        visit(group, term, block, weight_of(group, term, multipliers), delta);
      }
    }
  };
  each_term([&](const Group&, int, const Block& block, const Eigen::Vector3d& a, double delta) {
    const double length = a.norm();
    const double cosine = std::cos(std::min(delta, kHalfTurn));
    const double sine = std::sin(std::min(delta, kHalfTurn));
    for (std::size_t c = 0; c < n_corners_; ++c) {
      const double longest = length * block.length[c];
      const double along = a.dot(block.at_corner[c]);
      double most = longest;
      if (delta < kHalfTurn && along < longest * cosine - 1e-14) {
        most = std::min(most, along * cosine + a.cross(block.at_corner[c]).norm() * sine);
      }
      corner_value_[c] -= most;
    }
  });
  worst_ =
      static_cast<std::size_t>(std::min_element(corner_value_.begin(), corner_value_.end()) - corner_value_.begin());
  const double bound = constant_ + corner_value_[worst_];
  if (gradient == nullptr) return bound;
  each_term([&](const Group& group, int term, const Block& block, const Eigen::Vector3d& a, double delta) {
    const double cosine = std::cos(std::min(delta, kHalfTurn));
    const Eigen::Vector3d& b = block.at_corner[worst_];
    Eigen::Vector3d g = -block.length[worst_] * unit_or_zero(a);
    if (delta < kHalfTurn && a.dot(b) < a.norm() * block.length[worst_] * cosine - 1e-14) {
      g = -cosine * b - std::sin(delta) * b.cross(unit_or_zero(a.cross(b)));
    }
    scatter(group, term, g, gradient);
  });
  return bound;
}

}  // namespace modsearch::certify
