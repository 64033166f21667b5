#include <fmt/format.h>

#include <algorithm>
#include <modsearch/rl/model_archive_internal.hpp>
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

Eigen::Map<const Eigen::RowVectorXf> row_of(const std::vector<float>& table, std::size_t at, int n) {
  return {table.data() + at * static_cast<std::size_t>(n), n};
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

Experience Replay::experience(std::int64_t i) const {
  const auto at = static_cast<std::size_t>(i);
  Experience result;
  result.k = k_.at(at);
  result.s = row_of(s_, at, observation_size_).transpose();
  result.memory = row_of(memory_, at, memory_size_).transpose();
  result.reward = reward_[at];
  result.discount = discount_[at];
  result.remaining = remaining_[at];
  result.s_next = row_of(s_next_, at, observation_size_).transpose();
  result.next_mask = next_mask_[at];
  result.model = model_[at];
  return result;
}

void Replay::sample(Rng& rng, int first, int count, Batch& batch) const {
  if (k_.empty()) throw std::logic_error("replay: nothing to sample from");
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

void Replay::save(const std::string& prefix, Archive& archive) const {
  archive.put_integer(prefix + ".next", next_);
  archive.put(prefix + ".s", s_);
  archive.put(prefix + ".s_next", s_next_);
  archive.put(prefix + ".memory", memory_);
  archive.put(prefix + ".reward", reward_);
  archive.put(prefix + ".discount", discount_);
  archive.put(prefix + ".remaining", remaining_);
  archive.put(prefix + ".k", std::vector<std::int64_t>(k_.begin(), k_.end()));
  archive.put(prefix + ".next_mask", next_mask_);
  detail::put_models(archive, prefix + ".model", model_);
}

void Replay::load(const std::string& prefix, const Archive& archive, const Environment& environment) {
  const std::vector<std::int64_t> k = archive.integers(prefix + ".k");
  const std::size_t n = k.size();
  if (n > static_cast<std::size_t>(capacity_)) {
    archive.fail(prefix + ".k", fmt::format("{} experiences, at most {}", n, capacity_));
  }
  const auto floats = [&](const char* name, int width) {
    std::vector<float> values = archive.floats(prefix + name);
    if (values.size() != n * static_cast<std::size_t>(width)) {
      archive.fail(prefix + name, fmt::format("{} numbers, {} x {} are needed", values.size(), n, width));
    }
    return values;
  };
  s_ = floats(".s", observation_size_);
  s_next_ = floats(".s_next", observation_size_);
  memory_ = floats(".memory", memory_size_);
  reward_ = floats(".reward", 1);
  discount_ = floats(".discount", 1);
  remaining_ = floats(".remaining", 1);
  next_mask_ = archive.unsigned_integers(prefix + ".next_mask");
  if (next_mask_.size() != n) archive.fail(prefix + ".next_mask", fmt::format("not {} numbers", n));
  const int n_actions = environment.space().n_actions();
  for (const std::int64_t action : k) {
    if (action < 0 || action >= n_actions) archive.fail(prefix + ".k", fmt::format("{}: no such action", action));
  }
  k_.assign(k.begin(), k.end());
  model_ = detail::get_models(archive, prefix + ".model", n, environment);
  next_ = archive.integer(prefix + ".next");
  if (next_ < 0 || next_ >= capacity_) archive.fail(prefix + ".next", fmt::format("{}: not in the ring", next_));
}

}  // namespace modsearch
