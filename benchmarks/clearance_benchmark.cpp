// Whether an arm collides, and planning, which asks that a thousand times: ours against FCL. Every pair of cases works
// on equal inputs, and refuses to run where the two do not agree.
#include <benchmark/benchmark.h>
#include <fcl/narrowphase/collision.h>

#include <cmath>
#include <memory>
#include <modsearch/kinematics/edge_checker_internal.hpp>
#include <modsearch/kinematics/path_planning.hpp>
#include <modsearch/kinematics/rrt_connect_internal.hpp>
#include <modsearch/kinematics/shortcut_internal.hpp>
#include <random>
#include <string>

#include "kinematics/sample_arms.hpp"

namespace modsearch {
namespace {

// The obstacles of seed/random_obstacles.
Scene seed_obstacles() {
  using sample::translation;
  return Scene{{{"left", {{Sphere{0.3}, translation(-0.5, 0.5, 1.2)}}},
                {"right", {{Sphere{0.2}, translation(0.3, 0.3, 0.9)}}},
                {"box", {{Box{{0.3, 0.4, 0.5}}, translation(0.7, 0.6, 0.5)}}}}};
}

std::shared_ptr<fcl::CollisionGeometryd> fcl_shape(const Shape& shape) {
  if (const auto* s = std::get_if<Sphere>(&shape)) return std::make_shared<fcl::Sphered>(s->radius);
  if (const auto* s = std::get_if<Box>(&shape)) return std::make_shared<fcl::Boxd>(s->size);
  if (const auto* s = std::get_if<Cylinder>(&shape)) return std::make_shared<fcl::Cylinderd>(s->radius, s->length);
  const auto& capsule = std::get<Capsule>(shape);
  return std::make_shared<fcl::Capsuled>(capsule.radius, capsule.length);
}

// The usual way: one FCL object per shape, all pairs, boxes along the axes first.
class FclWorld {
 public:
  FclWorld(const Arm& arm, const Scene& scene, bool self_collision) : arm_{arm} {
    for (const ArmGeometry& geometry : arm.geometries()) bodies_.emplace_back(fcl_shape(geometry.shape));
    for (const Obstacle& obstacle : scene.obstacles()) {
      for (const PlacedShape& placed : obstacle.shapes) {
        obstacles_.emplace_back(fcl_shape(placed.shape), placed.X_FG);
        obstacles_.back().computeAABB();
      }
    }
    if (!self_collision) return;
    for (const auto& [first, second] : arm.chain().self_pairs()) {
      for (std::size_t a = 0; a < bodies_.size(); ++a) {
        for (std::size_t b = 0; b < bodies_.size(); ++b) {
          if (arm.geometries()[a].body == first && arm.geometries()[b].body == second) self_pairs_.emplace_back(a, b);
        }
      }
    }
  }

  bool collides(const Posture& posture) {
    for (std::size_t g = 0; g < bodies_.size(); ++g) {
      const ArmGeometry& geometry = arm_.geometries()[g];
      bodies_[g].setTransform(posture.frames[static_cast<std::size_t>(geometry.frame)] * geometry.X_FG);
      bodies_[g].computeAABB();
    }
    for (const fcl::CollisionObjectd& body : bodies_) {
      for (const fcl::CollisionObjectd& obstacle : obstacles_) {
        if (overlap(body, obstacle)) return true;
      }
    }
    for (const auto& [a, b] : self_pairs_) {
      if (overlap(bodies_[a], bodies_[b])) return true;
    }
    return false;
  }

 private:
  static bool overlap(const fcl::CollisionObjectd& a, const fcl::CollisionObjectd& b) {
    if (!a.getAABB().overlap(b.getAABB())) return false;
    fcl::CollisionResultd result;
    return fcl::collide(&a, &b, fcl::CollisionRequestd{}, result) > 0;
  }

  const Arm& arm_;
  std::vector<fcl::CollisionObjectd> bodies_;
  std::vector<fcl::CollisionObjectd> obstacles_;
  std::vector<std::pair<std::size_t, std::size_t>> self_pairs_;
};

// The edge checker as it would be with FCL: every state of the edge, halving, at the same resolution.
class FclChecker final : public MotionChecker {
 public:
  FclChecker(const Arm& arm, const Scene& scene, double resolution)
      : arm_{arm},
        world_{arm, scene, true},
        motion_{arm, arm.chain().lower_limits(), arm.chain().upper_limits()},
        resolution_{resolution} {}

  bool state_free(const double* q) override {
    arm_.forward(q, posture_);
    return !world_.collides(posture_);
  }

  bool edge_free(const double* a, const double* b) override {
    if (!state_free(b)) return false;
    const std::int64_t n = parts_of(motion_.travel(a, b), resolution_);
    ranges_.assign(1, {1, n - 1});
    Eigen::VectorXd q(arm_.n_joints());
    for (std::size_t next = 0; next < ranges_.size(); ++next) {
      const auto [first, last] = ranges_[next];
      if (first > last) continue;
      const std::int64_t middle = first + (last - first) / 2;
      interpolate(a, b, middle, n, arm_.n_joints(), q.data());
      if (!state_free(q.data())) return false;
      ranges_.emplace_back(first, middle - 1);
      ranges_.emplace_back(middle + 1, last);
    }
    return true;
  }

 private:
  const Arm& arm_;
  FclWorld world_;
  MotionBound motion_;
  double resolution_;
  Posture posture_;
  std::vector<std::pair<std::int64_t, std::int64_t>> ranges_;
};

struct Robot {
  explicit Robot(const std::string& types)
      : chain{sample::seed_chain(types)}, arm{chain.at(Eigen::VectorXd::Constant(chain.n_parameters(), 0.6))} {}
  Robot(const Robot&) = delete;  // the arm points to the chain
  Robot& operator=(const Robot&) = delete;

  Chain chain;
  Arm arm;
};

// ---- state validity ----

struct States {
  explicit States(const std::string& types) : robot{types}, scene{seed_obstacles()}, world{robot.arm, scene, true} {
    std::mt19937 generator{1};
    for (int i = 0; i < 4096; ++i) {
      postures.push_back(robot.arm.forward(sample::random_joints(robot.chain, generator)));
    }
  }

  bool own(const Posture& posture, Work& work) const {
    return scene.collides(robot.arm, posture, work) || self_collides(robot.arm, posture, work);
  }

  // Postures on which the two differ though no surface is within 10 micrometres of another.
  int disagreements() {
    int count = 0;
    Work work;
    for (const Posture& posture : postures) {
      if (own(posture, work) == world.collides(posture)) continue;
      const double clearance =
          std::min(scene.clearance(robot.arm, posture, work), self_clearance(robot.arm, posture, work));
      count += std::abs(clearance) > 1e-5 ? 1 : 0;
    }
    return count;
  }

  Robot robot;
  Scene scene;
  FclWorld world;
  std::vector<Posture> postures;
};

template <typename Collides>
void state_validity(benchmark::State& state, const std::string& types, Collides collides) {
  States states{types};
  if (states.disagreements() > 0) return state.SkipWithError("FCL and ours disagree");
  std::size_t i = 0;
  std::int64_t collisions = 0;
  for (auto _ : state) {
    collisions += collides(states, states.postures[i]) ? 1 : 0;
    i = (i + 1) % states.postures.size();
  }
  state.counters["colliding"] = static_cast<double>(collisions) / static_cast<double>(state.iterations());
}

void ref_state(benchmark::State& state, const std::string& types) {
  state_validity(state, types, [](States& states, const Posture& posture) { return states.world.collides(posture); });
}

void own_state(benchmark::State& state, const std::string& types) {
  Work work;
  state_validity(state, types, [&](States& states, const Posture& posture) { return states.own(posture, work); });
}

// ---- planning ----

struct Query {
  Eigen::VectorXd q_start;
  Eigen::VectorXd q_goal;
};

struct Queries {
  static constexpr PlanOptions kOptions{.max_iterations = 2000};

  explicit Queries(const std::string& types) : robot{types}, scene{seed_obstacles()} {
    std::mt19937 generator{2};
    while (queries.size() < 32) {  // free ends, and no straight line between them
      const Query query{sample::random_joints(robot.chain, generator), sample::random_joints(robot.chain, generator)};
      const Plan plan = plan_path(robot.arm, scene, query.q_start, query.q_goal, kOptions);
      if (plan.status == PlanStatus::kExact && plan.iterations > 0) queries.push_back(query);
    }
  }

  // plan_path with FCL in the place of our checker: the same tree and the same shortcuts.
  std::vector<Eigen::VectorXd> reference(const Query& query) const {
    FclChecker checker(robot.arm, scene, kOptions.resolution);
    if (!checker.state_free(query.q_start.data()) || !checker.state_free(query.q_goal.data())) return {};
    if (checker.edge_free(query.q_start.data(), query.q_goal.data())) return {query.q_start, query.q_goal};
    RrtConnectResult found = rrt_connect(query.q_start, query.q_goal, robot.chain.lower_limits(),
                                         robot.chain.upper_limits(), kOptions.max_iterations, kOptions.stream, checker);
    if (found.waypoints.empty()) return {};
    const auto path = shortened(std::move(found.waypoints), kOptions.shortcut_attempts, kOptions.stream, checker);
    for (std::size_t i = 0; i + 1 < path.size(); ++i) {
      if (!checker.edge_free(path[i].data(), path[i + 1].data())) return {};
    }
    return path;
  }

  // Queries on which the two do not give the same path to the last bit.
  int differing_paths() const {
    int count = 0;
    for (const Query& query : queries) {
      const Plan plan = plan_path(robot.arm, scene, query.q_start, query.q_goal, kOptions);
      const std::vector<Eigen::VectorXd> path = reference(query);
      bool equal = static_cast<std::size_t>(plan.path.waypoints.rows()) == path.size();
      for (std::size_t i = 0; equal && i < path.size(); ++i) {
        equal = plan.path.waypoints.row(static_cast<Eigen::Index>(i)) == path[i].transpose();
      }
      count += equal ? 0 : 1;
    }
    return count;
  }

  Robot robot;
  Scene scene;
  std::vector<Query> queries;
};

template <typename PlanOne>
void planning(benchmark::State& state, const std::string& types, PlanOne plan_one) {
  const Queries queries{types};
  if (queries.differing_paths() > 0) return state.SkipWithError("FCL and ours lead to different paths");
  std::size_t i = 0;
  for (auto _ : state) {
    plan_one(queries, queries.queries[i]);
    i = (i + 1) % queries.queries.size();
  }
}

void ref_plan(benchmark::State& state, const std::string& types) {
  planning(state, types,
           [](const Queries& queries, const Query& query) { benchmark::DoNotOptimize(queries.reference(query)); });
}

void own_plan(benchmark::State& state, const std::string& types) {
  planning(state, types, [](const Queries& queries, const Query& query) {
    benchmark::DoNotOptimize(
        plan_path(queries.robot.arm, queries.scene, query.q_start, query.q_goal, Queries::kOptions));
  });
}

BENCHMARK_CAPTURE(ref_state, hh, "hh")->Name("Ref/state/2_hinges");
BENCHMARK_CAPTURE(own_state, hh, "hh")->Name("Own/state/2_hinges");
BENCHMARK_CAPTURE(ref_state, hrhh, "hrhh")->Name("Ref/state/4_modules");
BENCHMARK_CAPTURE(own_state, hrhh, "hrhh")->Name("Own/state/4_modules");
BENCHMARK_CAPTURE(ref_plan, hh, "hh")->Name("Ref/plan/2_hinges")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(own_plan, hh, "hh")->Name("Own/plan/2_hinges")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(ref_plan, hrh, "hrh")->Name("Ref/plan/3_modules")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(own_plan, hrh, "hrh")->Name("Own/plan/3_modules")->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace modsearch

BENCHMARK_MAIN();
