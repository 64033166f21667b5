#include <fmt/format.h>

#include <algorithm>
#include <modsearch/rl/elite.hpp>
#include <stdexcept>

namespace modsearch {

Elite::Elite(int episodes) : capacity_{static_cast<std::size_t>(std::max(episodes, 0))} {
  if (episodes < 1) throw std::invalid_argument(fmt::format("elite: {} episodes, at least 1", episodes));
}

void Elite::add(double episode_return, std::vector<Experience> experiences) {
  const auto worse = [](double value, const Episode& episode) { return value > episode.value; };
  const auto place = std::upper_bound(episodes_.begin(), episodes_.end(), episode_return, worse);
  episodes_.insert(place, {episode_return, std::move(experiences)});
  if (episodes_.size() > capacity_) episodes_.pop_back();
}

void Elite::sample(Rng& rng, int first, int count, Batch& batch) const {
  if (episodes_.empty()) throw std::logic_error("elite: nothing to sample from");
  for (int row = first; row < first + count; ++row) {
    const Episode& episode = episodes_[static_cast<std::size_t>(rng.index(static_cast<int>(episodes_.size())))];
    const int n = static_cast<int>(episode.experiences.size());
    write_row(episode.experiences[static_cast<std::size_t>(rng.index(n))], row, batch);
  }
}

}  // namespace modsearch
