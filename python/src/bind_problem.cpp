#include <fmt/format.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/string_view.h>
#include <nanobind/stl/vector.h>
#include <nanobind/trampoline.h>

#include <modsearch/problem/files.hpp>
#include <numbers>

#include "arrays.hpp"
#include "bindings.hpp"
#include "named_design.hpp"
#include "placed_arm.hpp"
#include "search_control.hpp"

namespace modsearch::python {

std::vector<std::string> type_names(const ModuleLibrary& library, std::span<const int> types);

namespace {

using namespace nb::literals;

// Ctrl-C in the middle of an evaluation that nobody searches with: no std::exception, so that it is not taken for a
// fault of the design.
struct Interrupted {
  nb::python_error error;
};

std::string_view name_of(Fidelity fidelity) {
  switch (fidelity) {
    case Fidelity::kPoses:
      return "poses";
    case Fidelity::kScreen:
      return "screen";
    case Fidelity::kFull:
      return "full";
  }
  return "";
}

Fidelity fidelity_named(const std::string& text) {
  for (const Fidelity fidelity : {Fidelity::kPoses, Fidelity::kScreen, Fidelity::kFull}) {
    if (name_of(fidelity) == text) return fidelity;
  }
  throw std::invalid_argument(fmt::format("fidelity '{}' is not one of poses, screen, full", text));
}

Level level_named(const std::string& text) {
  const std::optional<Level> level = level_from_name(text);
  if (!level)
    throw std::invalid_argument(fmt::format("level '{}' is not one of none, posture, posture+self, path", text));
  return *level;
}

/// A problem whose scores come from Python. What it is like is said once, at construction, so that solvers can ask
/// without the interpreter.
class PythonProblem final : public DesignProblem {
 public:
  NB_TRAMPOLINE(DesignProblem);

  PythonProblem(std::string name, std::shared_ptr<const ModuleLibrary> library, int max_modules,
                Eigen::VectorXd context)
      : name_{std::move(name)}, library_{std::move(library)}, max_modules_{max_modules}, context_{std::move(context)} {
    constexpr int kMost = 64;
    if (max_modules_ < 1 || max_modules_ > kMost) {
      throw std::invalid_argument(fmt::format("max_modules is {}, not in [1, {}]", max_modules_, kMost));
    }
    if (!context_.allFinite()) throw std::invalid_argument("context: a number that is not finite");
  }

  [[nodiscard]] std::string name() const override { return name_; }
  [[nodiscard]] const ModuleLibrary& library() const override { return *library_; }
  [[nodiscard]] int max_modules() const override { return max_modules_; }
  [[nodiscard]] Eigen::VectorXd context() const override { return context_; }
  [[nodiscard]] const std::shared_ptr<const ModuleLibrary>& shared_library() const { return library_; }

 private:
  // Calls into Python. Its exceptions become words, for the meter counts and tells them, unless they are to end the
  // program: then the search ends, if there is one.
  template <typename Call>
  static auto told(Call&& call) {
    try {
      return call();
    } catch (const nb::python_error& error) {
      if (!ends_program(error)) throw std::runtime_error(words_of(error));
      SearchControl* control = SearchControl::current();
      if (control == nullptr) throw Interrupted{error};
      control->fail(error);
      throw std::runtime_error(words_of(error));
    }
  }

  [[nodiscard]] Evaluation do_evaluate(const Design& design, Fidelity fidelity) const override {
    const nb::gil_scoped_acquire gil;
    return told([&] {
      const nb::object result = nb_trampoline.base().attr("do_evaluate")(named(*library_, design), name_of(fidelity));
      const Evaluation* evaluation = nullptr;
      if (nb::try_cast(result, evaluation, false) && evaluation != nullptr) return *evaluation;
      throw std::runtime_error(
          fmt::format("do_evaluate returned {}, not an Evaluation", nb::cast<std::string>(nb::repr(result))));
    });
  }

  [[nodiscard]] std::vector<int> do_successors(std::span<const int> types) const override {
    const nb::gil_scoped_acquire gil;
    const nb::object method = nb::getattr(nb_trampoline.base(), "do_successors", nb::none());
    if (method.is_none()) return library_->successors(types);
    return told([&] {
      std::vector<int> next;
      for (const auto& type : nb::cast<std::vector<std::string>>(method(type_names(*library_, types)))) {
        const std::optional<int> k = library_->find(type);
        if (!k) throw std::invalid_argument(fmt::format("do_successors: '{}' is no type of the library", type));
        next.push_back(*k);
      }
      return next;
    });
  }

  std::string name_;
  std::shared_ptr<const ModuleLibrary> library_;
  int max_modules_;
  Eigen::VectorXd context_;
};

std::shared_ptr<const ModuleLibrary> library_of(const DesignProblem& problem) {
  if (const auto* robot = dynamic_cast<const RobotProblem*>(&problem)) return robot->spec().library;
  return dynamic_cast<const PythonProblem&>(problem).shared_library();
}

Evaluation evaluate(const DesignProblem& self, nb::handle design, const std::string& fidelity, nb::handle postures) {
  const Design resolved_design = design_from(self.library(), design);
  const Fidelity wanted = fidelity_named(fidelity);
  Witness witness;
  if (!postures.is_none()) witness.postures = to_matrix(postures, "postures");
  const nb::gil_scoped_release released;
  return self.evaluate(resolved_design, wanted, witness);
}

std::vector<std::string> successors(const DesignProblem& self, nb::handle design) {
  const std::vector<int> types = design_from(self.library(), design).types();
  return type_names(self.library(), self.successors(types));
}

nb::object with_origin(std::shared_ptr<const RobotProblem> problem, Origin origin) {
  nb::object object = nb::cast(std::move(problem));
  nb::setattr(object, "_origin", nb::cast(std::move(origin)));
  return object;
}

nb::object with_level(nb::handle_t<RobotProblem> self, const std::string& level) {
  const auto& problem = nb::cast<const RobotProblem&>(self);
  auto other = std::make_shared<const RobotProblem>(problem.with_level(level_named(level)));
  const std::optional<Origin> origin = origin_of(self);
  return origin ? with_origin(std::move(other), *origin) : nb::cast(std::move(other));
}

void make_goal(Goal* self, std::string id, nb::handle target, double tolerance, double angle, const std::string& type) {
  if (type != "at" && type != "reach") {
    throw std::invalid_argument(fmt::format("goal '{}': type '{}' is not one of at, reach", id, type));
  }
  new (self) Goal{.id = std::move(id),
                  .type = type == "at" ? GoalType::kAt : GoalType::kReach,
                  .region = region_about(target, tolerance, angle)};
}

std::shared_ptr<const RobotProblem> with_goals(const RobotProblem& self, const std::vector<Goal>& goals,
                                               const std::optional<std::string>& name) {
  RobotProblemSpec spec = self.spec();
  spec.name = name.value_or(spec.name + " with other goals");
  spec.task = std::make_shared<const GoalTask>(
      GoalTaskSpec{.name = spec.name, .goals = goals, .home = self.task().home(), .statics = self.task().statics()});
  return std::make_shared<const RobotProblem>(std::move(spec));
}

nb::object load(nb::handle id_or_file, nb::handle instance, const std::optional<std::string>& level) {
  const std::string reference = reference_from(id_or_file);
  const std::optional<Instance> asked = instance_from(instance);
  const ProblemFile file = load_problem_file(reference);
  Origin origin{reference, std::nullopt, file.sampling};
  if (file.sampled()) {
    origin.instance = asked.value_or(Instance{});
  } else if (asked && (asked->seed != 0 || asked->index != 0)) {
    throw std::invalid_argument(fmt::format("instance ({}, {}): {} is not sampled, so its only instance is (0, 0)",
                                            asked->seed, asked->index, reference));
  }
  std::shared_ptr<const RobotProblem> problem;
  try {
    problem = file.instance(asked.value_or(Instance{}));
  } catch (const std::exception& error) {
    throw FileError(error.what());  // no such instance: a fault of the file
  }
  if (level) problem = std::make_shared<const RobotProblem>(problem->with_level(level_named(*level)));
  return with_origin(std::move(problem), std::move(origin));
}

void bind_goal(nb::module_& m) {
  nb::class_<Goal>(m, "Goal", "Where the tip has to be; every goal gets a posture of its own.")
      .def("__init__", &make_goal, "id"_a, "target"_a, nb::kw_only(), "tolerance"_a = 1e-3,
           "angle"_a = 0.5 * std::numbers::pi / 180.0, "type"_a = "reach",
           nb::sig("def __init__(self, id: str, target: numpy.typing.ArrayLike, *, tolerance: float = 0.001, angle: "
                   "float = 0.008726646259971648, type: typing.Literal['at', 'reach'] = 'reach') -> None"),
           "`target`: a position [3], any orientation, or a pose [4, 4], in the world. `tolerance` [m]: radius about "
           "the\nposition; `angle` [rad]: likewise about the orientation of a pose. `type`: 'at' passes, 'reach' "
           "stands still. Raises\nValueError for what is none of these.")
      .def_ro("id", &Goal::id, "Name of the goal.")
      .def_prop_ro(
          "type", [](const Goal& self) { return name(self.type); }, "'at', 'reach' or 'follow'.")
      .def_prop_ro(
          "pose", [](const Goal& self) { return to_array(self.region.nominal()); }, kFresh,
          "Nominal pose of the tip in the world [4, 4].")
      .def_prop_ro(
          "position", [](const Goal& self) { return to_array(Eigen::VectorXd(self.position())); }, kFresh,
          "Nominal position of the tip [3], m.")
      .def_prop_ro(
          "tolerances",
          [](const Goal& self) {
            nb::dict dict;
            for (const Tolerance& tolerance : self.region.tolerances()) {
              dict[nb::str(name(tolerance.projection).data())] = nb::make_tuple(tolerance.lower, tolerance.upper);
            }
            return dict;
          },
          nb::sig("def tolerances(self) -> dict[str, tuple[float, float]]"),
          "Closed intervals by CoBRA's names of the projections ('r_sph', 'x', 'Theta_R', ..), m or rad.")
      .def(
          "contains",
          [](const Goal& self, nb::handle pose) { return self.region.contains(to_pose(numbers(pose), "pose")); },
          "pose"_a, nb::sig("def contains(self, pose: numpy.typing.ArrayLike) -> bool"),
          "Whether a pose of the tip [4, 4] is within all tolerances.")
      .def("__repr__", [](const Goal& self) {
        const Eigen::Vector3d p = self.position();
        return fmt::format("Goal('{}', {} ({:.4g}, {:.4g}, {:.4g}))", self.id, name(self.type), p.x(), p.y(), p.z());
      });
}

void bind_design_problem(nb::module_& m) {
  nb::class_<DesignProblem, PythonProblem>(
      m, "DesignProblem",
      "A search problem over designs: what every solver sees. Derive from it for a problem of your own:\n\n"
      "    class Mast(modsearch.DesignProblem):\n"
      "        def __init__(self):\n"
      "            super().__init__('mast', library='seed', max_modules=4)\n\n"
      "        def do_evaluate(self, design, fidelity):\n"
      "            height = ..\n"
      "            return modsearch.Evaluation(height, achieved=True)\n\n"
      "do_evaluate is a function of the design: no seed, no clock. What it raises counts as a failed evaluation of a "
      "search\n(Solution.failed, Solution.first_failure) and does not end it; evaluate() raises it as EvaluationError. "
      "A method\ndo_successors(types) may narrow down which types may follow.")
      .def(
          "__init__",
          [](nb::pointer_and_handle<DesignProblem> self, std::string name, nb::handle library, int max_modules,
             nb::handle context) {
            Eigen::VectorXd numbers_of_context = context.is_none() ? Eigen::VectorXd{} : to_vector(context, "context");
            new (static_cast<void*>(self.p))
                PythonProblem(std::move(name), library_from(library), max_modules, std::move(numbers_of_context));
          },
          "name"_a, "library"_a, "max_modules"_a, "context"_a = nb::none(),
          nb::sig("def __init__(self, name: str, library: LibraryLike, max_modules: int, context: "
                  "numpy.typing.ArrayLike | None = None) -> None"),
          "`library`: a library, or its ID or file. `max_modules`: most modules in a design, the base included, at "
          "most "
          "64.\n`context`: the instance as an agent sees it, about in [-1, 1].")
      .def_prop_ro("name", &DesignProblem::name, "ID or file, for messages and records.")
      .def_prop_ro("library", &library_of, "The modules that designs are made of.")
      .def_prop_ro("max_modules", &DesignProblem::max_modules, "Most modules in a design, the base included.")
      .def_prop_ro(
          "context", [](const DesignProblem& self) { return to_array(self.context()); }, kFresh,
          "The instance as an agent sees it: as many numbers for every instance of a family.")
      .def("successors", &successors, "design"_a = nb::tuple(),
           nb::sig("def successors(self, design: DesignLike = ()) -> list[str]"),
           "Types that may be attached to `design` next; none when it has max_modules.")
      .def("evaluate", &evaluate, "design"_a, "fidelity"_a = "full", "postures"_a = nb::none(),
           nb::sig("def evaluate(self, design: DesignLike, fidelity: typing.Literal['full', 'screen', 'poses'] = "
                   "'full', postures: numpy.typing.ArrayLike | None = None) -> Evaluation"),
           "Score and terms of `design`; the empty design is allowed. A function of its arguments. `fidelity`: "
           "'screen'\n"
           "leaves out the path, 'poses' whatever collides. `postures` [n_goals, n_joints]: to be tried first. Raises\n"
           "ValueError for a design outside the search space, EvaluationError for what a problem of your own raised.")
      .def(
          "__getstate__",
          [](nb::handle_t<DesignProblem> self) {
            const auto* own = dynamic_cast<const PythonProblem*>(&nb::cast<const DesignProblem&>(self));
            if (own == nullptr) throw nb::type_error("this problem cannot be pickled");
            return nb::make_tuple(own->name(), own->library().name(), own->max_modules(), to_array(own->context()),
                                  self.attr("__dict__"));
          },
          nb::sig("def __getstate__(self) -> tuple[typing.Any, ...]"),
          "What pickles a problem of your own: its attributes, and the library by its ID or file.")
      .def(
          "__setstate__",
          [](nb::pointer_and_handle<DesignProblem> self, const nb::tuple& state) {
            new (static_cast<void*>(self.p))
                PythonProblem(nb::cast<std::string>(state[0]), load_library(nb::cast<std::string>(state[1])),
                              nb::cast<int>(state[2]), to_vector(state[3], "context"));
            self.h.attr("__dict__").attr("update")(state[4]);
          },
          nb::sig("def __setstate__(self, state: tuple[typing.Any, ...], /) -> None"))
      .def("__repr__", [](const DesignProblem& self) {
        return fmt::format("<problem '{}', library '{}', at most {} modules>", self.name(), self.library().name(),
                           self.max_modules());
      });
}

}  // namespace

std::optional<Origin> origin_of(nb::handle problem) {
  const nb::object origin = nb::getattr(problem, "_origin", nb::none());
  if (origin.is_none()) return std::nullopt;
  return nb::cast<Origin>(origin);
}

std::optional<Instance> instance_from(nb::handle object) {
  if (object.is_none()) return std::nullopt;
  if (nb::isinstance<nb::sequence>(object) && !nb::isinstance<nb::str>(object) && nb::len(object) == 2) {
    std::uint64_t seed = 0;
    std::uint64_t index = 0;
    if (nb::try_cast(nb::object(object[0]), seed) && nb::try_cast(nb::object(object[1]), index)) {
      return Instance{seed, index};
    }
  }
  throw std::invalid_argument(fmt::format("instance {}: not (seed, index), two whole numbers of at least 0",
                                          nb::cast<std::string>(nb::repr(object))));
}

std::string reference_from(nb::handle object) {
  try {
    return nb::cast<std::string>(nb::module_::import_("os").attr("fspath")(object));
  } catch (const std::exception&) {
    throw std::invalid_argument(
        fmt::format("{} is neither an ID nor the name of a file", nb::cast<std::string>(nb::repr(object))));
  }
}

void bind_problem(nb::module_& m) {
  nb::register_exception_translator([](const std::exception_ptr& pointer, void*) {
    try {
      std::rethrow_exception(pointer);
    } catch (Interrupted& interrupted) {
      interrupted.error.restore();
    }
  });
  nb::class_<Origin>(m, "_Origin");
  bind_goal(m);
  bind_design_problem(m);
  nb::class_<RobotProblem, DesignProblem>(m, "RobotProblem",
                                          "Library, scene, task and scoring: the design problem everybody uses. Made "
                                          "by load_problem; one that was loaded can\n"
                                          "be pickled.",
                                          nb::dynamic_attr())
      .def_prop_ro(
          "reference",
          [](nb::handle_t<RobotProblem> self) {
            const std::optional<Origin> origin = origin_of(self);
            return origin ? std::optional{origin->reference} : std::nullopt;
          },
          "The file or ID that it was loaded by, or None.")
      .def_prop_ro(
          "instance",
          [](nb::handle_t<RobotProblem> self) -> nb::object {
            const std::optional<Origin> origin = origin_of(self);
            if (!origin || !origin->instance) return nb::none();
            return nb::make_tuple(origin->instance->seed, origin->instance->index);
          },
          nb::sig("def instance(self) -> tuple[int, int] | None"), "(seed, index) of a sampled problem, or None.")
      .def_prop_ro(
          "level", [](const RobotProblem& self) { return name(self.spec().level); },
          "What counts as a collision: 'none', 'posture', 'posture+self' or 'path'.")
      .def_prop_ro(
          "scoring", [](const RobotProblem& self) { return self.spec().scoring->name(); },
          "'algorithm1' or 'weighted'.")
      .def_prop_ro(
          "goals",
          [](const RobotProblem& self) {
            const std::span<const Goal> goals = self.task().goals();
            return std::vector<Goal>{goals.begin(), goals.end()};
          },
          "Where the tip has to be, in order.")
      .def_prop_ro(
          "obstacles",
          [](const RobotProblem& self) {
            std::vector<std::string> names;
            for (const Obstacle& obstacle : self.scene().obstacles()) names.push_back(obstacle.name);
            return names;
          },
          "Names of what the arm must not touch.")
      .def_prop_ro(
          "infeasible",
          [](const RobotProblem& self) {
            const std::optional<Infeasibility> why = self.infeasible();
            return why ? std::optional{why->reason} : std::nullopt;
          },
          "Why no design at all is achieved, in words, where that is proved; else None.")
      .def("with_level", &with_level, "level"_a,
           nb::sig("def with_level(self, level: typing.Literal['none', 'posture', 'posture+self', 'path']) -> "
                   "RobotProblem"),
           "The same problem with another collision level. Raises ValueError for a level that is none.")
      .def(
          "with_goals", &with_goals, "goals"_a, "name"_a = nb::none(),
          nb::sig(
              "def with_goals(self, goals: collections.abc.Sequence[Goal], name: str | None = None) -> RobotProblem"),
          "The same problem with goals of your own, visited in order: library, obstacles, scoring, level, home and "
          "statics\nstay. It has no file or ID, so that it cannot be pickled and its solutions cannot be saved. Raises "
          "ValueError without\ngoals.")
      .def(
          "arm",
          [](std::shared_ptr<const RobotProblem> self, nb::handle design) {
            const Design resolved_design = design_from(self->library(), design);
            return placed_arm(std::move(self), resolved_design);
          },
          "design"_a, nb::sig("def arm(self, design: DesignLike) -> Arm"),
          "The arm of `design` among the obstacles of the problem. Raises ValueError for a design outside the search "
          "space.");
  m.def("load_problem", &load, "id_or_file"_a, "instance"_a = nb::none(), "level"_a = nb::none(),
        nb::sig("def load_problem(id_or_file: str | os.PathLike[str], instance: tuple[int, int] | None = None, level: "
                "typing.Literal['none', 'posture', 'posture+self', 'path'] | None = None) -> RobotProblem"),
        "Reads a problem file, or a built-in problem by its ID ('seed/fixed').\n\n"
        "`instance`: (seed, index) of a problem with sampled goals (default: (0, 0)). `level`: another collision level "
        "than\nthe file's. Raises FileError, one sentence with file, place, value and limit, for a file that cannot be "
        "used, and\nValueError for an instance of a problem that has only one.");
  m.def("list_problems", &builtin_problems, "IDs of the built-in problems.");
}

}  // namespace modsearch::python
