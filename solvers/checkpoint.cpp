#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <modsearch/problem/output_lock.hpp>
#include <modsearch/solvers/checkpoint.hpp>

namespace modsearch {
namespace {

Archive state_of(const Checkpointing& checkpointing, const SteppedSolver& solver, const DesignProblem& problem,
                 const Meter& meter, const Search& search) {
  Archive archive;
  archive.put_text("solver", solver.name());
  archive.put_text("problem", problem.name());
  archive.put_text("identity", checkpointing.identity);
  meter.save(archive);
  search.save(archive);
  return archive;
}

void read(const Checkpointing& checkpointing, const SteppedSolver& solver, const DesignProblem& problem, Meter& meter,
          Search& search) {
  const Archive archive = Archive::load(checkpointing.file);
  const auto expect = [&](const std::string& entry, const std::string& ours) {
    const std::string theirs = archive.text(entry);
    if (theirs != ours) archive.fail(entry, fmt::format("is '{}', this search is of '{}'", theirs, ours));
  };
  expect("solver", solver.name());
  expect("problem", problem.name());
  expect("identity", checkpointing.identity);
  search.restore(archive);
  meter.restore(archive, problem);
}

// A solver that is nothing but the rest of a search: Solver::solve makes a solution of how it ends.
class Rest final : public Solver {
 public:
  Rest(const SteppedSolver& solver, Search& search, const Checkpointing& checkpointing)
      : solver_{solver}, search_{search}, checkpointing_{checkpointing} {}
  [[nodiscard]] std::string name() const override { return solver_.name(); }

 private:
  [[nodiscard]] SearchEnd do_solve(const DesignProblem& problem, Meter& meter, Rng) const override {
    const auto state = [&] { return state_of(checkpointing_, solver_, problem, meter, search_); };
    // A step that the meter cuts off leaves nothing that could be kept, so that a recent state is kept here.
    Archive latest = state();
    latest.save(checkpointing_.file);
    Clock::time_point kept = Clock::now();
    Clock::time_point written = kept;
    double keep_period = kKeepPeriod;
    while (true) {
      if (std::optional<SearchEnd> end = search_.step(meter)) {
        if (meter.stopped() && kept > written) latest.save(checkpointing_.file);
        return *std::move(end);
      }
      if (since(kept) < std::min(keep_period, checkpointing_.period)) continue;
      const Clock::time_point begun = Clock::now();
      latest = state();
      kept = Clock::now();
      keep_period = std::max(kKeepPeriod, kKeepShare * std::chrono::duration<double>(kept - begun).count());
      if (since(written) < checkpointing_.period) continue;
      latest.save(checkpointing_.file);
      written = kept;
    }
  }

  using Clock = std::chrono::steady_clock;
  static constexpr double kKeepPeriod = 0.5;  // [s]
  static constexpr double kKeepShare = 50.0;  // of the time, one in so many at most goes into keeping large searches
  [[nodiscard]] static double since(Clock::time_point then) {
    return std::chrono::duration<double>(Clock::now() - then).count();
  }

  const SteppedSolver& solver_;
  Search& search_;
  const Checkpointing& checkpointing_;
};

}  // namespace

Solution solve(const SteppedSolver& solver, const DesignProblem& problem, Meter& meter, Rng rng,
               const Checkpointing& checkpointing) {
  const OutputLock lock = OutputLock::of_file(checkpointing.file);
  const std::unique_ptr<Search> search = solver.start(problem, rng);
  if (checkpointing.resume && std::filesystem::exists(checkpointing.file)) {
    read(checkpointing, solver, problem, meter, *search);
  }
  return Rest{solver, *search, checkpointing}.solve(problem, meter, rng);
}

}  // namespace modsearch
