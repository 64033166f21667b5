#pragma once

#include <filesystem>
#include <stop_token>
#include <string>

namespace modsearch::app {

/// What modsearch-check, a program of its own that shares no code with the search, says of a certificate.
struct CheckerVerdict {
  enum class Kind {
    kAccepted,
    kRefused,  ///< or it cannot read the file, or failed: whatever it is, nothing is proved
    kNotDone,  ///< the time was up, or somebody asked to stop
  };
  Kind kind = Kind::kNotDone;
  std::string reason{};  ///< why not, one sentence
  double seconds = 0.0;
};

/// Where modsearch-check stands: beside this program.
[[nodiscard]] std::filesystem::path checker_program();

/// Has the certificate in `file` checked, for at most `seconds`. Throws std::invalid_argument if the program is not
/// there or cannot be run.
[[nodiscard]] CheckerVerdict run_checker(const std::filesystem::path& file, double seconds, std::stop_token stop);

}  // namespace modsearch::app
