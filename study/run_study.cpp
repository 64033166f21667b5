#include <fmt/format.h>
#include <poll.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <fstream>
#include <modsearch/study/compute_cell.hpp>
#include <modsearch/study/journal.hpp>
#include <modsearch/study/run_study.hpp>
#include <modsearch/study/time_left_internal.hpp>
#include <modsearch/study/worker_internal.hpp>
#include <utility>

namespace modsearch {
namespace {

using detail::Worker;

std::string in_words(const CellRecord& cell) {
  std::string text = fmt::format("{} of {} on {}", name(cell.key.kind), cell.key.label, cell.key.problem);
  if (cell.key.instance) text += fmt::format(" {}:{}", cell.key.instance->seed, cell.key.instance->index);
  return text + fmt::format(" with seed {}", cell.key.seed);
}

// A journal goes on only with what would have been in it anyway.
void check_same(const std::filesystem::path& file, const StudyFacts& found, const StudyFacts& wanted) {
  const auto agree = [&](const char* what, const std::string& there, const std::string& here) {
    if (there == here) return;
    throw FileError(fmt::format("{}: its {} is {}, of this run it is {}: the results would not belong together",
                                file.string(), what, there, here));
  };
  agree("study", found.name, wanted.name);
  agree("study's hash", found.hash, wanted.hash);
  agree("version", found.version, wanted.version);
  agree("compiler", found.compiler, wanted.compiler);
  agree("instruction set", found.instruction_set, wanted.instruction_set);
}

bool has_whole_line(const std::filesystem::path& file) {
  std::ifstream stream{file};
  std::string line;
  return std::getline(stream, line) && !stream.eof();
}

// One run of a study: what is to be computed, by whom, and what has come of it.
class Run {
 public:
  Run(const Study& study, const RunOptions& options)
      : study_{study}, options_{options}, file_{options.folder / "events.jsonl"}, plan_{cells_of(study)},
        ended_(plan_.size()), time_left_{plan_, options.jobs} {}

  StudyRecord operator()() {
    open();
    work_off(waiting_cells(), [this](const CellRecord& cell) { keep(cell); });
    if (!stopped()) recheck();
    journal_.reset();
    return read_journal(file_);
  }

 private:
  using Finish = std::function<void(const CellRecord&)>;

  [[nodiscard]] bool stopped() const { return options_.stop.stop_requested(); }

  void open() {
    StudyFacts facts = facts_of(study_, options_.command);
    std::error_code error;
    std::filesystem::create_directories(options_.folder, error);
    if (error) throw FileError(fmt::format("{}: cannot make this folder: {}", options_.folder.string(), error.message()));
    if (options_.lock == nullptr) lock_.emplace(OutputLock::of_folder(options_.folder));
    locate(facts);
    const bool there = std::filesystem::exists(file_);
    if (there && !options_.resume) {
      throw FileError(fmt::format("{}: this journal is there already: resume it, or name another folder", file_.string()));
    }
    if (there && has_whole_line(file_)) {
      const StudyRecord record = read_journal(file_);
      check_same(file_, record.study, facts);
      take_over(record);
      journal_.emplace(Journal::resume(file_));
      return;
    }
    std::filesystem::remove(file_);  // nothing but the beginning of its first line
    journal_.emplace(Journal::begin(file_, facts));
  }

  // Problems in files are named from the journal's folder on.
  void locate(StudyFacts& facts) const {
    const std::vector<std::string> builtin = builtin_problems();
    for (ProblemFacts& problem : facts.problems) {
      const bool is_file = !problem.location.empty() &&
                           std::find(builtin.begin(), builtin.end(), problem.location) == builtin.end();
      if (is_file) {
        problem.location =
            std::filesystem::proximate(std::filesystem::absolute(problem.location), options_.folder).string();
      }
    }
  }

  void take_over(const StudyRecord& record) {
    for (const CellRecord& cell : record.cells) {
      const auto number = static_cast<std::size_t>(cell.number);
      if (number >= plan_.size() || plan_[number].record.id != cell.id) {
        throw FileError(fmt::format("{}: cell {} is not cell {} of the study", file_.string(), cell.id, cell.number));
      }
      const bool has_lost_policy = cell.key.kind == CellKind::kTraining &&
                                   !std::filesystem::exists(options_.folder / policy_path(cell.id));
      if (cell.state == CellState::kDone && !has_lost_policy) count(cell);
    }
  }

  [[nodiscard]] std::vector<std::size_t> waiting_cells() const {
    std::vector<std::size_t> waiting;
    for (std::size_t number = 0; number < plan_.size(); ++number) {
      if (!ended_[number]) waiting.push_back(number);
    }
    return waiting;
  }

  // Computes the cells `waiting`, in order but for those that wait for their training.
  void work_off(std::vector<std::size_t> waiting, const Finish& finish) {
    std::vector<Worker> workers;
    while (!stopped() && (!waiting.empty() || !workers.empty())) {
      while (static_cast<int>(workers.size()) < options_.jobs) {
        const auto ready = std::find_if(waiting.begin(), waiting.end(), [&](std::size_t number) { return is_ready(number); });
        if (ready == waiting.end()) break;
        const std::size_t number = *ready;
        waiting.erase(ready);
        if (const std::optional<CellRecord> stuck = without_policy(number)) {
          journal_->start(*stuck);
          finish(*stuck);
          continue;
        }
        workers.push_back(begin(number));
        report(plan_[number].record, workers.size());
      }
      for (const CellRecord& cell : ended_of(workers)) {
        finish(cell);
        report(cell, workers.size());
      }
    }
  }

  [[nodiscard]] bool is_ready(std::size_t number) const {
    const std::optional<std::size_t> needs = plan_[number].needs;
    return !needs || ended_[*needs];
  }

  // The cell as it fails where its training did.
  [[nodiscard]] std::optional<CellRecord> without_policy(std::size_t number) const {
    const std::optional<std::size_t> needs = plan_[number].needs;
    if (!needs || ended_[*needs]->state == CellState::kDone) return std::nullopt;
    CellRecord cell = plan_[number].record;
    cell.state = CellState::kFailed;
    cell.failure = fmt::format("its training, cell {}, failed", plan_[*needs].record.id);
    return cell;
  }

  Worker begin(std::size_t number) {
    const PlannedCell& cell = plan_[number];
    const bool again = ended_[number].has_value();
    if (!again) journal_->start(cell.record);
    // A training that is repeated leaves the policy alone that others use.
    const bool trains_again = again && cell.record.key.kind == CellKind::kTraining;
    return {cell.record, [&] { return compute(study_, cell, trains_again ? aside() : options_.folder); }};
  }

  // Waits until something happens, a tenth of a second at most, and takes those that have ended out of `workers`.
  static std::vector<CellRecord> ended_of(std::vector<Worker>& workers) {
    std::vector<::pollfd> polled;
    for (const Worker& worker : workers) polled.push_back({worker.descriptor(), POLLIN, 0});
    constexpr int kMilliseconds = 100;  // somebody may ask to stop
    std::vector<CellRecord> ended;
    if (::poll(polled.data(), polled.size(), kMilliseconds) <= 0) return ended;
    for (std::size_t i = workers.size(); i-- > 0;) {
      if (polled[i].revents == 0 || !workers[i].receive()) continue;
      ended.push_back(workers[i].result());
      workers.erase(workers.begin() + static_cast<std::ptrdiff_t>(i));
    }
    return ended;
  }

  [[nodiscard]] std::filesystem::path aside() const { return options_.folder / "recheck"; }

  void keep(const CellRecord& cell) {
    journal_->finish(cell);
    count(cell);
  }

  void count(const CellRecord& cell) {
    ended_[static_cast<std::size_t>(cell.number)] = cell;
    ++n_ended_;
    n_failed_ += cell.state == CellState::kFailed;
    time_left_.add(cell);
  }

  void recheck() {
    std::vector<std::size_t> candidates;
    for (std::size_t number = 0; number < plan_.size(); ++number) {
      if (ended_[number]->state == CellState::kDone && !plan_[number].record.key.timed()) candidates.push_back(number);
    }
    std::vector<std::size_t> chosen;
    const std::size_t n = std::min(candidates.size(), static_cast<std::size_t>(options_.recheck));
    for (std::size_t i = 0; i < n; ++i) chosen.push_back(candidates[i * candidates.size() / n]);
    work_off(chosen, [this](const CellRecord& cell) { compare(cell); });
    std::filesystem::remove_all(aside());
  }

  void compare(const CellRecord& again) const {
    const CellRecord& known = *ended_[static_cast<std::size_t>(again.number)];
    const std::optional<std::string> differs =
        again.state == CellState::kDone ? difference(known, again) : "it failed this time: " + again.failure;
    if (!differs) return;
    throw StudyContradiction(fmt::format("cell {} ({}) was computed twice with different results: {}", again.id,
                                         in_words(again), *differs));
  }

  void report(const CellRecord& latest, std::size_t n_running) const {
    if (!options_.progress) return;
    const StudyProgress progress{.n_cells = static_cast<std::int64_t>(plan_.size()),
                           .n_ended = n_ended_,
                           .n_failed = n_failed_,
                           .n_running = static_cast<std::int64_t>(n_running),
                           .seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count(),
                           .left = time_left_.estimate(),
                           .latest = in_words(latest)};
    options_.progress(progress);
  }

  const Study& study_;
  const RunOptions& options_;
  std::optional<OutputLock> lock_;
  std::filesystem::path file_;
  std::vector<PlannedCell> plan_;
  std::vector<std::optional<CellRecord>> ended_;  // [n_cells], done or failed
  std::int64_t n_ended_ = 0;
  std::int64_t n_failed_ = 0;
  detail::TimeLeft time_left_;
  std::optional<Journal> journal_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace

StudyRecord run(const Study& study, const RunOptions& options) {
  if (options.folder.empty()) throw std::invalid_argument("run: no folder for the journal");
  if (options.jobs < 1) throw std::invalid_argument(fmt::format("run: {} jobs (at least 1)", options.jobs));
  if (options.recheck < 0) throw std::invalid_argument(fmt::format("run: {} cells to recheck (at least 0)", options.recheck));
  return Run{study, options}();
}

}  // namespace modsearch
