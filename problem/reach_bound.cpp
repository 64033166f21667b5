#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <modsearch/problem/reach_bound.hpp>

namespace modsearch {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
// Lengths are sums of a few dozen rounded numbers of the order of metres.
constexpr double kRounding = 1e-9;

struct Place {
  int body = 0;
  const Connector* connector = nullptr;
};

// The rigid pieces between the two connectors of a module, in order: each a translation affine in the parameters.
std::vector<AffineVector> rigid_pieces(const ModuleType& module) {
  std::vector<Place> places;
  for (std::size_t b = 0; b < module.bodies.size(); ++b) {
    for (const Connector& connector : module.bodies[b].connectors) {
      places.push_back({static_cast<int>(b), &connector});
    }
  }
  const Place entry = places.front();
  const Place exit = places.back();

  // Depth-first from the entry's body to the exit's; modules are trees of a few bodies.
  std::vector<int> joints;
  std::vector<bool> seen(module.bodies.size(), false);
  const auto search = [&](const auto& self, int body) -> bool {
    if (body == exit.body) return true;
    seen[static_cast<std::size_t>(body)] = true;
    for (std::size_t j = 0; j < module.joints.size(); ++j) {
      const ModuleJoint& joint = module.joints[j];
      if (joint.parent != body && joint.child != body) continue;
      const int other = joint.parent == body ? joint.child : joint.parent;
      if (seen[static_cast<std::size_t>(other)]) continue;
      joints.push_back(static_cast<int>(j));
      if (self(self, other)) return true;
      joints.pop_back();
    }
    return false;
  };
  search(search, entry.body);

  std::vector<AffineVector> pieces;
  AffinePose X = entry.connector->X_BC.inverse();
  int body = entry.body;
  for (const int j : joints) {
    const ModuleJoint& joint = module.joints[static_cast<std::size_t>(j)];
    const bool forward = joint.parent == body;
    X = X * (forward ? joint.X_PJ : joint.X_JC.inverse());
    const bool turned = !joint.angle.terms.empty() || joint.angle.offset != 0.0;
    if (!joint.fixed || turned) {  // what comes next may point anywhere
      pieces.push_back(X.translation);
      X = AffinePose{};
      if (!joint.fixed && !joint.joint.rotates()) {
        const double travel = std::max(std::abs(joint.joint.lower), std::abs(joint.joint.upper));
        pieces.push_back(AffineVector{Eigen::Vector3d{0.0, 0.0, travel}});
      }
    }
    X = X * (forward ? joint.X_JC : joint.X_PJ.inverse());
    body = forward ? joint.child : joint.parent;
  }
  pieces.push_back((X * exit.connector->X_BC).translation);
  return pieces;
}

}  // namespace

double ModuleSpan::greatest_length() const {
  double total = length;
  for (const Stretch& stretch : stretches) total += stretch.length_rate * stretch.range;
  return total;
}

double ModuleSpan::best_rate() const {
  double best = 0.0;
  for (const Stretch& stretch : stretches) {
    if (stretch.mass_rate > 0.0) best = std::max(best, stretch.length_rate / stretch.mass_rate);
  }
  return best;
}

ModuleSpan module_span(const ModuleType& module) {
  const int n = module.n_parameters();
  ModuleSpan span;
  span.cost = module.cost;
  span.stretches.resize(static_cast<std::size_t>(n));
  for (int i = 0; i < n; ++i) {
    const ParameterRange& range = module.parameters[static_cast<std::size_t>(i)];
    span.stretches[static_cast<std::size_t>(i)].range = range.upper - range.lower;
  }
  const auto lower = [&](int i) { return module.parameters[static_cast<std::size_t>(i)].lower; };

  // Parameters that weigh nothing (the place of a base) may take any value for free: these are counted at their
  // farthest at once, from the middle of their intervals.
  std::vector<bool> weightless(static_cast<std::size_t>(n), true);
  for (const ModuleBody& body : module.bodies) {
    for (const AffineScalar::Term& term : body.mass.terms) {
      if (term.scale != 0.0) weightless[static_cast<std::size_t>(term.parameter)] = false;
    }
  }
  for (const AffineVector& piece : rigid_pieces(module)) {
    // |offset + sum d_i x_i| <= |offset + sum d_i from_i| + sum |d_i| |x_i - from_i|, from the lower end or the middle.
    Eigen::Vector3d at_from = piece.offset;
    for (const AffineVector::Term& term : piece.terms) {
      ModuleSpan::Stretch& stretch = span.stretches[static_cast<std::size_t>(term.parameter)];
      if (weightless[static_cast<std::size_t>(term.parameter)]) {
        at_from += (lower(term.parameter) + 0.5 * stretch.range) * term.direction;
        span.length += 0.5 * stretch.range * term.direction.norm();
      } else {
        at_from += lower(term.parameter) * term.direction;
        stretch.length_rate += term.direction.norm();
      }
    }
    span.length += at_from.norm();
  }
  for (const ModuleBody& body : module.bodies) {
    span.mass += body.mass.offset;
    for (const AffineScalar::Term& term : body.mass.terms) {
      span.mass += term.scale * lower(term.parameter);
      span.stretches[static_cast<std::size_t>(term.parameter)].mass_rate += term.scale;
    }
  }
  // A parameter that makes the module lighter as it grows goes to its upper end at once: longer and lighter.
  for (ModuleSpan::Stretch& stretch : span.stretches) {
    if (stretch.mass_rate > 0.0) continue;
    span.mass += stretch.mass_rate * stretch.range;
    span.length += stretch.length_rate * stretch.range;
    stretch = {};
  }
  return span;
}

double position_slack(const PoseRegion& region) {
  double sphere = kInfinity;
  double radial = kInfinity;
  double axes[3] = {kInfinity, kInfinity, kInfinity};
  for (const Tolerance& tolerance : region.tolerances()) {
    const double extent = std::max(std::abs(tolerance.lower), std::abs(tolerance.upper));
    // Intervals taken in different frames bound different directions: only the nominal frame's are combined.
    const bool nominal_frame = tolerance.R_TN.isIdentity(1e-12);
    switch (tolerance.projection) {
      case Projection::kX:
      case Projection::kY:
      case Projection::kZ:
        if (nominal_frame) {
          double& axis = axes[static_cast<int>(tolerance.projection)];
          axis = std::min(axis, extent);
        }
        break;
      case Projection::kRSph:
        sphere = std::min(sphere, extent);
        break;
      case Projection::kRCyl:
        if (nominal_frame) radial = std::min(radial, extent);
        break;
      case Projection::kPhiCyl:
      case Projection::kTheta:
      case Projection::kPhiSph:
      case Projection::kNx:
      case Projection::kNy:
      case Projection::kNz:
      case Projection::kThetaR:
        break;
    }
  }
  return std::min(sphere, std::hypot(std::min(radial, std::hypot(axes[0], axes[1])), axes[2]));
}

Continuation any_of_types(std::span<const ModuleSpan> types, int more) {
  if (more <= 0) return {};
  // Each is taken as the lightest, the cheapest, the longest and the best to stretch at once.
  Continuation each{.mass = types.empty() ? 0.0 : kInfinity, .cost = types.empty() ? 0.0 : kInfinity};
  for (const ModuleSpan& type : types) {
    each.greatest_length = std::max(each.greatest_length, type.greatest_length());
    each.length = std::max(each.length, type.length);
    each.mass = std::min(each.mass, type.mass);
    each.cost = std::min(each.cost, type.cost);
    each.best_rate = std::max(each.best_rate, type.best_rate());
  }
  return {.length = more * each.length,
          .greatest_length = more * each.greatest_length,
          .mass = more * each.mass,
          .cost = more * each.cost,
          .best_rate = each.best_rate};
}

ReachBound reach_bound(std::span<const ModuleSpan* const> modules, double distance) {
  return reach_bound(modules, Continuation{}, distance);
}

ReachBound reach_bound(std::span<const ModuleSpan* const> modules, std::span<const ModuleSpan> types, int more,
                       double distance) {
  return reach_bound(modules, any_of_types(types, more), distance);
}

ReachBound reach_bound(std::span<const ModuleSpan* const> modules, const Continuation& rest, double distance) {
  ReachBound result;
  double length = 0.0;
  std::vector<ModuleSpan::Stretch> stretches;  // only those that lengthen: the others have no place in the order below
  for (const ModuleSpan* module : modules) {
    length += module->length;
    result.least_mass += module->mass;
    result.span += module->greatest_length();
    std::copy_if(module->stretches.begin(), module->stretches.end(), std::back_inserter(stretches),
                 [](const ModuleSpan::Stretch& stretch) { return stretch.length_rate > 0.0; });
  }
  length += rest.length;
  result.least_mass += rest.mass;
  result.span += rest.greatest_length;
  if (rest.best_rate > 0.0) stretches.push_back({.length_rate = rest.best_rate, .mass_rate = 1.0, .range = kInfinity});
  result.possible = !(distance > result.span + kRounding);
  std::sort(stretches.begin(), stretches.end(),
            [](const auto& a, const auto& b) { return a.length_rate * b.mass_rate > b.length_rate * a.mass_rate; });
  double missing = distance - kRounding - length;
  for (const ModuleSpan::Stretch& stretch : stretches) {
    if (missing <= 0.0) break;
    const double by = std::min(missing / stretch.length_rate, stretch.range);
    result.least_mass += by * stretch.mass_rate;
    missing -= by * stretch.length_rate;
  }
  return result;
}

}  // namespace modsearch
