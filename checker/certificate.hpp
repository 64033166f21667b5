#pragma once

#include <checker/coverage.hpp>
#include <optional>

namespace modsearch_check {

/// What a certificate proves.
struct Proof {
  std::string problem;
  std::string level;
  std::size_t max_modules = 1;
  bool unreachable = false;
  double upper = 0.0;           // no achieved design scores more
  std::optional<double> lower;  // the score of the design in the file, if there is one
  std::optional<double> gap;
  Count count;
};

/// Checks the certificate in `file`. Throws Malformed for what cannot be read and Rejected, with the reason, for what
/// is not proved.
[[nodiscard]] Proof check_certificate(const std::string& file);

/// The proof in sentences: what is proved, and what is no part of it.
[[nodiscard]] std::string in_words(const Proof& proof);

/// `text` on one line, control characters as \xNN: no name in a file may end a line and begin a verdict of its own.
[[nodiscard]] std::string printable(const std::string& text);

}  // namespace modsearch_check
