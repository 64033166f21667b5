#include <fmt/format.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/string_view.h>
#include <nanobind/stl/vector.h>
#include <nanobind/trampoline.h>

#include <cmath>
#include <modsearch/baselines/random_search.hpp>
#include <modsearch/baselines/refined.hpp>
#include <modsearch/solvers/verification.hpp>
#include <thread>

#include "app/solver_registry.hpp"
#include "arrays.hpp"
#include "bindings.hpp"
#include "named_design.hpp"
#include "search_control.hpp"

namespace modsearch::python {
namespace {

using namespace nb::literals;

/// A meter in the hands of Python, which may keep it for longer than the search lasts.
struct MeterHandle {
  Meter* meter = nullptr;                               ///< null: the search is over
  std::thread::id thread = std::this_thread::get_id();  ///< the one that searches: a meter is for one thread

  [[nodiscard]] Meter& use() const {
    if (meter == nullptr) throw std::runtime_error("this meter's search is over");
    if (thread != std::this_thread::get_id()) throw std::runtime_error("a meter is for the thread that searches");
    return *meter;
  }
};

/// A solver written in Python.
class PythonSolver final : public Solver {
 public:
  NB_TRAMPOLINE(Solver);

  [[nodiscard]] std::string name() const override {
    const nb::gil_scoped_acquire gil;
    return nb::cast<std::string>(nb_trampoline.base().attr("name"));
  }

 private:
  [[nodiscard]] SearchEnd do_solve(const DesignProblem& problem, Meter& meter, Rng rng) const override {
    const nb::gil_scoped_acquire gil;
    const SearchControl* control = SearchControl::current();
    const nb::object known = control != nullptr ? control->problem() : nb::cast(&problem, nb::rv_policy::reference);
    auto handle = std::make_shared<MeterHandle>(MeterHandle{&meter});
    struct Closing {
      MeterHandle& handle;
      ~Closing() { handle.meter = nullptr; }
    } const closing{*handle};
    const nb::object end = nb_trampoline.base().attr("do_solve")(known, handle, rng);
    if (end.is_none()) return {};
    if (nb::isinstance<nb::str>(end)) return {.stop = StopReason::kExhausted, .reason = nb::cast<std::string>(end)};
    throw std::runtime_error(fmt::format("do_solve returned {}, neither None nor the reason why it ended",
                                         nb::cast<std::string>(nb::repr(end))));
  }
};

std::optional<Evaluation> metered(const MeterHandle& self, const DesignProblem& problem, nb::handle design,
                                  bool screen) {
  Meter& meter = self.use();
  const Design resolved_design = design_from(problem.library(), design);
  const nb::gil_scoped_release released;
  return meter.evaluate(problem, resolved_design, screen ? Fidelity::kScreen : Fidelity::kFull);
}

nb::object to_object(const ModuleLibrary& library, const std::optional<Incumbent>& incumbent) {
  if (!incumbent) return nb::none();
  return nb::make_tuple(named(library, incumbent->design), incumbent->evaluation);
}

Array<double> to_array(const std::vector<TracePoint>& trace) {
  Array<double> array = new_array<double>({trace.size(), 4});
  double* out = array.data();
  for (const TracePoint& point : trace) {
    *out++ = static_cast<double>(point.evaluations);
    *out++ = point.seconds;
    *out++ = point.score;
    *out++ = point.achieved ? 1.0 : 0.0;
  }
  return array;
}

nb::dict outcomes_of(const Progress& spent) {
  nb::dict dict;
  for (std::size_t i = 0; i < kFailures; ++i) {
    if (spent.outcomes[i] == 0) continue;
    const auto failure = static_cast<Failure>(i);
    dict[nb::str(failure == Failure::kNone ? "achieved" : name(failure).data())] = spent.outcomes[i];
  }
  return dict;
}

// What there is when a search was cut off by an exception.
Solution interrupted(const Meter& meter) {
  Solution solution;
  solution.design = meter.best()->design;
  solution.evaluation = meter.best()->evaluation;
  solution.nearest = meter.nearest();
  solution.spent = meter.progress();
  solution.stop = StopReason::kInterrupted;
  return solution;
}

// Ctrl-C gives what there is, where there is something; everything else that was raised is raised.
bool gives_what_there_is(const nb::python_error& error, const Meter& meter) {
  return error.matches(PyExc_KeyboardInterrupt) && meter.best().has_value();
}

struct Chosen {
  std::shared_ptr<const Solver> solver;
  std::string name;
  std::vector<std::pair<std::string, std::string>> options;
};

Chosen chosen(nb::handle solver, bool refine) {
  Chosen result;
  if (nb::isinstance<nb::str>(solver)) {
    app::ChosenSolver known = app::choose_solver(nb::cast<std::string>(solver));
    result = {std::move(known.solver), known.name, known.options};
  } else {
    std::shared_ptr<const Solver> own;
    if (!nb::try_cast(solver, own) || own == nullptr) {
      throw std::invalid_argument(fmt::format("solver: {} is neither the name of a solver nor a Solver",
                                              nb::cast<std::string>(nb::repr(solver))));
    }
    result = {own, own->name(), {}};
  }
  if (refine) {
    result.solver = std::make_shared<Refined>(result.solver);
    result.options.emplace_back("refine", "true");
  }
  return result;
}

nb::dict solve(nb::object problem, nb::handle solver, std::optional<std::int64_t> evaluations,
               std::optional<double> seconds, double target_score, std::uint64_t seed, bool refine,
               nb::object progress) {
  const auto& searched = nb::cast<const DesignProblem&>(problem);
  const Chosen with = chosen(solver, refine);
  // As on the command line: without a budget until nothing more can be proved or improved, at the latest after 30 s.
  constexpr double kPatience = 30.0;
  Budget budget{.evaluations = evaluations.value_or(std::numeric_limits<std::int64_t>::max()),
                .target_score = target_score};
  if (seconds) budget.seconds = *seconds;
  if (!evaluations && !seconds) budget.seconds = kPatience;

  SearchControl control{problem, std::move(progress)};
  Meter meter{budget, [&](const Meter& m) { control.observe(m); }, control.token()};
  Solution solution;
  try {
    const nb::gil_scoped_release released;
    solution = with.solver->solve(searched, meter, Rng{seed});
  } catch (const nb::python_error& error) {
    if (!gives_what_there_is(error, meter)) throw;
    solution = interrupted(meter);
  }
  if (control.error()) {
    try {
      std::rethrow_exception(control.error());
    } catch (const nb::python_error& error) {
      if (!gives_what_there_is(error, meter)) throw;
    }
  }

  const ModuleLibrary& library = searched.library();
  nb::dict result;
  result["design"] = named(library, solution.design);
  result["evaluation"] = solution.evaluation;
  result["nearest"] = to_object(library, solution.nearest);
  result["stop"] = name(solution.stop);
  result["reason"] = solution.reason;
  result["bound"] =
      solution.bound ? nb::object(nb::make_tuple(solution.bound->score, solution.bound->reason)) : nb::none();
  nb::dict tallies;
  for (const Tally& tally : solution.tallies) tallies[nb::str(tally.what.c_str())] = tally.count;
  result["tallies"] = tallies;
  result["evaluations"] = solution.spent.evaluations;
  result["failed"] = solution.spent.failed;
  result["first_failure"] = meter.first_failure();
  result["program_evaluations"] = solution.spent.program_evaluations;
  result["outcomes"] = outcomes_of(solution.spent);
  result["seconds"] = solution.spent.seconds;
  result["trace"] = to_array(meter.trace());
  result["solver"] = with.name;
  nb::dict options;
  for (const auto& [key, value] : with.options) options[nb::str(key.c_str())] = value;
  result["options"] = options;
  return result;
}

nb::list list_solvers() {
  nb::list list;
  for (const app::SolverEntry& entry : app::solver_entries()) {
    nb::dict options;
    for (const app::OptionEntry& option : entry.options) {
      options[nb::str(option.key.c_str())] = nb::make_tuple(option.default_value, option.meaning);
    }
    list.append(nb::make_tuple(entry.name, entry.meaning, options));
  }
  list.append(
      nb::make_tuple("policy:FILE", "a trained agent, from the policy.json that `modsearch train` leaves", nb::dict{}));
  return list;
}

void bind_rng(nb::module_& m) {
  nb::class_<Rng>(m, "Rng",
                  "A stream of random numbers that is equal on every machine (Philox4x32-10).\n\n"
                  "For numpy: numpy.random.default_rng(rng.bits()).")
      .def(nb::init<std::uint64_t>(), "seed"_a)
      .def("bits", &Rng::bits, "64 uniform bits.")
      .def(
          "uniform", [](Rng& self, double lower, double upper) { return self.uniform(lower, upper); }, "lower"_a = 0.0,
          "upper"_a = 1.0, "Uniform in [lower, upper).")
      .def("index", &Rng::index, "n"_a, "Uniform in 0 .. n - 1. Raises ValueError if n < 1.")
      .def("normal", &Rng::normal, "Standard normal.")
      .def(
          "fork", [](const Rng& self, std::uint64_t index) { return self.fork(index); }, "index"_a,
          "An independent stream named by a number or a text, whatever this one has produced so far.")
      .def(
          "fork", [](const Rng& self, const std::string& label) { return self.fork(std::string_view{label}); },
          "label"_a)
      .def("__getstate__", [](const Rng& self) { return nb::make_tuple(self.state()[0], self.state()[1]); })
      .def("__setstate__", [](Rng& self, const nb::tuple& state) {
        new (&self) Rng(std::array{nb::cast<std::uint64_t>(state[0]), nb::cast<std::uint64_t>(state[1])});
      });
}

void bind_meter(nb::module_& m) {
  nb::class_<MeterHandle>(
      m, "Meter",
      "Counts what a solver does, keeps its best, and says when it is time to stop. A solver of your "
      "own gets one;\nafter its search, and in another thread, it raises RuntimeError.")
      .def("evaluate", &metered, "problem"_a, "design"_a, nb::kw_only(), "screen"_a = false,
           nb::sig("def evaluate(self, problem: DesignProblem, design: DesignLike, *, screen: bool = False) -> "
                   "Evaluation | None"),
           "The evaluation of `design`, or None when it is time to stop: then nothing was evaluated. What a problem of "
           "your\nown raises counts as a failed evaluation with score -inf. `screen`: without the path; never becomes "
           "the best.")
      .def(
          "say", [](const MeterHandle& self, std::string stage) { self.use().say(std::move(stage)); }, "stage"_a,
          "What the solver is at, in a few words for whoever watches.")
      .def_prop_ro(
          "stopped",
          [](const MeterHandle& self) {
            const std::optional<StopReason> stop = self.use().stopped();
            return stop ? std::optional{name(*stop)} : std::nullopt;
          },
          "Why it is time to stop ('evaluations', 'seconds', 'target score', 'interrupted'), or None.")
      .def_prop_ro(
          "evaluations", [](const MeterHandle& self) { return self.use().progress().evaluations; },
          "Evaluations so far.")
      .def_prop_ro(
          "seconds", [](const MeterHandle& self) { return self.use().progress().seconds; },
          "Time since the search began [s].")
      .def_prop_ro(
          "best",
          [](const MeterHandle& self) {
            return self.use().best() ? std::optional{self.use().best()->evaluation} : std::nullopt;
          },
          "The evaluation of the best design so far (standing, then score), or None.");
}

}  // namespace

void bind_solver(nb::module_& m) {
  bind_rng(m);
  bind_meter(m);
  nb::class_<Solver, PythonSolver>(
      m, "Solver",
      "Finds good designs for a problem. Derive from it for a solver of your own:\n\n"
      "    class Luck(modsearch.Solver):\n"
      "        name = 'luck'\n\n"
      "        def do_solve(self, problem, meter, rng):\n"
      "            while meter.evaluate(problem, modsearch.random_design(problem, rng)):\n"
      "                pass\n\n"
      "do_solve evaluates designs through the meter until that returns None, or until there is nothing left to try; it "
      "may\nreturn in words why it ended. The meter remembers the best. What it raises ends the search and is raised "
      "by "
      "solve.\nStateless: randomness comes from `rng` (Rng).")
      .def(nb::init<>())
      .def(
          "__getstate__", [](nb::handle_t<Solver> self) { return nb::make_tuple(self.attr("__dict__")); },
          nb::sig("def __getstate__(self) -> tuple[typing.Any, ...]"))
      .def(
          "__setstate__",
          [](nb::pointer_and_handle<Solver> self, const nb::tuple& state) {
            new (static_cast<void*>(self.p)) PythonSolver();
            self.h.attr("__dict__").attr("update")(state[0]);
          },
          nb::sig("def __setstate__(self, state: tuple[typing.Any, ...], /) -> None"))
      .def_prop_ro(
          "name", [](nb::handle self) { return nb::cast<std::string>(self.type().attr("__name__")); },
          nb::sig("def name(self) -> str"), "As records and messages call it; by default the name of the class.");
  m.def(
      "random_design",
      [](const DesignProblem& problem, Rng& rng) { return named(problem.library(), random_design(problem, rng)); },
      "problem"_a, "rng"_a,
      "A design with a uniform number of modules, uniform types among those that may follow, and uniform parameters.");
  m.def("_solve", &solve, "problem"_a, "solver"_a, "evaluations"_a.none(), "seconds"_a.none(), "target_score"_a,
        "seed"_a, "refine"_a, "progress"_a.none());
  m.def("_list_solvers", &list_solvers);
}

}  // namespace modsearch::python
