#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <modsearch/kinematics/processor_internal.hpp>
#include <modsearch/kinematics/simultaneous_ik.hpp>
#include <modsearch/kinematics/simultaneous_ik_kernel_internal.hpp>
#include <numbers>
#include <random>

namespace modsearch {
namespace {

using ::testing::HasSubstr;
constexpr double kPi = std::numbers::pi;

Eigen::Isometry3d tz(double z) { return Eigen::Isometry3d{Eigen::Translation3d{0.0, 0.0, z}}; }
Eigen::Isometry3d rx(double angle) { return Eigen::Isometry3d{Eigen::AngleAxisd{angle, Eigen::Vector3d::UnitX()}}; }

AffinePose length_along_z(int parameter) {
  AffinePose X;
  X.translation = AffineVector{0.0, 0.0, AffineScalar::of_parameter(parameter)};
  return X;
}

// `n` joints, each across the one before, with a length behind the second and the third and a twist behind the fourth,
// between two bends.
Chain arm_of(int n) {
  ChainBuilder builder{3};
  for (int j = 0; j < n; ++j) {
    builder.move(tz(0.1)).joint({.name = "q", .lower = -2.5, .upper = 2.5});
    if (j == 1 || j == 2) builder.move(length_along_z(j - 1));
    // Between two bends: about the axis of a joint it would be a joint that stands still.
    if (j == 3) builder.move(rx(0.7)).move(ParametricPose::turn(AffineScalar::of_parameter(2))).move(tz(0.1));
    builder.move(rx(j % 2 == 0 ? 0.5 * kPi : -0.5 * kPi));
  }
  return builder.move(tz(0.15)).build();
}

Eigen::VectorXd least_x() { return Eigen::Vector3d{0.1, 0.1, -1.5}; }
Eigen::VectorXd most_x() { return Eigen::Vector3d{0.6, 0.6, 1.5}; }

// Lengths and postures, and the poses that they put the tip into.
struct Planted {
  Eigen::VectorXd v;
  std::vector<PoseRegion> goals;
};

Planted planted(const Chain& chain, int n_goals, std::mt19937& random) {
  const auto uniform = [&](double a, double b) { return std::uniform_real_distribution<double>{a, b}(random); };
  Planted result;
  const Eigen::Index n_q = chain.n_joints();
  result.v.resize(3 + n_goals * n_q);
  for (Eigen::Index i = 0; i < 3; ++i) result.v[i] = uniform(least_x()[i], most_x()[i]);
  for (Eigen::Index i = 3; i < result.v.size(); ++i) result.v[i] = uniform(-2.0, 2.0);
  const Arm arm = chain.at(result.v.head(3));
  for (int g = 0; g < n_goals; ++g) {
    result.goals.push_back(PoseRegion::with_default_tolerances(arm.forward(result.v.segment(3 + g * n_q, n_q)).tip));
  }
  return result;
}

// Every start lies about `v`, farther and farther away.
SimultaneousIk::Start around(const Eigen::VectorXd& v, std::mt19937& random) {
  return [&, v](int i, Eigen::Ref<Eigen::VectorXd> start) {
    std::normal_distribution<double> shake{0.0, 0.02 + 0.03 * i};
    for (Eigen::Index k = 0; k < v.size(); ++k) start[k] = v[k] + shake(random);
  };
}

TEST(SimultaneousIk, FindsTheLengthsThatLetFourJointsMeetThreePoses) {
  // Four joints and three lengths against eighteen equations: no lengths do but those that were planted.
  const Chain chain = arm_of(4);
  std::mt19937 random{1};
  for (int trial = 0; trial < 20; ++trial) {
    const Planted task = planted(chain, 3, random);
    SimultaneousIk ik{chain, task.goals, least_x(), most_x()};
    int arrived = 0;
    (void)ik.solve(8, around(task.v, random), [&](int, const Eigen::VectorXd& v) {
      ++arrived;
      const Arm arm = chain.at(v.head(3));
      for (std::size_t g = 0; g < task.goals.size(); ++g) {
        const Eigen::VectorXd q = v.segment(3 + 4 * static_cast<Eigen::Index>(g), 4);
        EXPECT_TRUE(task.goals[g].contains(arm.forward(q).tip));
        EXPECT_TRUE((q.array() >= -2.5).all() && (q.array() <= 2.5).all());
      }
      EXPECT_TRUE((v.head(3).array() >= least_x().array()).all() && (v.head(3).array() <= most_x().array()).all());
      return true;
    });
    EXPECT_GE(arrived, 3) << "trial " << trial;
  }
}

TEST(SimultaneousIk, MeetsThePosesOfASixJointArmFromAnywhere) {
  const Chain chain = arm_of(6);
  std::mt19937 random{2};
  int solved = 0;
  for (int trial = 0; trial < 20; ++trial) {
    const Planted task = planted(chain, 3, random);
    SimultaneousIk ik{chain, task.goals, least_x(), most_x()};
    const auto anywhere = [&](int, Eigen::Ref<Eigen::VectorXd> v) {
      for (Eigen::Index k = 0; k < v.size(); ++k) {
        v[k] = std::uniform_real_distribution<double>{ik.lower()[k], ik.upper()[k]}(random);
      }
    };
    bool found = false;
    (void)ik.solve(200, anywhere, [&](int, const Eigen::VectorXd&) { return !(found = true); });
    solved += found ? 1 : 0;
  }
  EXPECT_GE(solved, 18);
}

TEST(SimultaneousIk, StopsWhenTheArrivalSaysSo) {
  const Chain chain = arm_of(6);
  std::mt19937 random{3};
  const Planted task = planted(chain, 1, random);
  SimultaneousIk ik{chain, task.goals, least_x(), most_x()};
  int arrived = 0;
  (void)ik.solve(100, around(task.v, random), [&](int, const Eigen::VectorXd&) { return ++arrived < 2; });
  EXPECT_EQ(arrived, 2);
}

TEST(SimultaneousIk, TellsHowNearItCameWhereNothingArrives) {
  const Chain chain = arm_of(3);
  // The tip is 0.1 + 0.1 + 0.6 + 0.1 + 0.6 + 0.15 = 1.65 m away from the base at most: half a metre is missing at
  // least.
  const std::vector<PoseRegion> goals{PoseRegion::ball({0.0, 0.0, 2.15}, 1e-3)};
  SimultaneousIk ik{chain, goals, least_x(), most_x()};
  std::mt19937 random{4};
  const SimultaneousIk::Outcome outcome = ik.solve(
      16, [&](int, Eigen::Ref<Eigen::VectorXd> v) { v.setRandom(); }, [](int, const Eigen::VectorXd&) { return true; });
  EXPECT_GE(outcome.least_cost, 0.5 * 0.5 * 0.5);
  ASSERT_EQ(outcome.nearest.size(), ik.lower().size());
  const Eigen::VectorXd v = outcome.nearest;
  const double miss =
      (chain.at(v.head(3)).forward(v.tail(3)).tip.translation() - goals[0].nominal().translation()).norm();
  EXPECT_NEAR(0.5 * miss * miss, outcome.least_cost, 1e-12);
}

TEST(SimultaneousIk, LeavesFreeWhatATaskLeavesFree) {
  // A tool that points along an axis within 0.1 rad, turned about it at will, within a box of 2 x 4 x 2 cm.
  const Chain chain = arm_of(5);
  std::mt19937 random{5};
  for (int trial = 0; trial < 10; ++trial) {
    const Planted task = planted(chain, 1, random);
    const PoseRegion region{task.goals[0].nominal(),
                            {{.projection = Projection::kX, .lower = -0.01, .upper = 0.01},
                             {.projection = Projection::kY, .lower = -0.02, .upper = 0.02},
                             {.projection = Projection::kZ, .lower = -0.01, .upper = 0.01},
                             {.projection = Projection::kNx, .lower = -0.1, .upper = 0.1},
                             {.projection = Projection::kNy, .lower = -0.1, .upper = 0.1}}};
    ASSERT_TRUE(SimultaneousIk::covers(region));
    SimultaneousIk ik{chain, std::vector{region}, least_x(), most_x()};
    int arrived = 0;
    (void)ik.solve(16, around(task.v, random), [&](int, const Eigen::VectorXd& v) {
      EXPECT_TRUE(region.contains(chain.at(v.head(3)).forward(v.tail(5)).tip));
      ++arrived;
      return true;
    });
    EXPECT_GE(arrived, 8);
  }
}

TEST(SimultaneousIk, KnowsArmsThatMeetPosesByLuckAlone) {
  std::mt19937 random{6};
  const auto generic = [&](int n_joints, int n_goals) {
    const Chain chain = arm_of(n_joints);
    const Planted task = planted(chain, n_goals, random);
    return SimultaneousIk{chain, task.goals, least_x(), most_x()}.generic();
  };
  EXPECT_TRUE(generic(6, 3));
  EXPECT_TRUE(generic(5, 3)) << "fifteen joint angles and three lengths for eighteen equations";
  EXPECT_FALSE(generic(4, 3)) << "twelve and three";
  EXPECT_TRUE(generic(4, 1));
  EXPECT_FALSE(generic(2, 1)) << "two and three: one short";

  // Joints on one line repeat each other, however many there are.
  ChainBuilder builder{0};
  for (int j = 0; j < 8; ++j) builder.move(tz(0.1)).joint({.name = "q", .lower = -2.5, .upper = 2.5});
  const Chain pole = builder.build();
  const std::vector<PoseRegion> goals{PoseRegion::with_default_tolerances(tz(0.8))};
  EXPECT_FALSE((SimultaneousIk{pole, goals, Eigen::VectorXd{}, Eigen::VectorXd{}}.generic()));
}

TEST(SimultaneousIk, RefusesWhatItCannotAimAt) {
  const Chain chain = arm_of(6);
  const auto refusal = [&](std::vector<PoseRegion> goals, const Eigen::VectorXd& lower) -> std::string {
    try {
      const SimultaneousIk ik{chain, goals, lower, most_x()};
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "nothing was refused";
  };
  const PoseRegion ball = PoseRegion::ball({0.5, 0.0, 0.5}, 1e-3);
  EXPECT_THAT(refusal({}, least_x()), HasSubstr("no goals, at least one is needed"));
  EXPECT_THAT(refusal({ball}, Eigen::VectorXd{}), HasSubstr("0 and 3 bounds given, the chain has 3 parameters"));
  const PoseRegion inclined{Eigen::Isometry3d::Identity(),
                            {{.projection = Projection::kTheta, .lower = 0.0, .upper = 0.5}}};
  EXPECT_FALSE(SimultaneousIk::covers(inclined));
  EXPECT_THAT(refusal({ball, inclined}, least_x()), HasSubstr("the tolerances of goal 1 cannot be aimed at"));
}

// What a kernel is given and writes, by hand: the arm of one turning joint and one length, x -> Rz(q) Tx(x).
class Kernel : public ::testing::Test {
 protected:
  struct alignas(64) Vector {
    double lane[detail::kIkLanes];
  };

  Kernel() {
    links[0].kind = detail::IkLink::Kind::kTurn;
    links[1].kind = detail::IkLink::Kind::kRigid;
    links[1].n_terms = 1;
    term.direction[0] = 1.0;
    target.position[0] = 0.3;
    target.position[1] = 0.4;
    const double turned[9] = {std::cos(0.2), -std::sin(0.2), 0.0, std::sin(0.2), std::cos(0.2), 0.0, 0.0, 0.0, 1.0};
    std::copy(std::begin(turned), std::end(turned), target.rotation);
    target.whole_position = target.whole_rotation = true;
    model = {.n_parameters = 1,
             .n_joints = 1,
             .n_goals = 1,
             .n_links = 2,
             .links = links,
             .terms = &term,
             .targets = &target,
             .lower = lower,
             .upper = upper,
             .length = 0.5};
    memory.resize(2 + 2 + 2 + detail::ik_normal_size(model) + detail::ik_work_size(model));
    Vector* next = memory.data();
    const auto take = [&](std::size_t n) {
      double* const here = next->lane;
      next += n;
      return here;
    };
    lanes = {.v = take(2),
             .cost = take(1),
             .damping = take(1),
             .position = take(1),
             .rotation = take(1),
             .normal = take(detail::ik_normal_size(model)),
             .work = take(detail::ik_work_size(model))};
    for (int lane = 0; lane < detail::kIkLanes; ++lane) {
      lanes.v[lane] = 0.2 + 0.1 * lane;                      // x
      lanes.v[detail::kIkLanes + lane] = -3.0 + 0.8 * lane;  // q
      lanes.cost[lane] = std::numeric_limits<double>::infinity();
      lanes.damping[lane] = 1e-2;
    }
  }

  // Half of |p - t|^2 + L^2 |R - R_N|^2 / 2, where |R - R_N|^2 = 4 (1 - cos(q - 0.2)) for a turn about z.
  [[nodiscard]] static double cost(double x, double q) {
    const double dx = x * std::cos(q) - 0.3;
    const double dy = x * std::sin(q) - 0.4;
    return 0.5 * (dx * dx + dy * dy) + 0.25 * (1.0 - std::cos(q - 0.2));
  }

  detail::IkLink links[2];
  detail::IkTerm term;
  detail::IkTarget target;
  double lower[2] = {0.1, -3.1};
  double upper[2] = {1.0, 3.1};
  detail::IkModel model;
  std::vector<Vector> memory;
  detail::IkLanes lanes;
};

TEST_F(Kernel, GivesCostAndGradientOfTheFormulaInEveryLane) {
  detail::kIkKernelSse2.step(model, lanes);  // the first step of a lane only looks
  for (int lane = 0; lane < detail::kIkLanes; ++lane) {
    const double x = lanes.v[lane];
    const double q = lanes.v[detail::kIkLanes + lane];
    EXPECT_NEAR(lanes.cost[lane], cost(x, q), 1e-14);
    constexpr double h = 1e-6;
    EXPECT_NEAR(lanes.normal[lane], (cost(x + h, q) - cost(x - h, q)) / (2.0 * h), 1e-8);
    EXPECT_NEAR(lanes.normal[detail::kIkLanes + lane], (cost(x, q + h) - cost(x, q - h)) / (2.0 * h), 1e-8);
  }
}

TEST_F(Kernel, NeverRaisesTheCostAndStaysWithinTheBounds) {
  std::vector<double> before(detail::kIkLanes, std::numeric_limits<double>::infinity());
  for (int i = 0; i < 50; ++i) {
    detail::kIkKernelSse2.step(model, lanes);
    for (int lane = 0; lane < detail::kIkLanes; ++lane) {
      const auto at = static_cast<std::size_t>(lane);
      EXPECT_LE(lanes.cost[lane], before[at]);
      before[at] = lanes.cost[lane];
      EXPECT_GE(lanes.v[lane], 0.1);
      EXPECT_LE(std::abs(lanes.v[detail::kIkLanes + lane]), 3.1);
    }
  }
}

TEST_F(Kernel, GivesTheSameBitsWithEveryInstructionSet) {
  const std::vector<Vector> at_first = memory;
  const auto after = [&](const detail::IkKernel& kernel) {
    memory = at_first;  // the pointers of the lanes stay
    for (int i = 0; i < 20; ++i) kernel.step(model, lanes);
    std::vector<double> numbers(lanes.v, lanes.v + 2 * detail::kIkLanes);
    numbers.insert(numbers.end(), lanes.cost, lanes.cost + detail::kIkLanes);
    return numbers;
  };
  const std::vector<double> plain = after(detail::kIkKernelSse2);
  if (detail::processor_has_v3()) {
    EXPECT_EQ(after(detail::kIkKernelAvx2), plain);
  }
  if (detail::processor_has_v4()) {
    EXPECT_EQ(after(detail::kIkKernelAvx512), plain);
  }
}

}  // namespace
}  // namespace modsearch
