#pragma once

#include <modsearch/rl/replay.hpp>

namespace modsearch {

/// The experiences of the best successful episodes, to be replayed beside the ordinary ones: thin optima that
/// exploration met once are not forgotten (self-imitation in the sense of Oh et al. 2018, kept as simple as it goes).
class Elite {
 public:
  /// `episodes`: how many are kept. Throws std::invalid_argument if it is below 1.
  explicit Elite(int episodes);

  /// Keeps the episode if it is among the best so far by its return; the older of equals stays.
  void add(double episode_return, std::vector<Experience> experiences);
  [[nodiscard]] bool empty() const { return episodes_.empty(); }
  /// Fills rows of `batch`: an episode uniformly, then one of its experiences.
  void sample(Rng& rng, int first, int count, Batch& batch) const;

  /// As Replay::save and Replay::load.
  void save(const std::string& prefix, Archive& archive) const;
  void load(const std::string& prefix, const Archive& archive, const Environment& environment, int memory_size);

 private:
  struct Episode {
    double value = 0.0;
    std::vector<Experience> experiences;
  };
  std::size_t capacity_;
  std::vector<Episode> episodes_;  // best first
};

}  // namespace modsearch
