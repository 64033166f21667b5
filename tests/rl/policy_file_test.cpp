#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <modsearch/problem/files.hpp>
#include <modsearch/rl/policy_file.hpp>
#include <modsearch/solvers/crc32c.hpp>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "problem/temporary_folder.hpp"

namespace modsearch {
namespace {

using nlohmann::json;
using test::TemporaryFolder;
using test::text_of;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

PolicyFile sample() {
  PolicyFile policy;
  policy.agent = "mpdqn";
  policy.settings = {{"gamma", "0.95"}, {"observation", "scaled"}, {"value_hidden", "128x64"}};
  policy.observation_size = 41;
  policy.actions = {{"link", 1}, {"hinge", 2}, {"rotary", 2}};
  policy.problem = "../seed_\"random\".json";
  policy.library = "seed";
  policy.training = {.version = "0.1.0",
                     .preset = "best",
                     .seed = std::numeric_limits<std::uint64_t>::max(),
                     .episodes = 50'000,
                     .steps = 60'000,
                     .updates = 59'000,
                     .seconds = 12.5,
                     .mean_return = 341.25};
  policy.tensors = {
      {"value", {1.0F, -0.5F, std::numeric_limits<float>::denorm_min()}}, {"nothing", {}}, {"actor", {0.1F}}};
  return policy;
}

std::filesystem::path weights_of(const std::filesystem::path& file) {
  return file.parent_path() / json::parse(text_of(file))["weights"]["file"].get<std::string>();
}

std::string refusal(const std::filesystem::path& file) {
  try {
    static_cast<void>(load_policy(file));
  } catch (const FileError& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr(file.string()), Not(HasSubstr("\n"))));
    return error.what();
  }
  return "no refusal";
}

TEST(PolicyFile, GivesBackBitByBitWhatWasWritten) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "policy.json";
  write_policy(file, sample());
  EXPECT_EQ(load_policy(file), sample());
  PolicyFile other = sample();
  other.training.mean_return.reset();
  write_policy(file, other);
  EXPECT_EQ(load_policy(file), other);
}

TEST(PolicyFile, HasTheHybridSpaceOfItsActions) { EXPECT_EQ(sample().space(), HybridSpace({1, 2, 2})); }

TEST(PolicyFile, KeepsPlainNumbersBesideTheDocument) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "policy.json";
  write_policy(file, sample());
  const std::string weights = text_of(weights_of(file));
  ASSERT_EQ(weights.size(), 16U);
  EXPECT_EQ(weights.substr(0, 8), std::string("\x00\x00\x80\x3f\x00\x00\x00\xbf", 8));  // 1.0F, -0.5F
  const json document = json::parse(text_of(file));
  EXPECT_EQ(document["weights"]["crc32c"].get<std::uint32_t>(), crc32c(std::as_bytes(std::span{weights})));
  EXPECT_EQ(document["weights"]["tensors"][2], json::parse(R"({"name": "actor", "offset": 12, "count": 1})"));
}

TEST(PolicyFile, CanBeMovedWithItsWeights) {
  const TemporaryFolder folder;
  write_policy(folder.path() / "policy.json", sample());
  std::filesystem::create_directories(folder.path() / "other");
  for (const auto& entry : std::filesystem::directory_iterator{folder.path()}) {
    if (entry.is_regular_file()) std::filesystem::rename(entry, folder.path() / "other" / entry.path().filename());
  }
  EXPECT_EQ(load_policy(folder.path() / "other" / "policy.json"), sample());
}

TEST(PolicyFile, LeavesNothingOfThePolicyThatItReplaces) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "policy.json";
  const auto neighbour = folder.path() / "best.json";
  PolicyFile other = sample();
  other.tensors[0].second[0] = 2.0F;
  write_policy(neighbour, sample());
  write_policy(file, sample());
  write_policy(file, other);
  write_policy(file, other);
  EXPECT_EQ(load_policy(file), other);
  EXPECT_EQ(load_policy(neighbour), sample());
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator{folder.path()}, {}), 4);
}

TEST(PolicyFile, ReplacesWhateverIsThere) {
  const TemporaryFolder folder;
  const auto file = folder.write("policy.json", "{ broken");
  write_policy(file, sample());
  EXPECT_EQ(load_policy(file), sample());
}

struct Bad {
  const char* pointer;
  json value;  // null: the key goes
  std::vector<std::string> parts;
};

TEST(PolicyFile, RefusesEveryFaultOfTheDocumentByItsPlace) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "policy.json";
  write_policy(file, sample());
  const json whole = json::parse(text_of(file));
  const Bad faults[] = {
      {"/modsearch", 2, {"at /modsearch: 2 is not an integer in [1, 1]"}},
      {"/agent", "", {"at /agent: \"\" is not the name of an agent"}},
      {"/agent", nullptr, {"at the top level: key \"agent\" is missing"}},
      {"/colour", "red", {"key \"colour\" is not known here"}},
      {"/settings/gamma", 0.95, {"at /settings/gamma: 0.95 is not a text"}},
      {"/observationSize", 0, {"at /observationSize: 0 is not an integer in [1, "}},
      {"/actions", json::array(), {"at /actions: has 0 actions, not in [1, 64]"}},
      {"/actions/1/type", "link", {"at /actions/1/type: \"link\" is not a type given once"}},
      {"/actions/1/parameters", -1, {"at /actions/1/parameters: -1 is not an integer in [0, "}},
      {"/problem", 3, {"at /problem: 3 is not a text"}},
      {"/library", nullptr, {"key \"library\" is missing"}},
      {"/training/seed", -1, {"at /training/seed: -1 is not an integer in [0, "}},
      {"/training/episodes", 1.5, {"at /training/episodes: 1.5 is not an integer"}},
      {"/training/seconds", -1.0, {"at /training/seconds: -1"}},
      {"/training/meanReturn", "high", {"at /training/meanReturn: \"high\" is not a number"}},
      {"/weights/file", "none.bin", {" -> ", "none.bin: there is no such file"}},
      {"/weights/bytes", 12, {"has 16 bytes, which is too many (limit 12)"}},
      {"/weights/bytes", 20, {"has 16 bytes (limit 20)"}},
      {"/weights/crc32c", 1, {"was altered: its checksum is ", ", not 1"}},
      {"/weights/tensors/0/name", "actor", {"at /weights/tensors/2/name: \"actor\" is not a name given once"}},
      {"/weights/tensors/1/offset", 8, {"at /weights/tensors/1/offset: 8 is not 12, where the tensor before it ends"}},
      {"/weights/tensors/2/count", 2, {"at /weights/tensors/2/count: 2 is not an integer in [0, 1]"}},
      {"/weights/tensors/2/count", 0, {"at /weights/tensors: the tensors end at byte 12 of 16"}},
  };
  for (const Bad& bad : faults) {
    json document = whole;
    const json::json_pointer pointer{bad.pointer};
    if (bad.value.is_null()) {
      document[pointer.parent_pointer()].erase(pointer.back());
    } else {
      document[pointer] = bad.value;
    }
    folder.write("policy.json", document.dump());
    const std::string sentence = refusal(file);
    for (const std::string& part : bad.parts) EXPECT_THAT(sentence, HasSubstr(part)) << bad.pointer;
  }
}

TEST(PolicyFile, RefusesWeightsThatWereAltered) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "policy.json";
  write_policy(file, sample());
  const std::string name = weights_of(file).filename().string();
  const std::string weights = text_of(weights_of(file));
  for (std::size_t i = 0; i < weights.size(); ++i) {
    std::string altered = weights;
    altered[i] = static_cast<char>(altered[i] ^ 1);
    folder.write(name, altered);
    EXPECT_THAT(refusal(file), HasSubstr("was altered")) << i;
  }
  folder.write(name, weights.substr(0, 15));
  EXPECT_THAT(refusal(file), HasSubstr("has 15 bytes (limit 16)"));
}

TEST(PolicyFile, RefusesWeightsThatAreNotFinite) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "policy.json";
  write_policy(file, sample());
  const std::string weights(
      "\x00\x00\xc0\x7f"
      "123456789012",
      16);  // a NaN first
  json document = json::parse(text_of(file));
  document["weights"]["crc32c"] = crc32c(std::as_bytes(std::span{weights}));
  folder.write(weights_of(file).filename().string(), weights);
  folder.write("policy.json", document.dump());
  EXPECT_THAT(refusal(file),
              HasSubstr("at /weights/tensors/0/name: tensor \"value\" holds numbers that are not finite"));
}

TEST(PolicyFile, IsNotWrittenIfItCouldNotBeReadBack) {
  const TemporaryFolder folder;
  const auto refused = [&](auto&& change) {
    PolicyFile policy = sample();
    change(policy);
    EXPECT_THROW(write_policy(folder.path() / "policy.json", policy), std::invalid_argument);
  };
  refused([](PolicyFile& policy) { policy.agent.clear(); });
  refused([](PolicyFile& policy) { policy.observation_size = 0; });
  refused([](PolicyFile& policy) { policy.actions.clear(); });
  refused([](PolicyFile& policy) { policy.actions[0].n_parameters = -1; });
  refused([](PolicyFile& policy) { policy.actions[1].type = "link"; });
  refused([](PolicyFile& policy) { policy.tensors[1].first = "actor"; });
  refused([](PolicyFile& policy) { policy.tensors[0].second[1] = std::numeric_limits<float>::quiet_NaN(); });
  refused([](PolicyFile& policy) { policy.training.seconds = -1.0; });
  refused([](PolicyFile& policy) { policy.training.mean_return = std::numeric_limits<double>::infinity(); });
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
  EXPECT_THROW(write_policy(folder.path() / "none" / "policy.json", sample()), FileError);
}

}  // namespace
}  // namespace modsearch
