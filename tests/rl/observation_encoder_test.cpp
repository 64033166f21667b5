#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <modsearch/problem/files.hpp>
#include <modsearch/rl/observation_encoder.hpp>

namespace modsearch {
namespace {

using ::testing::HasSubstr;

Placement placed(const ModuleLibrary& library, const char* name, std::initializer_list<double> lengths) {
  Placement placement{library.find(name).value(), Parameters(static_cast<Eigen::Index>(lengths.size()))};
  std::copy(lengths.begin(), lengths.end(), placement.parameters.begin());
  return placement;
}

std::vector<float> encoded(EncoderOptions options, const DesignProblem& problem, const Design& design) {
  const ObservationEncoder encoder{options, problem};
  const Eigen::VectorXf observation = encoder.encode(problem.library(), design, encoder.instance(problem));
  EXPECT_EQ(observation.size(), encoder.size());
  return {observation.begin(), observation.end()};
}

template <typename Action>
std::string refusal(Action action) {
  try {
    action();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

TEST(GoalBox, IsShownFromMinusOneToOneAfterAllElse) {
  const auto problem = load_problem("seed/fixed");  // target (1, 0, 1)
  const std::vector<double> box{0.0, -1.0, 0.5, 1.0, 1.0, 2.5};
  const std::vector<float> without = encoded({}, *problem, {});
  std::vector<float> expected = without;
  expected.insert(expected.end(), {1.0F, 0.0F, -0.5F});
  EXPECT_EQ(encoded({.goal_box = box}, *problem, {}), expected);
}

TEST(GoalBox, MustBeOne) {
  const auto problem = load_problem("seed/fixed");
  EXPECT_THAT(refusal([&] { ObservationEncoder({.goal_box = {0.0, 1.0}}, *problem); }), HasSubstr("box of 2 numbers"));
  EXPECT_THAT(refusal([&] {
                ObservationEncoder({.goal_box = {0.0, 0.0, 1.0, 1.0, 1.0, 1.0}}, *problem);
              }),
              HasSubstr("from 1 to 1 along z"));
}

TEST(Seed36, ShowsTheReportsThirtySixNumbersInItsOrder) {
  const auto problem = load_problem("seed/fixed");
  const ModuleLibrary& library = problem->library();
  const Design design{
      {placed(library, "hinge", {0.5, 1.25}), placed(library, "link", {0.75}), placed(library, "rotary", {1.5, 1.0})}};
  std::vector<float> expected(36, 0.0F);
  // IDs over three: base, hinge, link, rotary, then empty slots, which look like links.
  expected[0] = 1.0F;
  expected[1] = 1.0F / 3.0F;
  expected[3] = 2.0F / 3.0F;
  // Ten rows of two parameters in metres; the base has none.
  expected[12] = 0.5F;
  expected[13] = 1.25F;
  expected[14] = 0.75F;
  expected[16] = 1.5F;
  expected[17] = 1.0F;
  // Base (0, 0, 0), target (1, 0, 1).
  expected[33] = 1.0F;
  expected[35] = 1.0F;
  EXPECT_EQ(encoded({.kind = EncoderKind::kSeed36}, *problem, design), expected);
}

TEST(Seed36, ShowsTheEmptyDesignAsTheBaseAlone) {
  const auto problem = load_problem("seed/random_wide", {4, 2});
  const std::vector<float> numbers = encoded({.kind = EncoderKind::kSeed36}, *problem, {});
  EXPECT_EQ(numbers[0], 1.0F);
  for (std::size_t i = 1; i < 33; ++i) EXPECT_EQ(numbers[i], 0.0F) << i;
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(numbers[33 + i], static_cast<float>(problem->task().goals()[0].position()[static_cast<Eigen::Index>(i)]));
  }
}

TEST(Seed36, RefusesMoreModulesThanItHasSlots) {
  RobotProblemSpec spec = load_problem_file("seed/fixed").spec;
  spec.max_modules = 11;
  const RobotProblem problem{spec};
  EXPECT_THAT(refusal([&] { ObservationEncoder({.kind = EncoderKind::kSeed36}, problem); }),
              HasSubstr("11 modules with the base, at most 10"));
  // Nor from a later problem of the family.
  const ObservationEncoder encoder{{.kind = EncoderKind::kSeed36}, *load_problem("seed/fixed")};
  EXPECT_THAT(refusal([&] { (void)encoder.instance(problem); }), HasSubstr("11 modules with the base, at most 10"));
}

TEST(ScaledObservation, HasOneHotSlotsScaledParametersCountTargetAndItsCylindricalLengths) {
  const auto problem = load_problem("seed/fixed");
  const ModuleLibrary& library = problem->library();
  const auto hinge = static_cast<std::size_t>(library.find("hinge").value());
  const auto link = static_cast<std::size_t>(library.find("link").value());
  const std::vector<float> numbers =
      encoded({}, *problem, {{placed(library, "hinge", {0.5, 1.25}), placed(library, "link", {1.5})}});
  // Nine slots of (3 types + empty) + 2 parameters, the count, the target, rho and |t|.
  ASSERT_EQ(numbers.size(), 9U * 6U + 1U + 3U + 2U);
  std::vector<float> expected(numbers.size(), 0.0F);
  expected[hinge] = 1.0F;
  expected[4] = -1.0F;  // 0.5 is the lower end of [0.5, 1.5]
  expected[5] = 0.5F;   // 1.25
  expected[6 + link] = 1.0F;
  expected[6 + 4] = 1.0F;                                                      // 1.5; a link has no second parameter
  for (std::size_t slot = 2; slot < 9; ++slot) expected[6 * slot + 3] = 1.0F;  // empty
  expected[54] = 2.0F * 2.0F / 9.0F - 1.0F;                                    // two of nine
  expected[55] = expected[57] = 0.5F;                                          // (1, 0, 1) / 2 m
  expected[58] = 0.5F;                                                         // rho = 1
  expected[59] = static_cast<float>(0.5 * std::sqrt(2.0));
  EXPECT_EQ(numbers, expected);
}

TEST(ScaledObservation, LeavesTheCylindricalLengthsOutWhenAsked) {
  const auto problem = load_problem("seed/fixed");
  EXPECT_EQ(encoded({.cylindrical = false}, *problem, {}).size(), 58U);
}

TEST(ScaledObservation, MeasuresTheCylindricalLengthsFromTheBase) {
  RobotProblemSpec spec = load_problem_file("seed/fixed").spec;
  // The base lies on its side at (0, 0, 1): its axis is the world's x, on which the target (1, 0, 1) lies.
  spec.X_WB.translation() = Eigen::Vector3d{0.0, 0.0, 1.0};
  spec.X_WB.linear() = Eigen::AngleAxisd{0.5 * 3.14159265358979323846, Eigen::Vector3d::UnitY()}.toRotationMatrix();
  const std::vector<float> numbers = encoded({}, RobotProblem{spec}, {});
  EXPECT_NEAR(numbers[58], 0.0, 1e-7);
  EXPECT_NEAR(numbers[59], 0.5, 1e-7);
}

TEST(ScaledObservation, ShowsDistancesFromPointsOfTheBasesAxisWhenAsked) {
  const std::vector<float> numbers = encoded({.axis_heights = {0.5, -1.0}}, *load_problem("seed/fixed"), {});
  ASSERT_EQ(numbers.size(), 62U);
  // From (0, 0, 0.5) and (0, 0, -1) to (1, 0, 1), over 2 m.
  EXPECT_FLOAT_EQ(numbers[60], static_cast<float>(0.5 * std::sqrt(1.25)));
  EXPECT_FLOAT_EQ(numbers[61], static_cast<float>(0.5 * std::sqrt(5.0)));
}

TEST(WhitenedObservation, HoldsTheWhitenedNumbersInPlaceOfTheInstances) {
  const auto problem = load_problem("seed/fixed");  // target (1, 0, 1)
  const std::vector<float> plain = encoded({.cylindrical = false}, *problem, {});
  ASSERT_EQ(plain.size(), 58U);  // the target over 2 m comes last: 0.5, 0, 0.5
  const std::vector<double> mean{0.25, 0.0, 0.0};
  const std::vector<double> rows{4.0, 0.0, 0.0, 1.0, 2.0, 3.0};
  std::vector<double> whitening = mean;
  whitening.insert(whitening.end(), rows.begin(), rows.end());
  std::vector<float> expected(plain.begin(), plain.end() - 3);
  expected.insert(expected.end(), {4.0F * 0.25F, 0.25F + 3.0F * 0.5F});
  EXPECT_EQ(encoded({.cylindrical = false, .whitening = whitening}, *problem, {}), expected);
}

TEST(WhitenedObservation, IsRefusedForOtherNumbersThanTheInstances) {
  const auto problem = load_problem("seed/fixed");
  EXPECT_THAT(refusal([&] {
                ObservationEncoder({.whitening = {0.0, 1.0}}, *problem);
              }),
              HasSubstr("whitening: 2 numbers"));
  EXPECT_THAT(refusal([&] {
                ObservationEncoder({.kind = EncoderKind::kSeed36, .whitening = {0.0, 1.0}}, *problem);
              }),
              HasSubstr("not whitened"));
}

TEST(ScaledObservation, DescribesObstacles) {
  const auto problem = load_problem("seed/random_obstacles");
  // Three shapes of centre and radius: the first sphere is 0.3 m about (-0.5, 0.5, 1.2), all over 2 m.
  const std::vector<float> numbers = encoded({}, *problem, {});
  ASSERT_EQ(numbers.size(), 60U + 3U * 4U);
  EXPECT_THAT(std::vector<float>(numbers.begin() + 58, numbers.begin() + 62),
              ::testing::ElementsAre(-0.25F, 0.25F, 0.6F, 0.15F));
}

TEST(ObservationEncoder, RefusesAnInstanceWithAnotherContext) {
  const auto family = load_problem("seed/fixed");
  const ObservationEncoder encoder{{}, *family};
  const auto other = load_problem("seed/random_obstacles");
  EXPECT_THAT(refusal([&] { (void)encoder.instance(*other); }), HasSubstr("17 numbers describe it, 5 the others"));
}

TEST(ObservationEncoder, RefusesAnInstanceWithAnotherNumberOfModules) {
  RobotProblemSpec spec = load_problem_file("seed/fixed").spec;
  const ObservationEncoder encoder{{}, RobotProblem{spec}};
  spec.max_modules = 4;
  EXPECT_THAT(refusal([&] { (void)encoder.instance(RobotProblem{spec}); }), HasSubstr("at most 4 modules, 10"));
}

TEST(UnitParameters, MapEndsToEndsExactlyAndBack) {
  const ParameterRange range{"length", "m", 0.1, 0.7};
  EXPECT_EQ(from_unit(range, -1.0), 0.1);
  EXPECT_EQ(from_unit(range, 1.0), 0.7);
  EXPECT_NEAR(from_unit(range, 0.0), 0.4, 1e-16);
  EXPECT_EQ(to_unit(range, 0.1), -1.0);
  EXPECT_EQ(to_unit(range, 0.7), 1.0);
  EXPECT_EQ(to_unit({"fixed", "m", 0.3, 0.3}, 0.3), 0.0);
  EXPECT_EQ(from_unit({"fixed", "m", 0.3, 0.3}, 0.0), 0.3);
}

}  // namespace
}  // namespace modsearch
