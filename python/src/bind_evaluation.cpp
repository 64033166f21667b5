#include <fmt/format.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/string_view.h>
#include <nanobind/stl/vector.h>

#include <cmath>
#include <modsearch/problem/design_problem.hpp>
#include <modsearch/solvers/verification.hpp>

#include "arrays.hpp"
#include "bindings.hpp"

namespace modsearch::python {
namespace {

using namespace nb::literals;

Failure failure_named(const std::string& text) {
  for (std::size_t i = 0; i < kFailures; ++i) {
    const auto failure = static_cast<Failure>(i);
    if (name(failure) == text) return failure;
  }
  throw std::invalid_argument(
      fmt::format("why: '{}' is no reason for not being achieved, such as 'unreachable'", text));
}

TermId term_named(const std::string& text) {
  for (const TermId id :
       {TermId::kReached, TermId::kDistance, TermId::kModules, TermId::kMass, TermId::kCost, TermId::kCollision}) {
    if (name(id) == text) return id;
  }
  throw std::invalid_argument(
      fmt::format("terms: '{}' is not one of reached, distance, module, mass, cost, collision", text));
}

Terms terms_from(const std::map<std::string, double>& values) {
  Terms terms;
  for (const auto& [key, value] : values) terms.add(term_named(key), value);
  return terms;
}

nb::dict to_dict(const Terms& terms) {
  nb::dict dict;
  for (const Term& term : terms.items()) dict[nb::str(name(term.id).data())] = term.value;
  return dict;
}

nb::dict to_dict(const Work& work) {
  nb::dict dict;
  dict["forward"] = work.forward;
  dict["ik_iterations"] = work.ik_iterations;
  dict["distances"] = work.distances;
  dict["planner_states"] = work.planner_states;
  return dict;
}

std::optional<Path> path_from(nb::handle object) {
  if (object.is_none()) return std::nullopt;
  Path path{to_matrix(object[0], "path"), {}};
  const Eigen::VectorXd times = to_vector(object[1], "times of a path");
  path.times.assign(times.data(), times.data() + times.size());
  return path;
}

nb::object to_object(const std::optional<Path>& path) {
  if (!path) return nb::none();
  return nb::make_tuple(to_array(path->waypoints), to_array(std::span<const double>{path->times}));
}

// Everything there is to an attempt, in the order of the struct: for pickling.
nb::tuple state_of(const Attempt& a) {
  nb::list trajectories;
  for (const Eigen::MatrixXd& trajectory : a.trajectories) trajectories.append(to_array(trajectory));
  return nb::make_tuple(a.reached, a.achieved, a.collides, name(a.why), a.inconclusive, a.goal_error, a.relative_error,
                        a.clearance, a.torque_share, to_array(a.postures), trajectories, to_object(a.path),
                        a.goal_waypoints, a.step_waypoints, a.missing_motion,
                        nb::make_tuple(a.work.forward, a.work.ik_iterations, a.work.distances, a.work.planner_states));
}

Attempt attempt_from(const nb::tuple& state) {
  Attempt a;
  a.reached = nb::cast<bool>(state[0]);
  a.achieved = nb::cast<bool>(state[1]);
  a.collides = nb::cast<bool>(state[2]);
  a.why = failure_named(nb::cast<std::string>(state[3]));
  a.inconclusive = nb::cast<bool>(state[4]);
  a.goal_error = nb::cast<double>(state[5]);
  a.relative_error = nb::cast<double>(state[6]);
  a.clearance = nb::cast<double>(state[7]);
  a.torque_share = nb::cast<double>(state[8]);
  a.postures = to_matrix(state[9], "postures");
  for (const nb::handle each : state[10]) a.trajectories.push_back(to_matrix(each, "trajectories"));
  a.path = path_from(state[11]);
  a.goal_waypoints = nb::cast<std::vector<int>>(state[12]);
  a.step_waypoints = nb::cast<std::vector<int>>(state[13]);
  a.missing_motion = nb::cast<std::optional<std::pair<int, int>>>(state[14]);
  const nb::tuple work = nb::cast<nb::tuple>(state[15]);
  a.work = {nb::cast<std::int64_t>(work[0]), nb::cast<std::int64_t>(work[1]), nb::cast<std::int64_t>(work[2]),
            nb::cast<std::int64_t>(work[3])};
  return a;
}

std::string standing(const Attempt& attempt) {
  if (attempt.achieved) return "achieved";
  return fmt::format("{}, not achieved: {}", attempt.reached ? "reached" : "not reached", name(attempt.why));
}

void bind_attempt(nb::module_& m) {
  nb::class_<Path>(m, "Path", "A motion through joint space: straight lines between waypoints.")
      .def_prop_ro(
          "waypoints", [](const Path& self) { return to_array(self.waypoints); }, kFresh,
          "Joint positions, from home on [n_waypoints, n_joints], rad and m.")
      .def_prop_ro(
          "times", [](const Path& self) { return to_array(std::span<const double>{self.times}); }, kFresh,
          "Times of the waypoints [n_waypoints], s; empty: as fast as the joints may.")
      .def("__len__", [](const Path& self) { return self.waypoints.rows(); })
      .def("__repr__", [](const Path& self) {
        return fmt::format("Path({} waypoints of {} joints)", self.waypoints.rows(), self.waypoints.cols());
      });

  nb::class_<Attempt>(m, "Attempt", "What came of trying to fulfil a task with an arm.")
      .def_ro("reached", &Attempt::reached, "All goals' poses are, whatever collides.")
      .def_ro("achieved", &Attempt::achieved, "And the problem's collision level is met, too.")
      .def_ro("collides", &Attempt::collides, "The collision level is violated: an overlap, or no path.")
      .def_prop_ro(
          "why", [](const Attempt& self) { return name(self.why); },
          "First reason for not being achieved: 'none', 'unreachable', 'obstacle', 'no path', ..")
      .def_ro("inconclusive", &Attempt::inconclusive,
              "Where not achieved: a search for postures or motions ended so, which is no proof.")
      .def_ro("goal_error", &Attempt::goal_error, "Largest distance of the tip from a goal's nominal position [m].")
      .def_ro("relative_error", &Attempt::relative_error,
              "Mean over the goals of |t - p| / |t - b| where not reached, 0 where reached.")
      .def_ro("clearance", &Attempt::clearance, "Least over the goals' postures [m]; < 0: overlap; inf: no obstacles.")
      .def_ro("torque_share", &Attempt::torque_share,
              "Largest share of a joint's peak torque at any posture; 0 where torques are not limited.")
      .def_prop_ro(
          "postures", [](const Attempt& self) { return to_array(self.postures); }, kFresh,
          "A posture for each goal [n_goals, n_joints], rad or m.")
      .def_prop_ro(
          "trajectories",
          [](const Attempt& self) {
            nb::list list;
            for (const Eigen::MatrixXd& trajectory : self.trajectories) list.append(to_array(trajectory));
            return list;
          },
          nb::sig("def trajectories(self) -> list[numpy.typing.NDArray[numpy.float64]]"),
          "Postures at all poses of each trajectory that is followed, each [n_poses, n_joints].")
      .def_prop_ro(
          "path", [](const Attempt& self) { return self.path; },
          "The motion from home through all goals, or None; only at level 'path'.")
      .def_prop_ro(
          "goal_waypoints", [](const Attempt& self) { return self.goal_waypoints; },
          "Row of the path at which each goal is passed [n_goals].")
      .def_prop_ro(
          "missing_motion", [](const Attempt& self) { return self.missing_motion; },
          "Where no path was found: the goals (from, to) of the first motion that is missing; -1: home.")
      .def_prop_ro(
          "work", [](const Attempt& self) { return to_dict(self.work); }, nb::sig("def work(self) -> dict[str, int]"),
          "Inner work: forward kinematics, steps of inverse kinematics, distances, states of the planner.")
      .def("__repr__",
           [](const Attempt& self) {
             return fmt::format("Attempt({}, goal_error={:.4g} m, clearance={:.4g} m)", standing(self), self.goal_error,
                                self.clearance);
           })
      .def("__getstate__", [](const Attempt& self) { return state_of(self); })
      .def(
          "__setstate__", [](Attempt& self, const nb::tuple& state) { new (&self) Attempt(attempt_from(state)); },
          nb::sig("def __setstate__(self, state: tuple[typing.Any, ...], /) -> None"));
}

void make_evaluation(Evaluation* self, double score, bool achieved, std::optional<bool> reached,
                     const std::optional<std::string>& why, double relative_error, double clearance,
                     const std::map<std::string, double>& terms, nb::handle postures) {
  Evaluation evaluation;
  evaluation.score = score;
  evaluation.terms = terms_from(terms);
  Attempt& attempt = evaluation.attempt;
  attempt.achieved = achieved;
  attempt.reached = reached.value_or(achieved);
  if (achieved && !attempt.reached) throw std::invalid_argument("Evaluation: achieved and not reached");
  attempt.why = achieved ? Failure::kNone : failure_named(why.value_or("unreachable"));
  attempt.relative_error = relative_error;
  attempt.clearance = clearance;
  if (!postures.is_none()) attempt.postures = to_matrix(postures, "postures");
  new (self) Evaluation(std::move(evaluation));
}

void bind_verification(nb::module_& m) {
  nb::class_<Verification>(m, "Verification",
                           "What became of checking a design from scratch. True where it is verified.")
      .def_ro("verified", &Verification::verified,
              "Achieved at level path, the path is free when looked at finer, and all claims hold.")
      .def_ro("level", &Verification::level, "Highest level that holds: 'none', 'posture', 'path'.")
      .def_ro("findings", &Verification::findings, "One sentence per thing that is not as claimed or as asked.")
      .def_ro("evaluation", &Verification::evaluation, "At the problem's own collision level.")
      .def_ro("path_evaluation", &Verification::path_evaluation, "At level path.")
      .def_prop_ro(
          "path", [](const Verification& self) { return self.path; },
          "The motion that was checked: the claimed one, else a new one; None: there is none.")
      .def_prop_ro(
          "clearance",
          [](const Verification& self) {
            return self.check ? std::optional{self.check->clearance} : std::optional<double>{};
          },
          "Least clearance along the path [m]; None without a path.")
      .def_prop_ro(
          "states", [](const Verification& self) { return self.check ? self.check->states : 0; },
          "States of the path that were looked at.")
      .def("__bool__", [](const Verification& self) { return self.verified; })
      .def("__repr__", [](const Verification& self) {
        std::string text =
            fmt::format("Verification({}, level={}", self.verified ? "verified" : "not verified", self.level);
        for (const std::string& finding : self.findings) text += ", " + finding;
        return text + ")";
      });
}

}  // namespace

void bind_evaluation(nb::module_& m) {
  bind_attempt(m);
  nb::class_<Evaluation>(m, "Evaluation", "What a design is worth and why.")
      .def(
          "__init__", &make_evaluation, "score"_a, nb::kw_only(), "achieved"_a, "reached"_a = nb::none(),
          "why"_a = nb::none(), "relative_error"_a = 0.0, "clearance"_a = std::numeric_limits<double>::infinity(),
          "terms"_a = std::map<std::string, double>{}, "postures"_a = nb::none(),
          nb::sig("def __init__(self, score: float, *, achieved: bool, reached: bool | None = None, why: str | None = "
                  "None, relative_error: float = 0.0, clearance: float = float('inf'), terms: "
                  "collections.abc.Mapping[str, float] = {}, postures: numpy.typing.ArrayLike | None = None) -> None"),
          "For problems of your own. `score`: greater is better. `achieved`: the design does what was asked; an "
          "achieved\ndesign outranks any that is not. `reached`: it does but for what collides (default: achieved). "
          "`why`: the reason\nwhere it is not achieved, a name as in Attempt.why. `relative_error`: how far it is from "
          "its goals, 0 where reached.\n`terms`: summands of the score by name. `postures` [n_goals, n_joints]. Raises "
          "ValueError for a name that is unknown.")
      .def_ro("score", &Evaluation::score, "Greater is better; -inf: nothing was evaluated, or the problem failed.")
      .def_prop_ro(
          "terms", [](const Evaluation& self) { return to_dict(self.terms); },
          nb::sig("def terms(self) -> dict[str, float]"), "The summands of the score by name; they add up to it.")
      .def_ro("attempt", &Evaluation::attempt, "What came of trying the task with the arm.")
      .def_prop_ro(
          "achieved", [](const Evaluation& self) { return self.attempt.achieved; }, "attempt.achieved")
      .def_prop_ro(
          "reached", [](const Evaluation& self) { return self.attempt.reached; }, "attempt.reached")
      .def_prop_ro(
          "why", [](const Evaluation& self) { return name(self.attempt.why); }, "attempt.why")
      .def_prop_ro(
          "postures", [](const Evaluation& self) { return to_array(self.attempt.postures); }, kFresh,
          "attempt.postures")
      .def("better_than", &Evaluation::better_than, "other"_a,
           "Standing first, then score: an achieved design outranks one that is not.")
      .def("__repr__",
           [](const Evaluation& self) {
             return fmt::format("Evaluation({:.6f}, {})", self.score, standing(self.attempt));
           })
      .def("__getstate__",
           [](const Evaluation& self) {
             nb::list terms;
             for (const Term& term : self.terms.items()) terms.append(nb::make_tuple(name(term.id), term.value));
             return nb::make_tuple(self.score, terms, state_of(self.attempt));
           })
      .def(
          "__setstate__",
          [](Evaluation& self, const nb::tuple& state) {
            Evaluation evaluation;
            evaluation.score = nb::cast<double>(state[0]);
            for (const nb::handle term : state[1]) {
              evaluation.terms.add(term_named(nb::cast<std::string>(term[0])), nb::cast<double>(term[1]));
            }
            evaluation.attempt = attempt_from(nb::cast<nb::tuple>(state[2]));
            new (&self) Evaluation(std::move(evaluation));
          },
          nb::sig("def __setstate__(self, state: tuple[typing.Any, ...], /) -> None"));
  bind_verification(m);
}

}  // namespace modsearch::python
