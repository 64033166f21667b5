#pragma once

#include <checker/json.hpp>
#include <string>
#include <vector>

namespace modsearch_check {

/// Parameters may lie this far outside their intervals and tips outside their goals, joints beyond their limits and
/// bodies inside obstacles: what the toolkit calls achieved is so up to rounding [m], [rad].
inline constexpr double kSlack = 1e-12;

/// offset + sum of columns[i] times parameter i.
struct AffineScalar {
  Interval offset;
  std::vector<Interval> columns;
};

enum class Kind { kBox, kCylinder, kSphere, kMesh };

/// Box: edges x, y, z. Cylinder: radius, height along z. Sphere: radius. Centred at its pose.
struct Shape {
  Kind kind = Kind::kSphere;
  std::vector<AffineScalar> size;
  Pose pose;
};

struct Connector {
  Pose pose;               // points away from the body
  std::size_t gender = 0;  // f, m, h
  std::string type;
  std::vector<double> size;
};

struct Body {
  std::string id;
  AffineScalar mass;
  std::vector<Connector> connectors;
  std::vector<Shape> shapes;
};

/// child = parent * before * Rz(q) * after; a fixed one has its constant angle in `after`.
struct Joint {
  bool fixed = false;
  std::size_t parent = 0;
  std::size_t child = 0;
  Pose before;
  Pose after;
  double lower = 0.0;
  double upper = 0.0;
};

struct Parameter {
  std::string name;
  double lower = 0.0;
  double upper = 0.0;
};

struct Module {
  std::string id;
  double cost = 0.0;
  std::vector<Parameter> parameters;
  std::vector<Body> bodies;
  std::vector<Joint> joints;

  /// Of all connectors, (body, connector), in the order of the file.
  [[nodiscard]] std::vector<std::pair<std::size_t, std::size_t>> connectors() const;
  [[nodiscard]] bool has_connector(std::string_view type) const;
};

struct Library {
  Module base;
  std::vector<Module> types;  // those a design chooses from
  bool has_tips = false;      // then a design that does not end in a module with an "eef" connector is incomplete
};

struct Goal {
  std::string id;
  Numbers position{};
  double radius = 0.0;
};

struct Task {
  Pose base;
  std::vector<Goal> goals;
  std::vector<Shape> obstacles;  // all shapes of all obstacles, in the world
};

/// The score of an achieved design: head - mass_weight * mass.
struct Scoring {
  bool algorithm1 = true;
  double reached = 0.0;
  double module = 0.0;
  double cost = 0.0;
  double mass_weight = 5.0;

  /// `n`: modules, the base included; `costs`: the sum of theirs.
  [[nodiscard]] Interval head(std::size_t n, const Interval& costs) const;
};

struct Problem {
  Library library;
  Task task;
  Scoring scoring;
  std::size_t max_modules = 1;  // the base included
  std::string level;
  Json scoring_text;  // as the file has it
  bool sampled = false;

  [[nodiscard]] bool sees_obstacles() const { return level != "none"; }
};

/// Reads a problem file (or built-in problem) and everything it refers to; draws the goal of instance seed:index where
/// the file says how. `near`: the file whose folder relative paths start from. Throws Malformed for what cannot be read
/// and Rejected for problems about which nothing is proved.
[[nodiscard]] Problem read_problem(const std::string& file_or_id, const std::string& near, std::uint64_t seed,
                                   std::uint64_t index);

[[nodiscard]] Library read_library(const Value& value);
[[nodiscard]] Task read_task(const Value& value);
/// Shapes of a body or obstacle; `parameters` those of its module.
[[nodiscard]] Shape read_shape(const Value& value, const std::vector<Parameter>& parameters);

/// The target that instance seed:index draws: uniform in the box, the first that is not closer than `clearance` to an
/// obstacle.
[[nodiscard]] Numbers draw_target(const Numbers& lower, const Numbers& upper, double clearance, const Task& task,
                                  std::uint64_t seed, std::uint64_t index);

}  // namespace modsearch_check
