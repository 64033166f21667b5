#include <gmock/gmock.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "app/command.hpp"

namespace modsearch::testing {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::StartsWith;

TEST(Certify, ProvesWritesAndIsChecked) {
  const TemporaryFolder folder;
  const std::string file = folder / "proof/certificate.json";
  for (const char* problem : {"seed/fixed", "seed/random_narrow", "seed/random_wide", "seed/random_obstacles"}) {
    const Outcome made = modsearch({"certify", problem, "--out", file}, folder);
    EXPECT_EQ(made.status, 0) << made.err;
    EXPECT_THAT(made.out, StartsWith("proved       no design of at most 9 modules that reaches"));
    EXPECT_THAT(made.out, HasSubstr("no part      torques"));
    const Outcome checked = modsearch({"check-certificate", file}, folder);
    EXPECT_EQ(checked.status, 0) << checked.out;
    EXPECT_THAT(checked.out, StartsWith(std::string{"accepted: "} + problem));
  }

  json changed = json::parse(read_text(file));
  changed["claim"]["upper"] = changed["claim"]["upper"].get<double>() - 1.0;
  std::ofstream{file} << changed;
  const Outcome rejected = modsearch({"check-certificate", file, "--json"}, folder);
  EXPECT_EQ(rejected.status, 1);
  EXPECT_EQ(json::parse(rejected.out).at("verdict"), "rejected");
}

TEST(Certify, SpeaksJson) {
  const TemporaryFolder folder;
  const Outcome made =
      modsearch({"certify", "seed/fixed", "--gap", "0.001", "--json", "--out", folder / "c.json"}, folder);
  EXPECT_EQ(made.status, 0);
  const json answer = json::parse(made.out);
  EXPECT_EQ(answer.at("closed"), true);
  EXPECT_NEAR(answer.at("lower").get<double>(), 341.9148, 1e-3);
  EXPECT_LE(answer.at("gap").get<double>(), 0.001 + 1e-9);
}

TEST(Certify, ProvesThatFewerModulesDoNotSuffice) {
  const TemporaryFolder folder;
  const Outcome made = modsearch({"certify", "breakeven/short", "--fewer", "1", "--out", folder / "c.json"}, folder);
  EXPECT_EQ(made.status, 0) << made.out << made.err;
  EXPECT_THAT(made.out, HasSubstr("all of at most 1 module would"));
  EXPECT_EQ(modsearch({"check-certificate", folder / "c.json"}, folder).status, 0);
}

TEST(Certify, RefusesWhatIsWrong) {
  const TemporaryFolder folder;
  const Outcome to_folder = modsearch({"certify", "seed/fixed", "--out", folder.path().string()}, folder);
  EXPECT_EQ(to_folder.status, 2);
  EXPECT_THAT(to_folder.err, HasSubstr("is a folder, not the name of a file"));
  const Outcome gap = modsearch({"certify", "seed/fixed", "--gap", "0", "--out", folder / "c.json"}, folder);
  EXPECT_EQ(gap.status, 2);
  EXPECT_THAT(gap.err, HasSubstr("gap is 0, not in (0, 1]"));
  const Outcome fewer = modsearch({"certify", "seed/fixed", "--fewer", "9", "--out", folder / "c.json"}, folder);
  EXPECT_EQ(fewer.status, 2);
  EXPECT_THAT(fewer.err, HasSubstr("not in [0, 8]"));
  EXPECT_EQ(modsearch({"check-certificate", folder / "none.json"}, folder).status, 2);
}

}  // namespace
}  // namespace modsearch::testing
