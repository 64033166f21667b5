#include "study/demo_page.hpp"

#include <cmath>
#include <string>
#include <utility>
#include <vector>

namespace modsearch::testing {
namespace {

constexpr double kRadius = 0.055;  // of every link [m]

PagePose translation(double x, double y, double z) { return {1, 0, 0, x, 0, 1, 0, y, 0, 0, 1, z, 0, 0, 0, 1}; }

PagePose rotation_z(double q) {
  return {std::cos(q), -std::sin(q), 0, 0, std::sin(q), std::cos(q), 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
}

PagePose rotation_x(double q) {
  return {1, 0, 0, 0, 0, std::cos(q), -std::sin(q), 0, 0, std::sin(q), std::cos(q), 0, 0, 0, 0, 1};
}

PagePose rotation_y(double q) {
  return {std::cos(q), 0, std::sin(q), 0, 0, 1, 0, 0, -std::sin(q), 0, std::cos(q), 0, 0, 0, 0, 1};
}

PagePose operator*(const PagePose& a, const PagePose& b) {
  PagePose out{};
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = 0; j < 4; ++j) {
      for (std::size_t k = 0; k < 4; ++k) out[4 * i + j] += a[4 * i + k] * b[4 * k + j];
    }
  }
  return out;
}

PageBody link(const std::string& name, int module, double length) {
  PageBody body;
  body.name = name;
  body.module = module;
  body.shapes = {{.kind = PageShapeKind::kCylinder, .size = {kRadius, length}, .X_BG = translation(0, 0, length / 2)}};
  return body;
}

PageBody obstacle(const std::string& name, PageShapeKind kind, std::vector<double> size, const PagePose& pose) {
  PageBody body;
  body.name = name;
  body.shapes = {{.kind = kind, .size = std::move(size)}};
  body.keyframes = {pose};
  return body;
}

double smooth(double t) { return t * t * (3 - 2 * t); }

}  // namespace

Page demo_page(int samples) {
  const double lengths[4] = {0.5, 0.5, 0.5, 0.5};
  const double goal[3] = {-1.55, -0.5, -0.9};  // base, first hinge, second hinge [rad]

  Page page;
  page.title = "seed/random_obstacles, instance 7:3";
  page.problem = "seed/random_obstacles, instance 7:3";
  page.solver = "per-sequence (inner=own)";
  page.seed = "1";
  page.command =
      "modsearch solve seed/random_obstacles --instance 7:3 --solver per-sequence:inner=own --seed 1 --out out";
  page.modules = {{"base", {}},
                  {"hinge", {{"proximal", lengths[0], "m"}, {"distal", lengths[1], "m"}}},
                  {"hinge", {{"proximal", lengths[2], "m"}, {"distal", lengths[3], "m"}}}};
  page.mass = lengths[0] + lengths[1] + lengths[2] + lengths[3];
  page.terms = {{"reached", 50.0}, {"few modules", 150.0}, {"modules", -2.0}, {"mass", -5.0 * page.mass}};
  page.score = 198.0 - 5.0 * page.mass;
  page.achieved = true;
  page.verified = "path";
  page.evaluations = 4210;
  page.seconds = 0.873;
  page.clearance = 0.0192;
  page.goal_error = 0.00098;
  page.trace = {{1, 0.001, -7.9, false},  {4, 0.002, -3.1, false},  {19, 0.006, -2.4, false}, {61, 0.014, 172.0, true},
                {140, 0.03, 178.4, true}, {520, 0.11, 184.9, true}, {1650, 0.34, 188.0, true}};
  page.obstacles = {obstacle("sphere 1", PageShapeKind::kSphere, {0.3}, translation(-0.5, 0.5, 1.2)),
                    obstacle("sphere 2", PageShapeKind::kSphere, {0.2}, translation(0.3, 0.3, 0.9)),
                    obstacle("box", PageShapeKind::kBox, {0.3, 0.4, 0.5}, translation(0.7, 0.6, 0.5))};
  page.region = PageRegion{{0, 0, 1}, {1, 1, 2}};
  page.base = kPageIdentity;

  PageBody bodies[4] = {link("hinge 1, proximal", 1, lengths[0]), link("hinge 1, distal", 1, lengths[1]),
                        link("hinge 2, proximal", 2, lengths[2]), link("hinge 2, distal", 2, lengths[3])};
  bodies[0].joints = {{"base", PageJointKind::kRevolute, kPageIdentity},
                      {"hinge 1", PageJointKind::kRevolute, translation(0, 0, lengths[0]) * rotation_y(M_PI / 2)}};
  bodies[2].joints = {{"hinge 2", PageJointKind::kRevolute, translation(0, 0, lengths[2]) * rotation_y(M_PI / 2)}};
  for (int i = 0; i < samples; ++i) {
    const double t = samples > 1 ? static_cast<double>(i) / (samples - 1) : 1.0;
    const PagePose first = rotation_z(goal[0] * smooth(t));
    const PagePose second = first * translation(0, 0, lengths[0]) * rotation_x(goal[1] * std::sin(M_PI / 2 * t));
    const PagePose third = second * translation(0, 0, lengths[1]);
    const PagePose fourth = third * translation(0, 0, lengths[2]) * rotation_x(goal[2] * smooth(t) * t);
    const PagePose* poses[4] = {&first, &second, &third, &fourth};
    for (std::size_t k = 0; k < 4; ++k) bodies[k].keyframes.push_back(*poses[k]);
    const PagePose tip = fourth * translation(0, 0, lengths[3]);
    page.tip.push_back({tip[3], tip[7], tip[11]});
    if (samples > 1) page.times.push_back(3.2 * t);
  }
  page.bodies.assign(std::begin(bodies), std::end(bodies));
  page.targets = {{.name = "target", .position = page.tip.back(), .tolerance = 0.001, .frame = {}}};
  page.milestones = {{"home", 0}, {"target", samples - 1}};
  return page;
}

}  // namespace modsearch::testing
