#include <algorithm>
#include <array>
#include <cmath>
#include <modsearch/baselines/certify/node_bound_parts_internal.hpp>

namespace modsearch::certify {

using node_bound::at;
using node_bound::greatest_chord;
using node_bound::grow;

void NodeBound::clear_rows() {
  n_rows_ = 0;
  for (Group& group : groups_) {
    group.rows.clear();
    group.acting = model_.frames[at(group.frame)].acting;
    group.delta = delta_[frame(group.goal, group.acting)];
  }
}

bool NodeBound::too_short(int run) const {
  const StraightRun& body = model_.runs[at(run)];
  double length = (body.end.offset - body.start.offset).dot(body.axis);
  for (int k = 0; k < n_lengths_; ++k) {
    double rate = 0.0;
    for (const auto& term : body.end.terms) rate += term.parameter == k ? term.direction.dot(body.axis) : 0.0;
    for (const auto& term : body.start.terms) rate -= term.parameter == k ? term.direction.dot(body.axis) : 0.0;
    length += std::min(rate * box_.lower[at(k)], rate * box_.upper[at(k)]);
  }
  return !(length >= 2.0 * body.radius + 1e-9);
}

namespace {

// The point of the run's inner axis, affine in the lengths.
AffineVector point_of(const StraightRun& run, double tau) {
  AffineVector point{Eigen::Vector3d{(1.0 - tau) * run.start.offset + tau * run.end.offset +
                                     (1.0 - 2.0 * tau) * run.radius * run.axis}};
  for (const auto& term : run.start.terms) point.terms.push_back({term.parameter, (1.0 - tau) * term.direction});
  for (const auto& term : run.end.terms) {
    const auto same = std::find_if(point.terms.begin(), point.terms.end(),
                                   [&](const auto& other) { return other.parameter == term.parameter; });
    if (same == point.terms.end()) {
      point.terms.push_back({term.parameter, tau * term.direction});
    } else {
      same->direction += tau * term.direction;
    }
  }
  return point;
}

}  // namespace

NodeBound::BodyPoint NodeBound::body_point(int g, int run, double tau) const {
  const StraightRun& body = model_.runs[at(run)];
  const std::size_t f = frame(g, body.frame);
  // Without the heap: this is asked for many points of each box.
  std::array<Eigen::Vector3d, 16> columns;
  std::fill_n(columns.begin(), n_lengths_, Eigen::Vector3d::Zero());
  Eigen::Vector3d point =
      (1.0 - tau) * body.start.offset + tau * body.end.offset + (1.0 - 2.0 * tau) * body.radius * body.axis;
  for (const auto& term : body.start.terms) {
    point += (1.0 - tau) * middle_[at(term.parameter)] * term.direction;
    columns[at(term.parameter)] += (1.0 - tau) * term.direction;
  }
  for (const auto& term : body.end.terms) {
    point += tau * middle_[at(term.parameter)] * term.direction;
    columns[at(term.parameter)] += tau * term.direction;
  }
  const int acting = std::max(body.acting, model_.frames[at(body.frame)].acting);
  double reach = swing_[f] + point.norm() * greatest_chord(delta_[frame(g, acting)]);
  const double* stretch = stretch_.data() + f * at(n_lengths_);
  for (int k = 0; k < n_lengths_; ++k) reach += (stretch[k] + columns[at(k)].norm()) * half_[at(k)];
  return {origin_[f] + turn_[f] * point, reach};
}

void NodeBound::reach_shares(int g, int run, double tau, std::vector<double>& result) const {
  const StraightRun& body = model_.runs[at(run)];
  result.assign(middle_.size(), 0.0);
  const AffineVector point = point_of(body, tau);
  const double* stretch = stretch_.data() + frame(g, body.frame) * at(n_lengths_);
  for (int k = 0; k < n_lengths_; ++k) result[at(k)] = stretch[k] * half_[at(k)];
  for (const auto& term : point.terms) result[at(term.parameter)] += term.direction.norm() * half_[at(term.parameter)];
  for (int j = 0; j <= body.frame; ++j) {
    const bool last = j == body.frame;
    const AffineVector& piece = last ? point : model_.frames[at(j)].v;
    int acting = model_.frames[at(j)].acting;
    if (last) acting = std::max(acting, body.acting);
    Eigen::Vector3d sum = piece.offset;
    for (const auto& term : piece.terms) sum += middle_[at(term.parameter)] * term.direction;
    for (int v = 0; v < acting; ++v) {
      const std::size_t variable = at(n_lengths_ + g * n_joints_ + v);
      result[variable] += sum.norm() * half_[variable];
    }
  }
}

bool NodeBound::add_row(const Row& row) {
  const StraightRun& run = model_.runs[at(row.run)];
  if (!run.usable || too_short(row.run)) return false;
  const PlacedShape& shape = scenery_.obstacles[at(row.shape)];
  const BodyPoint point = body_point(row.goal, row.run, row.tau);
  Eigen::Vector3d normal;
  double beta = 0.0;
  if (row.ball) {
    const double R = row.radius + run.radius - kSlack;
    const double D = point.reach + 1e-12;
    normal = 2.0 * (point.x - row.centre);
    beta = R * R - D * D + point.x.squaredNorm() - row.centre.squaredNorm();
  } else {
    const auto* box = std::get_if<modsearch::Box>(&shape.shape);
    if (box == nullptr) return false;
    constexpr double kMargin = 1e-11;
    const int axis = row.face / 2;
    const double sign = row.face % 2 == 0 ? 1.0 : -1.0;
    const Eigen::Vector3d local = shape.X_FG.linear().transpose() * (point.x - shape.X_FG.translation());
    for (int k = 0; k < 3; ++k) {
      if (k != axis && !(std::abs(local[k]) + point.reach + kMargin <= 0.5 * box->size[k])) return false;
    }
    const double out = 0.5 * box->size[axis] + run.radius - kSlack;
    if (!(sign * local[axis] - point.reach > -out + kMargin)) return false;
    normal = sign * shape.X_FG.linear().col(axis);
    beta = normal.dot(shape.X_FG.translation()) + out;
  }
  grow(rows_, at(n_rows_ + 1));
  PlacedRow& placed = rows_[at(n_rows_)];
  placed.row = row;
  const double length = normal.norm();
  // A normal of no length says by its right-hand side alone whether the row can hold.
  placed.length = length > 1e-6 ? length : 1.0;
  placed.n = normal / placed.length;
  placed.beta = beta / placed.length;
  fill(placed.block, row.goal, run.frame, point_of(run, row.tau), run.acting);
  Group& group = groups_[frame(row.goal, run.frame)];
  group.rows.push_back(n_rows_);
  group.acting = std::max(group.acting, run.acting);
  group.delta = delta_[frame(row.goal, group.acting)];
  ++n_rows_;
  return true;
}

}  // namespace modsearch::certify
