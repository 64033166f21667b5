#include <algorithm>
#include <array>
#include <modsearch/baselines/pose_first/sequence_change_internal.hpp>
#include <modsearch/baselines/pose_first/sequence_sampler_internal.hpp>
#include <numeric>

namespace modsearch::detail {
namespace {

// A sequence under change: type and where it stood.
struct Slots {
  std::vector<int> types;
  std::vector<int> from;

  void erase(int at) {
    types.erase(types.begin() + at);
    from.erase(from.begin() + at);
  }
  void insert(int at, int type) {
    types.insert(types.begin() + at, type);
    from.insert(from.begin() + at, -1);
  }
};

void change_once(const ModuleLibrary& library, Slots& slots, Rng& rng) {
  const auto n = static_cast<int>(slots.types.size());
  const double kind = rng.uniform();
  if (n > 0 && kind < 0.4) {
    slots.erase(rng.index(n));
  } else if (n > 0 && kind < 0.65) {
    const int at = rng.index(n);
    slots.types[static_cast<std::size_t>(at)] = rng.index(library.n_types());
    slots.from[static_cast<std::size_t>(at)] = -1;
  } else if (n > 1 && kind < 0.85) {
    const auto a = static_cast<std::size_t>(rng.index(n));
    const auto b = static_cast<std::size_t>(rng.index(n));
    std::swap(slots.types[a], slots.types[b]);
    std::swap(slots.from[a], slots.from[b]);
  } else {
    slots.insert(rng.index(n + 1), rng.index(library.n_types()));
  }
}

// Where the numbers of each module begin.
template <typename Count>
std::vector<int> starts_of(const std::vector<int>& types, Count&& count) {
  std::vector<int> starts{0};
  for (const int k : types) starts.push_back(starts.back() + count(k));
  return starts;
}

template <typename Count>
std::vector<int> kept(const SequenceChange& change, const std::vector<int>& old_types, Count&& count) {
  const std::vector<int> before = starts_of(old_types, count);
  std::vector<int> indices;
  for (std::size_t i = 0; i < change.types.size(); ++i) {
    const int from = change.from[i];
    for (int p = 0; p < count(change.types[i]); ++p) {
      indices.push_back(from < 0 ? -1 : before[static_cast<std::size_t>(from)] + p);
    }
  }
  return indices;
}

}  // namespace

std::optional<SequenceChange> changed(const DesignProblem& problem, const std::vector<int>& types, Rng& rng) {
  constexpr int kTries = 100;
  const ModuleLibrary& library = problem.library();
  for (int attempt = 0; attempt < kTries; ++attempt) {
    Slots slots{types, std::vector<int>(types.size())};
    std::iota(slots.from.begin(), slots.from.end(), 0);
    const int times = 1 + rng.index(3) / 2;  // twice in one case of three
    for (int i = 0; i < times; ++i) change_once(library, slots, rng);
    const bool possible = static_cast<int>(slots.types.size()) < problem.max_modules() && slots.types != types &&
                          library.fits_together(slots.types) && library.complete(slots.types);
    if (!possible) continue;
    SequenceChange change{.types = std::move(slots.types), .from = std::move(slots.from)};
    const auto n_parameters = [&](int k) { return library.type(k).n_parameters(); };
    const auto n_joints = [&](int k) { return moving_joints(library.type(k)); };
    change.parameters = kept(change, types, n_parameters);
    change.joints = kept(change, types, n_joints);
    change.old_parameters = starts_of(types, n_parameters).back();
    change.old_joints = starts_of(types, n_joints).back();
    return change;
  }
  return std::nullopt;
}

void carry_over(const SequenceChange& change, const Eigen::VectorXd& old, int i, const Eigen::VectorXd& lower,
                const Eigen::VectorXd& upper, Rng& rng, Eigen::Ref<Eigen::VectorXd> v) {
  constexpr std::array<double, 4> kShakes{0.02, 0.08, 0.2, 0.4};  // standard deviations, of the variable's range
  const double shake = kShakes[static_cast<std::size_t>(i) % kShakes.size()];
  const auto set = [&](Eigen::Index at, int from) {
    if (from < 0) {
      v[at] = rng.uniform(lower[at], upper[at]);
    } else {
      v[at] = old[from] + shake * (upper[at] - lower[at]) * rng.normal();
    }
  };
  const auto n_x = static_cast<Eigen::Index>(change.parameters.size());
  const auto n_q = static_cast<Eigen::Index>(change.joints.size());
  for (Eigen::Index p = 0; p < n_x; ++p) set(p, change.parameters[static_cast<std::size_t>(p)]);
  if (n_q == 0) return;
  const Eigen::Index n_goals = (v.size() - n_x) / n_q;
  for (Eigen::Index g = 0; g < n_goals; ++g) {
    for (Eigen::Index j = 0; j < n_q; ++j) {
      const int from = change.joints[static_cast<std::size_t>(j)];
      const int offset = change.old_parameters + static_cast<int>(g) * change.old_joints;
      set(n_x + g * n_q + j, from < 0 ? -1 : offset + from);
    }
  }
}

}  // namespace modsearch::detail
