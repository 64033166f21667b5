#include <fmt/format.h>

#include <chrono>
#include <modsearch/solvers/checkpoint.hpp>

namespace modsearch {
namespace {

void write(const std::filesystem::path& file, const SteppedSolver& solver, const DesignProblem& problem,
           const Meter& meter, const Search& search) {
  Archive archive;
  archive.put_text("solver", solver.name());
  archive.put_text("problem", problem.name());
  meter.save(archive);
  search.save(archive);
  archive.save(file);
}

void read(const std::filesystem::path& file, const SteppedSolver& solver, const DesignProblem& problem, Meter& meter,
          Search& search) {
  const Archive archive = Archive::load(file);
  const auto expect = [&](const std::string& entry, const std::string& ours) {
    const std::string theirs = archive.text(entry);
    if (theirs != ours) archive.fail(entry, fmt::format("is '{}', this search is of '{}'", theirs, ours));
  };
  expect("solver", solver.name());
  expect("problem", problem.name());
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
    using Clock = std::chrono::steady_clock;
    Clock::time_point last = Clock::now();
    while (true) {
      if (std::optional<SearchEnd> end = search_.step(meter)) return *std::move(end);
      if (std::chrono::duration<double>(Clock::now() - last).count() < checkpointing_.period) continue;
      write(checkpointing_.file, solver_, problem, meter, search_);
      last = Clock::now();
    }
  }

  const SteppedSolver& solver_;
  Search& search_;
  const Checkpointing& checkpointing_;
};

}  // namespace

Solution solve(const SteppedSolver& solver, const DesignProblem& problem, Meter& meter, Rng rng,
               const Checkpointing& checkpointing) {
  const std::unique_ptr<Search> search = solver.start(problem, rng);
  if (checkpointing.resume && std::filesystem::exists(checkpointing.file)) {
    read(checkpointing.file, solver, problem, meter, *search);
  }
  return Rest{solver, *search, checkpointing}.solve(problem, meter, rng);
}

}  // namespace modsearch
