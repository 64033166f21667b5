#include <gtest/gtest.h>

#include <limits>
#include <modsearch/study/page.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "study/demo_page.hpp"

namespace modsearch {
namespace {

using testing::demo_page;

int occurrences(std::string_view text, std::string_view what) {
  int count = 0;
  for (std::size_t at = text.find(what); at != std::string_view::npos; at = text.find(what, at + 1)) ++count;
  return count;
}

// The data as the page's own script reads it: the text of the element, which ends at the first "</script".
nlohmann::json data_of(const std::string& html) {
  const std::string_view open = R"(<script type="application/json" id="data">)";
  const std::size_t begin = html.find(open) + open.size();
  return nlohmann::json::parse(html.substr(begin, html.find("</script", begin) - begin));
}

std::string refusal(const Page& page) {
  try {
    (void)write_page(page);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "not refused";
}

TEST(Page, IsOneDocumentThatNamesNoOtherFile) {
  const std::string html = write_page(demo_page());
  EXPECT_EQ(html.rfind("<!DOCTYPE html>", 0), 0u);
  EXPECT_EQ(occurrences(html, "</html>"), 1);
  EXPECT_EQ(occurrences(html, "<script src"), 0);
  EXPECT_EQ(occurrences(html, "<link rel=\"stylesheet\""), 0);
  EXPECT_EQ(occurrences(html, "@import"), 0);
  // Should something slip in all the same, the browser refuses to load it.
  EXPECT_NE(html.find("default-src 'none'"), std::string::npos);
}

TEST(Page, CarriesTheLibrariesItDrawsWith) {
  const std::string html = write_page(demo_page());
  EXPECT_NE(html.find("OrbitControls = function"), std::string::npos);
  EXPECT_NE(html.find("WebGLRenderer"), std::string::npos);
  for (const char* place : {"{{css}}", "{{data}}", "{{three}}", "{{orbit_controls}}", "{{script}}", "{{title}}"}) {
    EXPECT_EQ(html.find(place), std::string::npos) << place << " was not filled";
  }
}

TEST(Page, NamesTheLicenceOfWhatItCarries) {
  EXPECT_NE(write_page(demo_page()).find("three.js authors, MIT licence"), std::string::npos);
}

TEST(Page, KeepsHostileTextOutOfTheMarkup) {
  const std::string hostile = "</script><script>alert(1)</script><!--<script>&lt;\"'`{{three}}\xE2\x80\xA8\n\\u003c";
  Page page = demo_page();
  const std::string plain = write_page(page);
  page.title = page.problem = page.solver = page.seed = page.command = page.verified = page.reason = hostile;
  page.terms[0].name = page.modules[1].type = page.modules[1].parameters[0].name = hostile;
  page.modules[1].parameters[0].unit = page.bodies[0].name = page.bodies[0].shapes[0].name = hostile;
  page.bodies[0].joints[0].name = page.obstacles[0].name = page.targets[0].name = page.targets[0].miss =
      page.milestones[0].name = hostile;
  const std::string html = write_page(page);

  for (const char* tag : {"<script", "</script", "<!--", "</title"}) {
    EXPECT_EQ(occurrences(html, tag), occurrences(plain, tag)) << tag;
  }
  EXPECT_EQ(occurrences(html, "alert(1)"), occurrences(html, "u003ealert(1)") + occurrences(html, "&gt;alert(1)"));
  const nlohmann::json data = data_of(html);
  EXPECT_EQ(data["facts"]["problem"], hostile);
  EXPECT_EQ(data["facts"]["modules"][1]["parameters"][0]["unit"], hostile);
  EXPECT_EQ(data["scene"]["targets"][0]["name"], hostile);
  EXPECT_EQ(data["scene"]["bodies"][0]["joints"][0]["name"], hostile);
}

TEST(Page, ReplacesBytesThatAreNotUtf8) {
  Page page = demo_page();
  page.solver = "a\xFFz";
  EXPECT_EQ(data_of(write_page(page))["facts"]["solver"], "a\xEF\xBF\xBDz");
}

TEST(Page, SaysEveryNumberOfTheSolution) {
  const nlohmann::json facts = data_of(write_page(demo_page()))["facts"];
  EXPECT_DOUBLE_EQ(facts["score"], 188.0);
  EXPECT_DOUBLE_EQ(facts["mass"], 2.0);
  EXPECT_EQ(facts["evaluations"], 4210);
  EXPECT_DOUBLE_EQ(facts["goalError"], 0.00098);
  EXPECT_EQ(facts["modules"].size(), 3u);
  EXPECT_EQ(facts["trace"].size(), 7u);
  double sum = 0.0;
  for (const nlohmann::json& term : facts["terms"]) sum += term["value"].get<double>();
  EXPECT_DOUBLE_EQ(sum, facts["score"]);
}

TEST(Page, LeavesWhatIsNotKnownOpen) {
  const nlohmann::json facts = data_of(write_page(Page{}))["facts"];
  for (const char* key : {"score", "mass", "seconds", "clearance", "goalError"})
    EXPECT_TRUE(facts[key].is_null()) << key;
}

TEST(Page, WritesAPoseAsTheUpperThreeRowsRoundedToAMicrometre) {
  Page page;
  page.bodies.resize(1);
  page.bodies[0].keyframes = {{0, -1, 0, 0.12345678, 1, 0, 0, -1e-9, 0, 0, 1, 2, 0, 0, 0, 1}};
  EXPECT_EQ(data_of(write_page(page))["scene"]["bodies"][0]["keyframes"][0].dump(),
            "[0.0,-1.0,0.0,0.123457,1.0,0.0,0.0,0.0,0.0,0.0,1.0,2.0]");
}

TEST(Page, TakesASolutionWithoutAPath) {
  const nlohmann::json scene = data_of(write_page(demo_page(1)))["scene"];
  EXPECT_EQ(scene["samples"], 1);
  EXPECT_TRUE(scene["times"].empty());
}

TEST(Page, CarriesWhatIsMissedAndWhatTouches) {
  Page page = demo_page(1);
  page.targets[0].miss = "12 mm outside its tolerance";
  page.touches = {{.body = 1, .obstacle = true, .other = 2, .position = {0.1, 0.2, 0.3}, .depth = 0.004}};
  const nlohmann::json scene = data_of(write_page(page))["scene"];
  EXPECT_EQ(scene["targets"][0]["miss"], "12 mm outside its tolerance");
  EXPECT_EQ(scene["touches"][0]["body"], 1);
  EXPECT_EQ(scene["touches"][0]["other"], 2);
  EXPECT_EQ(scene["touches"][0]["position"].dump(), "[0.1,0.2,0.3]");
  EXPECT_EQ(scene["touches"][0]["depth"], 0.004);
}

TEST(Page, RefusesATouchOfSomethingThatIsNotThere) {
  Page page = demo_page(1);
  const std::string n = std::to_string(page.obstacles.size());
  page.touches = {{.body = 0, .obstacle = true, .other = static_cast<int>(page.obstacles.size())}};
  EXPECT_EQ(refusal(page), "write_page: something touches obstacle " + n + " of " + n);
}

TEST(Page, TakesMeshes) {
  Page page = demo_page();
  page.obstacles[0].shapes = {
      {.kind = PageShapeKind::kMesh, .vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, .triangles = {{0, 1, 2}}}};
  const nlohmann::json shape = data_of(write_page(page))["scene"]["obstacles"][0]["shapes"][0];
  EXPECT_EQ(shape["kind"], "mesh");
  EXPECT_EQ(shape["vertices"].size(), 9u);
  EXPECT_EQ(shape["triangles"].dump(), "[0,1,2]");
}

TEST(Page, OfALongPathIsBelowThreeMegabytes) {
  // The libraries are 0.9 MB. Twelve numbers of at most ten characters for each of four bodies at each of 2000 samples
  // are another megabyte; the tip and the times are small beside it.
  EXPECT_LT(write_page(demo_page(2000)).size(), 3'000'000u);
}

TEST(Page, RefusesAWrongNumberOfSizes) {
  Page page = demo_page();
  page.obstacles[2].shapes[0].size = {0.3, 0.4};
  EXPECT_EQ(refusal(page), "write_page: the box of body 'box' has 2 sizes instead of 3");
}

TEST(Page, RefusesABodyWithAnotherNumberOfSamples) {
  Page page = demo_page(60);
  page.bodies[1].keyframes.resize(59);
  EXPECT_EQ(refusal(page), "write_page: body 'hinge 1, distal' has 59 keyframes; the path has 60 samples");
}

TEST(Page, RefusesABodyThatIsNowhere) {
  Page page = demo_page(60);
  page.obstacles[0].keyframes.clear();
  EXPECT_EQ(refusal(page), "write_page: body 'sphere 1' has 0 keyframes; the path has 60 samples");
}

TEST(Page, RefusesATipPathOfAnotherLength) {
  Page page = demo_page(60);
  page.tip.pop_back();
  EXPECT_EQ(refusal(page), "write_page: tip has 59 entries; the path has 60 samples");
}

TEST(Page, RefusesTimesThatRunBackwards) {
  Page page = demo_page(60);
  page.times[30] = 0.0;
  EXPECT_EQ(refusal(page), "write_page: times decrease");
}

TEST(Page, RefusesAPoseThatIsNotFinite) {
  Page page = demo_page();
  page.bodies[0].keyframes[7][3] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(refusal(page), "write_page: the pose of body 'hinge 1, proximal' is not finite");
}

TEST(Page, RefusesATriangleWithoutItsVertex) {
  Page page = demo_page();
  page.obstacles[0].shapes = {
      {.kind = PageShapeKind::kMesh, .vertices = {{0, 0, 0}, {1, 0, 0}}, .triangles = {{0, 1, 2}}}};
  EXPECT_EQ(refusal(page), "write_page: the mesh of body 'sphere 1' names vertex 2 of 2");
}

TEST(Page, RefusesAMilestoneBeyondThePath) {
  Page page = demo_page(60);
  page.milestones[1].sample = 60;
  EXPECT_EQ(refusal(page), "write_page: milestone 'target' stands at sample 60 of 60");
}

}  // namespace
}  // namespace modsearch
