#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <modsearch/baselines/design_tree_internal.hpp>
#include <modsearch/solvers/search.hpp>
#include <utility>

namespace modsearch {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

}  // namespace

void ValueScale::see(const Rank& rank) {
  if (!std::isfinite(rank.score)) return;
  Range& range = scores_[static_cast<std::size_t>(rank.level)];
  range.least = std::min(range.least, rank.score);
  range.greatest = std::max(range.greatest, rank.score);
}

double ValueScale::value(const Rank& rank) const {
  const Range& range = scores_[static_cast<std::size_t>(rank.level)];
  const double by_score = range.greatest > range.least
                              ? std::clamp((rank.score - range.least) / (range.greatest - range.least), 0.0, 1.0)
                              : 1.0;
  const auto within = [&](double from, double to, double far) {
    return from + (to - from) * (0.9 * far + 0.1 * by_score);
  };
  switch (rank.level) {
    case Rank::Level::kHopeless:
    case Rank::Level::kFailed:
      return 0.0;
    case Rank::Level::kIncomplete:
      return 0.09 * by_score;
    case Rank::Level::kMisses:
      return within(0.1, 0.39, std::exp(rank.within));  // e^-1 where the error is the distance of the target
    case Rank::Level::kCollides:
      return within(0.4, 0.49, std::exp(10.0 * rank.within));  // e^-1 where bodies overlap by 10 cm
    case Rank::Level::kNoPath:
      return 0.5 + 0.09 * by_score;
    case Rank::Level::kAchieved:
      return 0.6 + 0.4 * by_score;
  }
  return 0.0;
}

void ValueScale::save(Archive& archive) const {
  std::vector<double> numbers;
  for (const Range& range : scores_) numbers.insert(numbers.end(), {range.least, range.greatest});
  archive.put("tree/scores", std::span<const double>{numbers});
}

void ValueScale::restore(const Archive& archive) {
  const std::vector<double> numbers = archive.numbers("tree/scores");
  if (numbers.size() != 2 * kLevels) archive.fail("tree/scores", fmt::format("does not hold {} numbers", 2 * kLevels));
  for (std::size_t i = 0; i < kLevels; ++i) scores_[i] = {numbers[2 * i], numbers[2 * i + 1]};
}

DesignTree::DesignTree(const DesignProblem& problem) : problem_{problem}, nodes_(1) {}

Design DesignTree::design(int i) const {
  Design design;
  for (int at = i; at != 0; at = node(at).parent) design.modules.push_back(node(at).placement);
  std::reverse(design.modules.begin(), design.modules.end());
  return design;
}

void DesignTree::expand(int i) {
  if (std::exchange(node(i).expanded, true)) return;
  std::vector<int> types = design(i).types();
  for (const int k : problem_.successors(types)) {
    types.push_back(k);
    Branch branch{.type = k, .own_bound = problem_.optimism(types).score, .deeper_bound = -kInfinity};
    for (int n = static_cast<int>(types.size()) + 1; n < problem_.max_modules(); ++n) {
      branch.deeper_bound = std::max(branch.deeper_bound, problem_.optimism_of_prefix(types, n).score);
    }
    node(i).branches.push_back(std::move(branch));
    types.pop_back();
  }
}

int DesignTree::add(int parent, std::size_t b, Placement placement) {
  const int i = static_cast<int>(nodes_.size());
  nodes_.push_back({.parent = parent, .placement = std::move(placement), .own = {}, .best = {}});
  node(parent).branches[b].children.push_back(i);
  return i;
}

void DesignTree::back_up(int i, const Rank& found) {
  for (int at = i; at >= 0; at = node(at).parent) {
    ++node(at).visits;
    node(at).best = std::max(node(at).best, found);
    if (at == 0) return;
    std::vector<Branch>& branches = node(node(at).parent).branches;
    std::find_if(branches.begin(), branches.end(), [&](const Branch& branch) {
      return branch.type == node(at).placement.type;
    })->visits += 1;
  }
}

void DesignTree::save(Archive& archive) const {
  std::vector<std::int64_t> numbers;  // per node: parent, type, visits, finished, expanded, levels of both ranks
  std::vector<double> ranks;          // per node: within and score of both ranks
  std::vector<double> parameters;     // of all modules, one node after the other
  for (const Node& each : nodes_) {
    numbers.insert(numbers.end(),
                   {each.parent, each.placement.type, each.visits, each.finished ? 1 : 0, each.expanded ? 1 : 0,
                    static_cast<std::int64_t>(each.own.level), static_cast<std::int64_t>(each.best.level)});
    ranks.insert(ranks.end(), {each.own.within, each.own.score, each.best.within, each.best.score});
    parameters.insert(parameters.end(), each.placement.parameters.begin(), each.placement.parameters.end());
  }
  archive.put("tree/nodes", std::span<const std::int64_t>{numbers});
  archive.put("tree/ranks", std::span<const double>{ranks});
  archive.put("tree/parameters", std::span<const double>{parameters});
}

void DesignTree::restore(const Archive& archive) {
  constexpr std::size_t kRow = 7;
  constexpr std::int64_t kMostVisits = std::int64_t{1} << 40U;  // a million seconds of them; sums of these are numbers
  const std::vector<std::int64_t> numbers = archive.integers("tree/nodes");
  const std::vector<double> ranks = archive.numbers("tree/ranks");
  const std::vector<double> parameters = archive.numbers("tree/parameters");
  const auto check = [&](bool right) {
    if (!right) archive.fail("tree/nodes", "is not a tree of designs of this problem");
  };
  const std::size_t n = numbers.size() / kRow;
  check(n > 0 && numbers.size() == kRow * n && ranks.size() == 4 * n);
  std::size_t next_parameter = 0;
  nodes_.assign(1, {});
  for (std::size_t i = 0; i < n; ++i) {
    const std::int64_t* const row = &numbers[kRow * i];
    check(row[2] >= 0 && row[2] <= kMostVisits);
    if (i > 0) {
      check(row[0] >= 0 && row[0] < static_cast<std::int64_t>(i));
      const int parent = static_cast<int>(row[0]);
      expand(parent);
      std::vector<Branch>& branches = node(parent).branches;
      const auto branch =
          std::find_if(branches.begin(), branches.end(), [&](const Branch& each) { return each.type == row[1]; });
      check(branch != branches.end());
      branch->visits += row[2];
      Placement placement{branch->type, Parameters(problem_.library().type(branch->type).n_parameters())};
      for (double& value : placement.parameters) {
        check(next_parameter < parameters.size());
        value = parameters[next_parameter++];
      }
      add(parent, static_cast<std::size_t>(branch - branches.begin()), std::move(placement));
    }
    Node& each = nodes_[i];
    each.visits = row[2];
    each.finished = row[3] != 0;
    each.own = restored_rank(archive, "tree/nodes", row[5], ranks[4 * i], ranks[4 * i + 1]);
    each.best = restored_rank(archive, "tree/nodes", row[6], ranks[4 * i + 2], ranks[4 * i + 3]);
    if (row[4] != 0) expand(static_cast<int>(i));
  }
}

}  // namespace modsearch
