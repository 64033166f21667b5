// What one command writes, every other takes: solutions of every built-in family, by solvers of every kind, through
// every command that reads one and every format that they can be converted to.
#include <gmock/gmock.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "app/command.hpp"

namespace modsearch::testing {
namespace {

using nlohmann::json;

struct Case {
  std::string problem;
  std::string instance;  // empty: fixed
  std::string solver;
  std::string fidelity;  // "path" or empty

  [[nodiscard]] std::string name() const { return problem + " " + instance + " " + solver + " " + fidelity; }
};

void add_instance(std::vector<std::string>& arguments, const Case& c) {
  if (!c.instance.empty()) arguments.insert(arguments.end(), {"--instance", c.instance});
}

// Writes the solution of `c` into `folder`/o and gives what the program said.
json solved(const Case& c, const TemporaryFolder& folder) {
  std::vector<std::string> arguments{"solve",     c.problem, "--solver", c.solver, "--evaluations", "60",
                                     "--seconds", "4",       "--json",   "--out",  folder / "o"};
  add_instance(arguments, c);
  if (!c.fidelity.empty()) arguments.insert(arguments.end(), {"--fidelity", c.fidelity});
  const Outcome outcome = modsearch(arguments, folder);
  EXPECT_TRUE(outcome.status == 0 || outcome.status == 1) << outcome.err;
  return json::parse(outcome.out);
}

double score_of(const Case& c, const std::string& file, const TemporaryFolder& folder) {
  std::vector<std::string> arguments{"evaluate", c.problem, file, "--json"};
  add_instance(arguments, c);
  const Outcome outcome = modsearch(arguments, folder);
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  return outcome.status == 0 ? json::parse(outcome.out).at("score").get<double>() : 0.0;
}

// The postures that are reported are those of the path, where there is one.
void expect_one_answer(const json& solution) {
  if (!solution.contains("trajectory") || !solution.contains("postures")) return;
  const json& rows = solution.at("trajectory").at("q");
  const json& postures = solution.at("postures");
  for (const json& posture : postures) {
    const bool on_the_way = std::any_of(rows.begin(), rows.end(), [&](const json& row) { return row == posture; });
    EXPECT_TRUE(on_the_way) << posture;
  }
}

void expect_taken_everywhere(const Case& c) {
  SCOPED_TRACE(c.name());
  const TemporaryFolder folder;
  const json said = solved(c, folder);
  const std::string file = folder / "o/solution.json";
  const json solution = json::parse(read_text(file));
  expect_one_answer(solution);

  const Outcome verified = modsearch({"verify", file}, folder);
  EXPECT_EQ(verified.status, said.at("verified") == true ? 0 : 1) << verified.out << verified.err;
  const Outcome page = modsearch({"render", file, "--out", folder / "page.html"}, folder);
  EXPECT_EQ(page.status, 0) << page.err;
  if (c.fidelity.empty()) {
    EXPECT_EQ(score_of(c, file, folder), said.at("score").get<double>());
  }

  for (const char* kind : {"modsearch", "timor", "cobra", "urdf"}) {
    const std::string out = folder / (std::string{kind} + (kind == std::string{"urdf"} ? ".urdf" : ".json"));
    const Outcome converted = modsearch({"convert", file, out, "--to", kind}, folder);
    EXPECT_EQ(converted.status, 0) << kind << ": " << converted.err;
  }
  if (c.fidelity.empty()) {
    EXPECT_EQ(score_of(c, folder / "modsearch.json", folder), said.at("score").get<double>());
  }
}

TEST(RoundTrips, TakeSolutionsOfEveryFamilyByEveryKindOfSolver) {
  const char* families[] = {"breakeven/short",   "breakeven/two_goals",    "breakeven/three_goals",
                            "breakeven/clutter", "breakeven/clutter_path", "seed/random_narrow",
                            "seed/random_wide",  "seed/random_obstacles",  "whitman/3g_3o",
                            "whitman/5g_5o",     "workshop/reach"};
  const char* solvers[] = {"auto", "random", "ga", "per-sequence"};
  int i = 0;
  for (const char* family : families) {
    for (int instance = 0; instance < 2; ++instance, ++i) {
      const std::string fidelity = i % 3 == 0 ? "path" : "";
      expect_taken_everywhere({family, "3:" + std::to_string(instance), solvers[i % 4], fidelity});
    }
  }
  for (const char* solver : solvers) {
    expect_taken_everywhere({"seed/fixed", "", solver, ""});
    expect_taken_everywhere({"seed/fixed", "", solver, "path"});
  }
  expect_taken_everywhere({"workshop/cell", "", "random", ""});
}

// A design's modules as a library of Timor's, its solution in CoBRA's keys, and both together read back: the design has
// other names and no lengths, and is worth the same.
TEST(RoundTrips, ReadADesignBackFromTheNeighboursFormats) {
  const TemporaryFolder folder;
  const json said = solved({"seed/fixed", "", "per-sequence", ""}, folder);
  const std::string solution = folder / "o/solution.json";
  for (const auto& [kind, out] : {std::pair{"timor", "frozen.json"}, std::pair{"cobra", "cobra.json"}}) {
    ASSERT_EQ(modsearch({"convert", solution, folder / out, "--to", kind}, folder).status, 0) << kind;
  }
  const Outcome back =
      modsearch({"convert", folder / "cobra.json", folder / "back.json", "--library", folder / "frozen.json"}, folder);
  ASSERT_EQ(back.status, 0) << back.err;
  ASSERT_EQ(modsearch({"convert", "seed/fixed", folder / "problem.json"}, folder).status, 0);
  json problem = json::parse(read_text(folder / "problem.json"));
  problem["library"] = "frozen.json";
  std::ofstream{folder / "frozen_problem.json"} << problem;
  const Outcome evaluated =
      modsearch({"evaluate", folder / "frozen_problem.json", folder / "back.json", "--json"}, folder);
  ASSERT_EQ(evaluated.status, 0) << evaluated.err;
  EXPECT_NEAR(json::parse(evaluated.out).at("score").get<double>(), said.at("score").get<double>(), 1e-9);
}

}  // namespace
}  // namespace modsearch::testing
