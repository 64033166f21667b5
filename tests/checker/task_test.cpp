#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <checker/problem.hpp>

// Tasks as CoBRA's collection has them, read by the checker as the search reads them.

namespace modsearch_check {
namespace {

const Json kIdentity = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}};

/// A ball to be reached, with a base in `pose`.
Json task_with_base(const Json& pose) {
  const Json goal = {{"nominal", kIdentity},
                     {"toleranceProjection", Json::array({"r_sph"})},
                     {"tolerance", Json::array({Json::array({0, 0.001})})},
                     {"frame", Json::array({"nominal"})}};
  return {{"header", {{"ID", "t"}, {"taskName", nullptr}}},
          {"frames", Json::object()},
          {"constraints", Json::array({Json::object(), {{"type", "basePlacement"}, {"pose", pose}}})},
          {"goals", Json::array({{{"ID", "g"}, {"type", "reach"}, {"goalPose", goal}}})}};
}

std::string verdict(const Json& task) {
  try {
    static_cast<void>(read_task(Value{task, "task"}));
    return "read";
  } catch (const Rejected& reason) {
    return reason.what();
  }
}

Json base(const Json& projections, const Json& intervals) {
  return {{"nominal", kIdentity}, {"toleranceProjection", projections}, {"tolerance", intervals}};
}

TEST(CheckedTask, HasABaseThatIsFixedWithinTheDefaultTolerance) {
  const Json millimetre = Json::array({-0.001, 0.001});
  const Json half_degree = Json::array({0.0, 0.0087266});
  EXPECT_EQ(verdict(task_with_base({{"nominal", kIdentity}})), "read");
  EXPECT_EQ(verdict(task_with_base(base(Json::array(), Json::array()))), "read");
  EXPECT_EQ(
      verdict(task_with_base(base({"x", "y", "z", "Theta_R"}, {millimetre, millimetre, millimetre, half_degree}))),
      "read");
}

// What is not listed is free: without a limit of its turn the base may be placed, and nothing is proved.
TEST(CheckedTask, ThatLetsItsBaseBePlacedIsRejected) {
  const Json millimetre = Json::array({-0.001, 0.001});
  const Json metre = Json::array({-1.0, 1.0});
  const Json half_degree = Json::array({0.0, 0.0087266});
  EXPECT_THAT(verdict(task_with_base(base({"x", "y", "z"}, {millimetre, millimetre, millimetre}))),
              testing::HasSubstr("bases that may be placed"));
  EXPECT_THAT(verdict(task_with_base(base({"x", "Theta_R"}, {metre, half_degree}))),
              testing::HasSubstr("bases that may be placed"));
}

TEST(CheckedTask, WithPosesThatHangOnOtherFramesIsRejected) {
  Json task = task_with_base({{"nominal", kIdentity}});
  task["goals"][0]["goalPose"]["nominalParent"] = "table";
  EXPECT_THAT(verdict(task), testing::HasSubstr("other frames than the world"));
}

}  // namespace
}  // namespace modsearch_check
