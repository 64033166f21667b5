#include <array>
#include <cmath>
#include <modsearch/baselines/certify/node_bound_parts_internal.hpp>

namespace modsearch::certify {

using node_bound::at;
using node_bound::n_pairs;
using node_bound::pair_of;
using node_bound::unit_or_zero;

// d bound / d weight of a term, to the multipliers that the weight is made of.
void NodeBound::scatter(const Group& group, int term, const Eigen::Vector3d& g, double* gradient) const {
  if (term >= 0) {
    const int r = group.rows[at(term)];
    gradient[3 * n_goals_ + r] += rows_[at(r)].n.dot(g);
    return;
  }
  Eigen::Map<Eigen::Vector3d>{gradient + 3 * group.goal} += g;
  for (int r = 0; r < n_rows_; ++r) {
    const PlacedRow& placed = rows_[at(r)];
    if (placed.row.goal == group.goal && group.frame < model_.runs[at(placed.row.run)].frame) {
      gradient[3 * n_goals_ + r] += placed.n.dot(g);
    }
  }
}

void NodeBound::second_order_gradient(const double* multipliers, double* gradient) const {
  const auto stride = at(n_lengths_ + 1);
  const auto joints = at(n_goals_ * n_joints_);
  for (const Group& group : groups_) {
    const double* h = &half_[at(n_lengths_ + group.goal * n_joints_)];
    const bool bent = group.acting > 0 && group.choice >= 2;
    const bool by_columns = group.acting > 0 && group.choice % 2 == 1 && !group.rows.empty();
    const double size_factor = bent ? group.delta * group.delta * group.delta / 6.0 : 0.5 * group.delta * group.delta;
    // How much each second derivative adds to the curvature.
    std::array<double, 136> weights{};
    if (bent) {
      std::array<double, 16> rows{};
      std::array<double, 136> entries{};
      for (int w = 0; w < group.acting; ++w) {
        for (int v = 0; v <= w; ++v) {
          const double entry = form_at(&group.forms[at(pair_of(v, w)) * stride], worst_) * h[v] * h[w];
          entries[at(pair_of(v, w))] = entry;
          rows[at(v)] += v == w ? entry : std::abs(entry);
          if (v != w) rows[at(w)] += std::abs(entry);
        }
      }
      for (int w = 0; w < group.acting; ++w) {
        for (int v = 0; v <= w; ++v) {
          const double on_v = rows[at(v)] > 0.0 ? 0.5 : 0.0;
          const double on_w = v != w && rows[at(w)] > 0.0 ? 0.5 : 0.0;
          const double sign = v == w || entries[at(pair_of(v, w))] >= 0.0 ? 1.0 : -1.0;
          weights[at(pair_of(v, w))] = (on_v + on_w) * sign * h[v] * h[w];
        }
      }
    }
    Eigen::Matrix3d directions = Eigen::Matrix3d::Zero();  // of the columns of M
    const Eigen::Matrix3d& R = turn_[frame(group.goal, group.frame)];
    if (by_columns) {
      for (int term = -1; term < static_cast<int>(group.rows.size()); ++term) {
        directions +=
            weight_of(group, term, multipliers) * (R.transpose() * block_of(group, term).at_corner[worst_]).transpose();
      }
      for (int k = 0; k < 3; ++k) directions.col(k) = unit_or_zero(directions.col(k));
    }
    for (int term = -1; term < static_cast<int>(group.rows.size()); ++term) {
      const Block& block = block_of(group, term);
      const auto n = at(block.n);
      Eigen::Vector3d g = -block.at_corner[worst_];
      const double* z = &corners_[worst_ * stride];
      for (int v = 0; v < block.acting; ++v) {
        const double slope = slope_at_[worst_ * joints + joint(group.goal, v)];
        const double factor = slope > 0.0 ? h[v] : slope < 0.0 ? -h[v] : 0.0;
        for (std::size_t i = 0; i < n; ++i) g -= factor * z[block.form[i]] * block.first[at(v) * n + i];
      }
      if (bent) {
        for (int p = 0; p < n_pairs(block.acting); ++p) {
          if (weights[at(p)] == 0.0) continue;
          for (std::size_t i = 0; i < n; ++i) g -= weights[at(p)] * z[block.form[i]] * block.second[at(p) * n + i];
        }
      }
      if (group.acting > 0) {
        if (by_columns) {
          g -= size_factor * (directions * (R.transpose() * block.at_corner[worst_]));
        } else {
          g -= size_factor * block.length[worst_] * unit_or_zero(weight_of(group, term, multipliers));
        }
      }
      scatter(group, term, g, gradient);
    }
  }
}

}  // namespace modsearch::certify
