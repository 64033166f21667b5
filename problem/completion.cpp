#include <fmt/format.h>

#include <algorithm>
#include <modsearch/problem/completion_internal.hpp>
#include <stdexcept>

namespace modsearch::detail {

Completion::Completion(const ModuleLibrary& library) : library_{library} {
  // Every free end that can occur gets a number when it is first met, and its steps when its turn comes.
  static_cast<void>(number_of(library.base_coupling()));
  for (std::size_t end = 0; end < ends_.size(); ++end) {
    std::vector<Step> steps;
    for (int k = 0; k < library.n_types(); ++k) {
      const std::optional<Coupling> next = library.coupling_after(ends_[end], k);
      if (!next) continue;
      // Whether a design is complete can be seen from its last module.
      const bool complete = library.complete(std::span{&k, 1});
      steps.push_back({.type = k, .next = number_of(*next), .modules = complete ? 1 : kNever});
    }
    steps_.push_back(std::move(steps));
  }
  const auto least = [&](int end) {
    int result = kNever;
    for (const Step& step : steps_[static_cast<std::size_t>(end)]) result = std::min(result, step.modules);
    return result;
  };
  for (bool changed = true; changed;) {
    changed = false;
    for (std::vector<Step>& steps : steps_) {
      for (Step& step : steps) {
        const int rest = least(step.next);
        if (rest == kNever || rest + 1 >= step.modules) continue;
        step.modules = rest + 1;
        changed = true;
      }
    }
  }
}

int Completion::number_of(const Coupling& coupling) {
  const auto [entry, added] = numbers_.try_emplace(coupling, static_cast<int>(ends_.size()));
  if (added) ends_.push_back(coupling);
  return entry->second;
}

// The free end after a module of type `k` was joined to `end`; -1 if it does not fit.
int Completion::after(int end, int k) const {
  const std::vector<Step>& steps = steps_[static_cast<std::size_t>(end)];
  const auto step = std::lower_bound(steps.begin(), steps.end(), k, [](const Step& a, int b) { return a.type < b; });
  return step != steps.end() && step->type == k ? step->next : -1;
}

std::vector<int> Completion::successors(std::span<const int> types, int room) const {
  int end = 0;
  for (const int k : types) {
    end = after(end, k);
    if (end < 0) {
      throw std::invalid_argument(fmt::format("library '{}': the modules do not fit together", library_.name()));
    }
  }
  std::vector<int> result;
  for (const Step& step : steps_[static_cast<std::size_t>(end)]) {
    if (step.modules <= room) result.push_back(step.type);
  }
  return result;
}

}  // namespace modsearch::detail
