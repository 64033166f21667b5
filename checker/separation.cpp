#include <algorithm>
#include <checker/separation.hpp>
#include <cmath>
#include <functional>

namespace modsearch_check {
namespace {

constexpr std::size_t kStarts = 8;

/// Largest n . x over the solid.
Interval support(const Solid& solid, const Vector& n) {
  const Vector local = transposed(solid.turn) * n;
  const Interval centre = dot(n, solid.centre);
  switch (solid.kind) {
    case Kind::kSphere:
      return centre + solid.size[0] * norm(n);
    case Kind::kBox:
      return centre +
             (solid.size[0] * abs(local[0]) + solid.size[1] * abs(local[1]) + solid.size[2] * abs(local[2])) * 0.5;
    case Kind::kCylinder:
      return centre + solid.size[0] * norm({local[0], local[1], 0.0}) + solid.size[1] * abs(local[2]) * 0.5;
    case Kind::kMesh:
      break;
  }
  throw Rejected("the incumbent cannot be checked among meshes");
}

/// Width of the gap between a and b in direction n, at least; negative where they overlap in it.
double gap(const Solid& a, const Solid& b, const Numbers& direction) {
  const Vector n = vector_of(direction);
  const Interval length = norm(n);
  if (!(length.lower() > 1e-6)) return -INFINITY;
  return ((-support(a, -n) - support(b, n)) / length).lower();
}

Numbers plus(const Numbers& a, double s, const Numbers& b) {
  return {a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]};
}
Numbers product(const Numbers& a, const Numbers& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
double inner(const Numbers& a, const Numbers& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Numbers unit(const Numbers& a) {
  const double length = std::sqrt(inner(a, a));
  return length > 1e-12 ? Numbers{a[0] / length, a[1] / length, a[2] / length} : Numbers{};
}

/// Directions that separate many pairs: between the centres, the axes of both, and across pairs of axes.
std::vector<Numbers> candidates(const Solid& a, const Solid& b) {
  std::vector<Numbers> result{plus(middle(a.centre), -1.0, middle(b.centre))};
  for (std::size_t i = 0; i < 3; ++i) {
    const Numbers e = middle(column(a.turn, i));
    const Numbers f = middle(column(b.turn, i));
    const Numbers between = result.front();
    result.push_back(e);
    result.push_back(f);
    result.push_back(plus(between, -inner(between, e), e));  // across one axis
    result.push_back(plus(between, -inner(between, f), f));
    for (std::size_t k = 0; k < 3; ++k) result.push_back(product(e, middle(column(b.turn, k))));
  }
  const std::size_t n = result.size();
  for (std::size_t i = 0; i < n; ++i) result.push_back({-result[i][0], -result[i][1], -result[i][2]});
  return result;
}

/// Turns a direction, ever more finely, as long as the gap in it widens; whether the solids are apart in the end.
bool gap_opens(const Solid& a, const Solid& b, Numbers best, double widest) {
  double step = 0.5;
  for (int round = 0; round < 1000 && step > 1e-13 && widest > -INFINITY; ++round) {
    const Numbers side = unit(product(best, std::abs(best[0]) < 0.6 ? Numbers{1.0, 0.0, 0.0} : Numbers{0.0, 1.0, 0.0}));
    const Numbers other = product(best, side);
    bool better = false;
    for (int k = 0; k < 8 && !better; ++k) {
      const double angle = k * 0.7853981633974483 + round;  // radians: other directions in every round
      const Numbers turned = unit(plus(plus(best, step * std::cos(angle), side), step * std::sin(angle), other));
      const double width = gap(a, b, turned);
      if (width >= -kSlack) return true;
      better = width > widest;
      if (better) {
        widest = width;
        best = turned;
      }
    }
    if (!better) step *= 0.7;
  }
  return false;
}

}  // namespace

bool are_apart(const Solid& a, const Solid& b, const std::vector<Numbers>& normals) {
  for (const Numbers& n : normals) {
    if (gap(a, b, n) >= -kSlack) return true;
  }
  std::vector<std::pair<double, Numbers>> starts;
  for (const Numbers& n : candidates(a, b)) {
    starts.emplace_back(gap(a, b, n), unit(n));
    if (starts.back().first >= -kSlack) return true;
  }
  std::sort(starts.begin(), starts.end(), std::greater<>{});
  starts.resize(kStarts);
  return std::any_of(starts.begin(), starts.end(),
                     [&](const auto& start) { return gap_opens(a, b, start.second, start.first); });
}

}  // namespace modsearch_check
