#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <modsearch/baselines/pose_first/sequence_belief_internal.hpp>

namespace modsearch::detail {
namespace {

// What a stratum is believed to do before it was tried counts as much as this many tries (arbitrary, small).
constexpr double kPriorTries = 2.0;
// Work of a try that nobody has made yet, in steps of the pose program.
constexpr double kUsualWork = 400.0;
// Tries between two settings of the pairs' weights: setting them takes as long as a try.
constexpr int kLearningPeriod = 64;

}  // namespace

SequenceBelief::SequenceBelief(const DesignProblem& problem, Rng rng)
    : problem_{problem}, sampler_{problem.library(), problem.max_modules() - 1} {
  const auto n_types = static_cast<std::size_t>(problem.library().n_types());
  met_.assign((n_types + 1) * n_types, 0.0);
  expected_.assign(met_.size(), 0.0);
  cheapness_.assign(n_types, 1.0);
  weigh_by_cost(rng);
  constexpr int kLooks = 4;  // sequences of a stratum that are looked at in advance
  for (const Stratum& stratum : sampler_.strata()) {
    Experience experience{.stratum = stratum, .bound = -std::numeric_limits<double>::infinity()};
    int generic = 0;
    for (int i = 0; i < kLooks; ++i) {
      const std::vector<int> types = sampler_.draw(stratum, rng);
      if (types.empty()) continue;
      experience.bound = std::max(experience.bound, problem_.optimism(types).score);
      const std::unique_ptr<PoseProgram> program = problem_.pose_program(types);
      if (program && program->generic()) ++generic;
    }
    // One in ten of those that can be followed in general (measured on generated tasks with six drives), and hardly any
    // of the others.
    experience.prior = 1e-4 + 0.1 * generic / kLooks;
    strata_.push_back(experience);
  }
}

// Types are drawn more often the less they cost. What a module costs is read off the bounds of random sequences, by
// least squares: the scoring may be anybody's.
void SequenceBelief::weigh_by_cost(Rng& rng) {
  const int n_types = problem_.library().n_types();
  const int n_samples = 4 * n_types + 64;
  Eigen::MatrixXd A = Eigen::MatrixXd::Identity(n_types + 1, n_types + 1) * 1e-3;
  Eigen::VectorXd b = Eigen::VectorXd::Zero(n_types + 1);
  for (int i = 0; i < n_samples && !sampler_.strata().empty(); ++i) {
    const auto& strata = sampler_.strata();
    const std::vector<int> types =
        sampler_.draw(strata[static_cast<std::size_t>(rng.index(static_cast<int>(strata.size())))], rng);
    const double bound = problem_.optimism(types).score;
    if (!std::isfinite(bound)) continue;
    Eigen::VectorXd row = Eigen::VectorXd::Zero(n_types + 1);
    row[n_types] = 1.0;
    for (const int k : types) row[k] += 1.0;
    A += row * row.transpose();
    b += bound * row;
  }
  const Eigen::VectorXd costs = -A.ldlt().solve(b).head(n_types).cwiseMin(0.0);
  const double scale = 0.5 * costs.mean();
  if (!(scale > 0.0)) return;
  for (int k = 0; k < n_types; ++k) cheapness_[static_cast<std::size_t>(k)] = std::exp(-costs[k] / scale);
  weigh_pairs();
}

std::size_t SequenceBelief::pair(int previous, int type) const {
  return static_cast<std::size_t>((previous + 1) * problem_.library().n_types() + type);
}

// A pair whose sequences succeed more often than their strata would have it is drawn more often.
void SequenceBelief::weigh_pairs() {
  constexpr double kCaution = 1.0;  // successes expected before a pair is believed
  constexpr double kMost = 8.0;     // times as often, or as seldom
  const int n_types = problem_.library().n_types();
  for (int a = -1; a < n_types; ++a) {
    for (int b = 0; b < n_types; ++b) {
      const double better = (met_[pair(a, b)] + kCaution) / (expected_[pair(a, b)] + kCaution);
      sampler_.set_weight(a, b, cheapness_[static_cast<std::size_t>(b)] * std::clamp(better, 1.0 / kMost, kMost));
    }
  }
  sampler_.refresh();
  learned_ = 0;
}

double SequenceBelief::chance(const Experience& e) const {
  return (e.succeeded + kPriorTries * e.prior) / (e.tried + kPriorTries);
}

std::size_t SequenceBelief::choose(double to_beat, Rng& rng) const {
  constexpr double kCurious = 0.05;  // of the draws go to any stratum that could still gain
  std::vector<double> promise;
  for (const Experience& e : strata_) {
    const double gain = std::max(e.bound - to_beat, 0.0);
    const double work = (e.work + kPriorTries * kUsualWork) / (e.tried + kPriorTries);
    promise.push_back(gain > 0.0 ? chance(e) * gain / work : 0.0);
  }
  double total = 0.0;
  double open = 0.0;
  for (const double p : promise) {
    total += p;
    open += p > 0.0 ? 1.0 : 0.0;
  }
  if (!(total > 0.0)) return static_cast<std::size_t>(rng.index(static_cast<int>(strata_.size())));
  double left = rng.uniform();
  std::size_t chosen = 0;
  for (std::size_t i = 0; i < promise.size(); ++i) {
    if (!(promise[i] > 0.0)) continue;
    chosen = i;
    left -= (1.0 - kCurious) * promise[i] / total + kCurious / open;
    if (left < 0.0) break;
  }
  return chosen;
}

std::optional<SequenceBelief::Drawn> SequenceBelief::draw(double to_beat, Rng& rng) {
  constexpr int kDraws = 64;
  if (strata_.empty()) return std::nullopt;
  for (int i = 0; i < kDraws; ++i) {
    Experience& experience = strata_[choose(to_beat, rng)];
    std::vector<int> types = sampler_.draw(experience.stratum, rng);
    if (types.empty()) continue;
    const double bound = problem_.optimism(types).score;
    experience.bound = std::max(experience.bound, bound);
    if (bound > to_beat) return Drawn{std::move(types), experience.stratum, bound};
  }
  return std::nullopt;
}

void SequenceBelief::learn(std::span<const int> types, double success, double work) {
  const Stratum stratum{static_cast<int>(types.size()), sampler_.joints_in(types)};
  const auto found =
      std::find_if(strata_.begin(), strata_.end(), [&](const Experience& e) { return e.stratum == stratum; });
  if (found == strata_.end()) return;
  const double expected = chance(*found);
  int previous = -1;
  for (const int k : types) {
    met_[pair(previous, k)] += success;
    expected_[pair(previous, k)] += expected;
    previous = k;
  }
  found->tried += 1.0;
  found->succeeded += success;
  found->work += work;
  if (++learned_ >= kLearningPeriod) weigh_pairs();
}

double SequenceBelief::greatest_bound() const {
  double bound = -std::numeric_limits<double>::infinity();
  for (const Experience& e : strata_) bound = std::max(bound, e.bound);
  return bound;
}

void SequenceBelief::save(Archive& archive) const {
  std::vector<double> numbers;
  for (const Experience& e : strata_) numbers.insert(numbers.end(), {e.bound, e.prior, e.tried, e.succeeded, e.work});
  archive.put("belief/strata", std::span<const double>{numbers});
  archive.put("belief/cheapness", std::span<const double>{cheapness_});
  archive.put("belief/met", std::span<const double>{met_});
  archive.put("belief/expected", std::span<const double>{expected_});
  archive.put_integer("belief/learned", learned_);
  // The weights that are in use are those of the last time that they were set.
  std::vector<double> weights;
  for (int a = -1; a < problem_.library().n_types(); ++a) {
    for (int b = 0; b < problem_.library().n_types(); ++b) weights.push_back(sampler_.weight(a, b));
  }
  archive.put("belief/weights", std::span<const double>{weights});
}

void SequenceBelief::restore(const Archive& archive) {
  const auto numbers = [&](const std::string& name, std::size_t size) {
    std::vector<double> values = archive.numbers(name);
    if (values.size() != size) archive.fail(name, "is of another problem");
    return values;
  };
  const std::vector<double> strata = numbers("belief/strata", 5 * strata_.size());
  for (std::size_t i = 0; i < strata_.size(); ++i) {
    const double* at = strata.data() + 5 * i;
    strata_[i] = {strata_[i].stratum, at[0], at[1], at[2], at[3], at[4]};
  }
  cheapness_ = numbers("belief/cheapness", cheapness_.size());
  met_ = numbers("belief/met", met_.size());
  expected_ = numbers("belief/expected", expected_.size());
  learned_ = static_cast<int>(archive.integer("belief/learned"));
  const std::vector<double> weights = numbers("belief/weights", met_.size());
  for (int a = -1; a < problem_.library().n_types(); ++a) {
    for (int b = 0; b < problem_.library().n_types(); ++b) sampler_.set_weight(a, b, weights[pair(a, b)]);
  }
  sampler_.refresh();
}

}  // namespace modsearch::detail
