#include <gtest/gtest.h>

#include <algorithm>
#include <modsearch/problem/completions_internal.hpp>
#include <modsearch/problem/end_proofs_internal.hpp>

#include "problem/end_tasks.hpp"

namespace modsearch {
namespace {

using detail::Completions;
using detail::least_joints;

struct Sums {
  int joints = 0;
  double mass = 0.0, cost = 0.0, length = 0.0, greatest_length = 0.0;
};

// All complete arms of `more` modules behind `types`, one by one.
template <typename Visit>
void for_each_completion(const ModuleLibrary& library, std::vector<int>& types, int more, const Visit& visit) {
  if (more == 0) {
    if (library.complete(types)) visit(types);
    return;
  }
  for (const int k : library.successors(types)) {
    types.push_back(k);
    for_each_completion(library, types, more - 1, visit);
    types.pop_back();
  }
}

TEST(Completions, AreTheLightestCheapestAndLongestOfAllThatAreEnumerated) {
  const auto library = load_library("workshop");
  std::vector<ModuleSpan> spans;
  std::vector<bool> may_end;
  for (int k = 0; k < library->n_types(); ++k) {
    spans.push_back(module_span(library->type(k)));
    // gripper_90 is ruled out.
    may_end.push_back(library->type(k).role() == ModuleRole::kEndEffector && library->type(k).id != "gripper_90");
  }
  const Completions completions{*library, spans, may_end, 2, 11};
  const auto joints_of = [&](const std::vector<int>& types) {
    int joints = 0;
    for (const int k : types) joints += library->type(k).role() == ModuleRole::kJoint ? 1 : 0;
    return joints;
  };
  const int adapter = library->find("adapter_120_60").value();
  const int drive = library->find("drive_120_bent").value();
  for (std::vector<int> prefix : {std::vector<int>{}, {adapter}, {drive}, {drive, adapter}}) {
    for (int more = 1; more <= 4; ++more) {
      const std::size_t given = prefix.size();
      std::optional<Sums> best;
      for_each_completion(*library, prefix, more, [&](const std::vector<int>& types) {
        if (!may_end[static_cast<std::size_t>(types.back())] || joints_of(types) < 2) return;
        Sums sums;
        for (std::size_t i = given; i < types.size(); ++i) {
          const ModuleSpan& span = spans[static_cast<std::size_t>(types[i])];
          sums.mass += span.mass;
          sums.cost += span.cost;
          sums.length += span.length;
          sums.greatest_length += span.greatest_length();
        }
        if (!best) best = sums;
        best->mass = std::min(best->mass, sums.mass);
        best->cost = std::min(best->cost, sums.cost);
        best->length = std::max(best->length, sums.length);
        best->greatest_length = std::max(best->greatest_length, sums.greatest_length);
      });
      const Continuation found = completions.completion(prefix, more);
      ASSERT_EQ(found.possible, best.has_value()) << given << " given, " << more << " more";
      if (!best) continue;
      EXPECT_NEAR(found.mass, best->mass, 1e-12);
      EXPECT_NEAR(found.cost, best->cost, 1e-9);
      EXPECT_NEAR(found.length, best->length, 1e-12);
      EXPECT_NEAR(found.greatest_length, best->greatest_length, 1e-12);
    }
  }
}

std::vector<std::optional<detail::PoseEnclosure>> exact(const std::vector<Eigen::Isometry3d>& poses, double metres,
                                                        double radians) {
  std::vector<std::optional<detail::PoseEnclosure>> result;
  for (const Eigen::Isometry3d& X : poses) {
    result.push_back(
        detail::enclosure(PoseRegion{X, {{Projection::kRSph, 0.0, metres}, {Projection::kThetaR, 0.0, radians}}}));
  }
  return result;
}

Eigen::Isometry3d pose(const Eigen::Vector3d& p, const Eigen::Vector3d& r) {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.translation() = p;
  X.linear() = test::rotation_of(r);
  return X;
}

// One joint turns the tip about one axis, here z through the origin; what also rises by a centimetre, or turns about
// another axis, needs two.
TEST(LeastJoints, AreAsManyAsDifferentPosesNeed) {
  const Eigen::Vector3d x = Eigen::Vector3d::UnitX();
  const Eigen::Vector3d y = Eigen::Vector3d::UnitY();
  const Eigen::Vector3d z = Eigen::Vector3d::UnitZ();
  const Eigen::Isometry3d start = pose(x, {0, 0, 0});
  EXPECT_EQ(least_joints(exact({start}, 1e-3, 0.01)), 0);
  EXPECT_EQ(least_joints(exact({start, pose(1.001 * x, {0, 0, 0})}, 1e-3, 0.01)), 0);
  EXPECT_EQ(least_joints(exact({start, pose(1.01 * x, {0, 0, 0})}, 1e-3, 0.01)), 1);  // may slide
  EXPECT_EQ(least_joints(exact({start, pose(y, 0.25 * test::kTurn * z), pose(-x, 0.5 * test::kTurn * z)}, 1e-3, 0.01)),
            1);
  EXPECT_EQ(least_joints(exact({start, pose(y + 0.1 * z, 0.25 * test::kTurn * z)}, 1e-3, 0.01)), 2);
  EXPECT_EQ(least_joints(exact({start, pose(y, 0.25 * test::kTurn * z), pose(x, 0.25 * test::kTurn * x)}, 1e-3, 0.01)),
            2);
  // Where any direction will do, one joint that slides, or turns, may do.
  std::vector<std::optional<detail::PoseEnclosure>> balls;
  for (const Eigen::Vector3d& p : {x, y, z}) balls.push_back(detail::enclosure(PoseRegion::ball(p, 1e-3)));
  EXPECT_EQ(least_joints(balls), 1);
}

// The poses that arms with so many joints take, moved within the tolerance, never need more.
TEST(LeastJoints, AreNeverMoreThanAnArmHasThatGetsThere) {
  Rng rng{5};
  const auto library = load_library("workshop");
  int seen[3] = {};
  while (*std::min_element(seen, seen + 3) < 300) {
    const std::vector<int> types = test::random_sequence(*library, 7, rng);
    const Chain chain = library->assemble(types);
    if (chain.n_joints() > 2) continue;
    ++seen[chain.n_joints()];
    const Arm arm = chain.at(test::random_parameters(*library, types, rng));
    std::vector<std::optional<detail::PoseEnclosure>> goals;
    for (int g = 0; g < 3; ++g) {
      const Eigen::Isometry3d X_WE = arm.forward(test::random_posture(chain, rng)).tip;
      const test::Looseness loose = test::looseness(rng.index(test::kLoosenesses), rng);
      const Eigen::Isometry3d D = loose.draw(Eigen::Isometry3d::Identity(), rng);
      goals.push_back(detail::enclosure(PoseRegion{X_WE * D.inverse(), loose.tolerances}));
    }
    ASSERT_LE(least_joints(goals), chain.n_joints());
  }
}

// Three generated poses need two joints; with a gripper and the adapter to it an arm has three modules at least, and no
// score is above 73. With the base alone (12 kg, 400 of cost), its length and the number of modules, 85 would be left.
TEST(Completions, BoundTheScoresOfGeneratedTasksByWhatEveryArmContains) {
  for (std::uint64_t i = 0; i < 20; ++i) {
    const auto problem = load_problem("whitman/3g_3o", {.seed = 1, .index = i});
    for (int n = 1; n < problem->max_modules(); ++n) {
      const Optimism optimism = problem->optimism_of_length(n);
      EXPECT_LT(optimism.score, 73.0);
      if (n < 3) {
        EXPECT_EQ(optimism.score, -std::numeric_limits<double>::infinity()) << n;
      }
    }
  }
}

}  // namespace
}  // namespace modsearch
