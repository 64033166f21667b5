#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace modsearch::certify {

/// The points x with normal . x >= least; the normal [n] has unit length.
struct HalfSpace {
  std::vector<double> normal;
  double least = 0.0;
};

/// Nearest points of polyhedra: the dual active-set method of Goldfarb and Idnani 1983, "A numerically stable dual
/// method for solving strictly convex quadratic programs", doi:10.1007/BF02591962, for the distance. Nothing is
/// allocated once the first were found.
class Projection {
 public:
  /// The point in all `half_spaces` that is nearest to `from` [n]; false: there is none.
  [[nodiscard]] bool nearest(std::span<const HalfSpace> half_spaces, const std::vector<double>& from,
                             std::vector<double>& result);

 private:
  // A half-space whose edge the point stays on, and how hard it pushes.
  struct Edge {
    std::size_t half_space = 0;
    double push = 0.0;
  };
  // Splits `normal` into its parts along the basis and what is left, `across_`; the square of the length of that.
  double split(const std::vector<double>& normal);
  // Takes in the edge that was split last.
  void add(std::size_t half_space, double push, double across_square);
  void drop(std::size_t edge, std::span<const HalfSpace> half_spaces);
  // How much the push of each edge falls for one of the normal that was split last.
  void find_falls();

  std::size_t n_edges_ = 0;
  std::vector<Edge> edges_;
  std::vector<std::vector<double>> basis_;  // orthonormal: edge by edge
  std::vector<std::vector<double>> parts_;  // of each edge's normal along the basis, up to its own
  std::vector<double> across_, along_, falls_;
};

}  // namespace modsearch::certify
