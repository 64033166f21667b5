#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <modsearch/baselines/certify/node_bound_internal.hpp>

namespace modsearch::certify {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
// Beyond this an angle counts as any angle: as the checker has it.
constexpr double kHalfTurn = 3.14;

std::size_t at(int i) { return static_cast<std::size_t>(i); }
int pair_of(int v, int w) { return w * (w + 1) / 2 + v; }  // v <= w
int n_pairs(int acting) { return acting * (acting + 1) / 2; }

// Largest |R b - R' b| / |b| for rotations at most `delta` apart.
double greatest_chord(double delta) { return delta >= kHalfTurn ? 2.0 : 2.0 * std::sin(0.5 * delta); }

Eigen::Vector3d unit_or_zero(const Eigen::Vector3d& a) {
  const double length = a.norm();
  return length > 0.0 ? Eigen::Vector3d{a / length} : Eigen::Vector3d{Eigen::Vector3d::Zero()};
}

template <typename T>
void grow(std::vector<T>& vector, std::size_t size) {
  if (vector.size() < size) vector.resize(size);
}

}  // namespace

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

double NodeBound::form_at(const double* form, std::size_t corner) const {
  const auto stride = at(n_lengths_ + 1);
  const double* z = &corners_[corner * stride];
  double value = 0.0;
  for (std::size_t i = 0; i < stride; ++i) value += form[i] * z[i];
  return value;
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
  std::array<double, 16> columns{};
  Eigen::Vector3d point =
      (1.0 - tau) * body.start.offset + tau * body.end.offset + (1.0 - 2.0 * tau) * body.radius * body.axis;
  for (const auto& term : body.start.terms) {
    point += (1.0 - tau) * middle_[at(term.parameter)] * term.direction;
    columns[at(term.parameter)] += (1.0 - tau) * term.direction.dot(body.axis);
  }
  for (const auto& term : body.end.terms) {
    point += tau * middle_[at(term.parameter)] * term.direction;
    columns[at(term.parameter)] += tau * term.direction.dot(body.axis);
  }
  const int acting = std::max(body.acting, model_.frames[at(body.frame)].acting);
  double reach = swing_[f] + point.norm() * greatest_chord(delta_[frame(g, acting)]);
  const double* stretch = stretch_.data() + f * at(n_lengths_);
  for (int k = 0; k < n_lengths_; ++k) reach += (stretch[k] + std::abs(columns[at(k)])) * half_[at(k)];
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
  if (gradient == nullptr) return bound;

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
