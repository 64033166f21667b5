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
  /// them would exceed.
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
  bool closed = false;            ///< to the gap that was asked for
  std::string json{};             ///< the file; empty: none was made
  std::string open{};             ///< why not, or what is left open
  std::int64_t boxes = 0;         ///< of the search
  std::int64_t leaves = 0;        ///< of the certificate
  std::int64_t sequences = 0;     ///< with a tree in it
};

/// Searches with BranchAndBound for half of the meter's time at most, then proves the bound it ended with once more,
/// with the cut held, and writes that proof down for the checker. Throws std::invalid_argument for a problem of which
/// nothing can be proved, saying why, and for options out of range.
[[nodiscard]] Certificate make_certificate(const RobotProblem& problem, const CertifyOptions& options,
                                           const CertificateNames& names, Meter& meter);

}  // namespace modsearch
