#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <modsearch/kinematics/arm.hpp>
#include <optional>
#include <stdexcept>

namespace modsearch {
namespace {

// The first size that is not a length: negative, infinite or not a number.
std::optional<double> impossible_size(const AffineShape& shape, const Eigen::VectorXd& x) {
  for (const AffineScalar& size : shape.size) {
    const double value = size.at(x);
    if (!(value >= 0.0 && std::isfinite(value))) return value;
  }
  return std::nullopt;
}

bool varies(const ParametricPose& X) { return !X.affine() || !X.head.translation.terms.empty(); }

bool varies(const BodyGeometry& geometry) {
  return varies(geometry.X_FG) || std::any_of(geometry.shape.size.begin(), geometry.shape.size.end(),
                                              [](const AffineScalar& size) { return !size.terms.empty(); });
}

// Both work on whole columns of the 4 x 4 matrices: four numbers make two vector instructions, three make none, and the
// last row comes out right by itself.

// Rotates the frame about its own z axis: only its first two columns change.
void turn_about_z(Eigen::Isometry3d& X, double angle) {
  const double c = std::cos(angle);
  const double s = std::sin(angle);
  const Eigen::Vector4d x_axis = X.matrix().col(0);
  const Eigen::Vector4d y_axis = X.matrix().col(1);
  X.matrix().col(0) = c * x_axis + s * y_axis;
  X.matrix().col(1) = c * y_axis - s * x_axis;
}

// X_AC = X_AB * X_BC; `rotates` false: the rotation of X_BC is the identity.
void compose(const Eigen::Isometry3d& X_AB, const Eigen::Isometry3d& X_BC, bool rotates, Eigen::Isometry3d& X_AC) {
  const Eigen::Matrix4d& A = X_AB.matrix();
  const Eigen::Matrix4d& B = X_BC.matrix();
  Eigen::Matrix4d& C = X_AC.matrix();
  if (rotates) {
    for (int k = 0; k < 3; ++k) C.col(k) = A.col(0) * B(0, k) + A.col(1) * B(1, k) + A.col(2) * B(2, k);
  } else {
    C.leftCols<3>() = A.leftCols<3>();
  }
  C.col(3) = A.col(0) * B(0, 3) + A.col(1) * B(1, 3) + A.col(2) * B(2, 3) + A.col(3);
}

}  // namespace

Arm::Arm(const Chain& chain, const Eigen::VectorXd& x) : chain_{&chain} {
  segments_.resize(static_cast<std::size_t>(chain.n_joints()) + 1, Eigen::Isometry3d::Identity());
  segment_rotates_.resize(segments_.size());
  for (int j = 0; j <= chain.n_joints(); ++j) segment_varies_.push_back(varies(chain.segment(j)));
  for (std::size_t b = 0; b < chain.bodies().size(); ++b) {
    for (std::size_t g = 0; g < chain.bodies()[b].geometries.size(); ++g) {
      geometries_.push_back({static_cast<int>(b), chain.bodies()[b].frame, {}, Eigen::Isometry3d::Identity(), 0.0});
      geometry_varies_.push_back(varies(chain.bodies()[b].geometries[g]));
    }
  }
  take(x);
  fill(true);
}

void Arm::set_parameters(const Eigen::VectorXd& x) {
  take(x);
  fill(false);
}

void Arm::take(const Eigen::VectorXd& x) {
  if (x.size() != chain_->n_parameters()) {
    throw std::invalid_argument(
        fmt::format("Arm: {} parameters given, the chain has {}", x.size(), chain_->n_parameters()));
  }
  if (!x.allFinite()) {
    const auto bad = std::find_if(x.begin(), x.end(), [](double value) { return !std::isfinite(value); });
    throw std::invalid_argument(fmt::format("Arm: parameter {} is {}", bad - x.begin(), *bad));
  }
  x_ = x;
}

void Arm::fill(bool all) {
  for (int j = 0; j <= n_joints(); ++j) {
    if (!all && segment_varies_[static_cast<std::size_t>(j)] == 0) continue;
    Eigen::Isometry3d& X = segments_[static_cast<std::size_t>(j)];
    X = chain_->segment(j).at(x_);
    segment_rotates_[static_cast<std::size_t>(j)] = X.linear() != Eigen::Matrix3d::Identity();
  }
  std::size_t index = 0;
  for (const Body& body : chain_->bodies()) {
    for (const BodyGeometry& geometry : body.geometries) {
      const std::size_t g = index++;
      if (!all && geometry_varies_[g] == 0) continue;
      ArmGeometry& filled = geometries_[g];
      filled.shape = geometry.shape.at(x_);
      if (const std::optional<double> size = impossible_size(geometry.shape, x_)) {
        throw std::invalid_argument(
            fmt::format("Arm: body '{}' has a size of {} m at the given parameters", body.name, *size));
      }
      filled.X_FG = geometry.X_FG.at(x_);
      filled.bounding_radius = bounding_radius(filled.shape);
    }
  }
}

Posture Arm::forward(const Eigen::VectorXd& q) const {
  if (q.size() != n_joints()) {
    throw std::invalid_argument(fmt::format("Arm: {} joint values given, the chain has {}", q.size(), n_joints()));
  }
  Posture posture;
  forward(q.data(), posture);
  return posture;
}

void Arm::forward(const double* q, Posture& posture) const {
  const auto n = static_cast<std::size_t>(n_joints());
  posture.frames.resize(n + 1, Eigen::Isometry3d::Identity());
  posture.frames[0].setIdentity();
  for (std::size_t j = 0; j < n; ++j) {
    Eigen::Isometry3d& X_WF = posture.frames[j + 1];
    compose(posture.frames[j], segments_[j], segment_rotates_[j], X_WF);
    if (chain_->joints()[j].rotates()) {
      turn_about_z(X_WF, q[j]);
    } else {
      X_WF.translation() += q[j] * X_WF.linear().col(2);
    }
  }
  compose(posture.frames[n], segments_[n], segment_rotates_[n], posture.tip);
}

Eigen::Matrix3Xd Arm::point_jacobian_q(const Posture& posture, int frame, const Eigen::Vector3d& p_W) const {
  Eigen::Matrix3Xd J = Eigen::Matrix3Xd::Zero(3, n_joints());
  for (int j = 0; j < frame; ++j) {
    const Eigen::Vector3d axis = posture.axis(j);
    J.col(j) =
        chain_->joints()[static_cast<std::size_t>(j)].rotates() ? axis.cross(p_W - posture.origin(j)).eval() : axis;
  }
  return J;
}

Eigen::Matrix3Xd Arm::point_jacobian_x(const Posture& posture, int frame, const Eigen::Vector3d& p_W) const {
  Eigen::Matrix3Xd J = Eigen::Matrix3Xd::Zero(3, chain_->n_parameters());
  for (int j = 0; j < frame; ++j) {
    const Eigen::Isometry3d& X_WF = posture.frames[static_cast<std::size_t>(j)];
    chain_->segment(j).for_each_move(
        x_, [&](const ParameterMove& move) { J.col(move.parameter) += move.velocity(X_WF, p_W); });
  }
  return J;
}

Eigen::Matrix<double, 6, Eigen::Dynamic> Arm::tip_jacobian_q(const Posture& posture) const {
  Eigen::Matrix<double, 6, Eigen::Dynamic> J(6, n_joints());
  J.topRows<3>() = point_jacobian_q(posture, n_joints(), posture.tip.translation());
  for (int j = 0; j < n_joints(); ++j) {
    const bool rotates = chain_->joints()[static_cast<std::size_t>(j)].rotates();
    J.bottomRows<3>().col(j) = rotates ? posture.axis(j) : Eigen::Vector3d::Zero().eval();
  }
  return J;
}

Eigen::Matrix<double, 6, Eigen::Dynamic> Arm::tip_jacobian_x(const Posture& posture) const {
  Eigen::Matrix<double, 6, Eigen::Dynamic> J(6, chain_->n_parameters());
  J.topRows<3>() = point_jacobian_x(posture, n_joints() + 1, posture.tip.translation());
  J.bottomRows<3>().setZero();
  for (int j = 0; j <= n_joints(); ++j) {
    const Eigen::Isometry3d& X_WF = posture.frames[static_cast<std::size_t>(j)];
    chain_->segment(j).for_each_move(x_, [&](const ParameterMove& move) {
      if (move.turns) J.bottomRows<3>().col(move.parameter) += X_WF.linear() * move.direction;
    });
  }
  return J;
}

Eigen::MatrixXd Arm::tip_hessian(const Posture& posture, const Eigen::Vector3d& y) const {
  return point_hessian(posture, n_joints(), chain_->segment(n_joints()), y);
}

Eigen::MatrixXd Arm::point_hessian(const Posture& posture, int frame, const ParametricPose& X_FP,
                                   const Eigen::Vector3d& y) const {
  const int n_x = chain_->n_parameters();
  const int n_q = n_joints();
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(n_x + n_q, n_x + n_q);
  const Eigen::Vector3d p_WP = posture.frames[static_cast<std::size_t>(frame)] * X_FP.at(x_).translation();
  const Eigen::Matrix3Xd J_q = point_jacobian_q(posture, frame, p_WP);
  // Only what lies beyond a turn turns with it; walk from the point inwards and add up the parameters' parts.
  Eigen::Matrix3Xd J_x_beyond = Eigen::Matrix3Xd::Zero(3, n_x);
  std::vector<ParameterMove> moves;
  const auto pass = [&](const ParametricPose& X, int j) {
    const Eigen::Isometry3d& X_WF = posture.frames[static_cast<std::size_t>(j)];
    moves.clear();
    X.for_each_move(x_, [&](const ParameterMove& move) { moves.push_back(move); });
    for (auto move = moves.rbegin(); move != moves.rend(); ++move) {
      const Eigen::Vector3d velocity = move->velocity(X_WF, p_WP);
      if (move->turns) {
        const Eigen::Vector3d w = y.cross(X_WF.linear() * move->direction);
        for (int k = j; k < frame; ++k) {
          H(move->parameter, n_x + k) += w.dot(J_q.col(k));
          H(n_x + k, move->parameter) = H(move->parameter, n_x + k);
        }
        const Eigen::VectorXd mixed = J_x_beyond.transpose() * w;
        H.row(move->parameter).head(n_x) += mixed;
        H.col(move->parameter).head(n_x) += mixed;
        H(move->parameter, move->parameter) += w.dot(velocity);
      }
      J_x_beyond.col(move->parameter) += velocity;
    }
  };
  pass(X_FP, frame);
  for (int i = frame - 1; i >= 0; --i) {
    if (chain_->joints()[static_cast<std::size_t>(i)].rotates()) {
      // y . (axis x v) = (y x axis) . v
      const Eigen::Vector3d w = y.cross(posture.axis(i));
      for (int j = i; j < frame; ++j) H(n_x + i, n_x + j) = H(n_x + j, n_x + i) = w.dot(J_q.col(j));
      const Eigen::VectorXd mixed = J_x_beyond.transpose() * w;
      H.row(n_x + i).head(n_x) += mixed;
      H.col(n_x + i).head(n_x) += mixed;
    }
    pass(chain_->segment(i), i);
  }
  return H;
}

double Arm::reach() const {
  double span = 0.0;
  for (int j = 1; j <= n_joints(); ++j) span += segments_[static_cast<std::size_t>(j)].translation().norm();
  for (const Joint& joint : chain_->joints()) {
    if (!joint.rotates()) span += std::max(std::abs(joint.lower), std::abs(joint.upper));
  }
  return n_joints() == 0 ? segments_[0].translation().norm() : span;
}

}  // namespace modsearch
