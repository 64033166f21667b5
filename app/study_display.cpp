#include "app/study_display.hpp"

#include <fmt/format.h>

#include <string>

namespace modsearch::app {
namespace {

std::string duration(double seconds) {
  if (seconds < 100.0) return fmt::format("{:.0f} s", seconds);
  if (seconds < 6000.0) return fmt::format("{:.0f} min", seconds / 60.0);
  return fmt::format("{:.1f} h", seconds / 3600.0);
}

}  // namespace

void StudyDisplay::update(const StudyProgress& progress) {
  if (!line_.due()) return;
  std::string text = fmt::format("{} of {} cells", progress.n_ended, progress.n_cells);
  if (progress.n_failed > 0) text += fmt::format(", {} failed", progress.n_failed);
  text += fmt::format(", {}", duration(progress.seconds));
  if (progress.left) text += fmt::format(", about {} left", duration(*progress.left));
  text += fmt::format("; {}", progress.latest);
  line_.show(static_cast<double>(progress.n_ended) / static_cast<double>(progress.n_cells), text);
}

}  // namespace modsearch::app
