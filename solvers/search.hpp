#pragma once

#include <memory>
#include <modsearch/solvers/archive.hpp>
#include <modsearch/solvers/solver.hpp>
#include <optional>

namespace modsearch {

/// A search under way, in steps: state that can be kept in an archive and taken up again later, in another process.
class Search {
 public:
  virtual ~Search() = default;
  /// Goes on to the next natural pause (a generation, a batch, a type sequence), some hundred evaluations at most.
  /// Nothing: there is more to do. Otherwise the search is over; where the meter said stop, the state is worth nothing
  /// any more, because the step was cut off in its middle.
  [[nodiscard]] virtual std::optional<SearchEnd> step(Meter& meter) = 0;
  /// Everything the next step depends on, but for the problem, the solver's options and the meter.
  virtual void save(Archive& archive) const = 0;
  /// The inverse, on a search that was started with the same problem and options. Throws FileError for another archive.
  virtual void restore(const Archive& archive) = 0;
};

/// A solver whose searches go in steps and can therefore resume from a checkpoint (solvers/checkpoint.hpp).
class SteppedSolver : public Solver {
 public:
  /// A search that has done nothing yet; `problem` and the solver must outlive it.
  [[nodiscard]] virtual std::unique_ptr<Search> start(const DesignProblem& problem, Rng rng) const = 0;

 private:
  [[nodiscard]] SearchEnd do_solve(const DesignProblem& problem, Meter& meter, Rng rng) const final;
};

/// Steps until the search is over.
[[nodiscard]] SearchEnd run(Search& search, Meter& meter);

/// Streams of random numbers in archives.
void put(Archive& archive, const std::string& name, const Rng& rng);
[[nodiscard]] Rng restored_rng(const Archive& archive, const std::string& name);
/// Matrices in archives, as the entries NAME/rows and NAME/values.
void put(Archive& archive, const std::string& name, const Eigen::MatrixXd& matrix);
[[nodiscard]] Eigen::MatrixXd restored_matrix(const Archive& archive, const std::string& name);
/// Designs in archives, as the entries NAME/types, NAME/lengths and NAME/parameters. `library`: gives the number of
/// parameters of each type. Restoring throws FileError for a design that does not belong to it.
void put(Archive& archive, const std::string& name, std::span<const Design> designs);
[[nodiscard]] std::vector<Design> restored_designs(const Archive& archive, const std::string& name,
                                                   const ModuleLibrary& library);

}  // namespace modsearch
