#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <modsearch/kinematics/pose_region.hpp>
#include <numbers>
#include <stdexcept>

namespace modsearch {
namespace {

constexpr double kPi = std::numbers::pi;
// Below this length a direction is noise: gradients that would divide by it are cut off.
constexpr double kTiny = 1e-12;

// Rotation vector of R: axis times angle, the angle in [0, pi]. At exactly pi either axis is right; one is given.
Eigen::Vector3d rotation_vector(const Eigen::Matrix3d& R) {
  Eigen::Quaterniond q{R};
  if (q.w() < 0.0) q.coeffs() = -q.coeffs();
  const double sine = q.vec().norm();  // of half the angle
  if (sine < kTiny) return 2.0 * q.vec();
  return (2.0 * std::atan2(sine, q.w()) / sine) * q.vec();
}

Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d result;
  result << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return result;
}

// d(rotation vector) / d(angular velocity, left): I - [r]/2 + (1 - (a/2) cot(a/2)) / a^2 [r]^2 with a = |r|
// (Barfoot, State Estimation for Robotics, 2017, section 7.1.5). Finite in all of [0, pi]: cot(pi/2) = 0.
Eigen::Matrix3d inverse_left_jacobian(const Eigen::Vector3d& r) {
  const double angle = r.norm();
  constexpr double kSeries = 1e-3;  // from here on the next term of the series, a^4 / 30240, is below rounding
  const double half = 0.5 * angle;
  const double factor = angle < kSeries ? 1.0 / 12.0 + angle * angle / 720.0
                                        : (1.0 - half * std::cos(half) / std::sin(half)) / (angle * angle);
  const Eigen::Matrix3d K = cross_matrix(r);
  return Eigen::Matrix3d::Identity() - 0.5 * K + factor * K * K;
}

// v / |v|, or x where v has no direction.
Eigen::Vector3d direction(const Eigen::Vector3d& v) {
  const double length = v.norm();
  return length < kTiny ? Eigen::Vector3d::UnitX().eval() : (v / length).eval();
}

bool turns(Projection projection) { return projection == Projection::kPhiCyl || projection == Projection::kPhiSph; }

bool is_angular(Projection projection) {
  switch (projection) {
    case Projection::kNx:
    case Projection::kNy:
    case Projection::kNz:
    case Projection::kThetaR:
      return true;
    case Projection::kX:
    case Projection::kY:
    case Projection::kZ:
    case Projection::kRCyl:
    case Projection::kPhiCyl:
    case Projection::kRSph:
    case Projection::kTheta:
    case Projection::kPhiSph:
      return false;
  }
  return false;
}

// The deviation D = nominal^-1 * actual as two vectors in the nominal frame.
struct Deviation {
  Eigen::Vector3d p_N;  // [m]
  Eigen::Vector3d r_N;  // rotation vector [rad]
};

Deviation deviation(const Eigen::Isometry3d& X_WN, const Eigen::Isometry3d& X_WE, bool with_rotation) {
  const Eigen::Matrix3d R_NW = X_WN.linear().transpose();
  return {R_NW * (X_WE.translation() - X_WN.translation()),
          with_rotation ? rotation_vector(R_NW * X_WE.linear()) : Eigen::Vector3d::Zero().eval()};
}

double value_of(const Tolerance& tolerance, const Deviation& D) {
  const Eigen::Vector3d p = tolerance.R_TN * D.p_N;
  const Eigen::Vector3d r = tolerance.R_TN * D.r_N;
  switch (tolerance.projection) {
    case Projection::kX:
      return p.x();
    case Projection::kY:
      return p.y();
    case Projection::kZ:
      return p.z();
    case Projection::kRCyl:
      return std::hypot(p.x(), p.y());
    case Projection::kPhiCyl:
    case Projection::kPhiSph:
      return std::atan2(p.y(), p.x());
    case Projection::kRSph:
      return p.norm();
    case Projection::kTheta:
      return std::atan2(std::hypot(p.x(), p.y()), p.z());
    case Projection::kNx:
      return r.x();
    case Projection::kNy:
      return r.y();
    case Projection::kNz:
      return r.z();
    case Projection::kThetaR:
      return r.norm();
  }
  return 0.0;
}

// d value / d p_T for the projections of the translation.
Eigen::Vector3d translation_gradient(Projection projection, const Eigen::Vector3d& p) {
  const double rho = std::hypot(p.x(), p.y());
  switch (projection) {
    case Projection::kX:
      return Eigen::Vector3d::UnitX();
    case Projection::kY:
      return Eigen::Vector3d::UnitY();
    case Projection::kZ:
      return Eigen::Vector3d::UnitZ();
    case Projection::kRCyl:
      return direction({p.x(), p.y(), 0.0});
    case Projection::kPhiCyl:
    case Projection::kPhiSph:
      if (rho < kTiny) return Eigen::Vector3d::Zero();
      return Eigen::Vector3d{-p.y(), p.x(), 0.0} / (rho * rho);
    case Projection::kRSph:
      return direction(p);
    case Projection::kTheta: {
      const double r = p.norm();
      if (r < kTiny) return Eigen::Vector3d::Zero();
      const Eigen::Vector3d outward = direction({p.x(), p.y(), 0.0});
      return (outward * (p.z() / r) - Eigen::Vector3d::UnitZ() * (rho / r)) / r;
    }
    case Projection::kNx:
    case Projection::kNy:
    case Projection::kNz:
    case Projection::kThetaR:
      break;
  }
  return Eigen::Vector3d::Zero();
}

// d value / d r_T for the projections of the rotation vector.
Eigen::Vector3d rotation_gradient(Projection projection, const Eigen::Vector3d& r) {
  if (projection == Projection::kNx) return Eigen::Vector3d::UnitX();
  if (projection == Projection::kNy) return Eigen::Vector3d::UnitY();
  if (projection == Projection::kNz) return Eigen::Vector3d::UnitZ();
  return direction(r);
}

// How far `value` is outside the interval, signed. An azimuth is a point on a circle: the shorter way round counts.
double outside(const Tolerance& tolerance, double value) {
  const double lower = tolerance.lower;
  const double upper = tolerance.upper;
  if (turns(tolerance.projection) && std::isfinite(lower) && std::isfinite(upper)) {
    value -= 2.0 * kPi * std::round((value - 0.5 * (lower + upper)) / (2.0 * kPi));
  }
  if (value < lower) return value - lower;
  return value <= upper ? 0.0 : value - upper;  // NaN stays NaN
}

}  // namespace

std::string_view name(Projection projection) {
  switch (projection) {
    case Projection::kX:
      return "x";
    case Projection::kY:
      return "y";
    case Projection::kZ:
      return "z";
    case Projection::kRCyl:
      return "r_cyl";
    case Projection::kPhiCyl:
      return "phi_cyl";
    case Projection::kRSph:
      return "r_sph";
    case Projection::kTheta:
      return "theta";
    case Projection::kPhiSph:
      return "phi_sph";
    case Projection::kNx:
      return "N_x";
    case Projection::kNy:
      return "N_y";
    case Projection::kNz:
      return "N_z";
    case Projection::kThetaR:
      return "Theta_R";
  }
  return "";
}

PoseRegion::PoseRegion(const Eigen::Isometry3d& X_WN, std::vector<Tolerance> tolerances)
    : X_WN_{X_WN}, tolerances_{std::move(tolerances)} {
  if (!X_WN.matrix().allFinite()) throw std::invalid_argument("PoseRegion: the nominal pose is not finite");
  for (const Tolerance& tolerance : tolerances_) {
    if (!(tolerance.lower <= tolerance.upper)) {
      throw std::invalid_argument(fmt::format("PoseRegion: tolerance of {}: [{}, {}] is not an interval",
                                              name(tolerance.projection), tolerance.lower, tolerance.upper));
    }
    if (!tolerance.R_TN.allFinite()) {
      throw std::invalid_argument(
          fmt::format("PoseRegion: tolerance of {}: its frame is not finite", name(tolerance.projection)));
    }
  }
}

PoseRegion PoseRegion::ball(const Eigen::Vector3d& p_W, double radius) {
  Eigen::Isometry3d X_WN = Eigen::Isometry3d::Identity();
  X_WN.translation() = p_W;
  return {X_WN, {{.projection = Projection::kRSph, .lower = 0.0, .upper = radius}}};
}

PoseRegion PoseRegion::with_default_tolerances(const Eigen::Isometry3d& X_WN) {
  constexpr double kMillimetre = 1e-3;
  constexpr double kHalfDegree = 0.5 * kPi / 180.0;
  return {X_WN,
          {{.projection = Projection::kX, .lower = -kMillimetre, .upper = kMillimetre},
           {.projection = Projection::kY, .lower = -kMillimetre, .upper = kMillimetre},
           {.projection = Projection::kZ, .lower = -kMillimetre, .upper = kMillimetre},
           {.projection = Projection::kThetaR, .lower = 0.0, .upper = kHalfDegree}}};
}

bool PoseRegion::is_ball() const {
  return tolerances_.size() == 1 && tolerances_[0].projection == Projection::kRSph && tolerances_[0].lower <= 0.0 &&
         tolerances_[0].upper >= 0.0;
}

bool PoseRegion::constrains_orientation() const {
  return std::any_of(tolerances_.begin(), tolerances_.end(),
                     [](const Tolerance& tolerance) { return is_angular(tolerance.projection); });
}

bool PoseRegion::contains(const Eigen::Isometry3d& X_WE) const {
  const Deviation D = deviation(X_WN_, X_WE, constrains_orientation());
  return std::all_of(tolerances_.begin(), tolerances_.end(), [&](const Tolerance& tolerance) {
    return std::abs(outside(tolerance, value_of(tolerance, D))) <= kSlack;  // false for NaN
  });
}

Eigen::VectorXd PoseRegion::values(const Eigen::Isometry3d& X_WE) const {
  const Deviation D = deviation(X_WN_, X_WE, constrains_orientation());
  Eigen::VectorXd result(static_cast<Eigen::Index>(tolerances_.size()));
  for (std::size_t i = 0; i < tolerances_.size(); ++i) {
    result[static_cast<Eigen::Index>(i)] = value_of(tolerances_[i], D);
  }
  return result;
}

Eigen::Matrix<double, Eigen::Dynamic, 6> PoseRegion::jacobian(const Eigen::Isometry3d& X_WE) const {
  const bool with_rotation = constrains_orientation();
  const Deviation D = deviation(X_WN_, X_WE, with_rotation);
  const Eigen::Matrix3d R_NW = X_WN_.linear().transpose();
  // E turns with the world angular velocity w: R_D' = [R_NW w] R_D, a perturbation from the left.
  const Eigen::Matrix3d turn = with_rotation ? (inverse_left_jacobian(D.r_N) * R_NW).eval() : R_NW;

  Eigen::Matrix<double, Eigen::Dynamic, 6> J(static_cast<Eigen::Index>(tolerances_.size()), 6);
  for (std::size_t i = 0; i < tolerances_.size(); ++i) {
    const Tolerance& tolerance = tolerances_[i];
    auto row = J.row(static_cast<Eigen::Index>(i));
    row.setZero();
    if (is_angular(tolerance.projection)) {
      const Eigen::Vector3d gradient = rotation_gradient(tolerance.projection, tolerance.R_TN * D.r_N);
      row.tail<3>() = gradient.transpose() * tolerance.R_TN * turn;
    } else {
      const Eigen::Vector3d gradient = translation_gradient(tolerance.projection, tolerance.R_TN * D.p_N);
      row.head<3>() = gradient.transpose() * tolerance.R_TN * R_NW;
    }
  }
  return J;
}

Eigen::VectorXd PoseRegion::violations(const Eigen::Isometry3d& X_WE) const {
  Eigen::VectorXd result = values(X_WE);
  for (std::size_t i = 0; i < tolerances_.size(); ++i) {
    double& value = result[static_cast<Eigen::Index>(i)];
    value = outside(tolerances_[i], value);
  }
  return result;
}

}  // namespace modsearch
