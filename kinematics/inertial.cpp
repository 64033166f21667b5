#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <modsearch/kinematics/inertial.hpp>
#include <numbers>
#include <vector>

namespace modsearch {
namespace {

/// Second moments of a body about the origin of its frame, by which solids simply add up: mass, first moment and
/// integral of p p^T.
struct Moments {
  double mass = 0.0;
  Eigen::Vector3d first = Eigen::Vector3d::Zero();
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
};

/// Inertia from the integral of p p^T about the same point, and back.
Eigen::Matrix3d inertia_of(const Eigen::Matrix3d& second) {
  return second.trace() * Eigen::Matrix3d::Identity() - second;
}
Eigen::Matrix3d second_of(const Eigen::Matrix3d& inertia) {
  return 0.5 * inertia.trace() * Eigen::Matrix3d::Identity() - inertia;
}

Moments moments(const Inertial& body) {
  return {body.mass, body.mass * body.p_FC, second_of(body.inertia) + body.mass * body.p_FC * body.p_FC.transpose()};
}

Inertial about_centre(const Moments& m) {
  Inertial body{m.mass};
  if (m.mass > 0.0) body.p_FC = m.first / m.mass;
  body.inertia = inertia_of(m.second - m.mass * body.p_FC * body.p_FC.transpose());
  return body;
}

Moments moved(const Moments& m, const Eigen::Isometry3d& X) {
  const Eigen::Matrix3d& R = X.linear();
  const Eigen::Vector3d& p = X.translation();
  const Eigen::Vector3d first = R * m.first;
  return {m.mass, first + m.mass * p,
          R * m.second * R.transpose() + first * p.transpose() + p * first.transpose() + m.mass * p * p.transpose()};
}

// Solids of density 1 about their own origins.

Moments diagonal(double volume, const Eigen::Vector3d& second) {
  return {volume, Eigen::Vector3d::Zero(), (volume * second).asDiagonal()};
}

Moments of(const Sphere& sphere) {
  const double r = sphere.radius;
  return diagonal(4.0 / 3.0 * std::numbers::pi * r * r * r, Eigen::Vector3d::Constant(r * r / 5.0));
}

Moments of(const Box& box) { return diagonal(box.size.prod(), box.size.cwiseAbs2() / 12.0); }

Moments of(const Cylinder& cylinder) {
  const double r = cylinder.radius;
  const double h = cylinder.length;
  return diagonal(std::numbers::pi * r * r * h, {r * r / 4.0, r * r / 4.0, h * h / 12.0});
}

Moments of(const Capsule& capsule) {
  const double r = capsule.radius;
  const double h = capsule.length;
  Moments result = of(Cylinder{r, h});
  // The two halves of a ball, each with its flat side on an end: centroid 3/8 r beyond it.
  const Moments ball = of(Sphere{r});
  result.mass += ball.mass;
  result.second += ball.second;
  result.second(2, 2) += ball.mass * (0.25 * h * h + 0.375 * r * h);
  return result;
}

/// What a closed mesh encloses: signed tetrahedra between the origin and each triangle. Empty for an open one, whose
/// area vectors do not add up to nothing.
std::optional<Moments> enclosed_by(const TriangleMesh& mesh) {
  Moments result;
  Eigen::Vector3d open = Eigen::Vector3d::Zero();
  double area = 0.0;
  for (const Eigen::Vector3i& triangle : mesh.triangles) {
    Eigen::Matrix3d corners;
    for (int k = 0; k < 3; ++k) corners.col(k) = mesh.vertices[static_cast<std::size_t>(triangle[k])];
    const Eigen::Vector3d twice_area = (corners.col(1) - corners.col(0)).cross(corners.col(2) - corners.col(0));
    open += twice_area;
    area += twice_area.norm();
    const double volume = corners.determinant() / 6.0;
    const Eigen::Vector3d sum = corners.rowwise().sum();
    result.mass += volume;
    result.first += volume / 4.0 * sum;
    result.second += volume / 20.0 * (corners * corners.transpose() + sum * sum.transpose());
  }
  constexpr double kClosed = 1e-6;  // of the area: files round their vertices
  if (open.norm() > kClosed * area) return std::nullopt;
  if (result.mass < 0.0) return Moments{-result.mass, -result.first, -result.second};  // its triangles face inwards
  return result;
}

Moments bounding_box(const TriangleMesh& mesh) {
  Eigen::Vector3d lower = mesh.vertices.front();
  Eigen::Vector3d upper = lower;
  for (const Eigen::Vector3d& vertex : mesh.vertices) {
    lower = lower.cwiseMin(vertex);
    upper = upper.cwiseMax(vertex);
  }
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.translation() = 0.5 * (lower + upper);
  return moved(of(Box{upper - lower}), X);
}

Moments of(const Mesh& mesh) {
  const std::optional<Moments> inside = enclosed_by(*mesh.triangles);
  return inside && physical(about_centre(*inside)) ? *inside : bounding_box(*mesh.triangles);
}

std::vector<PlacedShape> shapes_of(const Body& body, const Eigen::VectorXd& x) {
  std::vector<PlacedShape> shapes;
  for (const BodyGeometry& geometry : body.geometries) shapes.push_back({geometry.shape.at(x), geometry.X_FG.at(x)});
  return shapes;
}

/// Inertia of `body` about `p_FC` instead of its own centre of mass.
Eigen::Matrix3d inertia_about(const Inertial& body, const Eigen::Vector3d& p_FC) {
  const Eigen::Vector3d d = body.p_FC - p_FC;
  return body.inertia + inertia_of(body.mass * d * d.transpose());
}

}  // namespace

Inertial operator+(const Inertial& a, const Inertial& b) {
  const Moments ma = moments(a);
  const Moments mb = moments(b);
  return about_centre({ma.mass + mb.mass, ma.first + mb.first, ma.second + mb.second});
}

Inertial operator*(const Eigen::Isometry3d& X_AF, const Inertial& body) {
  return {body.mass, X_AF * body.p_FC, X_AF.linear() * body.inertia * X_AF.linear().transpose()};
}

bool physical(const Inertial& body, double slack) {
  if (!(body.mass > 0.0) || !body.inertia.allFinite()) return false;
  const Eigen::Matrix3d& J = body.inertia;
  if ((J - J.transpose()).cwiseAbs().maxCoeff() > slack * J.cwiseAbs().maxCoeff()) return false;
  const Eigen::Vector3d moments =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>{J, Eigen::EigenvaluesOnly}.eigenvalues();
  return moments[0] > 0.0 && moments[2] <= (moments[0] + moments[1]) * (1.0 + slack);
}

std::optional<Inertial> evenly_spread(double mass, std::span<const PlacedShape> shapes) {
  Moments total;
  for (const PlacedShape& placed : shapes) {
    const Moments one = moved(std::visit([](const auto& shape) { return of(shape); }, placed.shape), placed.X_FG);
    total = {total.mass + one.mass, total.first + one.first, total.second + one.second};
  }
  if (!(total.mass > 0.0)) return std::nullopt;
  const double density = mass / total.mass;
  return about_centre({mass, density * total.first, density * total.second});
}

Inertial inertial(const Body& body, const Eigen::VectorXd& x) {
  const Eigen::Isometry3d X_FB = body.spread.X_FB.at(x);
  Inertial result{body.mass.at(x), X_FB * body.spread.r_com.at(x)};
  if (!body.spread.evenly) {
    result.inertia = X_FB.linear() * body.spread.inertia * X_FB.linear().transpose();
  } else if (const std::optional<Inertial> even = evenly_spread(result.mass, shapes_of(body, x))) {
    result.inertia = inertia_about(*even, result.p_FC);
  }
  return result;
}

Inertial physical_inertial(const Body& body, const Eigen::VectorXd& x) {
  Inertial result = inertial(body, x);
  if (!(result.mass > 0.0) || physical(result)) return result;
  if (const std::optional<Inertial> even = evenly_spread(result.mass, shapes_of(body, x))) {
    result.inertia = inertia_about(*even, result.p_FC);
    if (physical(result)) return result;
  }
  constexpr double kSteel = 7850.0;  // [kg/m^3]: the densest usual material makes the smallest ball
  const double radius = std::cbrt(result.mass / (kSteel * 4.0 / 3.0 * std::numbers::pi));
  result.inertia = 0.4 * result.mass * radius * radius * Eigen::Matrix3d::Identity();
  return result;
}

}  // namespace modsearch
