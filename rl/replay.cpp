#include <fmt/format.h>

#include <algorithm>
#include <modsearch/rl/replay.hpp>
#include <stdexcept>

namespace modsearch {
namespace {

// Writes `row` at place `at` of a table whose rows have its length; at the end, the table grows.
void put_row(std::vector<float>& table, std::size_t at, const Eigen::VectorXf& row) {
  const auto n = static_cast<std::size_t>(row.size());
  if (at * n == table.size()) table.resize(table.size() + n);
  std::copy(row.begin(), row.end(), table.begin() + static_cast<std::ptrdiff_t>(at * n));
}

template <typename T>
void put(std::vector<T>& column, std::size_t at, T value) {
  if (at == column.size()) {
    column.push_back(std::move(value));
  } else {
    column[at] = std::move(value);
  }
}

}  // namespace

void write_row(const Experience& experience, int row, Batch& batch) {
  batch.s.row(row) = experience.s.transpose();
  batch.s_next.row(row) = experience.s_next.transpose();
  batch.x.row(row) = experience.memory.transpose();
  batch.k[row] = experience.k;
  batch.reward[row] = experience.reward;
  batch.discount[row] = experience.discount;
  batch.remaining[row] = experience.remaining;
  batch.next_mask[static_cast<std::size_t>(row)] = experience.next_mask;
  batch.model[static_cast<std::size_t>(row)] = experience.model.get();
}

Replay::Replay(std::int64_t capacity, int observation_size, int memory_size)
    : capacity_{capacity}, observation_size_{observation_size}, memory_size_{memory_size} {
  if (capacity < 1) throw std::invalid_argument(fmt::format("replay: a capacity of {}, at least 1", capacity));
}

void Replay::add(const Experience& experience) {
  const bool full = size() == capacity_;
  const auto at = static_cast<std::size_t>(full ? next_ : size());
  if (full) next_ = (next_ + 1) % capacity_;
  put_row(s_, at, experience.s);
  put_row(s_next_, at, experience.s_next);
  put_row(memory_, at, experience.memory);
  put(reward_, at, experience.reward);
  put(discount_, at, experience.discount);
  put(remaining_, at, experience.remaining);
  put(next_mask_, at, experience.next_mask);
  put(model_, at, experience.model);
  put(k_, at, static_cast<std::int32_t>(experience.k));
}

void Replay::sample(Rng& rng, int first, int count, Batch& batch) const {
  if (k_.empty()) throw std::logic_error("replay: nothing to sample from");
  const auto row_of = [](const std::vector<float>& table, std::size_t at, int n) {
    return Eigen::Map<const Eigen::RowVectorXf>(table.data() + at * static_cast<std::size_t>(n), n);
  };
  for (int row = first; row < first + count; ++row) {
    const auto at = static_cast<std::size_t>(rng.index(static_cast<int>(size())));
    batch.s.row(row) = row_of(s_, at, observation_size_);
    batch.s_next.row(row) = row_of(s_next_, at, observation_size_);
    batch.x.row(row) = row_of(memory_, at, memory_size_);
    batch.k[row] = k_[at];
    batch.reward[row] = reward_[at];
    batch.discount[row] = discount_[at];
    batch.remaining[row] = remaining_[at];
    batch.next_mask[static_cast<std::size_t>(row)] = next_mask_[at];
    batch.model[static_cast<std::size_t>(row)] = model_[at].get();
  }
}

}  // namespace modsearch
