#include <gtest/gtest.h>

#include <modsearch/baselines/certify/twins_internal.hpp>
#include <modsearch/problem/files.hpp>
#include <modsearch/problem/rng.hpp>
#include <numbers>

namespace modsearch::certify {
namespace {

constexpr int kLink = 0, kHinge = 1, kRotary = 2;

std::vector<int> circles(const std::vector<int>& types) {
  const auto problem = load_problem("seed/random_obstacles");
  const SequenceModel model{*problem, types};
  std::vector<int> joints = half_circles(model, 1);
  for (int& joint : joints) joint -= model.n_lengths();
  return joints;
}

TEST(Twins, OfTheBaseAreThereBeforeAHinge) {
  EXPECT_EQ(circles({kHinge}), std::vector<int>{0});
  EXPECT_EQ(circles({kLink, kHinge, kRotary, kHinge}), std::vector<int>{0});
  EXPECT_EQ(circles({kHinge, kHinge, kHinge}), std::vector<int>{0});
}

// The first elbow is bent for good, and the base stands still for the joint in front of it.
TEST(Twins, AreNotThereBeforeAnElbow) {
  EXPECT_EQ(circles({kRotary}), std::vector<int>{});
  EXPECT_EQ(circles({kLink, kRotary, kHinge}), std::vector<int>{});
}

TEST(Twins, HalveTheBoxForEveryGoal) {
  const auto problem = load_problem("breakeven/two_goals");
  const SequenceModel model{*problem, std::vector<int>{kHinge, kHinge}};
  const Box root = root_box(model, 2);
  const Box box = box_without_twins(model, 2);
  for (int v = 0; v < root.size(); ++v) {
    const bool base = v == model.n_lengths() || v == model.n_lengths() + model.n_joints();
    EXPECT_NEAR(box.width(v), base ? std::numbers::pi : root.width(v), 1e-9);
    if (base) {
      EXPECT_EQ(box.upper[static_cast<std::size_t>(v)], 0.0);
    }
  }
}

// In closed form for the reference library: the base half a turn further, hinges turned over, up to the first joint
// that turns about the arm, which takes half a turn back.
TEST(Twins, LieWhereTheyWere) {
  const auto problem = load_problem("seed/random_obstacles");
  Rng rng{4};
  for (int i = 0; i < 500; ++i) {
    std::vector<int> types{kHinge};
    for (int n = rng.index(4); n > 0; --n) types.push_back(rng.index(3));
    ASSERT_EQ(circles(types), std::vector<int>{0});
    const SequenceModel model{*problem, types};
    Eigen::VectorXd x(model.parameter_lower.size());
    for (Eigen::Index k = 0; k < x.size(); ++k) x[k] = rng.uniform(model.parameter_lower[k], model.parameter_upper[k]);
    const auto chain = problem->chain(types);
    const Arm arm = chain->at(x);
    Eigen::VectorXd q(model.n_joints());
    for (double& angle : q) angle = rng.uniform(-3.0, 3.0);
    Eigen::VectorXd twin = q;
    twin[0] += std::numbers::pi;
    Eigen::Index joint = 1;
    for (const int type : types) {
      if (type == kRotary) {
        twin[joint] += std::numbers::pi;
        break;
      }
      if (type == kHinge) {
        twin[joint] *= -1.0;
        ++joint;
      }
    }
    const Posture before = arm.forward(q);
    const Posture after = arm.forward(twin);
    EXPECT_TRUE(before.tip.translation().isApprox(after.tip.translation(), 1e-12));
    for (const ArmGeometry& geometry : arm.geometries()) {
      const auto frame = static_cast<std::size_t>(geometry.frame);
      for (const double along : {-0.3, 0.4}) {
        const Eigen::Vector3d point{0.0, 0.0, along};
        EXPECT_TRUE((before.frames[frame] * geometry.X_FG * point)
                        .isApprox(after.frames[frame] * geometry.X_FG * point, 1e-12));
      }
    }
  }
}

}  // namespace
}  // namespace modsearch::certify
