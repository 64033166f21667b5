#include <algorithm>
#include <modsearch/baselines/pose_first/sequence_sampler_internal.hpp>

namespace modsearch::detail {
namespace {

bool has_end_effectors(const ModuleLibrary& library) {
  for (int k = 0; k < library.n_types(); ++k) {
    if (library.type(k).role() == ModuleRole::kEndEffector) return true;
  }
  return false;
}

}  // namespace

int moving_joints(const ModuleType& type) {
  return static_cast<int>(
      std::count_if(type.joints.begin(), type.joints.end(), [](const ModuleJoint& joint) { return !joint.fixed; }));
}

SequenceSampler::SequenceSampler(const ModuleLibrary& library, int most_modules)
    : library_{library}, most_modules_{most_modules} {
  int most = 0;
  for (int k = 0; k < library.n_types(); ++k) {
    joints_.push_back(moving_joints(library.type(k)));
    most = std::max(most, joints_.back());
  }
  most_joints_ = most * most_modules;
  weights_.assign(static_cast<std::size_t>((library.n_types() + 1) * library.n_types()), 1.0);
  find_or_add(-1, library.base_coupling());
  const bool any_end = !has_end_effectors(library);
  for (std::size_t end = 0; end < ends_.size(); ++end) {  // grows as ends are met
    for (int k = 0; k < library.n_types(); ++k) {
      const auto after = library.coupling_after(ends_[end].coupling, k);
      if (!after) continue;
      const std::size_t next = find_or_add(k, *after);
      ends_[end].next.emplace_back(k, next);
      ends_[next].complete = any_end || library.type(k).role() == ModuleRole::kEndEffector;
    }
  }
  refresh();
  for (int n = 1; n <= most_modules_; ++n) {
    for (int j = 0; j <= most_joints_; ++j) {
      if (sum(n, j, 0) > 0.0) strata_.push_back({n, j});
    }
  }
}

int SequenceSampler::joints_in(std::span<const int> types) const {
  int joints = 0;
  for (const int k : types) joints += joints_of(k);
  return joints;
}

void SequenceSampler::set_weight(int previous, int type, double weight) {
  weights_[static_cast<std::size_t>((previous + 1) * library_.n_types() + type)] = weight;
}

double SequenceSampler::weight(int previous, int type) const {
  return weights_[static_cast<std::size_t>((previous + 1) * library_.n_types() + type)];
}

void SequenceSampler::refresh() {
  sums_.assign(static_cast<std::size_t>((most_modules_ + 1) * (most_joints_ + 1)) * ends_.size(), 0.0);
  for (std::size_t end = 0; end < ends_.size(); ++end) sum(0, 0, end) = ends_[end].complete ? 1.0 : 0.0;
  for (int n = 1; n <= most_modules_; ++n) {
    for (int j = 0; j <= most_joints_; ++j) {
      for (std::size_t end = 0; end < ends_.size(); ++end) {
        double total = 0.0;
        for (const auto& [type, next] : ends_[end].next) {
          const int left = j - joints_of(type);
          if (left >= 0) total += weight(ends_[end].type, type) * sum(n - 1, left, next);
        }
        sum(n, j, end) = total;
      }
    }
  }
}

std::vector<int> SequenceSampler::draw(Stratum stratum, Rng& rng) const {
  std::vector<int> types;
  std::size_t end = 0;
  int joints = stratum.joints;
  for (int n = stratum.modules; n > 0; --n) {
    double left = rng.uniform() * sum(n, joints, end);
    const std::pair<int, std::size_t>* chosen = nullptr;
    for (const auto& option : ends_[end].next) {
      const int rest = joints - joints_of(option.first);
      if (rest < 0) continue;
      const double share = weight(ends_[end].type, option.first) * sum(n - 1, rest, option.second);
      if (!(share > 0.0)) continue;
      chosen = &option;  // the last one where rounding leaves something over
      left -= share;
      if (left < 0.0) break;
    }
    if (!chosen) return {};
    types.push_back(chosen->first);
    joints -= joints_of(chosen->first);
    end = chosen->second;
  }
  return types;
}

std::size_t SequenceSampler::find_or_add(int type, const ModuleLibrary::Coupling& coupling) {
  const auto found = std::find_if(ends_.begin(), ends_.end(),
                                  [&](const End& end) { return end.type == type && end.coupling == coupling; });
  if (found != ends_.end()) return static_cast<std::size_t>(found - ends_.begin());
  ends_.push_back({.type = type, .coupling = coupling});
  return ends_.size() - 1;
}

double& SequenceSampler::sum(int modules, int joints, std::size_t end) {
  const auto row = static_cast<std::size_t>(modules * (most_joints_ + 1) + joints);
  return sums_[row * ends_.size() + end];
}

double SequenceSampler::sum(int modules, int joints, std::size_t end) const {
  const auto row = static_cast<std::size_t>(modules * (most_joints_ + 1) + joints);
  return sums_[row * ends_.size() + end];
}

}  // namespace modsearch::detail
