#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <modsearch/problem/files.hpp>
#include <modsearch/problem/json_internal.hpp>
#include <modsearch/rl/policy_file.hpp>
#include <modsearch/solvers/crc32c.hpp>
#include <set>
#include <stdexcept>
#include <string_view>

namespace modsearch {
namespace {

using detail::JsonCursor;
using nlohmann::ordered_json;

static_assert(std::endian::native == std::endian::little, "weights are little-endian");

constexpr std::int64_t kMost = std::numeric_limits<std::int64_t>::max();
constexpr std::int64_t kMostBytes = std::int64_t{1} << 32;  // of weights; the networks here have kilobytes
constexpr std::int64_t kMostNumbers = 1 << 20;              // of an observation or of an action's parameters

std::uint32_t checksum(std::string_view bytes) { return crc32c(std::as_bytes(std::span{bytes})); }

void check(const PolicyFile& policy) {
  const auto refuse = [](const std::string& what) { throw std::invalid_argument("policy: " + what); };
  if (policy.agent.empty()) refuse("no name of an agent");
  if (policy.observation_size < 1 || policy.observation_size > kMostNumbers) {
    refuse(fmt::format("an observation of {} numbers, not in [1, {}]", policy.observation_size, kMostNumbers));
  }
  static_cast<void>(policy.space());  // refuses impossible ones
  std::set<std::string_view> types;
  for (const PolicyFile::Action& action : policy.actions) {
    if (action.type.empty() || !types.insert(action.type).second) {
      refuse(fmt::format("an action of type '{}', empty or twice", action.type));
    }
  }
  std::set<std::string_view> names;
  for (const auto& [name, values] : policy.tensors) {
    if (name.empty() || !names.insert(name).second) refuse(fmt::format("a tensor '{}', empty or twice", name));
    if (!std::all_of(values.begin(), values.end(), [](float value) { return std::isfinite(value); })) {
      refuse(fmt::format("tensor '{}' holds numbers that are not finite: the training has diverged", name));
    }
  }
  const PolicyFile::Facts& facts = policy.training;
  if (facts.episodes < 0 || facts.steps < 0 || facts.updates < 0 || !(facts.seconds >= 0.0) ||
      !std::isfinite(facts.seconds) || (facts.mean_return && !std::isfinite(*facts.mean_return))) {
    refuse("a fact of the training is negative or not finite");
  }
}

std::string joined(const PolicyFile& policy) {
  std::string bytes;
  for (const auto& [name, values] : policy.tensors) {
    bytes.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(float));
  }
  return bytes;
}

/// Beginning of the names of the weights of `file`, which are named after their content: those in use are never
/// overwritten.
std::string weights_prefix(const std::filesystem::path& file) { return file.stem().string() + "-"; }

ordered_json to_json(const PolicyFile& policy, const std::string& weights_name, std::string_view weights) {
  ordered_json settings = ordered_json::object();
  for (const auto& [key, value] : policy.settings) settings[key] = value;
  ordered_json actions = ordered_json::array();
  for (const auto& [type, n_parameters] : policy.actions) {
    actions.push_back({{"type", type}, {"parameters", n_parameters}});
  }
  ordered_json tensors = ordered_json::array();
  std::size_t offset = 0;
  for (const auto& [name, values] : policy.tensors) {
    tensors.push_back({{"name", name}, {"offset", offset}, {"count", values.size()}});
    offset += values.size() * sizeof(float);
  }
  const PolicyFile::Facts& facts = policy.training;
  return {{"modsearch", 1},
          {"agent", policy.agent},
          {"settings", std::move(settings)},
          {"observationSize", policy.observation_size},
          {"actions", std::move(actions)},
          {"problem", policy.problem},
          {"library", policy.library},
          {"training",
           {{"version", facts.version},
            {"preset", facts.preset},
            {"seed", facts.seed},
            {"episodes", facts.episodes},
            {"steps", facts.steps},
            {"updates", facts.updates},
            {"seconds", facts.seconds},
            {"meanReturn", facts.mean_return ? ordered_json(*facts.mean_return) : ordered_json(nullptr)}}},
          {"weights",
           {{"file", weights_name},
            {"bytes", weights.size()},
            {"crc32c", checksum(weights)},
            {"tensors", std::move(tensors)}}}};
}

/// The weights that the policy at `file` uses, if there is one and they are its own.
std::optional<std::string> own_weights(const std::filesystem::path& file) {
  try {
    const detail::JsonDocument document = detail::load_json(file);
    const std::string name = document.cursor().at("weights").at("file").text();
    if (name.starts_with(weights_prefix(file)) && name.find('/') == std::string::npos) return name;
  } catch (const FileError&) {  // whatever is there gives way to the new policy
  }
  return std::nullopt;
}

PolicyFile::Facts read_facts(const JsonCursor& cursor) {
  cursor.expect_keys({"version", "preset", "seed", "episodes", "steps", "updates", "seconds", "meanReturn"});
  PolicyFile::Facts facts;
  facts.version = cursor.at("version").text();
  facts.preset = cursor.at("preset").text();
  facts.seed = cursor.at("seed").unsigned_integer();
  facts.episodes = cursor.at("episodes").integer(0, kMost);
  facts.steps = cursor.at("steps").integer(0, kMost);
  facts.updates = cursor.at("updates").integer(0, kMost);
  facts.seconds = cursor.at("seconds").number({.lower = 0.0});
  const JsonCursor mean_return = cursor.at("meanReturn");
  if (!mean_return.value().is_null()) facts.mean_return = mean_return.number();
  return facts;
}

std::vector<PolicyFile::Action> read_actions(const JsonCursor& cursor) {
  std::vector<PolicyFile::Action> actions;
  for (const JsonCursor& entry : cursor.items()) {
    entry.expect_keys({"type", "parameters"});
    const JsonCursor type = entry.at("type");
    const bool seen = std::any_of(actions.begin(), actions.end(),
                                  [&](const PolicyFile::Action& action) { return action.type == type.text(); });
    if (type.text().empty() || seen) type.fail_value("a type given once");
    actions.push_back({type.text(), static_cast<int>(entry.at("parameters").integer(0, kMostNumbers))});
  }
  if (actions.empty() || actions.size() > HybridSpace::kMaxActions) {
    cursor.fail(fmt::format("has {} actions, not in [1, {}]", actions.size(), HybridSpace::kMaxActions));
  }
  return actions;
}

/// The bytes of the weights, as many as the document says and with its checksum.
std::string read_weights(const JsonCursor& cursor) {
  const auto size = static_cast<std::uintmax_t>(cursor.at("bytes").integer(0, kMostBytes));
  const auto expected =
      static_cast<std::uint32_t>(cursor.at("crc32c").integer(0, std::numeric_limits<std::uint32_t>::max()));
  const std::filesystem::path file = cursor.source().directory / cursor.at("file").text();
  const std::string label = fmt::format("{} -> {}", cursor.source().label, file.string());
  std::string bytes = detail::read_text(file, label, size);
  if (bytes.size() != size) throw FileError(fmt::format("{}: has {} bytes (limit {})", label, bytes.size(), size));
  if (checksum(bytes) != expected) {
    throw FileError(fmt::format("{}: was altered: its checksum is {}, not {}", label, checksum(bytes), expected));
  }
  return bytes;
}

std::vector<std::pair<std::string, std::vector<float>>> read_tensors(const JsonCursor& cursor) {
  cursor.expect_keys({"file", "bytes", "crc32c", "tensors"});
  const std::string bytes = read_weights(cursor);
  std::vector<std::pair<std::string, std::vector<float>>> tensors;
  std::set<std::string> names;
  std::size_t offset = 0;
  const JsonCursor list = cursor.at("tensors");
  for (const JsonCursor& entry : list.items()) {
    entry.expect_keys({"name", "offset", "count"});
    const JsonCursor name = entry.at("name");
    if (name.text().empty() || !names.insert(name.text()).second) name.fail_value("a name given once");
    const JsonCursor begin = entry.at("offset");
    if (static_cast<std::size_t>(begin.integer(0, kMostBytes)) != offset) {
      begin.fail_value(fmt::format("{}, where the tensor before it ends", offset));
    }
    const auto most = static_cast<std::int64_t>((bytes.size() - offset) / sizeof(float));
    std::vector<float> values(static_cast<std::size_t>(entry.at("count").integer(0, most)));
    if (!values.empty()) std::memcpy(values.data(), bytes.data() + offset, values.size() * sizeof(float));
    if (!std::all_of(values.begin(), values.end(), [](float value) { return std::isfinite(value); })) {
      name.fail(fmt::format("tensor {} holds numbers that are not finite", detail::preview(name.value())));
    }
    offset += values.size() * sizeof(float);
    tensors.emplace_back(name.text(), std::move(values));
  }
  if (offset != bytes.size()) {
    list.fail(fmt::format("the tensors end at byte {} of {} (limit: at the last)", offset, bytes.size()));
  }
  return tensors;
}

}  // namespace

HybridSpace PolicyFile::space() const {
  std::vector<int> counts;
  for (const Action& action : actions) counts.push_back(action.n_parameters);
  return HybridSpace{std::move(counts)};
}

void write_policy(const std::filesystem::path& file, const PolicyFile& policy) {
  check(policy);
  const std::string weights = joined(policy);
  const std::string name = fmt::format("{}{:08x}.bin", weights_prefix(file), checksum(weights));
  const std::optional<std::string> former = own_weights(file);
  write_file(file.parent_path() / name, weights);
  write_file(file, detail::to_text(to_json(policy, name, weights)));
  if (former && *former != name) {
    std::error_code ignored;  // at worst an unused file stays behind
    std::filesystem::remove(file.parent_path() / *former, ignored);
  }
}

PolicyFile load_policy(const std::filesystem::path& file) {
  const detail::JsonDocument document = detail::load_json(file);
  const JsonCursor root = document.cursor();
  root.expect_keys(
      {"modsearch", "agent", "settings", "observationSize", "actions", "problem", "library", "training", "weights"});
  static_cast<void>(root.at("modsearch").integer(1, 1));
  PolicyFile policy;
  policy.agent = root.at("agent").text();
  if (policy.agent.empty()) root.at("agent").fail_value("the name of an agent");
  for (const auto& [key, value] : root.at("settings").members()) policy.settings[key] = value.text();
  policy.observation_size = static_cast<int>(root.at("observationSize").integer(1, kMostNumbers));
  policy.actions = read_actions(root.at("actions"));
  policy.problem = root.at("problem").text();
  policy.library = root.at("library").text();
  policy.training = read_facts(root.at("training"));
  policy.tensors = read_tensors(root.at("weights"));
  return policy;
}

}  // namespace modsearch
