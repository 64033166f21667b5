#pragma once

// The frames that a task names (CoBRA). Internal to the problem floor.

#include <map>
#include <modsearch/problem/json_internal.hpp>

namespace modsearch::detail {

/// Frames by their names: the world, those of the task's `frames`, and "goal.ID", the nominal pose of each goal that
/// was read so far, which later poses may refer to.
class TaskFrames {
 public:
  TaskFrames() = default;
  /// {name: {parent: name, transformation: 4x4} ..}, in any order. Refuses names that are taken, parents that do not
  /// exist and frames that hang on themselves.
  explicit TaskFrames(const JsonCursor& frames);

  /// Pose in the world of the frame that `name` names; refuses one that is none.
  [[nodiscard]] Eigen::Isometry3d at(const JsonCursor& name) const;
  void add_goal(const std::string& id, const Eigen::Isometry3d& X_WG) { X_WF_["goal." + id] = X_WG; }

 private:
  std::map<std::string, Eigen::Isometry3d> X_WF_{{"world", Eigen::Isometry3d::Identity()}};
};

}  // namespace modsearch::detail
