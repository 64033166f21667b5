#include <gmock/gmock.h>

#include <array>
#include <cmath>
#include <kinematics/sample_arms.hpp>
#include <modsearch/kinematics/inverse_kinematics.hpp>
#include <thread>

namespace modsearch {
namespace {

using sample::kPi;
using sample::kRadius;
using sample::seed_chain;
using testing::HasSubstr;
using testing::Le;
using testing::SizeIs;
using testing::ThrowsMessage;

constexpr double kTolerance = 1e-3;  // of the reference task [m]

double uniform(std::mt19937& generator, double lower, double upper) {
  return std::uniform_real_distribution<double>{lower, upper}(generator);
}

Eigen::VectorXd random_lengths(const Chain& chain, std::mt19937& generator) {
  Eigen::VectorXd x(chain.n_parameters());
  for (double& length : x) length = uniform(generator, 0.5, 1.5);
  return x;
}

// Least distance of a `seed` arm's tip from `t`, from the lengths alone. At most two hinges and rotaries.
//
// With rho = hypot(t_x, t_y) and links added to the length they continue:
// none: the fixed point (0, 0, L).  hinge: a full circle of radius d about (0, 0, p) in every plane through the z axis,
// so a sphere.  rotary: the distal part lies level at height p + r, so one horizontal circle of radius d - r.
// hinge-hinge: the second circle's centre is at distance a = d1 + p2 from (0, 0, p1), in the same plane: all distances
// |a - d2| .. a + d2, in every direction.
// hinge-rotary: the tip stands B = d2 - r off the line through (0, 0, p1), at A = d1 + p2 + r along it: distance
// hypot(A, B) always; the rotary can put the offset into the plane of the hinge, so every direction is met: a sphere.
// rotary-hinge: seen in the plane of the level distal part a circle of radius d2 about (a, p1 + r), a = d1 - r + p2;
// the base shows that plane to the target from either side. rotary-rotary: the second axis is the level line at height
// z0 = p1 + r; the tip circles about it with radius b = d2 - r at a = (d1 - r) + p2 + r from the z axis: always at
// distance hypot(a, b) from (0, 0, z0), as high as z0 +- b and no higher.
double least_distance(const std::string& types, const Eigen::VectorXd& x, const Eigen::Vector3d& t) {
  std::string actuated;
  std::array<double, 3> run{};  // straight lengths: before the first actuated joint, after it, after the second
  int parameter = 0;
  for (const char type : types) {
    run[actuated.size()] += x[parameter++];
    if (type == 'l') continue;
    actuated += type;
    run[actuated.size()] += x[parameter++];
  }
  const double r = kRadius;
  const double rho = std::hypot(t.x(), t.y());
  const double z = t.z() - run[0];  // height above the first actuated joint
  const double away = std::hypot(rho, z);
  if (actuated.empty()) return away;
  if (actuated == "h") return std::abs(away - run[1]);
  if (actuated == "r") return std::hypot(rho - (run[1] - r), z - r);
  if (actuated == "hh") return std::max({0.0, away - (run[1] + run[2]), std::abs(run[1] - run[2]) - away});
  if (actuated == "hr") return std::abs(away - std::hypot(run[1] + r, run[2] - r));
  const double above = z - r;
  if (actuated == "rh") {
    const double a = run[1] - r;
    return std::min(std::abs(std::hypot(rho - a, above) - run[2]), std::abs(std::hypot(-rho - a, above) - run[2]));
  }
  const double a = run[1];
  const double b = run[2] - r;
  const double s = std::hypot(rho, above);
  const double height = std::hypot(a, b) * above / s;  // where the ray to the target leaves the sphere
  return std::abs(height) <= b ? std::abs(s - std::hypot(a, b)) : std::hypot(rho - a, std::abs(above) - b);
}

// All type sequences of up to `most` modules with at most two actuated ones.
std::vector<std::string> sequences(std::size_t most) {
  std::vector<std::string> result{""};
  for (std::size_t i = 0; i < result.size(); ++i) {
    if (result[i].size() == most) continue;
    for (const char type : {'l', 'r', 'h'}) {
      const std::string longer = result[i] + type;
      if (std::count(longer.begin(), longer.end(), 'l') + 2 >= static_cast<std::ptrdiff_t>(longer.size())) {
        result.push_back(longer);
      }
    }
  }
  result.erase(result.begin());
  return result;
}

// A target at `distance` from what the arm can reach: from a random point down the distance function, whose slope is 1,
// onto the reachable set; then bisection on the way back out.
Eigen::Vector3d target_at(const std::string& types, const Eigen::VectorXd& x, double distance,
                          std::mt19937& generator) {
  while (true) {
    const double box = uniform(generator, 1.0, 8.0);  // the far side of the surface, and holes inside it
    const Eigen::Vector3d start{uniform(generator, -box, box), uniform(generator, -box, box),
                                uniform(generator, -box, box)};
    Eigen::Vector3d inside = start;
    for (int i = 0; i < 30 && least_distance(types, x, inside) > 0.5 * distance; ++i) {
      constexpr double kStep = 1e-6;
      Eigen::Vector3d slope;
      for (int axis = 0; axis < 3; ++axis) {
        const Eigen::Vector3d h = kStep * Eigen::Vector3d::Unit(axis);
        slope[axis] = (least_distance(types, x, inside + h) - least_distance(types, x, inside - h)) / (2.0 * kStep);
      }
      inside -= least_distance(types, x, inside) * slope;
    }
    Eigen::Vector3d outside = start;
    if (!(least_distance(types, x, inside) < distance && least_distance(types, x, outside) > distance)) continue;
    for (int i = 0; i < 100; ++i) {
      const Eigen::Vector3d middle = 0.5 * (inside + outside);
      (least_distance(types, x, middle) <= distance ? inside : outside) = middle;
    }
    return inside;
  }
}

bool within_limits(const Chain& chain, const Eigen::VectorXd& q) {
  return q.size() == chain.n_joints() && (q.array() >= chain.lower_limits().array()).all() &&
         (q.array() <= chain.upper_limits().array()).all();
}

TEST(InverseKinematics, VerdictOfEverySeedSequenceWithUpToThreeJointsAgreesWithItsReachInClosedForm) {
  std::mt19937 generator{1};
  constexpr int kPairs = 500;  // of each kind and sequence
  int pairs = 0;
  for (const std::string& types : sequences(4)) {
    const Chain chain = seed_chain(types);
    for (int i = 0; i < 2 * kPairs; ++i) {
      const Eigen::VectorXd x = random_lengths(chain, generator);
      // Half of the targets anywhere, the other half within a micrometre of the tolerance, some within a nanometre.
      Eigen::Vector3d t{uniform(generator, -2, 2), uniform(generator, -2, 2), uniform(generator, -2, 4)};
      if (i % 2 == 1) {
        const double width = i % 4 == 1 ? 1e-6 : 1e-9;
        t = target_at(types, x, kTolerance + uniform(generator, -width, width), generator);
      }
      const double expected = least_distance(types, x, t);
      const Arm arm = chain.at(x);
      const IkSolution solution = inverse_kinematics(arm, PoseRegion::ball(t, kTolerance), {.all = false});
      ASSERT_NEAR(solution.position_error, expected, 1e-11)
          << types << " x " << x.transpose() << " t " << t.transpose();
      ASSERT_EQ(solution.reached, expected <= kTolerance + PoseRegion::kSlack) << types << ' ' << expected - kTolerance;
      ASSERT_TRUE(solution.exact);
      ASSERT_TRUE(within_limits(chain, solution.postures.front()));
      ++pairs;
    }
  }
  EXPECT_GE(pairs, 10'000);
}

// A chain without structure, or with the right angles and parallel axes of real arms; random limits.
Chain random_chain(int n_joints, std::mt19937& generator) {
  const bool orthogonal = generator() % 2 == 0;
  const auto transform = [&] {
    Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
    if (orthogonal) {
      X.rotate(Eigen::AngleAxisd{kPi / 2 * static_cast<double>(generator() % 4), Eigen::Vector3d::UnitZ()});
      X.rotate(Eigen::AngleAxisd{kPi / 2 * static_cast<double>(generator() % 4), Eigen::Vector3d::UnitX()});
    } else {
      X.rotate(Eigen::Quaterniond{uniform(generator, -1, 1), uniform(generator, -1, 1), uniform(generator, -1, 1),
                                  uniform(generator, -1, 1)}
                   .normalized());
    }
    for (int axis = 0; axis < 3; ++axis) {
      X.translation()[axis] = orthogonal && generator() % 3 == 0 ? 0.0 : uniform(generator, -1, 1);
    }
    return X;
  };
  ChainBuilder builder{0};
  builder.move(transform());
  for (int j = 0; j < n_joints; ++j) {
    Joint joint{.name = "j"};
    switch (generator() % 4) {
      case 0:
        joint.lower = uniform(generator, -4, 2);
        joint.upper = joint.lower + uniform(generator, 0, 6.5);
        break;
      case 1:
        joint.type = JointType::kPrismatic;
        joint.lower = uniform(generator, -1, 0);
        joint.upper = joint.lower + uniform(generator, 0, 1.5);
        break;
      case 2:
        joint.type = JointType::kContinuous;
        joint.lower = -std::numeric_limits<double>::infinity();
        joint.upper = std::numeric_limits<double>::infinity();
        break;
      default:
        joint.lower = -kPi;
        joint.upper = kPi;
    }
    builder.joint(joint).move(transform());
  }
  return builder.build();
}

// Least distance by brute force: a grid over the limits, then a pattern search from its best points.
double brute_force(const Arm& arm, const Eigen::Vector3d& t) {
  const int n = arm.n_joints();
  const int points = n == 1 ? 400 : n == 2 ? 120 : 40;
  Eigen::VectorXd lower = arm.chain().lower_limits().cwiseMax(-kPi * 2.0);
  Eigen::VectorXd upper = arm.chain().upper_limits().cwiseMin(kPi * 2.0);
  for (int j = 0; j < n; ++j) {
    if (arm.chain().joints()[static_cast<std::size_t>(j)].type == JointType::kContinuous) {
      lower[j] = -kPi;
      upper[j] = kPi;
    }
  }
  Posture posture;
  const auto distance = [&](const Eigen::VectorXd& q) {
    arm.forward(q.data(), posture);
    return (posture.tip.translation() - t).norm();
  };
  std::vector<std::pair<double, Eigen::VectorXd>> grid;
  const int total = static_cast<int>(std::lround(std::pow(points, n)));
  double least = std::numeric_limits<double>::infinity();
  for (int k = 0; k < total; ++k) {
    Eigen::VectorXd q(n);
    for (int j = 0, rest = k; j < n; ++j, rest /= points) {
      q[j] = lower[j] + (upper[j] - lower[j]) * (rest % points) / (points - 1);
    }
    const double d = distance(q);
    least = std::min(least, d);
    if (d < least + 0.1) grid.emplace_back(d, q);
  }
  std::sort(grid.begin(), grid.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<Eigen::VectorXd> used;
  for (const auto& each : grid) {
    const double d = each.first;
    const Eigen::VectorXd& start = each.second;
    if (used.size() == 12 || d > grid.front().first + 0.1) break;
    if (std::any_of(used.begin(), used.end(), [&](const auto& q) { return (q - start).cwiseAbs().maxCoeff() < 0.3; })) {
      continue;
    }
    used.push_back(start);
    Eigen::VectorXd q = start;
    double best = d;
    for (double step = 0.1; step > 1e-9;) {
      bool better = false;
      for (int code = 0; code < std::lround(std::pow(3, n)); ++code) {
        Eigen::VectorXd trial = q;
        for (int j = 0, rest = code; j < n; ++j, rest /= 3) trial[j] += step * (rest % 3 - 1);
        trial = trial.cwiseMax(lower).cwiseMin(upper);
        const double value = distance(trial);
        if (value < best) {
          best = value;
          q = trial;
          better = true;
        }
      }
      if (!better) step *= 0.5;
    }
    least = std::min(least, best);
  }
  return least;
}

TEST(InverseKinematics, IsNeverFartherThanBruteForceOnRandomChainsOfOneToThreeJoints) {
  std::mt19937 generator{2};
  for (int i = 0; i < 240; ++i) {
    const int n = 1 + i % 3;
    const Chain chain = random_chain(n, generator);
    const Arm arm = chain.at(Eigen::VectorXd{0});
    const Eigen::Vector3d t{uniform(generator, -2, 2), uniform(generator, -2, 2), uniform(generator, -2, 2)};
    const IkSolution solution = inverse_kinematics(arm, PoseRegion::ball(t, kTolerance), {.all = i % 2 == 0});
    ASSERT_LE(solution.position_error, brute_force(arm, t) + 1e-9) << i;
    for (const Eigen::VectorXd& q : solution.postures) {
      ASSERT_TRUE(within_limits(chain, q)) << i << ": " << q.transpose();
      ASSERT_NEAR((arm.forward(q).tip.translation() - t).norm(), solution.position_error, 1.1e-9) << i;
    }
  }
}

TEST(InverseKinematics, SeedArmsWithLimitsShortOfATurnAgreeWithBruteForce) {
  std::mt19937 generator{3};
  for (const char* types : {"h", "r", "hh", "hr", "rh", "rr"}) {
    const Chain chain = seed_chain(types, 2.0);
    for (int i = 0; i < 6; ++i) {
      const Arm arm = chain.at(random_lengths(chain, generator));
      const Eigen::Vector3d t{uniform(generator, -2, 2), uniform(generator, -2, 2), uniform(generator, -1, 3)};
      const IkSolution solution = inverse_kinematics(arm, PoseRegion::ball(t, kTolerance), {.all = false});
      ASSERT_LE(solution.position_error, brute_force(arm, t) + 1e-9) << types << ' ' << i;
      ASSERT_TRUE(within_limits(chain, solution.postures.front()));
    }
  }
}

// Newton's method from random starts on an arm of three full circles, target within reach: the postures it finds.
std::vector<Eigen::VectorXd> found_from_random_starts(const Arm& arm, const Eigen::Vector3d& t,
                                                      std::mt19937& generator) {
  std::vector<Eigen::VectorXd> found;
  for (int start = 0; start < 100; ++start) {
    Eigen::Vector3d q{uniform(generator, -kPi, kPi), uniform(generator, -kPi, kPi), uniform(generator, -kPi, kPi)};
    Eigen::Vector3d e = Eigen::Vector3d::Ones();
    for (int step = 0; step < 60 && e.norm() > 1e-13; ++step) {
      const Posture posture = arm.forward(q);
      e = posture.tip.translation() - t;
      const Eigen::Matrix3d J = arm.tip_jacobian_q(posture).topRows<3>();
      const double damping = std::min(1e-3, 0.1 * e.squaredNorm());
      Eigen::Vector3d d = -J.transpose() * (J * J.transpose() + damping * Eigen::Matrix3d::Identity()).ldlt().solve(e);
      if (d.norm() > 0.5) d *= 0.5 / d.norm();
      q += d;
    }
    if (e.norm() > 1e-11) continue;
    const auto same = [&](const Eigen::VectorXd& other) {
      return std::all_of(&q[0], &q[0] + 3, [&, j = 0](double value) mutable {
        return std::abs(std::remainder(value - other[j++], 2.0 * kPi)) < 1e-4;
      });
    };
    if (std::none_of(found.begin(), found.end(), same)) found.push_back(q);
  }
  return found;
}

bool is_among(const Eigen::VectorXd& q, const std::vector<Eigen::VectorXd>& postures, double tolerance) {
  return std::any_of(postures.begin(), postures.end(), [&](const Eigen::VectorXd& other) {
    double apart = 0.0;
    for (Eigen::Index j = 0; j < q.size(); ++j) {
      apart = std::max(apart, std::abs(std::remainder(q[j] - other[j], 2.0 * kPi)));
    }
    return apart < tolerance;
  });
}

TEST(InverseKinematics, GivesEveryPostureThatReachesWithThreeGeneralRevoluteJoints) {
  std::mt19937 generator{4};
  for (int i = 0; i < 100; ++i) {
    ChainBuilder builder{0};
    for (int j = 0; j < 3; ++j) {
      Eigen::Isometry3d X{Eigen::Quaterniond{uniform(generator, -1, 1), uniform(generator, -1, 1),
                                             uniform(generator, -1, 1), uniform(generator, -1, 1)}
                              .normalized()};
      X.translation() << uniform(generator, -1, 1), uniform(generator, -1, 1), uniform(generator, -1, 1);
      builder.joint({.name = "j", .lower = -kPi, .upper = kPi}).move(X);
    }
    const Chain chain = builder.build();
    const Arm arm = chain.at(Eigen::VectorXd{0});
    const Eigen::Vector3d t = arm.forward(sample::random_joints(chain, generator)).tip.translation();
    const IkSolution solution = inverse_kinematics(arm, PoseRegion::ball(t, kTolerance));
    EXPECT_TRUE(solution.reached);
    EXPECT_LE(solution.postures.size(), 4u);  // at most four (Pieper)
    for (const Eigen::VectorXd& q : found_from_random_starts(arm, t, generator)) {
      ASSERT_TRUE(is_among(q, solution.postures, 1e-3)) << i << ": " << q.transpose();
    }
  }
}

TEST(InverseKinematics, TwoHingesReachAPointInFourPostures) {
  // Elbow up and down, and the same seen from behind with the base turned by half a circle.
  const Chain chain = seed_chain("hh");
  const Arm arm = chain.at(Eigen::Vector4d{0.5, 0.6, 0.5, 0.9});
  const Eigen::Vector3d t{0.7, 0.2, 0.9};
  const IkSolution solution = inverse_kinematics(arm, PoseRegion::ball(t, kTolerance));
  ASSERT_THAT(solution.postures, SizeIs(4));
  for (const Eigen::VectorXd& q : solution.postures) {
    EXPECT_LE((arm.forward(q).tip.translation() - t).norm(), 1e-12);
    // The elbow's angle from the law of cosines, a = 0.6 + 0.5 and b = 0.9: |t - shoulder|^2 = a^2 + b^2 + 2 a b cos.
    const double cosine = (0.7 * 0.7 + 0.2 * 0.2 + 0.4 * 0.4 - 1.1 * 1.1 - 0.9 * 0.9) / (2.0 * 1.1 * 0.9);
    EXPECT_NEAR(std::abs(q[2]), std::acos(cosine), 1e-9);
  }
}

TEST(InverseKinematics, GivesBothElbowsOfAnAlmostStretchedArm) {
  const Chain chain = seed_chain("hh");
  const Arm arm = chain.at(Eigen::Vector4d{0.5, 0.6, 0.5, 0.9});
  // A tenth of a millimetre short of stretched: the elbows are bent by 0.02 rad to either side.
  const Eigen::Vector3d t = Eigen::Vector3d{0, 0, 0.5} + (1.1 + 0.9 - 1e-4) * Eigen::Vector3d{0.6, 0.0, 0.8};
  EXPECT_THAT(inverse_kinematics(arm, PoseRegion::ball(t, kTolerance)).postures, SizeIs(4));
}

// Largest angle between neighbouring values of one joint, all the way round.
double largest_gap(const std::vector<Eigen::VectorXd>& postures, int joint) {
  std::vector<double> values;
  for (const Eigen::VectorXd& q : postures) values.push_back(q[joint]);
  std::sort(values.begin(), values.end());
  double gap = values.front() + 2.0 * kPi - values.back();
  for (std::size_t i = 1; i < values.size(); ++i) gap = std::max(gap, values[i] - values[i - 1]);
  return gap;
}

TEST(InverseKinematics, SamplesAOneParameterFamilyAt256Points) {
  // Base and rotary turn about one axis: whatever one does the other can undo.
  const Chain chain = seed_chain("rh");
  const Arm arm = chain.at(Eigen::Vector4d{0.6, 0.8, 0.5, 0.7});
  const IkSolution solution = inverse_kinematics(arm, PoseRegion::ball({0.5, 0.4, 1.6}, kTolerance));
  EXPECT_THAT(solution.postures, SizeIs(257));  // the family, and the plain posture ahead of it
  EXPECT_NEAR(largest_gap(solution.postures, 0), 2.0 * kPi / 256.0, 1e-9);
  EXPECT_NEAR(solution.postures.front()[1], 0.0, 1e-12);  // the plain one leaves the rotary alone
}

TEST(InverseKinematics, GivesOneWayToShareATurnWhereNoOtherIsAskedFor) {
  const Chain chain = seed_chain("rh");
  const Arm arm = chain.at(Eigen::Vector4d{0.6, 0.8, 0.5, 0.7});
  const PoseRegion region = PoseRegion::ball({0.5, 0.4, 1.6}, kTolerance);
  IkOptions one_way;
  one_way.shared_turns = false;
  const IkSolution one = inverse_kinematics(arm, region, one_way);
  const IkSolution all = inverse_kinematics(arm, region);
  EXPECT_THAT(one.postures, SizeIs(1));
  EXPECT_EQ(one.postures.front(), all.postures.front());
  EXPECT_EQ(one.position_error, all.position_error);
}

TEST(InverseKinematics, SamplesTheFamilyOfAWristThatReachesAWholeSphere) {
  const Chain chain = seed_chain("hr");
  const Arm arm = chain.at(Eigen::Vector4d{0.5, 0.6, 0.5, 0.9});
  const Eigen::Vector3d t{0.7, 0.2, 0.9};
  const IkSolution solution = inverse_kinematics(arm, PoseRegion::ball(t, kTolerance));
  EXPECT_GE(solution.postures.size(), 256u);
  const double expected = least_distance("hr", arm.parameters(), t);
  for (const Eigen::VectorXd& q : solution.postures) {
    EXPECT_NEAR((arm.forward(q).tip.translation() - t).norm(), expected, 1e-9);
  }
  // The tip stays in reach of the target's direction while the rotary turns through most of its circle.
  EXPECT_LE(largest_gap(solution.postures, 2), 1.5);
}

TEST(InverseKinematics, TurnsTheBaseAllRoundForATargetOnItsAxis) {
  const Chain chain = seed_chain("hh");
  const Arm arm = chain.at(Eigen::Vector4d{0.5, 0.6, 0.5, 0.9});
  const IkSolution solution = inverse_kinematics(arm, PoseRegion::ball({0, 0, 1.9}, kTolerance));
  EXPECT_TRUE(solution.reached);
  EXPECT_GE(solution.postures.size(), 256u);
  EXPECT_LE(largest_gap(solution.postures, 0), 2.0 * kPi / 256.0 + 1e-9);
}

TEST(InverseKinematics, SpendsAboutAsManyPointsOnATwoParameterFamily) {
  // Every posture puts the tip of a base with a rotary on its circle; seen from the axis all are equally far.
  const Chain chain = seed_chain("r");
  const Arm arm = chain.at(Eigen::Vector2d{0.6, 0.8});
  const IkSolution solution = inverse_kinematics(arm, PoseRegion::ball({0, 0, 0.2}, kTolerance));
  EXPECT_GE(solution.postures.size(), 200u);
  EXPECT_LE(solution.postures.size(), 600u);
  EXPECT_LE(largest_gap(solution.postures, 0), 0.5);
  EXPECT_LE(largest_gap(solution.postures, 1), 0.5);
}

TEST(InverseKinematics, OnePostureIsAmongAllAndEquallyClose) {
  std::mt19937 generator{5};
  for (const std::string& types : sequences(3)) {
    const Chain chain = seed_chain(types);
    const Arm arm = chain.at(random_lengths(chain, generator));
    const PoseRegion region =
        PoseRegion::ball({uniform(generator, -1, 1), uniform(generator, -1, 1), uniform(generator, 0, 2)}, kTolerance);
    const IkSolution all = inverse_kinematics(arm, region);
    const IkSolution one = inverse_kinematics(arm, region, {.all = false});
    EXPECT_THAT(one.postures, SizeIs(1));
    EXPECT_NEAR(one.position_error, all.position_error, 1e-12) << types;
    EXPECT_EQ(one.reached, all.reached) << types;
  }
}

}  // namespace
}  // namespace modsearch
