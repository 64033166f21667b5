#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <limits>
#include <map>
#include <modsearch/baselines/certify/sequence_tree_internal.hpp>
#include <modsearch/baselines/certify/twins_internal.hpp>
#include <utility>

namespace modsearch::certify {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

}  // namespace

SequenceTree::SequenceTree(const RobotProblem& problem, const Scenery& scenery, std::span<const int> types,
                           bool recorded)
    : n_goals_{static_cast<int>(scenery.targets.size())},
      model_{std::make_unique<SequenceModel>(problem, types)},
      prover_{std::make_unique<NodeProver>(*model_, scenery)} {
  if (!recorded) return;
  record_.emplace();
  for (const int variable : half_circles(*model_, n_goals_)) record_->halve(variable);
}

bool SequenceTree::comes_later(const Node& a, const Node& b) {
  if (a.bound != b.bound) return a.bound > b.bound;
  return a.number > b.number;
}

double SequenceTree::least_mass() const {
  return nodes_.empty() ? std::numeric_limits<double>::infinity() : nodes_.front().bound;
}

void SequenceTree::offer(Box box, Multipliers multipliers, double bound, double cut, std::size_t place) {
  std::vector<std::vector<CutOff>> rounds;
  const Verdict verdict = prover_->prove(box, multipliers, cut, record_ ? &rounds : nullptr);
  for (const std::vector<CutOff>& cuts : rounds) record_->cut_off(place, cuts);
  if (verdict.closed) {
    if (record_) record_->close(place, verdict.leaf);
    return;
  }
  nodes_.push_back({std::max(bound, verdict.bound), numbered_++, verdict.split, verdict.at, std::move(box),
                    std::move(multipliers), place});
  std::push_heap(nodes_.begin(), nodes_.end(), comes_later);
}

void SequenceTree::open(double cut) {
  offer(box_without_twins(*model_, n_goals_), prover_->first_multipliers(), -std::numeric_limits<double>::infinity(),
        cut, TreeRecord::kRoot);
}

bool SequenceTree::expand(double cut) {
  if (nodes_.empty() || nodes_.front().split < 0) return false;
  std::pop_heap(nodes_.begin(), nodes_.end(), comes_later);
  Node node = std::move(nodes_.back());
  nodes_.pop_back();
  ++expanded_;
  const std::size_t halves = record_ ? record_->split(node.place, node.split, node.at) : TreeRecord::kRoot;
  Box below = node.box;
  below.upper[at(node.split)] = node.at;
  offer(std::move(below), node.multipliers, node.bound, cut, halves);
  node.box.lower[at(node.split)] = node.at;
  offer(std::move(node.box), std::move(node.multipliers), node.bound, cut, halves + 1);
  return true;
}

ProofOutcome SequenceTree::proof(double cut, const std::function<bool()>& stop) {
  std::map<std::size_t, const Node*> open;
  for (const Node& node : nodes_) open[node.place] = &node;
  ProofOutcome outcome;
  TreeText text;
  TreeRecord::Walk walk{record_.value()};
  outcome.whole = true;
  while (outcome.whole && walk.next(text)) {
    const Node& node = *open.at(walk.place());
    outcome.whole = close_box(*prover_, node.box, node.multipliers, cut, stop, text, outcome);
  }
  outcome.nodes = "[" + text.nodes() + "]";
  outcome.leaves = text.leaves();
  return outcome;
}

Eigen::VectorXd SequenceTree::middle() const {
  const Box& box = nodes_.front().box;
  const int n_lengths = model_->n_lengths();
  std::vector<double> lengths;
  for (int k = 0; k < n_lengths; ++k) lengths.push_back(0.5 * (box.lower[at(k)] + box.upper[at(k)]));
  const Eigen::VectorXd x = model_->parameters(lengths);
  Eigen::VectorXd v(x.size() + box.size() - n_lengths);
  v.head(x.size()) = x;
  for (int i = n_lengths; i < box.size(); ++i) {
    v[x.size() + i - n_lengths] = 0.5 * (box.lower[at(i)] + box.upper[at(i)]);
  }
  return v;
}

std::string SequenceTree::description() const {
  if (nodes_.empty()) return "nothing is open";
  const Node& node = nodes_.front();
  std::string text =
      fmt::format("bound {:.6f} kg, {} open, cut {} at {:.4f}; y", node.bound, nodes_.size(), node.split, node.at);
  for (const Eigen::Vector3d& y : node.multipliers.y) text += fmt::format(" ({:.3f} {:.3f} {:.3f})", y[0], y[1], y[2]);
  for (const Row& row : node.multipliers.rows) {
    text += fmt::format("; row run {} at {:.2f} shape {} {} mu {:.3f}", row.run, row.tau, row.shape,
                        row.ball ? "ball" : "face", row.multiplier);
  }
  for (int v = 0; v < node.box.size(); ++v) {
    text += fmt::format("\n    {}: [{:.5f}, {:.5f}] {:.2e}", v, node.box.lower[at(v)], node.box.upper[at(v)],
                        node.box.width(v));
  }
  return text;
}

// Per node: bound, number, split, at, cap, lower, upper, y, number of rows, rows of 11 numbers.
void SequenceTree::save(Archive& archive, const std::string& name) const {
  std::vector<double> numbers;
  for (const Node& node : nodes_) {
    numbers.insert(numbers.end(), {node.bound, static_cast<double>(node.number), static_cast<double>(node.split),
                                   node.at, node.multipliers.cap ? 1.0 : 0.0});
    numbers.insert(numbers.end(), node.box.lower.begin(), node.box.lower.end());
    numbers.insert(numbers.end(), node.box.upper.begin(), node.box.upper.end());
    for (const Eigen::Vector3d& y : node.multipliers.y) numbers.insert(numbers.end(), y.begin(), y.end());
    numbers.push_back(static_cast<double>(node.multipliers.rows.size()));
    for (const Row& row : node.multipliers.rows) {
      numbers.insert(numbers.end(),
                     {static_cast<double>(row.goal), static_cast<double>(row.run), row.tau,
                      static_cast<double>(row.shape), row.ball ? 1.0 : 0.0, row.centre.x(), row.centre.y(),
                      row.centre.z(), row.radius, static_cast<double>(row.face), row.multiplier});
    }
  }
  archive.put(name + "/nodes", std::span<const double>{numbers});
  archive.put(name + "/counts",
              std::array<std::int64_t, 3>{static_cast<std::int64_t>(nodes_.size()), numbered_, expanded_});
}

void SequenceTree::restore(const Archive& archive, const std::string& name) {
  const std::vector<double> numbers = archive.numbers(name + "/nodes");
  const std::vector<std::int64_t> counts = archive.integers(name + "/counts");
  std::size_t next = 0;
  const auto refuse = [&] { archive.fail(name + "/nodes", "is not a list of boxes of this problem"); };
  const auto number = [&] {
    if (next == numbers.size()) refuse();
    return numbers[next++];
  };
  const auto whole = [&](std::size_t count) {
    const double value = number();
    if (!(value >= 0.0 && value < static_cast<double>(count))) refuse();
    return static_cast<int>(value);
  };
  if (counts.size() != 3 || counts[0] < 0) refuse();
  const Box root = root_box(*model_, n_goals_);
  nodes_.clear();
  record_.reset();
  for (std::int64_t i = 0; i < counts[0]; ++i) {
    Node node;
    node.bound = number();
    node.number = static_cast<std::int64_t>(number());
    const double split = number();
    node.split = split >= 0.0 && split < static_cast<double>(root.size()) ? static_cast<int>(split) : -1;
    node.at = number();
    node.multipliers.cap = number() != 0.0;
    for (std::vector<double>* ends : {&node.box.lower, &node.box.upper}) {
      for (int v = 0; v < root.size(); ++v) ends->push_back(number());
    }
    for (int g = 0; g < n_goals_; ++g) {
      const double x = number(), y = number(), z = number();
      node.multipliers.y.emplace_back(x, y, z);
    }
    for (int rows = whole(1000); rows > 0; --rows) {
      Row row;
      row.goal = whole(at(n_goals_));
      row.run = whole(model_->runs.size());
      row.tau = number();
      row.shape = whole(1'000'000);
      row.ball = number() != 0.0;
      for (int axis = 0; axis < 3; ++axis) row.centre[axis] = number();
      row.radius = number();
      row.face = whole(6);
      row.multiplier = number();
      node.multipliers.rows.push_back(row);
    }
    nodes_.push_back(std::move(node));
  }
  if (next != numbers.size()) refuse();
  numbered_ = counts[1];
  expanded_ = counts[2];
}

}  // namespace modsearch::certify
