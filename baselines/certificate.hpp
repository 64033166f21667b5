#pragma once

#include <modsearch/problem/files.hpp>
#include <modsearch/problem/robot_problem.hpp>
#include <modsearch/solvers/meter.hpp>
#include <optional>
#include <string>

namespace modsearch {

struct CertifyOptions {
  double gap = 1e-4;  ///< see BranchAndBoundOptions
  /// Instead: prove that no design of at most this many modules (without the base) is achieved, by a bound that all of
  /// them would exceed, or find one that is.
  std::optional<int> fewer{};
};

/// What a certificate says of the problem it belongs to.
struct CertificateNames {
  std::string problem;               ///< file relative to the certificate, or ID
  std::optional<Instance> instance;  ///< of a sampled problem
  std::string scoring;               ///< the problem file's, as JSON
};

/// What was proved.
struct Certificate {
  double upper = 0.0;             ///< no achieved design scores more; -inf: none is achieved
  std::optional<double> lower{};  ///< the score of a design that reaches and is free of obstacles
  std::optional<double> gap{};    ///< (upper - lower) as a share of the mass of that design (BranchAndBoundOptions)
  bool of_mass = true;            ///< the gap is that; false: mass costs nothing, and it is a share of the score
  bool closed = false;            ///< to the gap that was asked for
  /// Of CertifyOptions::fewer: one of no more modules that reaches and is free of obstacles, so there is no proof.
  std::optional<Design> refuted_by{};
  std::string json{};          ///< the file; empty: none was made
  std::string open{};          ///< why not, or what is left open
  std::int64_t boxes = 0;      ///< of the search
  std::int64_t leaves = 0;     ///< of the certificate
  std::int64_t sequences = 0;  ///< with a tree in it
};

/// Searches as BranchAndBound does, writes down what closed the boxes, and in the end closes those that are still open
/// against the bound that was reached: that is the proof for the checker. Where a box does not close after all, a
/// looser bound is proved. Throws std::invalid_argument for a problem of which nothing can be proved, saying why, and
/// for options out of range.
[[nodiscard]] Certificate make_certificate(const RobotProblem& problem, const CertifyOptions& options,
                                           const CertificateNames& names, Meter& meter);

}  // namespace modsearch
