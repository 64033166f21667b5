#pragma once

// Which ends of arms are proved to overlap an obstacle, and what follows for a task. Internal to the problem floor.

#include <modsearch/kinematics/scene.hpp>
#include <modsearch/problem/design_problem.hpp>
#include <modsearch/problem/pose_enclosure_internal.hpp>
#include <modsearch/problem/rigid_ends_internal.hpp>
#include <modsearch/problem/task.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace modsearch::detail {

/// The goals of a task as far as they can be enclosed [n_goals].
[[nodiscard]] std::vector<std::optional<PoseEnclosure>> enclosures(const Task& task);

/// How many joints an arm needs at least to bring its tip to poses that these enclose: 0, 1 or 2.
///
/// Two poses that cannot be the same need a joint. With a single one that turns, all poses of the tip lie about one
/// axis: from any of them to any other it turns about this axis and does not move along it. With a single one that
/// slides, all have the same rotation. Where the poses, with all their tolerance, allow neither, two are needed.
[[nodiscard]] int least_joints(const std::vector<std::optional<PoseEnclosure>>& goals);

/// Where a module at an end of an arm overlaps an obstacle for certain.
struct CertainOverlap {
  int goal = -1;  ///< -1: whatever the goals are, at the beginning of the arm
  int obstacle = 0;
  int module = RigidModule::kBase;  ///< type
  double depth = 0.0;               ///< at least [m]
};

/// What is proved about the ends of the arms of a library at the goals of a task, or about their beginnings.
class EndProofs {
 public:
  /// `ends`: of the library. `goals`: see `enclosures`.
  EndProofs(const ModuleLibrary& library, const RigidEnds& ends, const Task& task, const Scene& scene,
            const Eigen::Isometry3d& X_WB, const std::vector<std::optional<PoseEnclosure>>& goals);

  /// Why no arm at all is free of the obstacles; nothing if that is not proved.
  [[nodiscard]] const std::optional<Infeasibility>& infeasible() const { return infeasible_; }
  /// Whether arms that end with a module of type `k` are ruled out.
  [[nodiscard]] bool rules_out_end(int k) const;
  /// Why arms that begin with `types` are ruled out, in words; empty: they are not. `whole`: and end with them.
  [[nodiscard]] std::string ruled_out(std::span<const int> types, bool whole) const;

 private:
  using Verdicts = std::vector<std::optional<CertainOverlap>>;  // by module of a tree
  // Where the frame R of an end is.
  struct Place {
    PoseEnclosure poses;
    int goal = -1;  // -1: the base
  };

  [[nodiscard]] std::optional<CertainOverlap> overlap(const RigidModule& module, const PoseEnclosure& poses,
                                                      int goal) const;
  void judge_heads(const Eigen::Isometry3d& X_WB);
  void judge_tails(const std::vector<std::optional<PoseEnclosure>>& goals);
  void judge(const std::vector<RigidModule>& tree, int at, const std::vector<Place>& places, bool tail,
             Verdicts& verdicts);
  void conclude();
  [[nodiscard]] std::string reason(const std::vector<RigidModule>& tree, const Verdicts& verdicts, int at,
                                   const std::vector<int>& inwards) const;
  [[nodiscard]] std::string name_of(int module) const;
  [[nodiscard]] std::string described(const CertainOverlap& overlap) const;
  [[nodiscard]] Infeasibility infeasibility(const CertainOverlap& overlap, std::string reason) const;

  const ModuleLibrary& library_;
  const RigidEnds& ends_;
  const Task& task_;
  const Scene& scene_;
  int n_last_ = 0;                                 // of `ends`, those that may end an arm at the goals
  bool needs_joint_ = false;                       // beyond those of the base
  Verdicts heads_;                                 // empty: none is ruled out
  Verdicts tails_;                                 // likewise
  std::vector<std::vector<CertainOverlap>> last_;  // [n_goals], of the modules that end an arm
  std::optional<Infeasibility> infeasible_;
};

}  // namespace modsearch::detail
