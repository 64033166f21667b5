#pragma once

#include <cstdint>
#include <modsearch/problem/rng.hpp>
#include <modsearch/problem/robot_problem.hpp>
#include <optional>
#include <string>

namespace table1 {

/// A numeric inverse kinematics that may fail, as reinforcement learners usually have it behind their reward.
struct FallibleIk {
  int starts = 1;          ///< random postures it begins from, one after the other until one of them reaches
  int iterations = 20;     ///< of damped least squares, per start
  double damping = 0.1;    ///< lambda [m] in dq = J^T (J J^T + lambda^2 I)^-1 e (Wampler 1986; Nakamura, Hanafusa 1986)
  double longest = 0.5;    ///< norm of a step at most [rad]
  std::uint64_t salt = 0;  ///< other postures for the same design
  bool per_episode = false;  ///< a new salt in every episode: whether a design reaches is luck each time
  /// Error at which the solver calls itself done [m], by which episodes end; the reward goes by the goal's own
  /// tolerance. Nothing: one tolerance for both.
  std::optional<double> done_within;
};

/// "starts=1,iterations=20,damping=0.1,salt=7,per_episode=true,done_within=0.01", any part of it.
/// Throws std::invalid_argument for another key or a bad value.
[[nodiscard]] FallibleIk fallible_ik_from_text(const std::string& text);

/// Reach one goal, judged by FallibleIk instead of the exact inverse kinematics. The starts follow from the design's
/// numbers, so that evaluating stays a function of the design (and the salt).
class FallibleReach final : public modsearch::Task {
 public:
  /// Throws std::invalid_argument unless `goal` is a ball and the counts are at least 1.
  FallibleReach(modsearch::Goal goal, FallibleIk ik);

  [[nodiscard]] std::string_view name() const override { return "fallible reach"; }
  [[nodiscard]] std::span<const modsearch::Goal> goals() const override { return {&goal_, 1}; }
  /// Throws std::invalid_argument for a scene with obstacles: postures are not compared by clearance here.
  [[nodiscard]] modsearch::Attempt attempt(const modsearch::Arm& arm, const modsearch::Scene& scene,
                                           const modsearch::AttemptOptions& options) const override;

 private:
  modsearch::Goal goal_;
  FallibleIk ik_;
  double within_;  // error at which an attempt counts as reached [m]
};

/// `problem` with a FallibleReach in place of its task, and, where `ik.done_within` is given, a scoring that pays for
/// reaching only within the goal's own tolerance.
[[nodiscard]] modsearch::RobotProblemSpec with_fallible_ik(modsearch::RobotProblemSpec problem, const FallibleIk& ik);

}  // namespace table1
