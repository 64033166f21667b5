#include <algorithm>
#include <cmath>
#include <modsearch/problem/pose_rows_internal.hpp>

namespace modsearch::detail {
namespace {

// Rotation vector of R (axis times angle), by way of the quaternion: accurate at all angles.
Eigen::Vector3d rotation_vector(const Eigen::Matrix3d& R) {
  Eigen::Quaterniond quaternion{R};
  if (quaternion.w() < 0.0) quaternion.coeffs() *= -1.0;
  const double sine = quaternion.vec().norm();
  if (sine < 1e-12) return 2.0 * quaternion.vec();
  return 2.0 * std::atan2(sine, quaternion.w()) / sine * quaternion.vec();
}

Eigen::Matrix3d skew(const Eigen::Vector3d& v) {
  return (Eigen::Matrix3d{} << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0).finished();
}

// The factor of S^2 in the inverse left Jacobian of SO(3), (1 - (t/2) cot(t/2)) / t^2 at angle t, and its slope in t
// divided by t. Near 0 both lose their digits: there the first terms of their series, good to 1e-13.
struct SquareFactor {
  double value;
  double slope;
};

SquareFactor square_factor(double angle) {
  const double square = angle * angle;
  if (angle < 0.1) {
    return {1.0 / 12.0 + square * (1.0 / 720.0 + square * (1.0 / 30240.0 + square / 1209600.0)),
            1.0 / 360.0 + square * (1.0 / 7560.0 + square * (1.0 / 201600.0 + square / 5987520.0))};
  }
  const double sine = std::sin(0.5 * angle), cotangent = std::cos(0.5 * angle) / sine;
  const double value = (1.0 - 0.5 * angle * cotangent) / square;
  return {value, (0.5 * (0.5 / (sine * sine) - cotangent / angle) - 2.0 * value) / square};
}

// d rotation_vector(exp(w) R) / d w at w = 0: the inverse left Jacobian of SO(3).
Eigen::Matrix3d inverse_left_jacobian(const Eigen::Vector3d& r) {
  const Eigen::Matrix3d S = skew(r);
  return Eigen::Matrix3d::Identity() - 0.5 * S + square_factor(r.norm()).value * S * S;
}

Eigen::Vector3d axis_of(const Move& move) { return move.turns ? move.direction : Eigen::Vector3d::Zero().eval(); }

}  // namespace

// Second derivatives of the rows in the motion of the tip, weighted with their multipliers. The tip's position p has
// slope y and curvature P; the rotation vector r has slope l and curvature G.
struct PoseRows::Curvature {
  Eigen::Vector3d y = Eigen::Vector3d::Zero();
  Eigen::Matrix3d P = Eigen::Matrix3d::Zero();
  Eigen::Vector3d l = Eigen::Vector3d::Zero();
  Eigen::Matrix3d G = Eigen::Matrix3d::Zero();
  bool polar = false;     // P counts
  bool rotation = false;  // l and G count
  Eigen::Vector3d r = Eigen::Vector3d::Zero();
};

int PoseRows::count(const Tolerance& tolerance) {
  if (tolerance.lower > 0.0) return 1;
  switch (tolerance.projection) {
    case Projection::kRSph:
    case Projection::kThetaR:
      return 3;
    case Projection::kRCyl:
      return 2;
    case Projection::kX:
    case Projection::kY:
    case Projection::kZ:
    case Projection::kPhiCyl:
    case Projection::kTheta:
    case Projection::kPhiSph:
    case Projection::kNx:
    case Projection::kNy:
    case Projection::kNz:
      return 1;
  }
  return 1;
}

void PoseRows::add(const Tolerance& tolerance, Eigen::Index first) {
  Rows rows{.first = first, .count = count(tolerance), .region = {X_WN_, {tolerance}}};
  const Eigen::Matrix3d R_TW = tolerance.R_TN * X_WN_.linear().transpose();
  const auto component = [&](Projection x) {
    rows.A.row(0) = R_TW.row(static_cast<int>(tolerance.projection) - static_cast<int>(x));
  };
  switch (tolerance.projection) {
    case Projection::kX:
    case Projection::kY:
    case Projection::kZ:
      component(Projection::kX);
      break;
    case Projection::kNx:
    case Projection::kNy:
    case Projection::kNz:
      rows.form = Form::kRotation;
      component(Projection::kNx);
      break;
    case Projection::kThetaR:
      rows.form = rows.count == 1 ? Form::kAngle : Form::kRotation;
      break;
    case Projection::kRCyl:
      rows.A = R_TW;
      if (rows.count == 1) rows.form = Form::kPolar;
      break;
    case Projection::kRSph:
      if (rows.count == 1) rows.form = Form::kPolar;
      break;
    case Projection::kPhiCyl:
    case Projection::kTheta:
    case Projection::kPhiSph:
      rows.form = Form::kPolar;
      break;
  }
  rows_.push_back(std::move(rows));
}

void PoseRows::evaluate(const Eigen::Isometry3d& X_WE, std::span<const Move> moves,
                        SmoothProgram::Values& values) const {
  const Eigen::Vector3d& p_WE = X_WE.translation();
  const Eigen::Vector3d offset = p_WE - X_WN_.translation();
  const auto rotates = [](const Rows& rows) { return rows.form == Form::kRotation || rows.form == Form::kAngle; };
  const bool any_rotates = std::any_of(rows_.begin(), rows_.end(), rotates);
  Eigen::Vector3d r = Eigen::Vector3d::Zero();
  Eigen::Matrix3d dr = Eigen::Matrix3d::Zero();
  if (any_rotates) {
    r = rotation_vector(X_WE.linear() * X_WN_.linear().transpose());
    dr = inverse_left_jacobian(r);
  }
  for (const Rows& rows : rows_) {
    // Slope of every row in p or r.
    Eigen::Matrix3d slope = rows.A;
    switch (rows.form) {
      case Form::kPosition:
      case Form::kRotation:
        for (int i = 0; i < rows.count; ++i) {
          values.rows[rows.first + i] = rows.A.row(i).dot(rows.form == Form::kPosition ? offset : r);
        }
        break;
      case Form::kAngle: {
        const double angle = r.norm();
        values.rows[rows.first] = angle;
        slope.row(0) = angle < 1e-12 ? Eigen::RowVector3d::UnitX().eval() : (r / angle).transpose().eval();
        break;
      }
      case Form::kPolar:
        values.rows[rows.first] = rows.region.values(X_WE)[0];
        slope.row(0) = rows.region.jacobian(X_WE).leftCols<3>();
        break;
    }
    if (rotates(rows)) slope = slope * dr;
    for (const Move& move : moves) {
      const Eigen::Vector3d rate = rotates(rows) ? axis_of(move) : move.velocity(p_WE);
      const Eigen::Index column = columns_.of(move.variable);
      for (int i = 0; i < rows.count; ++i) values.jacobian(rows.first + i, column) += slope.row(i).dot(rate);
    }
  }
}

PoseRows::Curvature PoseRows::curvature(const Eigen::Isometry3d& X_WE, const Eigen::VectorXd& multipliers) const {
  Curvature result;
  for (const Rows& rows : rows_) {
    const auto weights = multipliers.segment(rows.first, rows.count);
    switch (rows.form) {
      case Form::kPosition:
        for (int i = 0; i < rows.count; ++i) result.y += weights[i] * rows.A.row(i).transpose();
        break;
      case Form::kRotation:
      case Form::kAngle: {
        if (!result.rotation) result.r = rotation_vector(X_WE.linear() * X_WN_.linear().transpose());
        result.rotation = true;
        if (rows.form == Form::kRotation) {
          for (int i = 0; i < rows.count; ++i) result.l += weights[i] * rows.A.row(i).transpose();
        } else if (const double angle = result.r.norm(); angle > 1e-12) {
          const Eigen::Vector3d unit = result.r / angle;
          result.l += weights[0] * unit;
          result.G += weights[0] / angle * (Eigen::Matrix3d::Identity() - unit * unit.transpose());
        }
        break;
      }
      case Form::kPolar: {
        // Central differences of an exact gradient, good to about 1e-9.
        constexpr double kStep = 1e-5;
        result.polar = true;
        result.y += weights[0] * rows.region.jacobian(X_WE).leftCols<3>().transpose();
        for (int i = 0; i < 3; ++i) {
          Eigen::Isometry3d ahead = X_WE, behind = X_WE;
          ahead.translation()[i] += kStep;
          behind.translation()[i] -= kStep;
          result.P.col(i) += weights[0] / (2.0 * kStep) *
                             (rows.region.jacobian(ahead) - rows.region.jacobian(behind)).leftCols<3>().transpose();
        }
        break;
      }
    }
  }
  return result;
}

// For moves a and b, a no later than b, with velocities v of the tip and axes w (0 for a slide): the second derivative
// of y . p is y . (w_a x v_b) + v_a . P v_b. With dr = D w, D the inverse left Jacobian, that of l . r is
//
//   (D w_a) . (C + G D) w_b + (D^T l) . (w_a x w_b),   (D w_a) . C w_b = l . (dD/dr [D w_a]) w_b,
//
// and from D = I - S/2 + f S^2, S = [r]x, f a function of |r|: C = [l]x / 2 - f ([l]x [r]x + [l x r]x) + f'/|r| r (S^2
// l)^T.
void PoseRows::add_curvature(const Eigen::Isometry3d& X_WE, std::span<const Move> moves,
                             const Eigen::VectorXd& multipliers, Eigen::MatrixXd& H) const {
  const Curvature all = curvature(X_WE, multipliers);
  Eigen::Matrix3d D = Eigen::Matrix3d::Zero(), C = Eigen::Matrix3d::Zero();
  if (all.rotation) {
    const Eigen::Matrix3d S = skew(all.r);
    const SquareFactor f = square_factor(all.r.norm());
    D = Eigen::Matrix3d::Identity() - 0.5 * S + f.value * S * S;
    C = 0.5 * skew(all.l) - f.value * (skew(all.l) * S + skew(all.l.cross(all.r))) +
        f.slope * all.r * (S * S * all.l).transpose() + all.G * D;
  }
  const Eigen::Vector3d turned = D.transpose() * all.l;
  const Eigen::Vector3d& p_WE = X_WE.translation();
  for (std::size_t a = 0; a < moves.size(); ++a) {
    const Move& first = moves[a];
    Eigen::Vector3d of_velocity = Eigen::Vector3d::Zero(), of_axis = Eigen::Vector3d::Zero();
    if (first.turns) {
      of_velocity = all.y.cross(first.direction);
      if (all.rotation) of_axis = C.transpose() * (D * first.direction) + turned.cross(first.direction);
    }
    if (all.polar) of_velocity += all.P * first.velocity(p_WE);
    if (!first.turns && !all.polar) continue;
    const Eigen::Index row = columns_.of(first.variable);
    for (std::size_t b = a; b < moves.size(); ++b) {
      const Move& second = moves[b];
      double curvature = of_velocity.dot(second.velocity(p_WE));
      if (second.turns) curvature += of_axis.dot(second.direction);
      const Eigen::Index column = columns_.of(second.variable);
      H(row, column) += curvature;
      if (b > a) H(column, row) += curvature;
    }
  }
}

}  // namespace modsearch::detail
