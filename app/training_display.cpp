#include "app/training_display.hpp"

#include <fmt/format.h>

namespace modsearch::app {

TrainingDisplay::TrainingDisplay(std::string what, bool quiet)
    : what_{std::move(what)}, line_{quiet}, start_{std::chrono::steady_clock::now()} {}

void TrainingDisplay::update(const Trainer& trainer) {
  if (line_.quiet()) return;
  if (first_episode_ < 0) first_episode_ = trainer.episode() - trainer.options().evaluate_every;
  if (!line_.due()) return;

  const EvaluationPoint& point = trainer.history().back();
  const std::int64_t episodes = trainer.options().episodes;
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  const double rate = static_cast<double>(point.episode - first_episode_) / seconds;
  line_.show(
      static_cast<double>(point.episode) / static_cast<double>(episodes),
      fmt::format("{}: {} of {} episodes, {:.0f}/s, at most {:.0f} s left; greedy return {:.3f}, {:.0f} % in one "
                  "step, epsilon {:.2f}",
                  what_, point.episode, episodes, rate, static_cast<double>(episodes - point.episode) / rate,
                  point.evaluation.mean_return, 100.0 * point.evaluation.one_step_share, point.epsilon));
}

}  // namespace modsearch::app
