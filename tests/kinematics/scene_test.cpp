#include <fcl/narrowphase/collision.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <modsearch/kinematics/scene.hpp>
#include <new>

#include "kinematics/sample_arms.hpp"

namespace {
thread_local long allocations = 0;
}

// Counts, for the test that the hot path does not allocate.
[[gnu::noinline]] void* operator new(std::size_t size) {
  ++allocations;
  if (void* memory = std::malloc(size > 0 ? size : 1)) return memory;
  throw std::bad_alloc{};
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

namespace modsearch {
namespace {

using sample::kRadius;
using sample::translation;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

Eigen::Isometry3d pose(const ArmGeometry& geometry, const Posture& posture) {
  return posture.frames[static_cast<std::size_t>(geometry.frame)] * geometry.X_FG;
}

// FCL's own shapes, for an independent opinion.
std::shared_ptr<fcl::CollisionGeometryd> fcl_shape(const Shape& shape) {
  if (const auto* s = std::get_if<Sphere>(&shape)) return std::make_shared<fcl::Sphered>(s->radius);
  if (const auto* s = std::get_if<Box>(&shape)) return std::make_shared<fcl::Boxd>(s->size);
  if (const auto* s = std::get_if<Cylinder>(&shape)) return std::make_shared<fcl::Cylinderd>(s->radius, s->length);
  const auto& capsule = std::get<Capsule>(shape);
  return std::make_shared<fcl::Capsuled>(capsule.radius, capsule.length);
}

bool fcl_overlap(const Shape& a, const Eigen::Isometry3d& X_WA, const Shape& b, const Eigen::Isometry3d& X_WB) {
  fcl::CollisionObjectd object_a(fcl_shape(a), X_WA);
  fcl::CollisionObjectd object_b(fcl_shape(b), X_WB);
  fcl::CollisionResultd result;
  return fcl::collide(&object_a, &object_b, fcl::CollisionRequestd{}, result) > 0;
}

// A mast of the given height with an arm of the given length that turns about the vertical at its top.
Chain crane(double height, double length) {
  ChainBuilder builder{0};
  const auto cylinder = [](double l) {
    return AffineShape{AffineShape::Kind::kCylinder, {AffineScalar{kRadius}, AffineScalar{l}}, nullptr};
  };
  const int mast = builder.body("mast", 0, 0.0, {{cylinder(height), translation(0, 0, height / 2)}});
  builder.move(translation(0, 0, height)).joint({.name = "slew", .lower = -sample::kPi, .upper = sample::kPi}, mast, 1);
  builder.move(sample::rotation_about_y(sample::kPi / 2));
  builder.body("jib", 0, 0.0, {{cylinder(length), translation(0, 0, length / 2)}});
  return builder.move(translation(0, 0, length)).build();
}

TEST(Scene, IsInfinitelyFarAwayWhenEmpty) {
  const Chain chain = crane(1.0, 1.0);
  const Arm arm = chain.at({});
  Work work;
  const Posture posture = arm.forward(Eigen::VectorXd::Zero(1));
  EXPECT_EQ(Scene{}.clearance(arm, posture, work), kInfinity);
  EXPECT_EQ(Scene{}.clearance(Eigen::Vector3d::Zero()), kInfinity);
  EXPECT_FALSE(Scene{}.collides(arm, posture, work));
  EXPECT_TRUE(Scene{}.contacts(arm, posture, 1.0, work).empty());
  EXPECT_EQ(self_clearance(arm, posture, work), kInfinity) << "mast and jib are neighbours";
  EXPECT_EQ(work.distances, 0);
}

TEST(Scene, MeasuresTheClearanceOfAnArmThatTurns) {
  const Chain chain = crane(1.0, 1.0);
  const Arm arm = chain.at({});
  // A ball of radius 0.1 beside the jib's end circle: at q = 0 the jib reaches from x = 0 to x = 1 at height 1.
  const Scene scene{{{"ball", {{Sphere{0.1}, translation(0.5, 0.4, 1.0)}}}}};
  Work work;
  EXPECT_NEAR(scene.clearance(arm, arm.forward(Eigen::VectorXd::Zero(1)), work), 0.4 - 0.1 - kRadius, 1e-12);
  // Turned by 90 degrees the jib lies along y, 0.5 from the ball's centre.
  EXPECT_NEAR(scene.clearance(arm, arm.forward(Eigen::VectorXd::Constant(1, sample::kPi / 2)), work),
              0.5 - 0.1 - kRadius, 1e-12);
  // Turned towards it: the axis passes through the centre, and a sideways move of both radii parts them.
  const double towards = std::atan2(0.4, 0.5);
  EXPECT_NEAR(scene.clearance(arm, arm.forward(Eigen::VectorXd::Constant(1, towards)), work), -0.1 - kRadius, 1e-9);
  EXPECT_TRUE(scene.collides(arm, arm.forward(Eigen::VectorXd::Constant(1, towards)), work));
}

TEST(Scene, MeasuresTheClearanceOfAPoint) {
  const Scene scene = sample::mixed_scene();
  EXPECT_NEAR(scene.clearance(Eigen::Vector3d{0.3, 0.3, 1.5}), 0.6 - 0.2, 1e-12) << "above the second sphere";
  EXPECT_NEAR(scene.clearance(Eigen::Vector3d{0.7, 0.6, 0.85}), 0.1, 1e-12) << "above the box";
  EXPECT_NEAR(scene.clearance(Eigen::Vector3d{0.7, 0.6, 0.65}), -0.1, 1e-12) << "inside the box";
}

TEST(Scene, GivesTheLeastDistanceOfAllPairsWhateverTheCapsulesPart) {
  std::mt19937 generator{1};
  const Chain chain = sample::seed_chain("hrlh");
  const Scene scene = sample::mixed_scene();
  const Arm arm = chain.at(Eigen::VectorXd::Constant(chain.n_parameters(), 0.6));
  for (int i = 0; i < 1000; ++i) {
    const Posture posture = arm.forward(sample::random_joints(chain, generator));
    double least = kInfinity;
    bool overlap = false;
    std::vector<Contact> near;
    for (std::size_t g = 0; g < arm.geometries().size(); ++g) {
      const ArmGeometry& geometry = arm.geometries()[g];
      for (const Obstacle& obstacle : scene.obstacles()) {
        for (const PlacedShape& placed : obstacle.shapes) {
          const Eigen::Isometry3d X_WG = pose(geometry, posture);
          const double distance = signed_distance(geometry.shape, X_WG, placed.shape, placed.X_FG);
          least = std::min(least, distance);
          overlap = overlap || overlaps(geometry.shape, X_WG, placed.shape, placed.X_FG);
          const Separation found = separation(geometry.shape, X_WG, placed.shape, placed.X_FG);
          if (found.distance < 0.2) {
            near.push_back({found, static_cast<int>(g), static_cast<int>(&obstacle - scene.obstacles().data()),
                            static_cast<int>(&placed - obstacle.shapes.data())});
          }
        }
      }
    }
    Work work;
    EXPECT_EQ(scene.clearance(arm, posture, work), least);
    EXPECT_EQ(scene.collides(arm, posture, work), overlap);
    const std::vector<Contact> contacts = scene.contacts(arm, posture, 0.2, work);
    ASSERT_EQ(contacts.size(), near.size());
    for (std::size_t c = 0; c < contacts.size(); ++c) {
      EXPECT_EQ(contacts[c].separation.distance, near[c].separation.distance);
      EXPECT_EQ(contacts[c].geometry, near[c].geometry);
      EXPECT_EQ(contacts[c].other, near[c].other);
      EXPECT_EQ(contacts[c].other_shape, near[c].other_shape);
    }
  }
}

// Between ceiling and floor the answer is the clearance; beyond them it only says on which side.
void expect_within(double exact, double ceiling, double floor, double answer) {
  if (exact >= ceiling) {
    EXPECT_EQ(answer, ceiling);
  } else if (exact > floor) {
    EXPECT_EQ(answer, exact);
  } else {
    EXPECT_GE(answer, exact);
    EXPECT_LE(answer, floor);
  }
}

TEST(Scene, MeasuresBetweenCeilingAndFloorOnly) {
  std::mt19937 generator{8};
  std::uniform_real_distribution<double> angle{-sample::kPi, sample::kPi};
  std::uniform_real_distribution<double> somewhere{-0.5, 1.0};
  auto tent = std::make_shared<TriangleMesh>();  // a mesh among the obstacles: it is searched no farther either
  tent->vertices = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}, {0, 0, 1}};
  tent->triangles = {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}};
  const Scene scene{{{"tent", {{Mesh{tent}, translation(1.5, 0.0, 0.2)}}},
                     {"box", {{Box{{0.3, 0.3, 0.3}}, translation(-1.0, 0.5, 1.0)}}}}};
  const Chain chain = sample::seed_chain("hlhr");
  const Arm arm = chain.at(Eigen::VectorXd::Constant(chain.n_parameters(), 0.6));
  for (int i = 0; i < 300; ++i) {
    Eigen::VectorXd q(chain.n_joints());
    for (double& each : q) each = angle(generator);
    const Posture posture = arm.forward(q);
    Work work;
    const double one = somewhere(generator);
    const double other = somewhere(generator);
    const double ceiling = std::max(one, other);
    const double floor = std::min(one, other);
    expect_within(scene.clearance(arm, posture, work), ceiling, floor,
                  scene.clearance(arm, posture, work, ceiling, floor));
    expect_within(self_clearance(arm, posture, work), ceiling, floor,
                  self_clearance(arm, posture, work, ceiling, floor));
  }
}

TEST(Scene, AgreesWithFclOnWhatCollides) {
  std::mt19937 generator{2};
  const Chain chain = sample::seed_chain("hrlh");
  const Scene scene = sample::mixed_scene();
  int collisions = 0;
  for (int i = 0; i < 1000; ++i) {
    std::uniform_real_distribution<double> length{0.5, 1.5};
    const Eigen::VectorXd x = Eigen::VectorXd::NullaryExpr(chain.n_parameters(), [&] { return length(generator); });
    const Arm arm = chain.at(x);
    const Posture posture = arm.forward(sample::random_joints(chain, generator));
    bool expected = false;
    for (const ArmGeometry& geometry : arm.geometries()) {
      for (const Obstacle& obstacle : scene.obstacles()) {
        for (const PlacedShape& placed : obstacle.shapes) {
          expected = expected || fcl_overlap(geometry.shape, pose(geometry, posture), placed.shape, placed.X_FG);
        }
      }
    }
    Work work;
    collisions += expected ? 1 : 0;
    // FCL's answers within a micrometre of touching are its tolerance's.
    if (std::abs(scene.clearance(arm, posture, work)) > 1e-6) {
      EXPECT_EQ(scene.collides(arm, posture, work), expected) << i;
    }
  }
  EXPECT_GT(collisions, 100) << "the sample must hold both answers";
  EXPECT_LT(collisions, 900);
}

TEST(Scene, LeavesFarPairsToTheirCapsules) {
  const Chain chain = crane(1.0, 1.0);
  const Arm arm = chain.at({});
  const Scene scene{{{"far", {{Box{{1, 1, 1}}, translation(5, 0, 0)}, {Sphere{1.0}, translation(0, 5, 0)}}}}};
  const Posture posture = arm.forward(Eigen::VectorXd::Zero(1));
  Work work;
  EXPECT_FALSE(scene.collides(arm, posture, work));
  EXPECT_EQ(work.distances, 0);
  // From the jib's end at x = 1 and its lower side to the box's edge at x = 4.5, z = 0.5.
  EXPECT_NEAR(scene.clearance(arm, posture, work), std::hypot(3.5, 0.5 - kRadius), 1e-9);
}

TEST(Scene, AllocatesNothingToTellACollision) {
  std::mt19937 generator{3};
  const Chain chain = sample::seed_chain("hhrh");
  const Arm arm = chain.at(Eigen::VectorXd::Constant(chain.n_parameters(), 0.7));
  const Scene scene = sample::mixed_scene();
  std::vector<Posture> postures;
  for (int i = 0; i < 200; ++i) postures.push_back(arm.forward(sample::random_joints(chain, generator)));
  Work work;
  int collisions = 0;
  const long before = allocations;
  for (const Posture& posture : postures) {
    collisions += scene.collides(arm, posture, work) ? 1 : 0;
    collisions += self_collides(arm, posture, work) ? 1 : 0;
  }
  EXPECT_EQ(allocations, before);
  EXPECT_GT(collisions, 0);
}

TEST(Scene, RefusesAShapeThatIsNone) {
  const auto message = [](const PlacedShape& shape) -> std::string {
    try {
      const Scene scene{{{"good", {}}, {"wall", {{Sphere{1.0}, Eigen::Isometry3d::Identity()}, shape}}}};
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "accepted";
  };
  using testing::HasSubstr;
  EXPECT_THAT(message({Sphere{-1.0}, Eigen::Isometry3d::Identity()}), HasSubstr("obstacle 1 ('wall'), shape 1"));
  EXPECT_THAT(message({Box{{1, std::nan(""), 1}}, Eigen::Isometry3d::Identity()}), HasSubstr("wall"));
  EXPECT_THAT(message({Sphere{1.0}, translation(kInfinity, 0, 0)}), HasSubstr("not finite"));
  Eigen::Isometry3d scaled = Eigen::Isometry3d::Identity();
  scaled.linear() *= 2.0;
  EXPECT_THAT(message({Sphere{1.0}, scaled}), HasSubstr("no rigid motion"));
  Eigen::Isometry3d mirror = Eigen::Isometry3d::Identity();
  mirror.linear()(0, 0) = -1.0;
  EXPECT_THAT(message({Sphere{1.0}, mirror}), HasSubstr("no rigid motion"));
}

TEST(SelfCollision, ComparesOnlyBodiesThatAreNotNeighbours) {
  // Three hinges, every cylinder 0.5 long. Bodies: 0 p0 | joint | 1 d0, 2 p1 | joint | 3 d1, 4 p2 | joint | 5 d2.
  const Chain chain = sample::seed_chain("hhh");
  const Arm arm = chain.at(Eigen::VectorXd::Constant(chain.n_parameters(), 0.5));
  Work work;
  const auto posture = [&](double q1, double q2, double q3) { return arm.forward(Eigen::Vector4d{0.0, q1, q2, q3}); };
  // Stretched out. Closest: two bodies with one of length 0.5 between them, e.g. p0 and p1.
  EXPECT_NEAR(self_clearance(arm, posture(0, 0, 0), work), 0.5, 1e-9);
  // Three right angles in the plane of the hinges: p0 from (0, 0) to (0, .5), d0 and p1 on to (1, .5), d1 and p2 down
  // to (1, -.5), d2 back to (.5, -.5). The closest that are not neighbours lie either side of a body of 0.5, at a right
  // angle: the flat end of one at 0.5 from the axis of the other, e.g. p1 and p0.
  EXPECT_NEAR(self_clearance(arm, posture(sample::kPi / 2, sample::kPi / 2, sample::kPi / 2), work), 0.5 - kRadius,
              1e-9);
  EXPECT_FALSE(self_collides(arm, posture(sample::kPi / 2, sample::kPi / 2, sample::kPi / 2), work));
  // Folded back onto itself, d1 lies in p1 (neighbours by the joint), p2 in d0, and d2 in p0.
  EXPECT_TRUE(self_collides(arm, posture(0, sample::kPi, 0), work));
  EXPECT_LT(self_clearance(arm, posture(0, sample::kPi, 0), work), -kRadius);
}

TEST(SelfCollision, AgreesWithFclOnEveryPairOfBodies) {
  std::mt19937 generator{4};
  const Chain chain = sample::seed_chain("hrhlh");
  const Arm arm = chain.at(Eigen::VectorXd::Constant(chain.n_parameters(), 0.5));
  int collisions = 0;
  for (int i = 0; i < 1000; ++i) {
    const Posture posture = arm.forward(sample::random_joints(chain, generator));
    bool expected = false;
    double least = kInfinity;
    std::size_t near = 0;
    for (const auto& [first, second] : chain.self_pairs()) {
      for (const ArmGeometry& a : arm.geometries()) {
        for (const ArmGeometry& b : arm.geometries()) {
          if (a.body != first || b.body != second) continue;
          expected = expected || fcl_overlap(a.shape, pose(a, posture), b.shape, pose(b, posture));
          const double distance = signed_distance(a.shape, pose(a, posture), b.shape, pose(b, posture));
          least = std::min(least, distance);
          near += separation(a.shape, pose(a, posture), b.shape, pose(b, posture)).distance < 0.1 ? 1 : 0;
        }
      }
    }
    Work work;
    EXPECT_EQ(self_clearance(arm, posture, work), least);
    EXPECT_EQ(self_contacts(arm, posture, 0.1, work).size(), near);
    collisions += expected ? 1 : 0;
    if (std::abs(least) > 1e-6) {
      EXPECT_EQ(self_collides(arm, posture, work), expected) << i;
    }
  }
  EXPECT_GT(collisions, 50) << "the sample must hold both answers";
  EXPECT_LT(collisions, 950);
}

TEST(BoundingCapsule, NeverGivesMoreThanTheDistanceOfTheShapesInside) {
  std::mt19937 generator{5};
  std::uniform_real_distribution<double> size{0.0, 1.0};
  std::normal_distribution<double> normal{0.0, 1.0};
  const auto shape = [&]() -> Shape {
    switch (generator() % 4) {
      case 0:
        return Sphere{size(generator)};
      case 1:
        return Box{{size(generator), size(generator), size(generator)}};
      case 2:
        return Cylinder{size(generator), size(generator)};
      default:
        return Capsule{size(generator), size(generator)};
    }
  };
  const auto random_pose = [&] {
    Eigen::Quaterniond q{normal(generator), normal(generator), normal(generator), normal(generator)};
    return translation(normal(generator), normal(generator), normal(generator)) * q.normalized();
  };
  for (int i = 0; i < 10'000; ++i) {
    const Shape a = shape();
    const Shape b = shape();
    const Eigen::Isometry3d X_WA = random_pose();
    const Eigen::Isometry3d X_WB = random_pose();
    const double bound =
        gap(bounding_capsule(a, bounding_radius(a), X_WA), bounding_capsule(b, bounding_radius(b), X_WB));
    EXPECT_LE(bound, signed_distance(a, X_WA, b, X_WB));
  }
}

}  // namespace
}  // namespace modsearch
