#pragma once

#include <modsearch/rl/agent.hpp>

namespace modsearch {

class Archive;

/// A transition with its return, as the replay keeps it.
struct Experience {
  Eigen::VectorXf s;
  int k = 0;
  Eigen::VectorXf memory;  ///< see Agent::remember
  float reward = 0.0F;     ///< scaled; n rewards, discounted, where returns have n steps
  float discount = 0.0F;   ///< of the value of s_next
  float remaining = 0.0F;  ///< discounted return to the end of the episode
  Eigen::VectorXf s_next;
  ActionMask next_mask = 0;
  std::shared_ptr<const ActionModel> model;
};

/// Row `row` of `batch` becomes `experience`; the model must outlive the batch.
void write_row(const Experience& experience, int row, Batch& batch);

/// A ring of the last `capacity` experiences, sampled uniformly with replacement (Lin 1992; Mnih et al. 2015). Rows of
/// float: memory grows with the content, not with the capacity.
class Replay {
 public:
  /// Throws std::invalid_argument if capacity < 1.
  Replay(std::int64_t capacity, int observation_size, int memory_size);

  void add(const Experience& experience);
  [[nodiscard]] std::int64_t size() const { return static_cast<std::int64_t>(k_.size()); }
  /// Number `i` in the ring's memory. Throws std::out_of_range unless 0 <= i < size().
  [[nodiscard]] Experience experience(std::int64_t i) const;
  /// Fills rows first .. first + count - 1 of `batch`. Throws std::logic_error if the replay is empty.
  void sample(Rng& rng, int first, int count, Batch& batch) const;

  /// Everything, under names that begin with `prefix`; models by their keys.
  void save(const std::string& prefix, Archive& archive) const;
  /// Throws FileError if the archive does not fit. `environment` restores the models.
  void load(const std::string& prefix, const Archive& archive, const Environment& environment);

 private:
  std::int64_t capacity_;
  int observation_size_;
  int memory_size_;
  std::int64_t next_ = 0;      // where the next one goes once the ring is full
  std::vector<float> s_;       // [size x observation_size]
  std::vector<float> s_next_;  // [size x observation_size]
  std::vector<float> memory_;  // [size x memory_size]
  std::vector<float> reward_, discount_, remaining_;
  std::vector<std::int32_t> k_;
  std::vector<ActionMask> next_mask_;
  std::vector<std::shared_ptr<const ActionModel>> model_;
};

}  // namespace modsearch
