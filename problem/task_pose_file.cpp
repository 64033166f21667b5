#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <modsearch/problem/task_pose_internal.hpp>
#include <numbers>

namespace modsearch::detail {
namespace {

constexpr double kPi = std::numbers::pi;

/// R_TN of one tolerance frame: "nominal", a frame of the task, or a pose given in the world, of which only the
/// rotation matters.
Eigen::Matrix3d read_tolerance_frame(const JsonCursor& cursor, const Eigen::Isometry3d& X_WN,
                                     const TaskFrames& frames) {
  if (cursor.value() == Json("nominal")) return Eigen::Matrix3d::Identity();
  const Eigen::Isometry3d X_WT = cursor.value().is_array() ? cursor.pose() : frames.at(cursor);
  return X_WT.linear().transpose() * X_WN.linear();
}

/// What names the tolerances' frames; Timor 1.1.1 writes `frame` where all tolerances are of one kind.
std::optional<JsonCursor> find_tolerance_frames(const JsonCursor& pose) {
  const std::optional<JsonCursor> frame = pose.find("frame");
  if (frame && pose.has("toleranceFrame")) frame->fail("the frames of the tolerances are given twice (limit 1)");
  return frame ? frame : pose.find("toleranceFrame");
}

/// The frames of `n` tolerances: one for all, or a list beside them.
std::vector<Eigen::Matrix3d> read_tolerance_frames(const JsonCursor& pose, const Eigen::Isometry3d& X_WN,
                                                   const TaskFrames& known, std::size_t n) {
  const std::optional<JsonCursor> cursor = find_tolerance_frames(pose);
  if (!cursor) return std::vector<Eigen::Matrix3d>(n, Eigen::Matrix3d::Identity());
  const Json& value = cursor->value();
  const bool is_matrix =
      value.is_array() && !value.empty() && value[0].is_array() && !value[0].empty() && value[0][0].is_number();
  if (!value.is_array() || is_matrix) {
    return std::vector<Eigen::Matrix3d>(n, read_tolerance_frame(*cursor, X_WN, known));
  }
  std::vector<Eigen::Matrix3d> frames;
  if (value.size() != n) cursor->fail(fmt::format("has {} frames for {} projections", value.size(), n));
  for (const JsonCursor& entry : cursor->items()) frames.push_back(read_tolerance_frame(entry, X_WN, known));
  return frames;
}

constexpr std::array kProjections = {Projection::kX,    Projection::kY,      Projection::kZ,     Projection::kRSph,
                                     Projection::kRCyl, Projection::kPhiCyl, Projection::kTheta, Projection::kPhiSph,
                                     Projection::kNx,   Projection::kNy,     Projection::kNz,    Projection::kThetaR};

/// One tolerance with its place in the file.
struct GivenTolerance {
  Tolerance tolerance;
  JsonCursor projection;
  JsonCursor interval;
};

/// The listed tolerances, without those from -Infinity (for a radius from 0) to Infinity, which leave everything free.
std::vector<GivenTolerance> read_tolerances(const JsonCursor& pose, const Eigen::Isometry3d& X_WN,
                                            const TaskFrames& frames) {
  const std::vector<JsonCursor> projections = pose.at("toleranceProjection").items();
  const JsonCursor list = pose.at("tolerance");
  const std::vector<JsonCursor> intervals = list.items();
  if (intervals.size() != projections.size()) {
    list.fail(fmt::format("has {} intervals for {} projections", intervals.size(), projections.size()));
  }
  const std::vector<Eigen::Matrix3d> R_TN = read_tolerance_frames(pose, X_WN, frames, projections.size());
  std::vector<GivenTolerance> result;
  for (std::size_t i = 0; i < projections.size(); ++i) {
    const std::size_t which = projections[i].choice(
        {"x", "y", "z", "r_sph", "r_cyl", "phi_cyl", "theta", "phi_sph", "N_x", "N_y", "N_z", "Theta_R"});
    const std::vector<JsonCursor> ends = intervals[i].items(2);
    constexpr NumberLimits kAny{.allow_infinity = true};
    const Tolerance tolerance{kProjections[which], ends[0].number(kAny), ends[1].number(kAny), R_TN[i]};
    if (tolerance.lower > tolerance.upper) {
      ends[1].fail_value(fmt::format("at least {}, the lower end", tolerance.lower));
    }
    const bool radius = tolerance.projection == Projection::kRSph || tolerance.projection == Projection::kRCyl;
    const bool no_least = std::isinf(tolerance.lower) || (radius && tolerance.lower <= 0.0);
    if (no_least && std::isinf(tolerance.upper)) continue;
    if (!std::isfinite(tolerance.lower) || !std::isfinite(tolerance.upper)) {
      ends[std::isfinite(tolerance.lower) ? 1 : 0].fail_value("a finite end, as the other one is");
    }
    result.push_back({tolerance, projections[i], intervals[i]});
  }
  return result;
}

/// Tolerances are given, and not as empty lists, with which Timor 1.1.1 writes a pose that came without any.
bool has_tolerances(const JsonCursor& pose) {
  const auto some = [&](const char* key) { return pose.has(key) && pose.at(key).value() != Json::array(); };
  const bool given =
      some("toleranceProjection") || some("tolerance") || pose.has("toleranceProjection") != pose.has("tolerance");
  const std::optional<JsonCursor> frame = find_tolerance_frames(pose);
  if (frame && !given && frame->value() != Json::array()) {
    frame->fail("a frame of tolerances needs toleranceProjection and tolerance");
  }
  return given;
}

Eigen::Isometry3d read_nominal(const JsonCursor& pose, const TaskFrames& frames) {
  pose.expect_keys({"nominal", "nominalParent", "toleranceProjection", "tolerance", "toleranceFrame", "frame"});
  const Eigen::Isometry3d X_PN = pose.at("nominal").pose();
  const std::optional<JsonCursor> parent = pose.find("nominalParent");
  return parent ? frames.at(*parent) * X_PN : X_PN;
}

/// Whether [lower, upper] holds 0 and lies within `most` of it.
bool is_mounting(const BasePlacement::Interval& interval, double most) {
  return interval.lower <= 0.0 && interval.upper >= 0.0 && std::max(-interval.lower, interval.upper) <= most;
}

/// Collects what the tolerances of a base leave to choose.
class BaseReader {
 public:
  explicit BaseReader(const Eigen::Isometry3d& X_WN) { base_.X_WN = X_WN; }

  void add(const GivenTolerance& given) {
    const Tolerance& tolerance = given.tolerance;
    const BasePlacement::Interval interval{tolerance.lower, tolerance.upper};
    switch (tolerance.projection) {
      case Projection::kX:
        return slide(0, interval, given);
      case Projection::kY:
        return slide(1, interval, given);
      case Projection::kZ:
        return slide(2, interval, given);
      case Projection::kNz:
        return turn(interval, given);
      case Projection::kThetaR:
        require_zero(interval, given);
        return turn({-interval.upper, interval.upper}, given);
      case Projection::kNx:
      case Projection::kNy:
        return require_zero(interval, given);
      case Projection::kRCyl:
      case Projection::kRSph:
        if (is_mounting(interval, kMillimetre)) return;
        [[fallthrough]];
      case Projection::kPhiCyl:
      case Projection::kTheta:
      case Projection::kPhiSph:
        given.projection.fail_value(
            "one of \"x\", \"y\", \"z\", \"N_x\", \"N_y\", \"N_z\", \"Theta_R\" for a base: it may be placed in a box, "
            "not "
            "yet in a cylinder or a ball");
    }
  }

  [[nodiscard]] BasePlacement placement() const {
    BasePlacement result = base_;
    BasePlacement::Interval* const axes[] = {&result.x, &result.y, &result.z};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (slides_[axis] && !is_mounting(*slides_[axis], kMillimetre)) *axes[axis] = *slides_[axis];
    }
    if (is_mounting(result.yaw, kHalfDegree)) result.yaw = {};
    return result;
  }

 private:
  // CoBRA's default tolerance, with slack for ends that were written with fewer digits.
  static constexpr double kMillimetre = 0.001 + 1e-9;        // [m]
  static constexpr double kHalfDegree = kPi / 360.0 + 1e-6;  // [rad]

  void slide(std::size_t axis, const BasePlacement::Interval& interval, const GivenTolerance& given) {
    const bool has_frame = slides_[0] || slides_[1] || slides_[2];
    if (has_frame && given.tolerance.R_TN != base_.R_TN) {
      given.projection.fail("a base that is placed along axes of two frames is not supported yet");
    }
    base_.R_TN = given.tolerance.R_TN;
    slides_[axis] = slides_[axis] ? both(*slides_[axis], interval, given) : interval;
  }

  void turn(const BasePlacement::Interval& interval, const GivenTolerance& given) {
    base_.yaw = both(base_.yaw, interval, given);
  }

  /// All tolerances hold.
  static BasePlacement::Interval both(const BasePlacement::Interval& a, const BasePlacement::Interval& b,
                                      const GivenTolerance& given) {
    const BasePlacement::Interval result{std::max(a.lower, b.lower), std::min(a.upper, b.upper)};
    if (result.lower > result.upper) {
      given.interval.fail_value(fmt::format("an interval that meets [{}, {}], which holds too", a.lower, a.upper));
    }
    return result;
  }

  static void require_zero(const BasePlacement::Interval& interval, const GivenTolerance& given) {
    if (interval.lower > 0.0 || interval.upper < 0.0) given.interval.fail_value("an interval that holds 0");
  }

  BasePlacement base_{.yaw = {-kPi, kPi}};
  std::array<std::optional<BasePlacement::Interval>, 3> slides_{};  // x, y, z
};

}  // namespace

PoseRegion read_region(const JsonCursor& cursor, const TaskFrames& frames) {
  const Eigen::Isometry3d X_WN = read_nominal(cursor, frames);
  // Empty lists ask for nothing: Timor 1.1.1 takes any pose then.
  const bool asks_for_nothing = cursor.has("toleranceProjection") && cursor.has("tolerance");
  if (!has_tolerances(cursor) && !asks_for_nothing) return PoseRegion::with_default_tolerances(X_WN);
  std::vector<Tolerance> tolerances;
  for (const GivenTolerance& given : read_tolerances(cursor, X_WN, frames)) tolerances.push_back(given.tolerance);
  return cursor.guard([&] { return PoseRegion{X_WN, std::move(tolerances)}; });
}

BaseOfTask read_base(const JsonCursor& cursor, const TaskFrames& frames) {
  if (cursor.value().is_array()) return {cursor.pose()};
  BaseOfTask base{read_nominal(cursor, frames)};
  if (!has_tolerances(cursor)) return base;
  BaseReader reader{base.X_WB};
  for (const GivenTolerance& given : read_tolerances(cursor, base.X_WB, frames)) reader.add(given);
  const BasePlacement placement = reader.placement();
  if (!placement.fixed()) {
    base.placement = placement;
    return base;
  }
  const Eigen::Vector3d p_T{placement.x.lower, placement.y.lower, placement.z.lower};
  base.X_WB = base.X_WB * Eigen::Translation3d{placement.R_TN.transpose() * p_T} *
              Eigen::AngleAxisd{placement.yaw.lower, Eigen::Vector3d::UnitZ()};
  return base;
}

}  // namespace modsearch::detail
