// Signed clearance against FCL on equal inputs: Own/<pair>_<query> and Ref/<pair>_<query>, time per pair.
// FCL gets its geometry objects ready made, as a planner would keep them.

#include <benchmark/benchmark.h>
#include <fcl/fcl.h>

#include <cmath>
#include <memory>
#include <modsearch/kinematics/separation.hpp>
#include <random>
#include <string>
#include <vector>

namespace modsearch {
namespace {

using Eigen::AngleAxisd;
using Eigen::Isometry3d;
using Eigen::Vector3d;

enum class Kind { kSphere, kCapsule, kCylinder, kBox };

struct Pair {
  Shape a, b;
  Isometry3d X_WA, X_WB;
  std::shared_ptr<fcl::CollisionGeometryd> fcl_a, fcl_b;
};

/// Uniform numbers from the engine's integers, equal with every standard library.
class Draw {
 public:
  explicit Draw(unsigned seed) : engine_(seed) {}
  double uniform(double low, double high) { return low + (high - low) * static_cast<double>(engine_()) / 4294967296.0; }
  Vector3d in_cube(double half) { return {uniform(-half, half), uniform(-half, half), uniform(-half, half)}; }
  Isometry3d pose(double half) {
    Isometry3d X = Isometry3d::Identity();
    X.translation() = in_cube(half);
    return X * AngleAxisd(uniform(0.0, 3.0), in_cube(1.0).normalized());
  }

 private:
  std::mt19937 engine_;
};

Shape draw_shape(Draw& draw, Kind kind) {
  switch (kind) {
    case Kind::kSphere:
      return Sphere{draw.uniform(0.05, 0.3)};
    case Kind::kCapsule:
      return Capsule{draw.uniform(0.03, 0.1), draw.uniform(0.1, 0.6)};
    case Kind::kCylinder:
      return Cylinder{draw.uniform(0.03, 0.1), draw.uniform(0.1, 0.6)};
    case Kind::kBox:
      return Box{Vector3d(draw.uniform(0.1, 0.6), draw.uniform(0.1, 0.6), draw.uniform(0.1, 0.6))};
  }
  return Sphere{};
}

std::shared_ptr<fcl::CollisionGeometryd> geometry(const Shape& shape) {
  if (const auto* s = std::get_if<Sphere>(&shape)) return std::make_shared<fcl::Sphered>(s->radius);
  if (const auto* s = std::get_if<Capsule>(&shape)) return std::make_shared<fcl::Capsuled>(s->radius, s->length);
  if (const auto* s = std::get_if<Cylinder>(&shape)) return std::make_shared<fcl::Cylinderd>(s->radius, s->length);
  return std::make_shared<fcl::Boxd>(std::get<Box>(shape).size);
}

constexpr std::size_t kPairs = 1024;  // fits the cache; a power of two to walk around

/// Pairs of a robot's and an obstacle's size within a metre of each other; 4 to 24 % of them overlap.
std::vector<Pair> draw_pairs(Kind a, Kind b) {
  Draw draw(12345);
  std::vector<Pair> pairs;
  for (std::size_t i = 0; i < kPairs; ++i) {
    Pair pair{draw_shape(draw, a), draw_shape(draw, b), draw.pose(0.5), draw.pose(0.5), nullptr, nullptr};
    pair.fcl_a = geometry(pair.a);
    pair.fcl_b = geometry(pair.b);
    pairs.push_back(std::move(pair));
  }
  return pairs;
}

bool own_overlaps(const Pair& p) { return overlaps(p.a, p.X_WA, p.b, p.X_WB); }
double own_distance(const Pair& p) { return signed_distance(p.a, p.X_WA, p.b, p.X_WB); }
double own_separation(const Pair& p) { return separation(p.a, p.X_WA, p.b, p.X_WB).p_WA.x(); }

bool fcl_overlaps(const Pair& p) {
  fcl::CollisionRequestd request;
  request.gjk_solver_type = fcl::GST_INDEP;
  fcl::CollisionResultd result;
  return fcl::collide(p.fcl_a.get(), p.X_WA, p.fcl_b.get(), p.X_WB, request, result) > 0;
}

fcl::DistanceResultd fcl_query(const Pair& p, bool witnesses) {
  fcl::DistanceRequestd request(witnesses);
  request.gjk_solver_type = fcl::GST_INDEP;
  fcl::DistanceResultd result;
  fcl::distance(p.fcl_a.get(), p.X_WA, p.fcl_b.get(), p.X_WB, request, result);
  return result;
}
double fcl_distance(const Pair& p) { return fcl_query(p, false).min_distance; }
double fcl_separation(const Pair& p) { return fcl_query(p, true).nearest_points[0].x(); }

/// What is compared must be the same: equal booleans, and distances of free pairs equal to FCL's own accuracy. FCL
/// stops short now and then, so two in a hundred may differ.
std::string difference(const std::vector<Pair>& pairs) {
  int distances_differ = 0;
  for (const Pair& pair : pairs) {
    const double distance = own_distance(pair);
    if (std::abs(distance) < 1e-6) continue;
    if (own_overlaps(pair) != fcl_overlaps(pair)) return "booleans differ from FCL's";
    if (own_overlaps(pair) != (distance < 0.0)) return "overlaps and signed_distance differ";
    if (distance > 0.0 && std::abs(fcl_distance(pair) - distance) > 1e-4) ++distances_differ;
  }
  return distances_differ > static_cast<int>(pairs.size() / 50) ? "distances differ from FCL's" : "";
}

template <class Query>
void run(benchmark::State& state, Kind a, Kind b, const Query& query) {
  const std::vector<Pair> pairs = draw_pairs(a, b);
  if (const std::string reason = difference(pairs); !reason.empty()) {
    state.SkipWithError(reason.c_str());
    return;
  }
  std::size_t i = 0;
  for (auto _ : state) {
    auto answer = query(pairs[i++ % kPairs]);
    benchmark::DoNotOptimize(answer);
  }
}

void add(const std::string& name, Kind a, Kind b) {
  const auto both = [&](const std::string& query, auto own, auto reference) {
    benchmark::RegisterBenchmark(("Ref/" + name + "_" + query).c_str(),
                                 [=](benchmark::State& state) { run(state, a, b, reference); });
    benchmark::RegisterBenchmark(("Own/" + name + "_" + query).c_str(),
                                 [=](benchmark::State& state) { run(state, a, b, own); });
  };
  both("overlaps", own_overlaps, fcl_overlaps);
  both("distance", own_distance, fcl_distance);
  both("separation", own_separation, fcl_separation);
}

[[maybe_unused]] const bool kRegistered = [] {
  add("cylinder_sphere", Kind::kCylinder, Kind::kSphere);
  add("cylinder_box", Kind::kCylinder, Kind::kBox);
  add("cylinder_cylinder", Kind::kCylinder, Kind::kCylinder);
  add("capsule_sphere", Kind::kCapsule, Kind::kSphere);
  add("capsule_box", Kind::kCapsule, Kind::kBox);
  add("capsule_capsule", Kind::kCapsule, Kind::kCapsule);
  add("box_box", Kind::kBox, Kind::kBox);
  return true;
}();

}  // namespace
}  // namespace modsearch
