#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <modsearch/kinematics/scene.hpp>
#include <modsearch/problem/readers_internal.hpp>
#include <modsearch/problem/rigid_ends_internal.hpp>
#include <modsearch/problem/whitman.hpp>
#include <numbers>
#include <optional>
#include <stdexcept>

namespace modsearch {
namespace {

using nlohmann::ordered_json;

constexpr double kGrid = 0.25;       // [m], and the edge of a box
constexpr int kFromAxis = 2;         // grid points to either side of the base's axis
constexpr int kLevels = 5;           // grid points above each other
constexpr double kStem = 0.5;        // [m] above the ground, what is kept free about the base's axis
constexpr double kFromStem = 0.2;    // [m] a goal to that
constexpr double kFromBoxes = 0.06;  // [m] a goal to the boxes: about half a gripper
constexpr double kFreeEnd = 0.005;   // [m] an end effector to the boxes, where ends have to be free
constexpr int kMostDraws = 10'000;   // of a goal, for an end effector that is free
constexpr int kMost = 20;

/// On the base's axis or next to it, near the ground: a box there would leave the arm no room to begin.
bool on_the_stem(const Eigen::Vector3d& p_W) { return p_W.head<2>().lpNorm<1>() < 1.5 * kGrid && p_W.z() < kStem; }

std::vector<Eigen::Vector3d> draw_boxes(int n, Rng rng) {
  std::vector<Eigen::Vector3d> free;
  for (int i = -kFromAxis; i <= kFromAxis; ++i) {
    for (int j = -kFromAxis; j <= kFromAxis; ++j) {
      for (int k = 0; k < kLevels; ++k) {
        const Eigen::Vector3d p_W{kGrid * i, kGrid * j, kGrid * k};
        if (!on_the_stem(p_W)) free.push_back(p_W);
      }
    }
  }
  std::vector<Eigen::Vector3d> boxes;
  for (int i = 0; i < n; ++i) {
    const auto drawn = free.begin() + rng.index(static_cast<int>(free.size()));
    boxes.push_back(*drawn);
    free.erase(drawn);
  }
  return boxes;
}

Eigen::Isometry3d at(const Eigen::Vector3d& p_W) { return Eigen::Isometry3d{Eigen::Translation3d{p_W}}; }

/// Uniform over all rotations (Shoemake 1992, "Uniform random rotations", Graphics Gems III).
Eigen::Matrix3d draw_rotation(Rng& rng) {
  const double u = rng.uniform();
  const double a = 2.0 * std::numbers::pi * rng.uniform();
  const double b = 2.0 * std::numbers::pi * rng.uniform();
  const double r = std::sqrt(1.0 - u);
  const double s = std::sqrt(u);
  return Eigen::Quaterniond{s * std::cos(b), r * std::sin(a), r * std::cos(a), s * std::sin(b)}.toRotationMatrix();
}

// The end effectors of a library at the tip, parameters at their lower ends.
class EndEffectors {
 public:
  explicit EndEffectors(const ModuleLibrary& library) {
    if (!library.has_end_effectors()) {
      throw std::invalid_argument(
          fmt::format("whitman: free ends are asked for, and library '{}' has no end effector", library.name()));
    }
    const detail::RigidEnds ends = detail::rigid_ends(library);
    for (int i = 0; i < ends.n_last; ++i) {
      const detail::RigidModule& module = ends.tails[static_cast<std::size_t>(i)];
      std::vector<PlacedShape>& shapes = shapes_.emplace_back();
      for (const detail::RigidPart& part : module.parts) {
        shapes.push_back({part.shape.at(module.lower), part.X_RG.at(module.lower)});
      }
    }
  }

  /// Whether one of them keeps clear of the boxes with the tip at `X_WE`.
  [[nodiscard]] bool any_free(const Eigen::Isometry3d& X_WE, const Scene& scene) const {
    const auto keeps_clear = [&](const PlacedShape& shape) {
      return std::all_of(scene.obstacles().begin(), scene.obstacles().end(), [&](const Obstacle& box) {
        return signed_distance(shape.shape, X_WE * shape.X_FG, box.shapes[0].shape, box.shapes[0].X_FG) >= kFreeEnd;
      });
    };
    return std::any_of(shapes_.begin(), shapes_.end(), [&](const std::vector<PlacedShape>& shapes) {
      return std::all_of(shapes.begin(), shapes.end(), keeps_clear);
    });
  }

 private:
  std::vector<std::vector<PlacedShape>> shapes_;  // by end effector
};

Eigen::Isometry3d draw_goal(const Scene& scene, Rng& rng) {
  Eigen::Vector3d p_W;
  do {
    p_W = {rng.uniform(-0.5, 0.5), rng.uniform(-0.5, 0.5), rng.uniform(0.0, 1.0)};
  } while (scene.clearance(p_W) < kFromBoxes || (p_W.head<2>().norm() < kFromStem && p_W.z() < kStem));
  Eigen::Isometry3d X_WG = at(p_W);
  X_WG.linear() = draw_rotation(rng);
  return X_WG;
}

Eigen::Isometry3d draw_goal(const Scene& scene, const std::optional<EndEffectors>& ends, Rng& rng) {
  for (int draw = 0; draw < kMostDraws; ++draw) {
    const Eigen::Isometry3d X_WG = draw_goal(scene, rng);
    if (!ends || ends->any_free(X_WG, scene)) return X_WG;
  }
  throw std::runtime_error(
      fmt::format("whitman: no end effector is free of the boxes at any of {} goals in a row", kMostDraws));
}

ordered_json goal_json(int number, const Eigen::Isometry3d& X_WG) {
  constexpr double kHalfDegree = std::numbers::pi / 360.0;
  return {{"ID", std::to_string(number)},
          {"type", "reach"},
          {"goalPose",
           {{"nominal", detail::to_json(X_WG)},
            {"toleranceProjection", {"x", "y", "z", "Theta_R"}},
            {"tolerance", {{-0.001, 0.001}, {-0.001, 0.001}, {-0.001, 0.001}, {0, kHalfDegree}}}}}};
}

ordered_json box_json(int number, const Eigen::Vector3d& p_W) {
  return {{"ID", fmt::format("box {}", number)},
          {"collision",
           {{{"type", "box"},
             {"parameters", {{"x", kGrid}, {"y", kGrid}, {"z", kGrid}}},
             {"pose", detail::to_json(at(p_W))}}}}};
}

detail::Json family() { return detail::Json::parse(detail::builtin_problem("whitman/3g_3o").value()); }

}  // namespace

std::string whitman_task(const WhitmanTasks& tasks, Instance instance) {
  for (const auto& [what, n] : {std::pair{"goals", tasks.goals}, std::pair{"boxes", tasks.boxes}}) {
    if (n < 1 || n > kMost) throw std::invalid_argument(fmt::format("whitman: {} {} (limit: 1 to {})", n, what, kMost));
  }
  const Rng rng = Rng{instance.seed}.fork("whitman").fork(instance.index);
  ordered_json obstacles = ordered_json::array();
  std::vector<Obstacle> placed;
  for (const Eigen::Vector3d& p_W : draw_boxes(tasks.boxes, rng.fork("boxes"))) {
    obstacles.push_back(box_json(static_cast<int>(placed.size()) + 1, p_W));
    placed.push_back({"box", {{Box{Eigen::Vector3d::Constant(kGrid)}, at(p_W)}}});
  }
  const Scene scene{std::move(placed)};
  ordered_json goals = ordered_json::array();
  std::optional<EndEffectors> ends;
  if (tasks.free_ends) ends.emplace(*tasks.free_ends);
  Rng goal_rng = rng.fork("goals");
  for (int i = 1; i <= tasks.goals; ++i) goals.push_back(goal_json(i, draw_goal(scene, ends, goal_rng)));

  const ordered_json task{
      {"header",
       {{"ID", fmt::format("whitman/{}g_{}o{}/{}/{}", tasks.goals, tasks.boxes, tasks.free_ends ? "_free" : "",
                           instance.seed, instance.index)},
        {"version", "2022"},
        {"taskName", fmt::format("{} goals among {} boxes", tasks.goals, tasks.boxes)},
        {"tags", {"generated"}},
        {"timeStepSize", 0.01},
        {"gravity", {0, 0, -9.81}}}},
      {"obstacles", std::move(obstacles)},
      {"constraints",
       {{{"type", "joint"}, {"parts", {"q", "tau"}}},
        {{"type", "selfCollisionFree"}},
        {{"type", "collisionFree"}},
        {{"type", "allGoalsFulfilled"}},
        {{"type", "validAssembly"}},
        {{"type", "basePlacement"}, {"pose", {{"nominal", detail::to_json(Eigen::Isometry3d::Identity())}}}}}},
      {"goals", std::move(goals)}};
  return detail::to_text(task);
}

std::shared_ptr<const ModuleLibrary> whitman_library() { return load_library(family().at("library")); }

std::string whitman_problem(const std::string& task) {
  const detail::Json given = family();
  ordered_json problem{{"modsearch", 1}, {"task", task}};
  for (const char* key : {"library", "maxModules", "collision", "scoring"}) problem[key] = ordered_json(given.at(key));
  return detail::to_text(problem);
}

}  // namespace modsearch
