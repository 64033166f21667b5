#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <map>
#include <modsearch/baselines/certify/node_prover_internal.hpp>
#include <string>

namespace modsearch::certify {
namespace {

constexpr int kMostRows = 3;        // new ones in a box; those of the box around stay
constexpr int kRounds = 3;          // of ascent and contraction in one box
constexpr int kMoreSteps = 25;      // of ascent, where the multipliers are to blame
constexpr double kUnchanged = 0.8;  // share of a box that is left and not worth another round
constexpr double kExplained = 0.5;  // share of what is missing that the width of a box has to explain
// Less than this share of what is missing, and no body point that moves: no smaller box will do either, because bodies
// count as a radius shorter at their flat ends than they are.
constexpr double kHopeless = 0.01;
constexpr double kWeightOfRows = 3;    // multiplier that a row without one is taken to get [kg/m]
constexpr double kWeightOfGoals = 1;   // least length of a goal's multiplier where boxes are cut [kg/m]
constexpr double kWorthwhile = 0.1;    // least share of an interval that is cut off
constexpr double kShortOfAll = 0.999;  // share of what the chord cuts off: rounding has to have room
constexpr double kNarrow = 1e-9;       // intervals that are not cut any more

std::size_t at(int i) { return static_cast<std::size_t>(i); }

}  // namespace

NodeProver::NodeProver(const SequenceModel& model, const Scenery& scenery)
    : model_{model}, scenery_{scenery}, bound_{model, scenery}, written_bound_{model, scenery} {}

Multipliers NodeProver::first_multipliers() const {
  // One kilogram per metre towards the goals, shared among them.
  Multipliers multipliers;
  for (const Target& target : scenery_.targets) {
    const double length = target.position.norm();
    multipliers.y.push_back(target.position / (std::max(length, 1e-9) * static_cast<double>(scenery_.targets.size())));
  }
  return multipliers;
}

double NodeProver::target(const Box& box, double cut) const {
  // What weighs more than any design in the box is not there.
  return std::min(cut, greatest_mass(model_, box) + 1e-5);
}

void NodeProver::load(NodeBound& bound, const Box& box, const Multipliers& multipliers,
                      std::vector<double>& values) const {
  bound.set_box(box);
  values.clear();
  for (const Eigen::Vector3d& y : multipliers.y) values.insert(values.end(), y.begin(), y.end());
  for (const Row& row : multipliers.rows) {
    if (row.multiplier > 0.0 && bound.add_row(row)) values.push_back(row.multiplier);
  }
}

void NodeProver::store(const std::vector<double>& values, bool cap, Multipliers& multipliers) const {
  for (std::size_t g = 0; g < multipliers.y.size(); ++g) {
    multipliers.y[g] = Eigen::Vector3d{values[3 * g], values[3 * g + 1], values[3 * g + 2]};
  }
  multipliers.cap = cap;
  multipliers.rows.clear();
  for (int r = 0; r < bound_.n_rows(); ++r) {
    Row row = bound_.row(r);
    row.multiplier = values[3 * multipliers.y.size() + at(r)];
    if (row.multiplier > 1e-9) multipliers.rows.push_back(row);
  }
}

bool NodeProver::closes(const Box& box, const Multipliers& multipliers, double cut, Objective objective,
                        ClosedLeaf& leaf) {
  load(written_bound_, box, multipliers, written_values_);
  const double value = written_bound_.value(written_values_.data(), multipliers.cap, objective, nullptr);
  leaf.kind = objective;
  if (objective == Objective::kNothing) {
    if (!(value > 1e-8)) return false;
  } else if (!(value >= target(box, cut))) {
    return false;
  } else if (!(value >= cut)) {
    leaf.kind = Objective::kNothing;
    if (!(written_bound_.value(written_values_.data(), multipliers.cap, Objective::kNothing, nullptr) > 1e-8))
      return false;
  }
  write(multipliers, leaf.kind, leaf);
  return true;
}

// The multipliers that `written_bound_` was loaded with.
void NodeProver::write(const Multipliers& multipliers, Objective objective, ClosedLeaf& leaf) const {
  leaf.kind = objective;
  leaf.multipliers.y = multipliers.y;
  leaf.multipliers.cap = multipliers.cap;
  leaf.multipliers.rows.clear();
  for (int r = 0; r < written_bound_.n_rows(); ++r) {
    leaf.multipliers.rows.push_back(written_bound_.row(r));
    // As the certificate has it: of the normal that is not scaled.
    leaf.multipliers.rows.back().multiplier =
        written_values_[3 * multipliers.y.size() + at(r)] / written_bound_.normal_length(r);
  }
}

double NodeProver::contract(Box& box, const Multipliers& multipliers, double cut, double wanted, Objective objective,
                            std::vector<CutOff>* cuts) {
  double left = 1.0;
  const int n = multipliers.cap ? model_.n_lengths() : box.size();
  // What is heavier than all that is in the box is written down as what is not there.
  const Objective written = objective == Objective::kMass && wanted >= cut ? Objective::kMass : Objective::kNothing;
  const double enough = written == Objective::kMass ? cut : 1e-8;
  std::optional<CutOff> group;
  for (int v = 0; v < n; ++v) {
    const double width = bound_.box().width(v);
    if (width < kNarrow) continue;
    const NodeBound::Ends ends = bound_.ends(v);
    const bool above = ends.upper > ends.lower;
    const double most = std::max(ends.lower, ends.upper);
    const double least = std::min(ends.lower, ends.upper);
    if (!(most >= wanted) || !(most > least)) continue;
    const double share = std::min(1.0, (most - wanted) / (most - least));
    if (share < kWorthwhile) continue;
    const double part = kShortOfAll * share;
    const double place = above ? bound_.box().upper[at(v)] - part * width : bound_.box().lower[at(v)] + part * width;
    if (!(place > box.lower[at(v)] && place < box.upper[at(v)])) continue;
    if (cuts != nullptr) {
      if (!group) {
        group.emplace();
        load(written_bound_, bound_.box(), multipliers, written_values_);
        written_bound_.value(written_values_.data(), multipliers.cap, written, nullptr);
        write(multipliers, written, group->leaf);
      }
      const NodeBound::Ends there = written_bound_.ends(v);
      const double end = above ? there.upper : there.lower;
      if (!(end >= enough && end - part * std::abs(there.upper - there.lower) >= enough)) continue;
      group->parts.push_back({v, place, above});
    }
    const double before = box.width(v);
    (above ? box.upper : box.lower)[at(v)] = place;
    left *= box.width(v) / before;
  }
  if (group && !group->parts.empty()) cuts->push_back(std::move(*group));
  return left;
}

double NodeProver::contract_by_reach(Box& box, double cut, std::vector<CutOff>* cuts) {
  double left = 1.0;
  const int n_goals = static_cast<int>(scenery_.targets.size());
  const int K = model_.n_lengths();
  const int J = model_.n_joints();
  Multipliers multipliers;
  bound_.clear_rows();
  for (int g = 0; g < n_goals; ++g) {
    // The row that sees as little as possible of all variables but one: weighted least squares.
    Eigen::Matrix3d S = Eigen::Matrix3d::Identity() * 1e-9;
    std::array<Eigen::Vector3d, 32> columns;
    std::array<int, 32> variables{};
    int n = 0;
    for (int i = 0; i < K + J; ++i) {
      const int v = i < K ? i : K + g * J + (i - K);
      const double half = 0.5 * bound_.box().width(v);
      if (half < kNarrow) continue;
      columns[at(n)] = half * bound_.tip_derivative(g, v);
      S += columns[at(n)] * columns[at(n)].transpose();
      variables[at(n++)] = v;
    }
    const Eigen::Matrix3d inverse = S.inverse();
    for (int i = 0; i < n; ++i) {
      Eigen::Vector3d y = inverse * columns[at(i)];
      const double length = y.norm();
      if (!(length > 0.0) || !std::isfinite(length)) continue;
      y /= length;
      const double own = std::abs(y.dot(columns[at(i)]));
      double others = scenery_.targets[at(g)].radius;
      for (int k = 0; k < n; ++k) others += k == i ? 0.0 : std::abs(y.dot(columns[at(k)]));
      // To first order the variable lies within (off +- others) / own of its half-width.
      const double off = std::abs(y.dot(scenery_.targets[at(g)].position - bound_.tip(g)));
      if (off < others - (1.0 - 2.0 * kWorthwhile) * own) continue;
      for (const double sign : {1.0, -1.0}) {
        multipliers.y.assign(at(n_goals), Eigen::Vector3d::Zero());
        multipliers.y[at(g)] = sign * y;
        values_.assign(at(3 * n_goals), 0.0);
        for (int k = 0; k < 3; ++k) values_[at(3 * g + k)] = sign * y[k];
        bound_.value(values_.data(), false, Objective::kNothing, nullptr);
        left *= contract(box, multipliers, cut, 1e-7, Objective::kNothing, cuts);
      }
    }
  }
  return left;
}

double NodeProver::choose_split(const Box& box, const std::vector<double>& values, Verdict& verdict) {
  bound_.value(values.data(), false, Objective::kMass, nullptr);
  bound_.losses(values.data(), losses_);
  // A row that has no multiplier yet may get one where the body point can move less: what it loses now, as if it had.
  // A face loses nothing, with or without: without this, boxes on a wall get narrow in the angles and never in the
  // lengths.
  for (std::size_t c = 0; c < std::min(candidates_.size(), at(kMostRows)); ++c) {
    const RowCandidate& candidate = candidates_[c];
    if (candidate.row.multiplier > 0.0 && candidate.row.ball) continue;
    bound_.reach_shares(candidate.row.goal, candidate.row.run, candidate.row.tau, shares_);
    double sum = 0.0;
    for (const double share : shares_) sum += share;
    if (!(sum > 0.0)) continue;
    const double near = std::clamp(1.0 + candidate.cut / sum, 0.0, 1.0);
    const double lost = kWeightOfRows * near * std::min(sum, candidate.blunt);
    for (std::size_t v = 0; v < shares_.size(); ++v) losses_[v] += lost * shares_[v] / sum;
  }
  // Nor does a goal lose anything that has no multiplier: it may get one where its posture is better known.
  const int n_goals = static_cast<int>(scenery_.targets.size());
  for (int g = 0; g < n_goals; ++g) {
    const double weight = kWeightOfGoals - Eigen::Vector3d{&values[at(3 * g)]}.norm();
    if (weight <= 0.0) continue;
    const int first = model_.n_lengths() + g * model_.n_joints();
    double turn = 0.0;
    for (int v = first; v < first + model_.n_joints(); ++v) turn += 0.5 * box.width(v);
    for (int v = first; v < first + model_.n_joints(); ++v) {
      losses_[at(v)] += 0.25 * weight * box.width(v) * turn * bound_.tip_derivative(g, v).norm();
    }
  }
  int best = -1;
  double sum = 0.0;
  for (int v = 0; v < box.size(); ++v) {
    if (box.width(v) < kNarrow) continue;
    sum += losses_[at(v)];
    if (best < 0 || losses_[at(v)] > losses_[at(best)]) best = v;
  }
  verdict.split = best;
  if (best >= 0) verdict.at = 0.5 * (box.lower[at(best)] + box.upper[at(best)]);
  return sum;
}

// Where the bound has not lost what is missing, the arm that it believes in is one that collides, somewhere else than
// at the middle: the box is cut where it lets the body points move most.
void NodeProver::split_for_rows(const Box& box, bool hopeless, Verdict& verdict) {
  constexpr double kSharp = 1e-4;  // points that move less [m] are as good as held
  // Wider boxes are not given up [m], [rad]: a design may still be found in them, or a row close them.
  constexpr double kSmall = 5e-5;
  double most = kSharp;
  double widest = 0.0;
  for (int v = 0; v < box.size(); ++v) widest = std::max(widest, box.width(v));
  if (hopeless && !candidates_.empty() && widest < kSmall) verdict.split = -1;
  for (const RowCandidate& candidate : candidates_) {
    bound_.reach_shares(candidate.row.goal, candidate.row.run, candidate.row.tau, shares_);
    for (int v = 0; v < box.size(); ++v) {
      if (box.width(v) < kNarrow || shares_[at(v)] <= most) continue;
      most = shares_[at(v)];
      verdict.split = v;
    }
  }
}

Verdict NodeProver::prove(Box& box, Multipliers& multipliers, double cut, std::vector<std::vector<CutOff>>* rounds) {
  const int n_goals = static_cast<int>(scenery_.targets.size());
  Verdict verdict;
  verdict.bound = least_mass(model_, box);
  for (int round = 0; round < kRounds; ++round) {
    bound_.set_box(box);
    find_rows(bound_, model_, scenery_, multipliers.rows, candidates_);
    if (!candidates_.empty() && candidates_.front().inside) {
      Multipliers alone;
      alone.y.assign(scenery_.targets.size(), Eigen::Vector3d::Zero());
      alone.rows.push_back(candidates_.front().row);
      alone.rows.front().multiplier = 1.0;
      for (const bool cap : {true, false}) {
        alone.cap = cap;
        if (!closes(box, alone, cut, Objective::kNothing, verdict.leaf)) continue;
        verdict.closed = true;
        return verdict;
      }
    }
    values_.clear();
    for (const Eigen::Vector3d& y : multipliers.y) values_.insert(values_.end(), y.begin(), y.end());
    int kept = 0;
    for (const RowCandidate& candidate : candidates_) {
      if (kept >= kMostRows && candidate.row.multiplier <= 0.0) continue;
      if (!bound_.add_row(candidate.row)) continue;
      values_.push_back(candidate.row.multiplier);
      ++kept;
    }
    const double wanted = target(box, cut);
    double widest = 0.0;
    for (int v = model_.n_lengths(); v < box.size(); ++v) widest = std::max(widest, box.width(v));
    bool cap = false;
    if (widest > 0.5) {
      const double second = bound_.value(values_.data(), false, Objective::kMass, nullptr);
      cap = bound_.value(values_.data(), true, Objective::kMass, nullptr) > second;
    }
    const int steps = bound_.n_rows() > 0 ? 8 + 4 * n_goals : 6 * n_goals;
    double value = ascent_.climb(bound_, cap, wanted, steps, values_);
    verdict.bound = std::max(verdict.bound, value);
    store(values_, cap, multipliers);
    if (value >= wanted && closes(box, multipliers, cut, Objective::kMass, verdict.leaf)) {
      verdict.closed = true;
      return verdict;
    }
    // The split is that of the box as it is now, unless parts are cut off it.
    double lost = choose_split(box, values_, verdict);
    if (lost < kExplained * (wanted - value)) {
      // More is missing than the box can have lost: the multipliers are not the best yet.
      value = ascent_.climb(bound_, cap, wanted, kMoreSteps, values_);
      verdict.bound = std::max(verdict.bound, value);
      store(values_, cap, multipliers);
      if (value >= wanted && closes(box, multipliers, cut, Objective::kMass, verdict.leaf)) {
        verdict.closed = true;
        return verdict;
      }
      lost = choose_split(box, values_, verdict);
      if (lost < kExplained * (wanted - value)) split_for_rows(box, lost < kHopeless * (wanted - value), verdict);
    }
    if (cap) bound_.value(values_.data(), true, Objective::kMass, nullptr);
    std::vector<CutOff>* cuts = rounds != nullptr ? &rounds->emplace_back() : nullptr;
    double left = contract(box, multipliers, cut, wanted, Objective::kMass, cuts);
    if (!cap || widest < 2.0) left *= contract_by_reach(box, cut, cuts);
    if (left > kUnchanged) break;
  }
  if (verdict.split >= 0) {
    verdict.at = 0.5 * (box.lower[at(verdict.split)] + box.upper[at(verdict.split)]);
    if (box.width(verdict.split) < kNarrow) verdict.split = -1;
  }
  return verdict;
}

}  // namespace modsearch::certify
