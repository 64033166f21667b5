#include <gtest/gtest.h>

#include <modsearch/problem/base_placement.hpp>
#include <modsearch/problem/files.hpp>
#include <modsearch/problem/reach_bound.hpp>

namespace modsearch {
namespace {

using Stretch = ModuleSpan::Stretch;

// 1 m and 1 kg, stretched by up to 2 m at 1 kg/m: 2.5 m take 1.5 m more.
TEST(ReachBound, StretchesAModuleUntilItIsLongEnough) {
  const ModuleSpan module{.length = 1.0, .mass = 1.0, .stretches = {Stretch{1.0, 1.0, 2.0}}};
  const ModuleSpan* const arm[] = {&module};
  EXPECT_NEAR(reach_bound(arm, 2.5).least_mass, 2.5, 1e-6);
  EXPECT_TRUE(reach_bound(arm, 3.0).possible);
  EXPECT_FALSE(reach_bound(arm, 3.1).possible);
}

// 2 m are missing: one by the stretch at 1 kg/m, the other by that at 3 kg/m, although a parameter without any length
// lies between them.
TEST(ReachBound, StretchesTheLightestFirstWhateverLiesBetween) {
  const ModuleSpan heavy{.length = 0.0, .mass = 0.0, .stretches = {Stretch{1.0, 3.0, 5.0}}};
  const ModuleSpan idle{.length = 0.0, .mass = 0.0, .stretches = {Stretch{0.0, 0.0, 1.0}}};
  const ModuleSpan light{.length = 0.0, .mass = 0.0, .stretches = {Stretch{1.0, 1.0, 1.0}}};
  const ModuleSpan* const arm[] = {&heavy, &idle, &light};
  EXPECT_NEAR(reach_bound(arm, 2.0).least_mass, 4.0, 1e-6);
}

// Two more of: 1 m at 2 kg, or 0.5 m at 1 kg that stretches by up to 1 m at 4 kg/m. The lightest, the longest, and the
// best stretch at once: 2 * 1 kg, 2 * 1 m without a stretch, then 4 kg/m.
TEST(ReachBound, TakesWhatMayFollowAtItsBest) {
  const std::vector<ModuleSpan> types{{.length = 1.0, .mass = 2.0},
                                      {.length = 0.5, .mass = 1.0, .stretches = {Stretch{1.0, 4.0, 1.0}}}};
  const ModuleSpan first{.length = 1.0, .mass = 0.5};
  const ModuleSpan* const arm[] = {&first};
  EXPECT_NEAR(reach_bound(arm, types, 2, 3.0).least_mass, 2.5, 1e-6);
  EXPECT_NEAR(reach_bound(arm, types, 2, 3.5).least_mass, 2.5 + 0.5 * 4.0, 1e-6);
  EXPECT_TRUE(reach_bound(arm, types, 2, 4.0).possible);  // 1 + 2 * 1.5
  EXPECT_FALSE(reach_bound(arm, types, 2, 4.1).possible);
}

// A base that may be half a metre off either way along x and y: whatever the weightless place, it is within 1 m of the
// nominal one, and no closer bound than that is lost by starting from a corner.
TEST(ReachBound, CountsThePlaceOfABaseFromTheMiddle) {
  BasePlacement placement;
  placement.x = {-0.5, 0.5};
  placement.y = {-0.5, 0.5};
  placement.yaw = {-1.0, 1.0};
  const ModuleSpan span = module_span(with_placed_base(*load_library("seed"), placement).type(0));
  EXPECT_NEAR(span.length, 1.0, 1e-12);
  EXPECT_NEAR(span.greatest_length(), 1.0, 1e-12);
  EXPECT_EQ(span.mass, 0.0);
  placement.x = {0.5, 1.5};  // 1 m away in the middle, half a metre more at the ends
  EXPECT_NEAR(module_span(with_placed_base(*load_library("seed"), placement).type(0)).length, 1.0 + 0.5 + 0.5, 1e-12);
}

}  // namespace
}  // namespace modsearch
