#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <modsearch/problem/attempt.hpp>
#include <modsearch/problem/design.hpp>

namespace modsearch {

/// The poses of all goals of a task for one type sequence, and nothing else: equations in (x, q_goal1, q_goal2, ..),
/// lengths and postures at once. No mass, no clearance: these are for whoever gets there. Many starts cost what one
/// start of the smooth program does.
///
/// A workspace: one thread at a time.
class PoseProgram {
 public:
  /// What came of a set of starts.
  struct Outcome {
    std::int64_t steps = 0;  ///< of all starts together: inner work
    /// Half the sum of squares at the best start that did not arrive [m^2]; +inf: all arrived.
    double least_cost = std::numeric_limits<double>::infinity();
    Eigen::VectorXd nearest{};  ///< where that was; empty: all arrived
  };
  /// Writes start number `i` into `v` (within the bounds, or it is moved there); another point each time that it is
  /// asked for the same start.
  using Start = std::function<void(int i, Eigen::Ref<Eigen::VectorXd> v)>;
  /// Start `i` has arrived at `v`: every goal's region contains the tip. False: no further start is worth it.
  using Arrival = std::function<bool(int i, const Eigen::VectorXd& v)>;

  virtual ~PoseProgram() = default;
  /// Bounds of the variables (x, q_goal1, ..), all finite.
  [[nodiscard]] virtual const Eigen::VectorXd& lower() const = 0;
  [[nodiscard]] virtual const Eigen::VectorXd& upper() const = 0;
  /// Whether any goal asks for more than a position.
  [[nodiscard]] virtual bool asks_for_orientation() const = 0;
  /// Whether such arms meet goals in general: a small change of any goal can be followed by a small change of the
  /// variables. False for sequences that meet them by luck alone: too few joints and lengths, or joints that repeat
  /// each other.
  [[nodiscard]] virtual bool generic() = 0;
  /// Works off starts 0 .. n_starts - 1.
  virtual Outcome solve(int n_starts, const Start& start, const Arrival& arrival) = 0;
  /// The design and the postures at `v`.
  [[nodiscard]] virtual Design design(const Eigen::VectorXd& v) const = 0;
  [[nodiscard]] virtual Witness witness(const Eigen::VectorXd& v) const = 0;
};

}  // namespace modsearch
