#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <map>
#include <modsearch/problem/design.hpp>
#include <modsearch/problem/files.hpp>
#include <modsearch/solvers/meter.hpp>
#include <modsearch/solvers/solver.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace modsearch {

/// What is known of a comparison from its journal: everything that tables, plots and pages are made of. Plain values.

/// What a cell of a study does.
enum class CellKind {
  kTraining,  ///< trains an agent; others use its policy
  kBound,     ///< bounds what can be achieved on an instance
  kRun,       ///< one solver on one instance with one seed
};
/// "training", "bound", "run".
[[nodiscard]] std::string_view name(CellKind kind);

/// How far a cell has come.
enum class CellState {
  kStarted,  ///< and not ended when the journal was written
  kDone,
  kFailed,  ///< it threw, crashed or was killed
};
/// "started", "done", "failed".
[[nodiscard]] std::string_view name(CellState state);

/// What makes a cell the one it is. Everything but `label` goes into its ID.
struct CellKey {
  CellKind kind = CellKind::kRun;
  std::string problem;               ///< file or ID; of a training: the family it is trained on
  std::optional<Instance> instance;  ///< of a sampled problem; none for a training
  std::string label;                 ///< the solver's or agent's name in tables: one per solver of the study
  std::string solver;                ///< "ga:polish=3"; of a training, and of the runs of its policy: the agent
  std::uint64_t seed = 0;            ///< of the run, or of the training
  Budget budget;
  std::string training;  ///< ID of the cell that trained the policy; empty: nothing was trained

  /// Bounded by time: two computations may differ.
  [[nodiscard]] bool timed() const { return budget.seconds < std::numeric_limits<double>::infinity(); }
};

/// One improvement of the best design of a run: a TracePoint with what the design is made of.
struct Improvement {
  std::int64_t evaluations = 0;
  double seconds = 0.0;
  double score = 0.0;
  bool achieved = false;
  int modules = 1;    ///< the base included
  double mass = 0.0;  ///< [kg]
};

/// A design as files keep it: module types by their IDs, parameters by their names, base to tip.
struct DesignRecord {
  struct Module {
    std::string type;
    std::map<std::string, double> parameters;

    friend bool operator==(const Module&, const Module&) = default;
  };
  std::vector<Module> modules;

  friend bool operator==(const DesignRecord&, const DesignRecord&) = default;
};
[[nodiscard]] DesignRecord record_of(const ModuleLibrary& library, const Design& design);
/// Throws std::invalid_argument for modules or parameters that the library does not have.
[[nodiscard]] Design design_of(const ModuleLibrary& library, const DesignRecord& record);

/// One summand of a score.
struct TermRecord {
  std::string name;
  double value = 0.0;

  friend bool operator==(const TermRecord&, const TermRecord&) = default;
};

/// What a training has to tell beside what was spent.
struct TrainingFacts {
  std::int64_t episodes = 0;
  std::int64_t steps = 0;    ///< of the environment
  std::int64_t updates = 0;  ///< of the networks
  double mean_return = 0.0;  ///< of the last evaluation on the way
  std::string policy;        ///< the file, relative to the study's folder
  std::string weights;       ///< hash of the policy's weights: what has to come out alike
};

/// What a finished cell found and what it spent.
struct CellOutcome {
  DesignRecord design;  ///< the best; empty for a training
  Witness witness{};    ///< the postures with which it is achieved; empty where it is not
  double score = -std::numeric_limits<double>::infinity();
  bool achieved = false;
  bool reached = false;
  std::string failure;      ///< why the best is not achieved ("unreachable", "torque", ..); empty where it is
  double goal_error = 0.0;  ///< [m]; infinite where nothing was evaluated
  int modules = 1;          ///< the base included
  double mass = 0.0;        ///< [kg]
  std::vector<TermRecord> terms;
  Progress spent;            ///< evaluations, inner work, wall-clock seconds
  double cpu_seconds = 0.0;  ///< of the process, user and system
  std::string stop;          ///< why it ended: "evaluations", "optimal", ..
  std::string reason;        ///< in the solver's words
  std::optional<Bound> bound;
  std::optional<TrainingFacts> training;  ///< of a training
};

/// A cell as far as it has come.
struct CellRecord {
  std::string id;          ///< 16 hexadecimal digits, see cell_id
  std::int64_t number = 0;  ///< place in the study, from 0
  CellKey key;
  CellState state = CellState::kStarted;
  std::vector<Improvement> trace;       ///< of a finished run
  std::optional<CellOutcome> outcome;   ///< kDone
  std::string failure;                  ///< kFailed: what happened
  std::optional<int> signal;            ///< kFailed: the signal that ended it
};

/// One solver of a study.
struct SolverFacts {
  std::string label;
  std::string solver;  ///< as in CellKey::solver
  bool trained = false;
};

/// One problem of a study.
struct ProblemFacts {
  std::string name;      ///< as in CellKey::problem
  std::string location;  ///< ID, or file relative to the journal's folder; empty: a program made it
  std::vector<Instance> instances;  ///< empty for a problem that is not sampled
};

/// A study as its journal names it.
struct StudyFacts {
  std::string name;
  std::string hash;  ///< of the study and everything it refers to: 16 hexadecimal digits
  std::string version;          ///< of modsearch
  std::string command;          ///< the command line that began it; may be empty
  std::string compiler;         ///< with its version
  std::string instruction_set;  ///< of the networks: "sse2", "avx2", "avx512"
  std::int64_t n_cells = 0;     ///< planned
  std::vector<ProblemFacts> problems;
  std::vector<SolverFacts> solvers;
  std::vector<std::uint64_t> seeds;
  Budget budget;
  /// Shares of mass above the bound that count as targets [%], falling.
  std::vector<double> mass_targets;
};

/// A journal, read.
struct StudyRecord {
  StudyFacts study;
  std::vector<CellRecord> cells;  ///< those that were started, in the study's order

  /// Cells that are done or failed.
  [[nodiscard]] std::int64_t n_ended() const;
  /// The cell with this ID; null if there is none.
  [[nodiscard]] const CellRecord* find(std::string_view id) const;
};

/// Where the results of two computations of one cell differ, in words: "score: 341.9 and 341.8". Clock readings are no
/// results; a cell that is not done has none. Nothing: they agree.
[[nodiscard]] std::optional<std::string> difference(const CellRecord& first, const CellRecord& second);

/// Reads the journal `events.jsonl` of a study. A last line that is torn (the program was killed while it wrote) is
/// left out. Throws FileError (file, line, what) for any other line that is not as a journal has them, and for a cell
/// that was done twice with different results.
[[nodiscard]] StudyRecord read_journal(const std::filesystem::path& file);

}  // namespace modsearch
