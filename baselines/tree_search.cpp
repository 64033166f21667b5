#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <modsearch/baselines/design_tree_internal.hpp>
#include <modsearch/baselines/memetic_polish.hpp>
#include <modsearch/baselines/random_search.hpp>
#include <modsearch/baselines/tree_search.hpp>
#include <stdexcept>

namespace modsearch {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

class TreeSearching final : public Search {
 public:
  TreeSearching(const TreeSearchOptions& options, const DesignProblem& problem, Rng rng)
      : options_{options}, problem_{problem}, rng_{rng}, tree_{problem} {}

  std::optional<SearchEnd> step(Meter& meter) override {
    if (!begun_) {
      if (!meter.evaluate(problem_, Design{})) return SearchEnd{};
      if (std::optional<SearchEnd> end = pointless(meter, problem_)) return end;
      begun_ = true;
    }
    constexpr int kBatch = 32;  // descents between two places where the search can be taken up: arbitrary
    for (int i = 0; i < kBatch; ++i) {
      if (tree_.node(0).finished) return end(meter);
      if (!descend(meter)) return SearchEnd{};
    }
    return std::nullopt;
  }

  void save(Archive& archive) const override {
    put(archive, "rng", rng_);
    archive.put_integer("tree/begun", begun_ ? 1 : 0);
    scale_.save(archive);
    tree_.save(archive);
  }
  void restore(const Archive& archive) override {
    rng_ = restored_rng(archive, "rng");
    begun_ = archive.integer("tree/begun") != 0;
    scale_.restore(archive);
    tree_.restore(archive);
  }

 private:
  using Node = DesignTree::Node;
  using Branch = DesignTree::Branch;

  // From the root to a new design, or to a node below which nothing can win. False: time to stop.
  [[nodiscard]] bool descend(Meter& meter) {
    const double to_beat = score_to_beat(meter);
    int at = 0;
    while (true) {
      tree_.expand(at);
      const int b = chosen_branch(at, to_beat);
      if (b < 0) {
        tree_.node(at).finished = true;
        return !meter.stopped();
      }
      const Branch& branch = tree_.node(at).branches[static_cast<std::size_t>(b)];
      const int child = chosen_child(branch, to_beat);
      if (child < 0) return grow(at, static_cast<std::size_t>(b), meter);
      at = child;
    }
  }

  // UCB1 of something worth `value` that was taken `visits` of `all` times.
  [[nodiscard]] double ucb(double value, std::int64_t visits, std::int64_t all) const {
    return value + options_.exploration * std::sqrt(std::log(static_cast<double>(std::max<std::int64_t>(all, 1))) /
                                                    static_cast<double>(visits));
  }

  // What counts of a child: all that hangs on it, as long as more modules could still win.
  [[nodiscard]] const Rank& worth(const Branch& branch, int child, double to_beat) const {
    const Node& node = tree_.node(child);
    return branch.deeper_bound > to_beat ? node.best : node.own;
  }
  [[nodiscard]] int best_child(const Branch& branch, double to_beat) const {
    return *std::max_element(branch.children.begin(), branch.children.end(),
                             [&](int a, int b) { return worth(branch, a, to_beat) < worth(branch, b, to_beat); });
  }

  // Children that can be grown further.
  [[nodiscard]] bool open(const Branch& branch, int child, double to_beat) const {
    return branch.deeper_bound > to_beat && !tree_.node(child).finished;
  }
  [[nodiscard]] bool live(const Branch& branch, double to_beat) const {
    if (std::max(branch.own_bound, branch.deeper_bound) <= to_beat) return false;
    if (branch.children.empty() || problem_.library().type(branch.type).n_parameters() > 0) return true;
    return open(branch, branch.children.front(), to_beat);
  }

  [[nodiscard]] int chosen_branch(int at, double to_beat) const {
    const std::vector<Branch>& branches = tree_.node(at).branches;
    int best = -1;
    double best_ucb = -kInfinity;
    for (std::size_t b = 0; b < branches.size(); ++b) {
      const Branch& branch = branches[b];
      if (!live(branch, to_beat)) continue;
      if (branch.children.empty()) return static_cast<int>(b);
      const double value = scale_.value(worth(branch, best_child(branch, to_beat), to_beat));
      const double bound = ucb(value, branch.visits, tree_.node(at).visits);
      if (bound > best_ucb) {
        best = static_cast<int>(b);
        best_ucb = bound;
      }
    }
    return best;
  }

  // The child to go on from; -1: a new one.
  [[nodiscard]] int chosen_child(const Branch& branch, double to_beat) const {
    const bool discrete = problem_.library().type(branch.type).n_parameters() == 0;
    if (discrete) return branch.children.empty() ? -1 : branch.children.front();
    const double most = std::ceil(options_.width * std::pow(static_cast<double>(branch.visits), options_.growth));
    if (static_cast<double>(branch.children.size()) < std::max(most, 1.0)) return -1;
    int best = -1;
    double best_ucb = -kInfinity;
    for (const int child : branch.children) {
      if (!open(branch, child, to_beat)) continue;
      const double bound = ucb(scale_.value(tree_.node(child).best), tree_.node(child).visits, branch.visits);
      if (bound > best_ucb) {
        best = child;
        best_ucb = bound;
      }
    }
    return best;
  }

  // A new module in a branch, evaluated, and what may come after it. False: time to stop.
  [[nodiscard]] bool grow(int at, std::size_t b, Meter& meter) {
    const double to_beat = score_to_beat(meter);
    const Branch& branch = tree_.node(at).branches[b];
    const bool deeper = branch.deeper_bound > to_beat;
    const Rank foremost = branch.children.empty() ? Rank{} : worth(branch, best_child(branch, to_beat), to_beat);
    Design design = tree_.design(at);
    design.modules.push_back(new_placement(branch, to_beat));
    const std::optional<Rank> own = evaluate_rank(meter, problem_, design);
    if (!own) return false;
    Rank found = *own;
    if (options_.rollout && deeper && own->level < Rank::Level::kAchieved) {
      const std::optional<Rank> continued = evaluate_rank(meter, problem_, continuation(design));
      if (!continued) return false;
      found = std::max(found, *continued);
      scale_.see(*continued);
    }
    if (options_.polish > 0 && own->level > Rank::Level::kFailed && *own > foremost) {
      constexpr double kClearance = 1e-6;  // as the first of per-sequence
      const std::optional<Design> better =
          polished(problem_, design, kClearance, options_.inner, meter, options_.polish);
      if (meter.stopped()) return false;
      const std::optional<Rank> rank = better ? evaluate_rank(meter, problem_, *better) : std::optional{Rank{}};
      if (!rank) return false;
      found = std::max(found, *rank);
      scale_.see(*rank);
    }
    scale_.see(*own);
    const int child = tree_.add(at, b, design.modules.back());
    tree_.node(child).own = *own;
    tree_.back_up(child, found);
    return true;
  }

  // Voronoi optimistic optimisation: from the whole box, or closer to the best of the branch than to any other. A step
  // from the best that leaves its cell is halved until it stays.
  [[nodiscard]] Placement new_placement(const Branch& branch, double to_beat) {
    Placement placement = random_placement(problem_.library(), branch.type, rng_);
    if (branch.children.empty() || rng_.uniform() < options_.uniform) return placement;
    const std::vector<ParameterRange>& ranges = problem_.library().type(branch.type).parameters;
    const int best = best_child(branch, to_beat);
    const Parameters& centre = tree_.node(best).placement.parameters;
    const auto distance = [&](const Parameters& a, const Parameters& b) {
      double sum = 0.0;
      for (Eigen::Index i = 0; i < a.size(); ++i) {
        const ParameterRange& range = ranges[static_cast<std::size_t>(i)];
        if (range.upper > range.lower) sum += std::pow((a[i] - b[i]) / (range.upper - range.lower), 2);
      }
      return sum;
    };
    constexpr double kFirst = 0.5;  // standard deviation, share of the interval
    constexpr int kHalvings = 40;
    double step = kFirst;
    for (int i = 0; i < kHalvings; ++i, step *= 0.5) {
      for (Eigen::Index j = 0; j < centre.size(); ++j) {
        const ParameterRange& range = ranges[static_cast<std::size_t>(j)];
        const double moved = centre[j] + step * (range.upper - range.lower) * rng_.normal();
        placement.parameters[j] = std::clamp(moved, range.lower, range.upper);
      }
      const double to_best = distance(placement.parameters, centre);
      const bool inside = std::all_of(branch.children.begin(), branch.children.end(), [&](int child) {
        return child == best || to_best < distance(placement.parameters, tree_.node(child).placement.parameters);
      });
      if (inside) break;
    }
    return placement;
  }

  // The design with random modules after it, one more with probability 1/2 each.
  [[nodiscard]] Design continuation(Design design) {
    std::vector<int> types = design.types();
    do {
      const std::vector<int> allowed = problem_.successors(types);
      if (allowed.empty()) break;
      types.push_back(allowed[static_cast<std::size_t>(rng_.index(static_cast<int>(allowed.size())))]);
      design.modules.push_back(random_placement(problem_.library(), types.back(), rng_));
    } while (rng_.uniform() < 0.5);
    return design;
  }

  [[nodiscard]] SearchEnd end(const Meter& meter) const {
    const double best = score_to_beat(meter);
    if (meter.progress().failed > 0) {
      return {StopReason::kExhausted, "nothing is left that could beat the best, but evaluations failed"};
    }
    if (meter.progress().inconclusive > 0) {
      return {StopReason::kExhausted, "every design that could beat the best was evaluated; " + nothing_proved(meter)};
    }
    if (best == -kInfinity) {
      return {StopReason::kUnreachable, "every design was evaluated or ruled out by its bound, none is achieved",
              Bound{-kInfinity, "every design was evaluated or ruled out"}};
    }
    return {StopReason::kOptimal, "every design that could beat the best was evaluated",
            Bound{best, "modules, mass by reach"}};
  }

  const TreeSearchOptions& options_;
  const DesignProblem& problem_;
  Rng rng_;
  DesignTree tree_;
  ValueScale scale_;
  bool begun_ = false;
};

}  // namespace

TreeSearch::TreeSearch(TreeSearchOptions options) : options_{options} {
  const auto refuse = [](const char* what, double value, const char* limit) {
    throw std::invalid_argument(fmt::format("mcts: {} is {}, not {}", what, value, limit));
  };
  if (!(options_.exploration >= 0.0 && options_.exploration < kInfinity)) {
    refuse("exploration", options_.exploration, "a number of at least 0");
  }
  if (!(options_.width > 0.0 && options_.width < kInfinity)) refuse("width", options_.width, "a positive number");
  if (!(options_.growth >= 0.0 && options_.growth <= 1.0)) refuse("growth", options_.growth, "in [0, 1]");
  if (!(options_.uniform >= 0.0 && options_.uniform <= 1.0)) refuse("uniform", options_.uniform, "in [0, 1]");
  if (options_.polish < 0) refuse("polish", options_.polish, "at least 0");
}

std::unique_ptr<Search> TreeSearch::start(const DesignProblem& problem, Rng rng) const {
  return std::make_unique<TreeSearching>(options_, problem, rng);
}

}  // namespace modsearch
