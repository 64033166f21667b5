#pragma once

#include <stop_token>

#include "app/arguments.hpp"

namespace modsearch::app {

/// Exit statuses of the program.
enum class Status {
  kSuccess = 0,   ///< solved, verified, listed
  kNegative = 1,  ///< not achieved, not verified
  kBadInput = 2,  ///< bad file or usage; output that cannot be written
  kFailure = 3,   ///< an internal failure
  kInterrupted = 130,
};

/// Each command writes its result to stdout and everything else to stderr, and throws for bad input: FileError or
/// std::invalid_argument.
[[nodiscard]] Status solve(const SolveArguments& arguments, const CommonArguments& common, std::stop_token stop);
[[nodiscard]] Status train(const TrainArguments& arguments, const CommonArguments& common, std::stop_token stop);
[[nodiscard]] Status compare(const CompareArguments& arguments, const CommonArguments& common, std::stop_token stop);
[[nodiscard]] Status evaluate(const EvaluateArguments& arguments, const CommonArguments& common);
[[nodiscard]] Status verify_solution(const VerifyArguments& arguments, const CommonArguments& common);
[[nodiscard]] Status render(const RenderArguments& arguments, const CommonArguments& common);
[[nodiscard]] Status convert(const ConvertArguments& arguments, const CommonArguments& common);
[[nodiscard]] Status generate(const GenerateArguments& arguments, const CommonArguments& common);
[[nodiscard]] Status certify(const CertifyArguments& arguments, const CommonArguments& common, std::stop_token stop);
/// Becomes modsearch-check, which lies beside this program.
[[nodiscard]] Status check_certificate(const CheckCertificateArguments& arguments, const CommonArguments& common);
[[nodiscard]] Status best_known(const BestKnownArguments& arguments, const CommonArguments& common);
[[nodiscard]] Status list(const ListArguments& arguments, const CommonArguments& common);

/// What the commands print may still wait in a buffer: throws FileError if it cannot be written, say to a full disk.
void flush_output();

}  // namespace modsearch::app
