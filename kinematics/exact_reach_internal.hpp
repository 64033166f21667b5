#pragma once

// Internal: least distance of the tip of a chain of at most three joints from a point, and every posture that attains
// it. The method and its limits: docs/inverse_kinematics.md.

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cstdint>
#include <modsearch/kinematics/arm.hpp>
#include <vector>

namespace modsearch::internal {

constexpr int kMaxReachJoints = 3;
/// Joint values; the entries from `n` on are 0.
using ReachJoints = Eigen::Vector3d;

/// A joint, and the fixed transform from the frame that moves with it to the next joint's frame (or the tip).
struct ReachLink {
  bool rotates = true;
  /// Any angle is allowed up to whole turns: [lower, upper] is one turn then, and its ends are the same posture.
  bool full_circle = false;
  double lower = 0.0;  ///< [rad] or [m], finite
  double upper = 0.0;
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  Eigen::Vector3d p = Eigen::Vector3d::Zero();  ///< [m]
};

/// A chain of at most three joints and the point its tip should come close to.
struct ReachProblem {
  int n = 0;
  std::array<ReachLink, kMaxReachJoints> links;
  /// In the frame of joint 0 before it moves; without joints in the tip's own frame [m].
  Eigen::Vector3d target = Eigen::Vector3d::Zero();
};

/// A posture with the tip's distance from the target [m].
struct Nearest {
  ReachJoints q;
  double distance;
};

/// A short list without heap: the search for one posture is the hot loop of the whole toolkit.
class NearestList {
 public:
  static constexpr int kCapacity = 48;
  /// Adds, or drops what does not fit any more.
  void add(const Nearest& item) {
    if (size_ < kCapacity) items_[static_cast<std::size_t>(size_++)] = item;
  }
  void add_first(const Nearest& item) {
    add(item);
    std::rotate(begin(), end() - 1, end());
  }
  void resize(int size) { size_ = size; }
  [[nodiscard]] int size() const { return size_; }
  [[nodiscard]] Nearest* begin() { return items_.data(); }
  [[nodiscard]] Nearest* end() { return items_.data() + size_; }
  [[nodiscard]] const Nearest* begin() const { return items_.data(); }
  [[nodiscard]] const Nearest* end() const { return items_.data() + size_; }
  Nearest& operator[](int i) { return items_[static_cast<std::size_t>(i)]; }
  const Nearest& operator[](int i) const { return items_[static_cast<std::size_t>(i)]; }

 private:
  std::array<Nearest, kCapacity> items_;
  int size_ = 0;
};

/// Inner work, for the meter.
struct ReachWork {
  std::int64_t iterations = 0;
  std::int64_t forward = 0;
};

/// Throws std::invalid_argument if the arm has more than three joints. `target` in the world [m].
[[nodiscard]] ReachProblem reach_problem(const Arm& arm, const Eigen::Vector3d& target);

/// The same problem with joint `k` fixed at `value`, one joint fewer.
[[nodiscard]] ReachProblem with_joint_fixed(const ReachProblem& problem, int k, double value);

/// A posture of the problem above with joint `k` put back at `value`.
[[nodiscard]] ReachJoints with_joint_inserted(const ReachJoints& q, int k, double value);

/// One posture of least distance.
[[nodiscard]] Nearest nearest(const ReachProblem& problem, ReachWork& work);

/// Which postures count, and how densely families of them are sampled; see IkOptions.
struct FamilyOptions {
  double tie = 0.0;  ///< [m]
  int points = 1;
  bool shared_turns = true;
};

/// Every posture within `tie` of the least distance: isolated ones, and families at about `points` points.
[[nodiscard]] std::vector<Nearest> all_nearest(const ReachProblem& problem, const FamilyOptions& options,
                                               ReachWork& work);

}  // namespace modsearch::internal
