#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <modsearch/study/report.hpp>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <string_view>

#include "problem/temporary_folder.hpp"
#include "study/synthetic_study.hpp"

namespace modsearch {
namespace {

using nlohmann::json;
using testing::synthetic_study;

int occurrences(std::string_view text, std::string_view what) {
  int count = 0;
  for (std::size_t at = text.find(what); at != std::string_view::npos; at = text.find(what, at + 1)) ++count;
  return count;
}

json data_of(const std::string& html) {
  const std::string_view open = R"(<script type="application/json" id="data">)";
  const std::size_t begin = html.find(open) + open.size();
  return json::parse(html.substr(begin, html.find("</script", begin) - begin));
}

const ReportOptions kQuick{.bootstrap = {.resamples = 50}};

TEST(Report, IsOneDocumentThatNamesNoOtherFile) {
  const std::string html = report_page(synthetic_study({.instances = 2, .seeds = 2}), {}, kQuick);
  EXPECT_EQ(html.rfind("<!DOCTYPE html>", 0), 0u);
  EXPECT_EQ(occurrences(html, "<script src"), 0);
  EXPECT_EQ(occurrences(html, "<link rel=\"stylesheet\""), 0);
  EXPECT_NE(html.find("default-src 'none'"), std::string::npos);
  EXPECT_NE(html.find("Chart.js contributors, MIT licence"), std::string::npos);
  for (const char* place : {"{{css}}", "{{data}}", "{{chart}}", "{{script}}", "{{title}}"}) {
    EXPECT_EQ(html.find(place), std::string::npos) << place << " was not filled";
  }
}

TEST(Report, KeepsHostileTextOutOfTheMarkup) {
  const std::string hostile = "</script><script>alert(1)</script><!--&\"'{{chart}}";
  StudyRecord record = synthetic_study({.instances = 2, .seeds = 2});
  const std::string plain = report_page(record, {}, kQuick);
  record.study.name = record.study.command = record.study.compiler = hostile;
  record.study.solvers[1].label = record.study.solvers[1].solver = hostile;
  for (CellRecord& cell : record.cells) {
    if (cell.key.label == "slow") cell.key.label = hostile;
    if (cell.state == CellState::kFailed) cell.failure = hostile;
  }
  const std::string html = report_page(record, {}, kQuick);
  for (const char* tag : {"<script", "</script", "<!--", "</title"}) {
    EXPECT_EQ(occurrences(html, tag), occurrences(plain, tag)) << tag;
  }
  EXPECT_EQ(data_of(html)["solvers"][1]["label"], hostile);
  EXPECT_EQ(data_of(html)["groups"][0]["rows"][1]["label"], hostile);
}

TEST(Report, IsTheSameForTheSameJournal) {
  const StudyRecord record = synthetic_study({.instances = 3, .seeds = 3});
  EXPECT_EQ(report_page(record, {}, kQuick), report_page(record, {}, kQuick));
}

TEST(Report, TellsWhatTheStudyShows) {
  const json data = data_of(report_page(synthetic_study({.instances = 4, .seeds = 3}), {}, kQuick));
  ASSERT_EQ(data["groups"].size(), 3u) << "both problems, and all together";
  const json& narrow = data["groups"][1];
  EXPECT_EQ(narrow["name"], "seed/random_narrow");
  EXPECT_EQ(narrow["bounded"], 4);
  ASSERT_EQ(narrow["rows"].size(), 3u);
  EXPECT_EQ(narrow["rows"][0]["success"][0][0], 1.0);
  EXPECT_EQ(narrow["rows"][2]["training"]["evaluations"], 20'000.0);
  // All targets of "steady" together: those that are met at the first achieved design at evaluation 4, and so on.
  const json& steps = narrow["curves"]["evaluations"]["use"][0];
  EXPECT_EQ(steps["x"][0], 4.0);
  EXPECT_GT(steps["y"].back(), 0.8);
  // Per instance, the agent's first runtime is its training and two evaluations.
  EXPECT_EQ(narrow["curves"]["evaluations"]["perInstance"][2]["x"][0], 20'002.0);
  EXPECT_EQ(data["failures"][0]["what"], "killed by signal 11");
  EXPECT_EQ(data["instances"].size(), 8u);
}

TEST(Report, GivesUnfinishedAndEmptyStudiesToo) {
  StudyRecord record = synthetic_study({.instances = 2, .seeds = 2});
  record.cells.resize(2);
  EXPECT_TRUE(data_of(report_page(record, {}, kQuick))["groups"][0]["rows"].empty());
  record.cells.clear();
  EXPECT_TRUE(data_of(report_page(record, {}, kQuick))["instances"].empty());
}

TEST(Report, IsWrittenWithAViewOfTheBestDesignOfEveryInstance) {
  const test::TemporaryFolder folder;
  const StudyRecord record = synthetic_study({.instances = 1, .seeds = 1});
  write_report(record, folder.path() / "report.html", kQuick);
  std::ostringstream html;
  html << std::ifstream{folder.path() / "report.html"}.rdbuf();
  const json data = data_of(html.str());
  for (const json& instance : data["instances"]) {
    const std::filesystem::path view = folder.path() / instance["view"].get<std::string>();
    ASSERT_TRUE(std::filesystem::exists(view)) << view;
    std::ostringstream text;
    text << std::ifstream{view}.rdbuf();
    const json facts = data_of(text.str())["facts"];
    EXPECT_EQ(facts["modules"][1]["type"], "hinge");
    EXPECT_NEAR(facts["modules"][1]["parameters"][1]["value"], instance["best"]["mass"].get<double>() - 0.5, 1e-5);
  }
}

TEST(Report, LinksNoViewWhereTheProblemCannotBeLoaded) {
  const test::TemporaryFolder folder;
  StudyRecord record = synthetic_study({.instances = 1, .seeds = 1});
  record.study.problems[0].location = "gone.json";
  record.study.problems[1].location = "";
  write_report(record, folder.path() / "report.html", kQuick);
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "views"));
}

}  // namespace
}  // namespace modsearch
