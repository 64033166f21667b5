#include <gtest/gtest.h>

#include <modsearch/baselines/certify/tree_record_internal.hpp>

namespace modsearch::certify {
namespace {

ClosedLeaf leaf(double y) { return {Objective::kMass, {{{y, 0.0, 0.0}}, {}, false}}; }
const std::string kZeros = R"(,"0x0p+0","0x0p+0"])";

TEST(TreeRecord, IsWrittenInPreorderWhateverTheOrderItGrewIn) {
  TreeRecord record;
  const std::size_t halves = record.split(TreeRecord::kRoot, 2, 0.5);
  record.close(halves + 1, leaf(1.0));
  const std::size_t quarters = record.split(halves, 0, 0.25);
  record.close(quarters + 1, leaf(2.0));
  record.cut_off(quarters, {{leaf(4.0), {{1, 0.5, true}}}});
  record.close(quarters, leaf(8.0));
  TreeRecord::Walk walk{record};
  TreeText text;
  EXPECT_FALSE(walk.next(text));
  EXPECT_EQ(text.nodes(), R"(["s",2,"0x1p-1"],["s",0,"0x1p-2"],["c",[["m","0x1p+2")" + kZeros +
                              R"(,[1,"0x1p-1","above"]]],["m","0x1p+3")" + kZeros + R"(,["m","0x1p+1")" + kZeros +
                              R"(,["m","0x1p+0")" + kZeros);
  EXPECT_EQ(text.leaves(), 4);
}

TEST(TreeRecord, IsWalkedFromOneOpenBoxToTheNext) {
  TreeRecord record;
  const std::size_t halves = record.split(TreeRecord::kRoot, 0, 0.5);
  TreeRecord::Walk walk{record};
  TreeText text;
  ASSERT_TRUE(walk.next(text));
  EXPECT_EQ(walk.place(), halves);
  text.close(leaf(1.0));
  ASSERT_TRUE(walk.next(text));
  EXPECT_EQ(walk.place(), halves + 1);
  text.close(leaf(2.0));
  EXPECT_FALSE(walk.next(text));
  EXPECT_EQ(text.nodes(), R"(["s",0,"0x1p-1"],["m","0x1p+0")" + kZeros + R"(,["m","0x1p+1")" + kZeros);
}

}  // namespace
}  // namespace modsearch::certify
