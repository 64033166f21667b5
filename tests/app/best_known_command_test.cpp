#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "app/command.hpp"

namespace modsearch {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;
using testing::modsearch;
using testing::Outcome;
using testing::read_text;
using testing::TemporaryFolder;

void write(const std::string& file, const std::string& text) { std::ofstream{file} << text; }

TEST(BestKnownCommand, KeepsWhatVerifiesAndRefusesTheRestWithASentence) {
  const TemporaryFolder folder;
  (void)modsearch({"solve", "seed/random_obstacles", "--instance", "0:3", "--out", folder / "out"}, folder);
  const std::string file = folder / "out/solution.json";
  const Outcome first = modsearch({"best-known", file, "--tables", folder / "tables"}, folder);
  EXPECT_EQ(first.status, 0) << first.out << first.err;
  EXPECT_THAT(first.out, HasSubstr("1 added, 0 improved, 0 not better"));
  EXPECT_TRUE(std::filesystem::exists(folder / "tables/seed/random_obstacles.json"));
  const json again = json::parse(modsearch({"best-known", file, "--tables", folder / "tables", "--json"}, folder).out);
  EXPECT_EQ(again.at("families").at(0).at("kept"), 1);
  EXPECT_TRUE(again.at("files").empty());
  json boasting = json::parse(read_text(file));
  boasting["score"] = boasting["score"].get<double>() + 1.0;
  boasting["terms"][0]["value"] = boasting["terms"][0]["value"].get<double>() + 1.0;
  write(folder / "boasting.json", boasting.dump());
  const Outcome refused = modsearch({"best-known", folder / "boasting.json", "--tables", folder / "tables"}, folder);
  EXPECT_EQ(refused.status, 1) << refused.out << refused.err;
  EXPECT_THAT(refused.out, HasSubstr("boasting.json: the design for instance 0:3 of seed/random_obstacles does not "
                                     "verify: the score is"));
  EXPECT_EQ(modsearch({"best-known", folder / "absent.json"}, folder).status, 2);
}

}  // namespace
}  // namespace modsearch
