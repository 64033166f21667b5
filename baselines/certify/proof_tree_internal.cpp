#include <algorithm>
#include <cmath>
#include <limits>
#include <modsearch/baselines/certify/proof_tree_internal.hpp>
#include <modsearch/baselines/certify/twins_internal.hpp>

namespace modsearch::certify {
namespace {

// A box this deep in the tree does not close at all.
constexpr int kDeepest = 600;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

// One box and those it is cut into.
class Closing {
 public:
  Closing(NodeProver& prover, double cut, const std::function<bool()>& stop, TreeText& text, ProofOutcome& outcome)
      : prover_{prover}, cut_{cut}, stop_{stop}, text_{text}, outcome_{outcome} {}

  bool close(Box box, Multipliers multipliers, int depth) {
    if (stop_()) {
      outcome_.in_time = false;
      return fail("the time is up");
    }
    if (depth > kDeepest) return fail("a box does not close, however small it is cut");
    std::vector<std::vector<CutOff>> rounds;
    const Verdict verdict = prover_.prove(box, multipliers, cut_, &rounds);
    for (const std::vector<CutOff>& cuts : rounds) text_.cut_off(cuts);
    if (verdict.closed) {
      text_.close(verdict.leaf);
      return true;
    }
    if (verdict.split < 0) return fail("a box does not close, however small it is cut");
    text_.split(verdict.split, verdict.at);
    Box below = box;
    below.upper[at(verdict.split)] = verdict.at;
    if (!close(std::move(below), multipliers, depth + 1)) return false;
    box.lower[at(verdict.split)] = verdict.at;
    return close(std::move(box), std::move(multipliers), depth + 1);
  }

 private:
  bool fail(const char* why) {
    outcome_.open = why;
    return false;
  }

  NodeProver& prover_;
  double cut_;
  const std::function<bool()>& stop_;
  TreeText& text_;
  ProofOutcome& outcome_;
};

}  // namespace

bool close_box(NodeProver& prover, Box box, Multipliers multipliers, double cut, const std::function<bool()>& stop,
               TreeText& text, ProofOutcome& outcome) {
  return Closing{prover, cut, stop, text, outcome}.close(std::move(box), std::move(multipliers), 0);
}

ProofOutcome prove_sequence(const SequenceModel& model, const Scenery& scenery, double cut,
                            const std::function<bool()>& stop) {
  NodeProver prover{model, scenery};
  ProofOutcome outcome;
  TreeText text;
  const int n_goals = static_cast<int>(scenery.targets.size());
  for (const int variable : half_circles(model, n_goals)) text.halve(variable);
  outcome.whole =
      close_box(prover, box_without_twins(model, n_goals), prover.first_multipliers(), cut, stop, text, outcome);
  outcome.nodes = "[" + text.nodes() + "]";
  outcome.leaves = text.leaves();
  return outcome;
}

bool out_of_reach(const SequenceModel& model, const Scenery& scenery, double head, double weight, double upper) {
  constexpr double kMargin = 1e-7;  // what is nearly out of reach gets a tree, which the checker takes as well
  const AffineVector& ground = model.frames.front().v;
  double distance = 0.0;
  for (const Target& target : scenery.targets) {
    distance = std::max(distance, (target.position - ground.offset).norm() - target.radius);
  }
  const auto n = model.lower.size();
  double reach = 0.0;
  double mass = model.mass;
  std::vector<double> farther(n);
  for (std::size_t j = 0; j < model.frames.size(); ++j) {
    const AffineVector& v = model.frames[j].v;
    Eigen::Vector3d piece = j == 0 ? Eigen::Vector3d{Eigen::Vector3d::Zero()} : v.offset;
    for (const auto& term : v.terms) {
      piece += model.lower[at(term.parameter)] * term.direction;
      farther[at(term.parameter)] += term.direction.norm();
    }
    reach += piece.norm();
  }
  double longest = reach;
  for (std::size_t k = 0; k < n; ++k) {
    mass += model.masses[k] * model.lower[k];
    longest += farther[k] * (model.upper[k] - model.lower[k]);
  }
  if (distance > longest + kMargin) return true;
  if (weight <= 0.0) return head <= upper - kMargin;
  const auto least_mass_for = [&](double lambda) {
    double least = mass + lambda * (distance - reach);
    for (std::size_t k = 0; k < n; ++k) {
      least += std::min(0.0, (model.masses[k] - lambda * farther[k]) * (model.upper[k] - model.lower[k]));
    }
    return least;
  };
  double best = least_mass_for(0.0);
  for (std::size_t k = 0; k < n; ++k) {
    if (farther[k] > 0.0 && model.masses[k] > 0.0) best = std::max(best, least_mass_for(model.masses[k] / farther[k]));
  }
  return head - weight * best <= upper - kMargin;
}

}  // namespace modsearch::certify
