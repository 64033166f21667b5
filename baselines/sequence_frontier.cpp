#include <algorithm>
#include <cstdint>
#include <limits>
#include <modsearch/baselines/lexicographic.hpp>
#include <modsearch/baselines/sequence_frontier.hpp>
#include <modsearch/problem/sequence_count.hpp>
#include <utility>

namespace modsearch {
namespace {

constexpr double kImpossible = -std::numeric_limits<double>::infinity();

}  // namespace

SequenceFrontier::SequenceFrontier(const DesignProblem& problem, std::size_t limit, std::vector<double> weights)
    : problem_{problem}, limit_{limit}, weights_{std::move(weights)} {
  for (int n = 1; n < problem.max_modules(); ++n) offer({.length = n}, problem.optimism_of_length(n), heap_);
  std::make_heap(heap_.begin(), heap_.end(), comes_later);
}

bool SequenceFrontier::comes_later(const Node& a, const Node& b) {
  if (a.bound != b.bound) return a.bound < b.bound;
  if (a.length != b.length) return a.length > b.length;
  if (a.types.size() != b.types.size()) return a.types.size() < b.types.size();
  return a.types > b.types;
}

void SequenceFrontier::offer(Node node, Optimism optimism, std::vector<Node>& to) {
  node.bound = optimism.score;
  if (node.bound > kImpossible) {
    to.push_back(std::move(node));
    return;
  }
  impossible_ = std::move(optimism.reason);
  if (weights_.empty()) return;
  left_out_ += count_designs(problem_.library(), node.types, node.length, weights_).complete;
}

SequenceFrontier::Node SequenceFrontier::take() {
  std::vector<Node>& from = dive_.empty() ? heap_ : dive_;
  if (dive_.empty()) std::pop_heap(heap_.begin(), heap_.end(), comes_later);
  Node node = std::move(from.back());
  from.pop_back();
  return node;
}

void SequenceFrontier::expand(const Node& node, bool diving) {
  std::vector<Node> children;
  for (const int k : problem_.successors(node.types)) {
    Node child = node;
    child.types.push_back(k);
    const bool whole = static_cast<int>(child.types.size()) == child.length;
    Optimism optimism = whole ? problem_.optimism(child.types) : problem_.optimism_of_prefix(child.types, child.length);
    offer(std::move(child), std::move(optimism), children);
  }
  if (diving) {
    std::sort(children.begin(), children.end(), comes_later);
    std::move(children.begin(), children.end(), std::back_inserter(dive_));
    return;
  }
  for (Node& child : children) {
    heap_.push_back(std::move(child));
    std::push_heap(heap_.begin(), heap_.end(), comes_later);
  }
}

std::optional<SequenceFrontier::Sequence> SequenceFrontier::next(const Meter& meter) {
  constexpr int kExpansions = 4096;
  const double least = score_to_beat(meter);
  for (int i = 0; i < kExpansions && !exhausted(); ++i) {
    const bool diving = !dive_.empty() || heap_.size() >= limit_;
    Node node = take();
    if (node.bound <= least) {
      if (!diving) heap_.clear();  // nothing that waits there is worth more
      continue;
    }
    if (static_cast<int>(node.types.size()) == node.length) return Sequence{std::move(node.types), node.bound};
    expand(node, diving);
  }
  return std::nullopt;
}

double SequenceFrontier::bound() const {
  double bound = heap_.empty() ? kImpossible : heap_.front().bound;
  for (const Node& node : dive_) bound = std::max(bound, node.bound);
  return bound;
}

void SequenceFrontier::save(Archive& archive) const {
  std::vector<double> bounds;
  std::vector<std::int64_t> numbers;  // per node: length, number of types, types
  for (const std::vector<Node>* nodes : {&heap_, &dive_}) {
    for (const Node& node : *nodes) {
      bounds.push_back(node.bound);
      numbers.push_back(node.length);
      numbers.push_back(static_cast<std::int64_t>(node.types.size()));
      numbers.insert(numbers.end(), node.types.begin(), node.types.end());
    }
  }
  archive.put_integer("frontier/diving", static_cast<std::int64_t>(dive_.size()));
  archive.put("frontier/bounds", std::span<const double>{bounds});
  archive.put("frontier/sequences", std::span<const std::int64_t>{numbers});
  archive.put_text("frontier/impossible", impossible_);
  archive.put_number("frontier/left out", left_out_);
}

void SequenceFrontier::restore(const Archive& archive) {
  const std::vector<double> bounds = archive.numbers("frontier/bounds");
  const std::vector<std::int64_t> numbers = archive.integers("frontier/sequences");
  std::size_t at = 0;
  const auto number = [&](std::int64_t most) {
    if (at == numbers.size() || numbers[at] < 0 || numbers[at] > most) {
      archive.fail("frontier/sequences", "is not a list of type sequences of this problem");
    }
    return static_cast<int>(numbers[at++]);
  };
  std::vector<Node> nodes;
  for (const double bound : bounds) {
    Node node{.bound = bound, .length = number(problem_.max_modules() - 1)};
    node.types.resize(static_cast<std::size_t>(number(node.length)));
    for (int& k : node.types) k = number(problem_.library().n_types() - 1);
    nodes.push_back(std::move(node));
  }
  const std::int64_t diving = archive.integer("frontier/diving");
  if (at != numbers.size() || diving < 0 || diving > static_cast<std::int64_t>(nodes.size())) {
    archive.fail("frontier/sequences", "does not fit its bounds");
  }
  dive_.assign(std::make_move_iterator(nodes.end() - diving), std::make_move_iterator(nodes.end()));
  nodes.resize(nodes.size() - static_cast<std::size_t>(diving));
  heap_ = std::move(nodes);
  std::make_heap(heap_.begin(), heap_.end(), comes_later);
  impossible_ = archive.text("frontier/impossible");
  left_out_ = archive.number("frontier/left out");
}

}  // namespace modsearch
