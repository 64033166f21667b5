#include <algorithm>
#include <map>
#include <modsearch/problem/completions_internal.hpp>

namespace modsearch::detail {
namespace {

using Coupling = ModuleLibrary::Coupling;

int joints_of(const ModuleType& module) {
  return static_cast<int>(
      std::count_if(module.joints.begin(), module.joints.end(), [](const ModuleJoint& joint) { return !joint.fixed; }));
}

constexpr Continuation kNone{.possible = false};

}  // namespace

Completions::Completions(const ModuleLibrary& library, std::span<const ModuleSpan> spans,
                         const std::vector<bool>& may_end, int least_joints, int most_modules)
    : types_(static_cast<std::size_t>(library.n_types())),
      may_end_{may_end},
      base_joints_{joints_of(library.base())},
      least_joints_{least_joints},
      most_modules_{most_modules} {
  // Free ends by number, that of the base first.
  std::map<Coupling, int> numbers{{library.base_coupling(), 0}};
  std::vector<Coupling> ends{library.base_coupling()};
  for (std::size_t end = 0; end < ends.size(); ++end) {
    const Coupling free = ends[end];
    for (int k = 0; k < library.n_types(); ++k) {
      const std::optional<Coupling> next = library.coupling_after(free, k);
      if (next && numbers.try_emplace(*next, static_cast<int>(ends.size())).second) ends.push_back(*next);
    }
  }
  n_ends_ = static_cast<int>(ends.size());
  double best_rate = 0.0;
  for (std::size_t k = 0; k < types_.size(); ++k) {
    types_[k].joints = joints_of(library.type(static_cast<int>(k)));
    for (const Coupling& end : ends) {
      const std::optional<Coupling> next = library.coupling_after(end, static_cast<int>(k));
      types_[k].next.push_back(next ? numbers.at(*next) : -1);
    }
    best_rate = std::max(best_rate, spans[k].best_rate());
  }

  table_.assign(static_cast<std::size_t>((most_modules_ + 1) * n_ends_ * (least_joints_ + 1)), kNone);
  for (int more = 1; more <= most_modules_; ++more) {
    for (int end = 0; end < n_ends_; ++end) {
      for (int missing = 0; missing <= least_joints_; ++missing) {
        Continuation& best = entry(more, end, missing);
        for (std::size_t k = 0; k < types_.size(); ++k) {
          const int next = types_[k].next[static_cast<std::size_t>(end)];
          if (next < 0) continue;
          const int still_missing = std::max(0, missing - types_[k].joints);
          const bool last = more == 1;
          if (last && (still_missing > 0 || !may_end_[k])) continue;
          const Continuation rest = last ? Continuation{} : entry(more - 1, next, still_missing);
          if (!rest.possible) continue;
          best.length = std::max(best.possible ? best.length : 0.0, spans[k].length + rest.length);
          best.greatest_length =
              std::max(best.possible ? best.greatest_length : 0.0, spans[k].greatest_length() + rest.greatest_length);
          best.mass = best.possible ? std::min(best.mass, spans[k].mass + rest.mass) : spans[k].mass + rest.mass;
          best.cost = best.possible ? std::min(best.cost, spans[k].cost + rest.cost) : spans[k].cost + rest.cost;
          best.best_rate = best_rate;
          best.possible = true;
        }
      }
    }
  }
}

Continuation Completions::completion(std::span<const int> types, int more) const {
  int end = 0;
  int joints = base_joints_;
  for (const int k : types) {
    const Type& type = types_[static_cast<std::size_t>(k)];
    end = type.next[static_cast<std::size_t>(end)];
    if (end < 0) return kNone;
    joints += type.joints;
  }
  const int missing = std::max(0, least_joints_ - joints);
  if (more > most_modules_) return kNone;
  if (more > 0) return entry(more, end, missing);
  const bool ends_well = !types.empty() && may_end_[static_cast<std::size_t>(types.back())];
  return missing > 0 || !ends_well ? kNone : Continuation{};
}

}  // namespace modsearch::detail
