// What a training remembers between two episodes. All of its random numbers come from streams that are numbered by
// episode and update, so that counters are enough.
#include <fmt/format.h>

#include <modsearch/rl/state_archive.hpp>
#include <modsearch/rl/training.hpp>

namespace modsearch {
namespace {

// An evaluation point as a row of numbers; the history is a table of them.
constexpr std::size_t kColumns = 12;

void append_row(const EvaluationPoint& point, std::vector<double>& table) {
  const EvaluationSummary& e = point.evaluation;
  table.insert(table.end(),
               {static_cast<double>(point.episode), static_cast<double>(point.steps),
                static_cast<double>(point.updates), point.epsilon, point.training_return, point.value_loss,
                point.seconds, e.mean_return, e.deviation, e.success_share, e.one_step_share, e.mean_steps});
}

EvaluationPoint point_of(const double* row) {
  EvaluationPoint point;
  point.episode = static_cast<std::int64_t>(row[0]);
  point.steps = static_cast<std::int64_t>(row[1]);
  point.updates = static_cast<std::int64_t>(row[2]);
  point.epsilon = row[3];
  point.training_return = row[4];
  point.value_loss = row[5];
  point.seconds = row[6];
  point.evaluation = {.mean_return = row[7],
                      .deviation = row[8],
                      .success_share = row[9],
                      .one_step_share = row[10],
                      .mean_steps = row[11]};
  return point;
}

}  // namespace

void Trainer::save(Archive& archive) const {
  archive.put_text("agent.name", agent_.name());
  put(archive, "agent", agent_.state());
  replay_.save("replay", archive);
  if (elite_) elite_->save("elite", archive);
  archive.put("training.counters",
              std::vector<std::int64_t>{episode_, steps_, updates_, updates_at_evaluation_, best_evaluation_});
  archive.put("training.sums", std::vector<double>{updates_owed_, return_sum_, loss_sum_, seconds_, best_return_});
  archive.put("training.best_policy", best_policy_);
  std::vector<double> history;
  for (const EvaluationPoint& point : history_) append_row(point, history);
  archive.put("training.history", history);
}

void Trainer::load(const Archive& archive) {
  const std::string agent = archive.text("agent.name");
  if (agent != agent_.name()) archive.fail("agent.name", fmt::format("'{}' instead of '{}'", agent, agent_.name()));
  const std::vector<std::int64_t> counters = archive.integers("training.counters");
  if (counters.size() != 5) archive.fail("training.counters", fmt::format("{} numbers instead of 5", counters.size()));
  const std::vector<double> sums = archive.numbers("training.sums");
  if (sums.size() != 5) archive.fail("training.sums", fmt::format("{} numbers instead of 5", sums.size()));
  const std::vector<double> history = archive.numbers("training.history");
  if (history.size() % kColumns != 0) archive.fail("training.history", fmt::format("not rows of {}", kColumns));
  const std::span<const std::byte> best = archive.bytes("training.best_policy");
  std::size_t policy = 0;
  for (const StatePart& part : agent_.state()) policy += part.policy ? part.bytes.size() : 0;
  if (!best.empty() && best.size() != policy) {
    archive.fail("training.best_policy", fmt::format("{} bytes, {} are needed", best.size(), policy));
  }
  if (elite_) elite_->load("elite", archive, *environment_, agent_.memory_size());
  replay_.load("replay", archive, *environment_);
  restore(archive, "agent", agent_.state());

  episode_ = counters[0];
  steps_ = counters[1];
  updates_ = counters[2];
  updates_at_evaluation_ = counters[3];
  best_evaluation_ = counters[4];
  updates_owed_ = sums[0];
  return_sum_ = sums[1];
  loss_sum_ = sums[2];
  seconds_ = sums[3];
  best_return_ = sums[4];
  diverged_ = false;
  best_policy_.assign(best.begin(), best.end());
  history_.clear();
  for (std::size_t at = 0; at < history.size(); at += kColumns) history_.push_back(point_of(history.data() + at));
}

}  // namespace modsearch
