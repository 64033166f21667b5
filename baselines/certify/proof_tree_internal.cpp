#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <modsearch/baselines/certify/proof_tree_internal.hpp>

namespace modsearch::certify {
namespace {

// A box this deep in the tree does not close at all.
constexpr int kDeepest = 600;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

class Writer {
 public:
  Writer(const SequenceModel& model, const Scenery& scenery, double cut, const std::function<bool()>& stop)
      : model_{model},
        n_goals_{static_cast<int>(scenery.targets.size())},
        prover_{model, scenery},
        cut_{cut},
        stop_{stop} {}

  [[nodiscard]] ProofOutcome run() {
    outcome_.nodes = "[";
    outcome_.whole = close(root_box(model_, n_goals_), prover_.first_multipliers(), 0);
    outcome_.nodes += "]";
    return std::move(outcome_);
  }

 private:
  bool close(Box box, Multipliers multipliers, int depth) {
    if (stop_()) return fail("the time is up");
    if (depth > kDeepest) return fail("a box does not close, however small it is cut");
    std::vector<std::vector<CutOff>> rounds;
    const Verdict verdict = prover_.prove(box, multipliers, cut_, &rounds);
    for (const std::vector<CutOff>& cuts : rounds) cut_off(cuts);
    if (verdict.closed) {
      begin();
      leaf(verdict.leaf);
      return true;
    }
    if (verdict.split < 0) return fail("a box does not close, however small it is cut");
    begin() += fmt::format("[\"s\",{},{}]", verdict.split, hex(verdict.at));
    Box below = box;
    below.upper[at(verdict.split)] = verdict.at;
    if (!close(std::move(below), multipliers, depth + 1)) return false;
    box.lower[at(verdict.split)] = verdict.at;
    return close(std::move(box), std::move(multipliers), depth + 1);
  }

  bool fail(const char* why) {
    outcome_.open = why;
    return false;
  }

  void cut_off(const std::vector<CutOff>& cuts) {
    if (cuts.empty()) return;
    std::string& text = begin();
    text += "[\"c\"";
    for (const CutOff& cut : cuts) {
      text += ",[";
      leaf(cut.leaf);
      for (const CutOff::Part& part : cut.parts) {
        text += fmt::format(",[{},{},\"{}\"]", part.variable, hex(part.at), part.above ? "above" : "below");
      }
      text += "]";
    }
    text += "]";
  }

  void leaf(const ClosedLeaf& closed) {
    ++outcome_.leaves;
    const Multipliers& m = closed.multipliers;
    std::string& text = outcome_.nodes;
    text += closed.kind == Objective::kMass ? "[\"m" : "[\"n";
    text += m.cap ? "c\"" : "\"";
    for (const Eigen::Vector3d& y : m.y) text += fmt::format(",{},{},{}", hex(y.x()), hex(y.y()), hex(y.z()));
    for (const Row& row : m.rows) {
      text += fmt::format(",[{},{},{},{},{},", row.goal, row.run, hex(row.tau), hex(row.multiplier), row.shape);
      if (row.ball) {
        text += fmt::format("\"ball\",{},{},{},{}]", hex(row.centre.x()), hex(row.centre.y()), hex(row.centre.z()),
                            hex(row.radius));
      } else {
        text += fmt::format("\"face\",{}]", row.face);
      }
    }
    text += "]";
  }

  std::string& begin() {
    if (outcome_.nodes.size() > 1) outcome_.nodes += ",";
    return outcome_.nodes;
  }

  const SequenceModel& model_;
  int n_goals_;
  NodeProver prover_;
  double cut_;
  const std::function<bool()>& stop_;
  ProofOutcome outcome_;
};

}  // namespace

std::string hex(double number) {
  char text[48];
  std::snprintf(text, sizeof text, "\"%a\"", number);
  return text;
}

ProofOutcome prove_sequence(const SequenceModel& model, const Scenery& scenery, double cut,
                            const std::function<bool()>& stop) {
  return Writer{model, scenery, cut, stop}.run();
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
