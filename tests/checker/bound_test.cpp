#include <gmock/gmock.h>

#include <cfenv>
#include <checker/bound.hpp>
#include <modsearch/problem/files.hpp>
#include <random>

#include "naive_certificate.hpp"

namespace modsearch_check {
namespace {

constexpr const char* kScene = "seed/random_obstacles";

/// Random arms, and the toolkit's own kinematics and distances to look at them with: it shares no code with the
/// checker.
class Bounds : public testing::Test {
 protected:
  double uniform(double lower, double upper) {
    return lower + (upper - lower) * static_cast<double>(bits_() >> 11) * 0x1p-53;
  }
  std::size_t index(std::size_t n) { return bits_() % n; }

  struct Arm {
    std::vector<std::size_t> types;
    std::vector<double> x;
    std::vector<double> q;
    Numbers tip{};
    double mass = 0.0;
    double clearance = 0.0;
  };

  void look(Arm& arm) const {
    const Rounding nearest{FE_TONEAREST};
    const std::vector<int> types(arm.types.begin(), arm.types.end());
    const modsearch::Chain chain = toolkit_->library().assemble(types);
    const Eigen::VectorXd x = Eigen::Map<const Eigen::VectorXd>(arm.x.data(), static_cast<Eigen::Index>(arm.x.size()));
    const Eigen::VectorXd q = Eigen::Map<const Eigen::VectorXd>(arm.q.data(), static_cast<Eigen::Index>(arm.q.size()));
    const modsearch::Arm built = chain.at(x);
    const modsearch::Posture posture = built.forward(q);
    modsearch::Work work;
    for (int axis = 0; axis < 3; ++axis) arm.tip[static_cast<std::size_t>(axis)] = posture.tip.translation()[axis];
    arm.mass = built.mass();
    arm.clearance = toolkit_->scene().clearance(built, posture, work);
  }

  Arm draw_arm(std::size_t most) {
    Arm arm;
    const std::size_t n = 1 + index(most);
    std::size_t joints = 1;
    for (std::size_t i = 0; i < n; ++i) {
      arm.types.push_back(index(3));
      const std::size_t parameters = problem_.library.types[arm.types.back()].parameters.size();
      for (std::size_t k = 0; k < parameters; ++k) arm.x.push_back(uniform(0.5, 1.5));
      joints += arm.types.back() == 0 ? 0 : 1;
    }
    for (std::size_t j = 0; j < joints; ++j) arm.q.push_back(uniform(-3.0, 3.0));
    look(arm);
    return arm;
  }

  /// A box with the arm in it.
  Box draw_box(const Model& model, const Arm& arm) {
    Box box{std::vector<double>(model.n_lengths()), {}};
    for (std::size_t i = 0; i < arm.x.size(); ++i) box.lower[model.variable_of[i]] += arm.x[i];
    for (const double q : arm.q) box.lower.push_back(q);
    box.upper = box.lower;
    const double width = std::exp2(uniform(-12.0, 1.0));
    for (std::size_t v = 0; v < box.lower.size(); ++v) {
      box.lower[v] -= width * uniform(0.0, 1.0);
      box.upper[v] += width * uniform(0.0, 1.0);
    }
    return box;
  }

  Row draw_row(const Model& model) {
    Row row{0, index(model.runs.size()), uniform(0.0, 1.0), uniform(0.0, 2.0), index(3), true, {}, 0.0, index(6)};
    const Shape& shape = problem_.task.obstacles[row.shape];
    row.centre = middle(shape.pose.move.offset);
    if (shape.kind == Kind::kSphere) {
      row.radius = shape.size[0].offset.lower();
    } else if (bits_() % 2 == 0) {
      row.ball = false;
    } else {  // a ball in a box of 0.3 x 0.4 x 0.5
      row.radius = uniform(0.0, 0.14);
      for (double& entry : row.centre) entry += uniform(-0.15 + row.radius, 0.15 - row.radius);
    }
    return row;
  }

  std::shared_ptr<const modsearch::RobotProblem> toolkit_ = modsearch::load_problem(kScene);
  std::mt19937_64 bits_{7};
  Rounding up_{FE_UPWARD};
  Problem problem_ = read_problem(kScene, "", 0, 0);
};

TEST_F(Bounds, LeaveNoArmOutThatReachesAndIsFree) {
  int with_rows = 0;
  for (int i = 0; i < 30'000; ++i) {
    const Arm arm = draw_arm(3);
    const Model model = Assembler{problem_}.model(arm.types);
    // This arm is achieved: its tip is where the goal is, up to the tolerance.
    problem_.task.goals[0].position = arm.tip;
    problem_.task.goals[0].position[index(3)] += uniform(-0.001, 0.001);
    const Box box = draw_box(model, arm);
    Leaf leaf{
        bits_() % 2 == 0, bits_() % 4 == 0, {Numbers{uniform(-2.0, 2.0), uniform(-2.0, 2.0), uniform(-2.0, 2.0)}}, {}};
    if (arm.clearance >= 0.0) {
      for (std::size_t k = index(4); k > 0; --k) leaf.rows.push_back(draw_row(model));
    }
    double bound = -INFINITY;
    try {
      bound = lower_bound(problem_, model, box, leaf);
      with_rows += leaf.rows.empty() ? 0 : 1;
    } catch (const Rejected&) {  // a row does not hold in this box
      leaf.rows.clear();
      bound = lower_bound(problem_, model, box, leaf);
    }
    EXPECT_LE(bound, (leaf.mass ? arm.mass : 0.0) + 1e-9);
  }
  EXPECT_GT(with_rows, 5'000);
}

TEST_F(Bounds, OfPartsLeaveNoArmOutThatIsInThem) {
  int angles = 0, stronger = 0;
  for (int i = 0; i < 20'000; ++i) {
    const Arm arm = draw_arm(3);
    const Model model = Assembler{problem_}.model(arm.types);
    problem_.task.goals[0].position = arm.tip;
    const Box box = draw_box(model, arm);
    Leaf leaf{bits_() % 2 == 0, false, {Numbers{uniform(-2.0, 2.0), uniform(-2.0, 2.0), uniform(-2.0, 2.0)}}, {}};
    const std::size_t v = index(box.lower.size());
    leaf.cap = v < model.n_lengths() && bits_() % 4 == 0;
    std::vector<double> at(model.n_lengths());
    for (std::size_t k = 0; k < arm.x.size(); ++k) at[model.variable_of[k]] += arm.x[k];
    at.insert(at.end(), arm.q.begin(), arm.q.end());
    const bool above = bits_() % 2 == 0;
    const double end = above ? box.lower[v] : box.upper[v];
    const Shown shown{problem_, model, box, leaf};
    const double bound = shown.in_part(v, at[v] + uniform(0.0, 1.0) * (end - at[v]), above);
    EXPECT_LE(bound, (leaf.mass ? arm.mass : 0.0) + 1e-9);
    EXPECT_GE(shown.in_part(v, end, above), shown.in_box() - 1e-9);
    angles += v >= model.n_lengths() ? 1 : 0;
    stronger += shown.in_part(v, at[v], above) > shown.in_box() + 1e-3 ? 1 : 0;
  }
  EXPECT_GT(angles, 5'000);
  EXPECT_GT(stronger, 5'000);
}

TEST_F(Bounds, OfAPartIsThatOfTheWholeBoxUpToItsEnd) {
  // At the far end of a length only the corners there are left.
  const Arm arm = draw_arm(1);
  const Model model = Assembler{problem_}.model(arm.types);
  Box box = draw_box(model, arm);
  const Leaf leaf{true, false, {Numbers{0.4, 0.2, -0.3}}, {}};
  const Shown shown{problem_, model, box, leaf};
  const double whole = std::min(shown.in_part(0, box.upper[0], true), shown.in_part(0, box.lower[0], false));
  EXPECT_NEAR(whole, shown.in_box(), 1e-12);
  EXPECT_THROW(static_cast<void>(Shown{problem_, model, box, {true, true, leaf.y, {}}}.in_part(model.n_lengths(),
                                                                                               box.lower.back(), true)),
               Rejected);
}

TEST_F(Bounds, AreExactAtAPoint) {
  for (int i = 0; i < 200; ++i) {
    const Arm arm = draw_arm(3);
    const Model model = Assembler{problem_}.model(arm.types);
    problem_.task.goals[0].position = arm.tip;
    Box box = draw_box(model, arm);
    for (std::size_t k = 0; k < model.n_lengths(); ++k) box.lower[k] = 0.0;
    for (std::size_t k = 0; k < arm.x.size(); ++k) box.lower[model.variable_of[k]] += arm.x[k];
    std::copy(arm.q.begin(), arm.q.end(), box.lower.begin() + static_cast<std::ptrdiff_t>(model.n_lengths()));
    box.upper = box.lower;
    const Numbers y{0.3, -0.8, 0.5};
    const double tolerance = 0.001 * std::sqrt(0.3 * 0.3 + 0.8 * 0.8 + 0.5 * 0.5);
    for (const bool cap : {false, true}) {
      EXPECT_NEAR(lower_bound(problem_, model, box, {true, cap, {y}, {}}), arm.mass - tolerance, 1e-9);
    }
  }
}

TEST_F(Bounds, FallShortByTheSquareOfTheAnglesAndByTheirCubeWhereTheArmIsStretchedOut) {
  // An arm straight up, 2 m long and 2 kg: down to the tip the second derivatives are positive, up to it negative.
  const Model model = Assembler{problem_}.model({1});
  problem_.task.goals[0].position = {0.0, 0.0, 2.0};
  const auto shortfall = [&](double up, double h) {
    const Box box{{0.5, 1.5, -h, -h}, {0.5, 1.5, h, h}};
    return 2.0 - 0.001 - lower_bound(problem_, model, box, {true, false, {Numbers{0.0, 0.0, up}}, {}});
  };
  EXPECT_NEAR(shortfall(-1.0, 1e-3) / shortfall(-1.0, 1e-4), 100.0, 1.0);
  EXPECT_NEAR(shortfall(1.0, 1e-2) / shortfall(1.0, 1e-3), 1000.0, 10.0);
}

TEST_F(Bounds, LetJointsAboutParallelAxesStandStillTogether) {
  int seen = 0;
  for (int i = 0; i < 2'000; ++i) {
    Arm arm = draw_arm(3);
    const Model model = Assembler{problem_}.model(arm.types);
    const Box root = root_box(model, 1);
    for (std::size_t j = 0; j + 1 < arm.q.size(); ++j) {
      if (!model.idle[j]) continue;
      ++seen;
      double nearest = INFINITY;
      for (const double sign : {1.0, -1.0}) {
        Arm other = arm;
        other.q[j] = 0.0;
        other.q[j + 1] = std::remainder(arm.q[j + 1] + sign * arm.q[j], 6.283185307179586);
        look(other);
        nearest = std::min(nearest,
                           std::hypot(other.tip[0] - arm.tip[0], other.tip[1] - arm.tip[1], other.tip[2] - arm.tip[2]));
      }
      EXPECT_LT(nearest, 1e-12);
      EXPECT_EQ(root.upper[model.n_lengths() + j], 0.0);
      EXPECT_GE(root.upper[model.n_lengths() + j + 1], model.idle[j + 1] ? 0.0 : kPiUp);
    }
  }
  EXPECT_GT(seen, 100);
}

TEST_F(Bounds, CountARowByHowFarItsBodyPointIsFromTheObstacle) {
  // A hinge 1.2 m up, its distal part horizontal: a body point above the middle of the box, whose top is at 0.75 m.
  // With y = 0 the bound is mass + mu (beta - n . x).
  const Model model = Assembler{problem_}.model({1});
  const double away = std::hypot(0.7, 0.6);
  const std::vector<double> at{1.2, 1.0, std::atan2(0.7, -0.6), std::acos(0.0)};
  const double tau = (away - 0.055) / (1.0 - 2.0 * 0.055);  // between the ends of the inner axis
  const auto bound = [&](const Row& row) {
    return lower_bound(problem_, model, {at, at}, {true, false, {Numbers{}}, {row}});
  };
  EXPECT_NEAR(bound({0, 1, tau, 3.0, 2, false, {}, 0.0, 4}), 2.2 + 3.0 * (0.75 + 0.055 - 1.2), 1e-9);
  // A ball of 0.1 m about (0.7, 0.6, 0.6) within the box: mu (R^2 - |x - b|^2).
  const Row ball{0, 1, tau, 3.0, 2, true, {0.7, 0.6, 0.6}, 0.1, 0};
  EXPECT_NEAR(bound(ball), 2.2 + 3.0 * (0.155 * 0.155 - 0.6 * 0.6), 1e-9);
  // Lowered into it, the row alone shows that nothing is achieved there: without the mass, the bound is positive.
  const std::vector<double> low{0.7, 1.0, at[2], at[3]};
  EXPECT_NEAR(lower_bound(problem_, model, {low, low}, {false, false, {Numbers{}}, {ball}}),
              3.0 * (0.155 * 0.155 - 0.1 * 0.1), 1e-9);
}

TEST_F(Bounds, RefuseRowsThatDoNotHold) {
  const Model model = Assembler{problem_}.model({1});
  problem_.task.goals[0].position = {0.7, 0.6, 1.0};
  const Box box{{1.0, 1.0, -0.01, -0.01}, {1.0, 1.0, 0.01, 0.01}};  // an arm straight up, 2 m long
  const auto reason = [&](const Row& row) {
    try {
      static_cast<void>(lower_bound(problem_, model, box, {true, false, {Numbers{}}, {row}}));
      return std::string{"holds"};
    } catch (const Rejected& rejected) {
      return std::string{rejected.what()};
    }
  };
  const Row small_sphere{0, 0, 0.5, 1.0, 1, true, {0.3, 0.3, 0.9}, 0.2, 0};
  EXPECT_EQ(reason(small_sphere), "holds");
  Row row = small_sphere;
  row.radius = 0.2000001;
  EXPECT_THAT(reason(row), testing::HasSubstr("sticks out"));
  row = small_sphere;
  row.centre[0] += 1e-9;
  EXPECT_THAT(reason(row), testing::HasSubstr("sticks out"));
  row = small_sphere;
  row.ball = false;
  EXPECT_THAT(reason(row), testing::HasSubstr("no box"));
  row.shape = 2;  // the arm does not stand above any face of the box
  EXPECT_THAT(reason(row), testing::HasSubstr("sides of its face"));
  const Box short_box{{0.1, 1.0, -0.01, -0.01}, {0.2, 1.0, 0.01, 0.01}};
  EXPECT_THROW(static_cast<void>(lower_bound(problem_, model, short_box, {true, false, {Numbers{}}, {small_sphere}})),
               Rejected);
}

TEST_F(Bounds, SeeStraightBodiesAsOneRun) {
  // link, hinge: the link continues into the hinge's proximal part. rotary, link: so does the distal part, from -r on.
  const Model straight = Assembler{problem_}.model({0, 1});
  ASSERT_EQ(straight.runs.size(), 2U);
  EXPECT_EQ(straight.n_lengths(), 2U);
  EXPECT_EQ(straight.variable_of, (std::vector<std::size_t>{0, 0, 1}));
  const Model elbow = Assembler{problem_}.model({2, 0});
  ASSERT_EQ(elbow.runs.size(), 2U);
  EXPECT_EQ(elbow.runs[1].start.offset[1].lower(), 0.055);  // -r along an axis that points to -y
  EXPECT_EQ(elbow.runs[1].end.columns[1][1].lower(), -1.0);
}

TEST(Targets, AreThoseThatTheToolkitDraws) {
  for (const char* id : {"seed/random_narrow", "seed/random_wide", "seed/random_obstacles"}) {
    for (std::uint64_t index = 0; index < 300; ++index) {
      const Eigen::Vector3d theirs = modsearch::load_problem(id, {2022, index})->task().goals()[0].position();
      const Numbers mine = read_problem(id, "", 2022, index).task.goals[0].position;
      for (int axis = 0; axis < 3; ++axis) EXPECT_EQ(mine[static_cast<std::size_t>(axis)], theirs[axis]);
    }
  }
}

}  // namespace
}  // namespace modsearch_check
