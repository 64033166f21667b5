#include <fmt/format.h>

#include <algorithm>
#include <modsearch/rl/elite.hpp>
#include <modsearch/solvers/archive.hpp>
#include <numeric>
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

void Elite::save(const std::string& prefix, Archive& archive) const {
  std::vector<double> values;
  std::vector<std::int64_t> lengths;
  std::int64_t total = 0;
  for (const Episode& episode : episodes_) {
    values.push_back(episode.value);
    lengths.push_back(static_cast<std::int64_t>(episode.experiences.size()));
    total += lengths.back();
  }
  archive.put(prefix + ".values", values);
  archive.put(prefix + ".lengths", lengths);
  if (total == 0) return;
  const Experience& any = episodes_.front().experiences.front();
  Replay all{total, static_cast<int>(any.s.size()), static_cast<int>(any.memory.size())};
  for (const Episode& episode : episodes_) {
    for (const Experience& experience : episode.experiences) all.add(experience);
  }
  all.save(prefix, archive);
}

void Elite::load(const std::string& prefix, const Archive& archive, const Environment& environment, int memory_size) {
  const std::vector<double> values = archive.numbers(prefix + ".values");
  const std::vector<std::int64_t> lengths = archive.integers(prefix + ".lengths");
  episodes_.clear();
  const auto fits = [](std::int64_t length) { return length > 0 && length < (std::int64_t{1} << 31); };
  if (values.size() != lengths.size() || values.size() > capacity_ ||
      !std::all_of(lengths.begin(), lengths.end(), fits)) {
    archive.fail(prefix + ".lengths", "not the lengths of an elite's episodes");
  }
  if (lengths.empty()) return;
  const std::int64_t total = std::accumulate(lengths.begin(), lengths.end(), std::int64_t{0});
  Replay all{total, environment.observation_size(), memory_size};
  all.load(prefix, archive, environment);
  if (all.size() != total) archive.fail(prefix + ".k", "not as many experiences as the episodes have");
  std::int64_t at = 0;
  for (std::size_t i = 0; i < lengths.size(); ++i) {
    Episode episode{values[i], {}};
    for (std::int64_t j = 0; j < lengths[i]; ++j) episode.experiences.push_back(all.experience(at++));
    episodes_.push_back(std::move(episode));
  }
}

}  // namespace modsearch
