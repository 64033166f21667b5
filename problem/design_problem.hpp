#pragma once

#include <memory>
#include <modsearch/problem/attempt.hpp>
#include <modsearch/problem/design.hpp>
#include <modsearch/problem/pose_program.hpp>
#include <modsearch/problem/scoring.hpp>
#include <modsearch/problem/smooth_program.hpp>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

namespace modsearch {

/// What a design is worth and why.
struct Evaluation {
  double score = -std::numeric_limits<double>::infinity();
  Terms terms;
  Attempt attempt;

  /// Standing first, then score: an achieved design outranks one that is not (PROBLEM 4).
  [[nodiscard]] bool better_than(const Evaluation& other) const {
    if (attempt.achieved != other.attempt.achieved) return attempt.achieved;
    return score > other.score;
  }
};

enum class Fidelity {
  kPoses,   ///< leaves out whatever collides: the goals' poses alone; an upper bound on the screen's score
  kScreen,  ///< leaves out the path and nothing else: an upper bound on the full score
  kFull,
};

/// A problem could not evaluate a design that is within the search space: what its own code threw, in its words. A
/// wrong design is another matter: that is std::invalid_argument.
class EvaluationError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// How far inside its limits a relaxation stays, so that its optimum is still achieved after rounding, and which of its
/// rows it has from the beginning.
struct Relaxation {
  double tolerance_margin = 1e-7;  ///< off the tolerance of a pose [m or rad]: ten times what inner solvers leave open
  double clearance_margin = 1e-6;  ///< least clearance asked for [m]
  /// Rows of clearance are left out as long as they hold by more than this [m], above 0 (SmoothProgram::grow). A solve
  /// with `own` takes 0.9 ms with 1 and 5 mm, 1.2 ms with 2 cm, 5.3 ms with 10 cm; the answers are the same.
  double near = 0.005;
  bool all_rows = false;  ///< nothing is left out: for comparison; the answers are the same
  /// So many poses of a trajectory have a posture of their own, evenly spread; 0: the task's goals, its knots.
  int knots = 0;
};

/// What can be said of a type sequence before anything is optimised.
struct Optimism {
  /// No achieved design with these types scores more; -inf: proved that none is achieved.
  double score = std::numeric_limits<double>::infinity();
  std::string reason;  ///< why no design is achieved, in words; empty unless score is -inf
};

/// Why no design of a problem is achieved, where that is proved before anything is searched. Indices are -1, and names
/// empty, where the proof is not about such a thing.
struct Infeasibility {
  std::string reason;  ///< in words, with goal, obstacle and modules
  int goal = -1;       ///< index into the task's goals; -1: whatever the goals are
  std::string goal_id{};
  int obstacle = -1;  ///< index into the scene's obstacles: what is overlapped, by the module below
  std::string obstacle_name{};
  int module = -1;  ///< type of the library; -1: the base
  std::string module_id{};
  double depth = 0.0;  ///< how deep a point of the module is in the obstacle at least, wherever it may stand [m]
};

/// A search problem over designs: what every solver sees. Immutable and safe to share between threads: `evaluate` is a
/// function of the design, with no seed, in any order, from any thread.
class DesignProblem {
 public:
  virtual ~DesignProblem() = default;

  [[nodiscard]] virtual std::string name() const = 0;
  [[nodiscard]] virtual const ModuleLibrary& library() const = 0;
  /// Most modules in a design, the base included.
  [[nodiscard]] virtual int max_modules() const = 0;
  /// Types that may be attached next: the action mask. Empty when max_modules() is reached. A robot problem leaves out
  /// those after which no design can be complete any more, because no end effector fits into max_modules().
  [[nodiscard]] std::vector<int> successors(std::span<const int> types) const;
  /// Whether Fidelity::kScreen leaves something out: a screened evaluation is then no answer, only a reason to look
  /// closer.
  [[nodiscard]] virtual bool staged() const { return false; }
  /// Fidelities from cheap to dear, each of which asks for more than the one before; the last is kFull. For searches
  /// that spend most on the few designs that pass the cheap ones.
  [[nodiscard]] virtual std::vector<Fidelity> stages() const;
  /// The instance as an agent sees it: numbers of a length that is fixed for a family of instances.
  [[nodiscard]] virtual Eigen::VectorXd context() const = 0;

  /// Score and terms of `design`; the empty design is allowed.
  /// Throws std::invalid_argument (module, parameter, value, limit) for a design outside the search space,
  /// EvaluationError for whatever std::exception do_evaluate ends with.
  /// `witness`: postures to try first. What is achieved with them is the answer; otherwise the better of that attempt
  /// and the one without them (unless these are the only ones wanted). The same arguments give the same evaluation.
  [[nodiscard]] Evaluation evaluate(const Design& design, Fidelity fidelity = Fidelity::kFull,
                                    const Witness& witness = {}) const;

  /// The smooth relaxation for a fixed type sequence, or null where there is none. It may leave out rows until they
  /// matter: `minimise` takes care of that, and whoever works with the program itself calls its `grow`.
  [[nodiscard]] virtual std::unique_ptr<SmoothProgram> relax(std::span<const int> types,
                                                             const Relaxation& relaxation = {}) const;
  /// The poses of all goals for a fixed type sequence, or null where the problem has no such thing.
  [[nodiscard]] virtual std::unique_ptr<PoseProgram> pose_program(std::span<const int> types) const;
  /// Whether it is proved that no design is achieved, and why; by default nothing is. Every solver looks at it first.
  [[nodiscard]] virtual std::optional<Infeasibility> infeasible() const;
  /// An upper bound on the score of achieved designs with exactly these types; +inf where nothing is known.
  [[nodiscard]] virtual Optimism optimism(std::span<const int> types) const;
  /// The same for all designs of exactly `n` modules (without the base) at once.
  [[nodiscard]] virtual Optimism optimism_of_length(int n) const;
  /// The same for those of exactly `n` modules that begin with `types`; by default that of all of this length.
  [[nodiscard]] virtual Optimism optimism_of_prefix(std::span<const int> types, int n) const;

 private:
  [[nodiscard]] virtual std::vector<int> do_successors(std::span<const int> types) const;
  [[nodiscard]] virtual Evaluation do_evaluate(const Design& design, Fidelity fidelity) const = 0;
  /// The attempt with the postures of `witness` and no others; by default there are no postures to speak of, and it is
  /// do_evaluate.
  [[nodiscard]] virtual Evaluation do_evaluate_with(const Design& design, Fidelity fidelity,
                                                    const Witness& witness) const;
};

}  // namespace modsearch
