#include <fmt/format.h>

#include <modsearch/rl/model_archive_internal.hpp>
#include <span>
#include <stdexcept>

namespace modsearch::detail {

void put_models(Archive& archive, const std::string& name,
                const std::vector<std::shared_ptr<const ActionModel>>& models) {
  std::vector<double> keys;
  std::vector<std::int64_t> ends;
  ends.reserve(models.size());
  for (const auto& model : models) {
    if (model) {
      const std::vector<double> key = model->key();
      keys.insert(keys.end(), key.begin(), key.end());
    }
    ends.push_back(static_cast<std::int64_t>(keys.size()));
  }
  archive.put(name + ".keys", keys);
  archive.put(name + ".ends", ends);
}

std::vector<std::shared_ptr<const ActionModel>> get_models(const Archive& archive, const std::string& name,
                                                           std::size_t count, const Environment& environment) {
  const std::vector<double> keys = archive.numbers(name + ".keys");
  const std::vector<std::int64_t> ends = archive.integers(name + ".ends");
  if (ends.size() != count) archive.fail(name + ".ends", fmt::format("{} models, {} are needed", ends.size(), count));
  std::vector<std::shared_ptr<const ActionModel>> models(count);
  std::int64_t begin = 0;
  for (std::size_t i = 0; i < count; ++i) {
    if (ends[i] < begin || ends[i] > static_cast<std::int64_t>(keys.size())) {
      archive.fail(name + ".ends", fmt::format("number {} is {}, not in [{}, {}]", i, ends[i], begin, keys.size()));
    }
    const std::span key{keys.data() + begin, static_cast<std::size_t>(ends[i] - begin)};
    begin = ends[i];
    if (key.empty()) continue;
    try {
      models[i] = environment.restore_model(key);
    } catch (const std::invalid_argument& e) {
      archive.fail(name + ".keys", e.what());
    }
  }
  return models;
}

}  // namespace modsearch::detail
