#include <fmt/format.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <modsearch/kinematics/inverse_kinematics.hpp>
#include <modsearch/kinematics/statics.hpp>
#include <numbers>

#include "arrays.hpp"
#include "bindings.hpp"
#include "placed_arm.hpp"

namespace modsearch::python {
namespace {

using namespace nb::literals;

// Postures that a caller gave: one [n_joints], or many [n, n_joints].
struct Postures {
  Numbers q;
  bool single = true;
  std::size_t n = 1;

  [[nodiscard]] const double* row(std::size_t i, int n_joints) const {
    return q.data() + i * static_cast<std::size_t>(n_joints);
  }
};

Postures postures_from(const PlacedArm& self, nb::handle object) {
  Postures postures{numbers(object)};
  const Numbers& q = postures.q;
  const auto n_joints = static_cast<std::size_t>(self.arm.n_joints());
  if ((q.ndim() != 1 && q.ndim() != 2) || q.shape(q.ndim() - 1) != n_joints) {
    std::string shape;
    for (std::size_t i = 0; i < q.ndim(); ++i) shape += (i == 0 ? "" : ", ") + std::to_string(q.shape(i));
    throw std::invalid_argument(fmt::format("q has shape [{}], the arm has {} joints: [{}] or [n, {}] is needed", shape,
                                            n_joints, n_joints, n_joints));
  }
  postures.single = q.ndim() == 1;
  postures.n = postures.single ? 1 : q.shape(0);
  for (std::size_t i = 0; i < q.size(); ++i) {
    if (!std::isfinite(q.data()[i])) throw std::invalid_argument("q: a joint position is not a finite number");
  }
  return postures;
}

// An array of one entry of `shape` per posture; a single posture has no axis of its own.
Array<double> result(const Postures& postures, std::initializer_list<std::size_t> shape) {
  if (postures.single) return new_array<double>(shape);
  std::vector<std::size_t> whole{postures.n};
  whole.insert(whole.end(), shape.begin(), shape.end());
  switch (whole.size()) {
    case 1:
      return new_array<double>({whole[0]});
    case 2:
      return new_array<double>({whole[0], whole[1]});
    default:
      return new_array<double>({whole[0], whole[1], whole[2]});
  }
}

// Calls `each(posture of row i, i)`, other threads of Python running meanwhile.
template <typename Each>
void for_each_posture(const PlacedArm& self, const Postures& postures, Each&& each) {
  const nb::gil_scoped_release released;
  Posture posture;
  for (std::size_t i = 0; i < postures.n; ++i) {
    self.arm.forward(postures.row(i, self.arm.n_joints()), posture);
    each(posture, i);
  }
}

Array<double> forward(const PlacedArm& self, nb::handle q) {
  const Postures postures = postures_from(self, q);
  Array<double> X_WE = result(postures, {4, 4});
  double* out = X_WE.data();
  for_each_posture(self, postures,
                   [&](const Posture& posture, std::size_t i) { write_pose(posture.tip, out + 16 * i); });
  return X_WE;
}

Array<double> frames(const PlacedArm& self, nb::handle q) {
  const Postures postures = postures_from(self, q);
  if (!postures.single) throw std::invalid_argument("frames: one posture [n_joints] is needed");
  const auto n = static_cast<std::size_t>(self.arm.n_joints()) + 1;
  Array<double> X_WF = new_array<double>({n, 4, 4});
  double* out = X_WF.data();
  for_each_posture(self, postures, [&](const Posture& posture, std::size_t) {
    for (std::size_t f = 0; f < n; ++f) write_pose(posture.frames[f], out + 16 * f);
  });
  return X_WF;
}

Array<double> jacobian(const PlacedArm& self, nb::handle q) {
  const Postures postures = postures_from(self, q);
  const auto n_joints = static_cast<std::size_t>(self.arm.n_joints());
  Array<double> jacobians = result(postures, {6, n_joints});
  double* out = jacobians.data();
  for_each_posture(self, postures, [&](const Posture& posture, std::size_t i) {
    using RowMajor = Eigen::Matrix<double, 6, Eigen::Dynamic, Eigen::RowMajor>;
    Eigen::Map<RowMajor>(out + 6 * n_joints * i, 6, self.arm.n_joints()) = self.arm.tip_jacobian_q(posture);
  });
  return jacobians;
}

// One number per posture: a float for one, an array [n] for many.
template <typename Measure>
nb::object measured(const PlacedArm& self, nb::handle q, Measure&& measure) {
  const Postures postures = postures_from(self, q);
  std::vector<double> values(postures.n);
  for_each_posture(self, postures, [&](const Posture& posture, std::size_t i) { values[i] = measure(posture); });
  if (postures.single) return nb::float_(values.front());
  return nb::cast(to_array(std::span<const double>{values}));
}

nb::object clearance(const PlacedArm& self, nb::handle q) {
  return measured(self, q, [&](const Posture& posture) {
    Work work;
    return self.problem ? self.problem->scene().clearance(self.arm, posture, work)
                        : std::numeric_limits<double>::infinity();
  });
}

nb::object self_distance(const PlacedArm& self, nb::handle q) {
  return measured(self, q, [&](const Posture& posture) {
    Work work;
    return self_clearance(self.arm, posture, work);
  });
}

Eigen::Vector3d three(nb::handle object, const char* what) {
  const Eigen::VectorXd values = to_vector(object, what);
  if (values.size() != 3) throw std::invalid_argument(fmt::format("{}: {} numbers, 3 are needed", what, values.size()));
  return values;
}

Array<double> torques(const PlacedArm& self, nb::handle q, std::optional<double> payload, nb::handle force,
                      nb::handle torque) {
  StaticLoad load;
  if (self.problem) {
    const Statics statics = self.problem->task().statics();
    load.gravity = statics.gravity;
    load.payload = statics.payload;
  }
  if (payload) load.payload = *payload;
  if (!force.is_none()) load.wrench.force = three(force, "force");
  if (!torque.is_none()) load.wrench.torque = three(torque, "torque");
  const Postures postures = postures_from(self, q);
  const auto n_joints = static_cast<std::size_t>(self.arm.n_joints());
  Array<double> held = result(postures, {n_joints});
  double* out = held.data();
  for_each_posture(self, postures, [&](const Posture& posture, std::size_t i) {
    Eigen::Map<Eigen::VectorXd>(out + n_joints * i, self.arm.n_joints()) = static_torques(self.arm, posture, load);
  });
  return held;
}

PoseRegion region_from(const PlacedArm& self, nb::handle goal, double tolerance, double angle) {
  const auto goals = self.problem ? self.problem->task().goals() : std::span<const Goal>{};
  if (nb::isinstance<nb::str>(goal)) {
    const auto id = nb::cast<std::string>(goal);
    for (const Goal& each : goals) {
      if (each.id == id) return each.region;
    }
    throw std::invalid_argument(fmt::format("goal '{}': the problem has none of this name", id));
  }
  if (nb::isinstance<nb::int_>(goal)) {
    const auto index = nb::cast<std::int64_t>(goal);
    if (index < 0 || index >= static_cast<std::int64_t>(goals.size())) {
      throw std::invalid_argument(fmt::format("goal {}: the problem has {} goals", index, goals.size()));
    }
    return goals[static_cast<std::size_t>(index)].region;
  }
  return region_about(goal, tolerance, angle);
}

IkSolution inverse(const PlacedArm& self, nb::handle goal, double tolerance, double angle, bool all) {
  const PoseRegion region = region_from(self, goal, tolerance, angle);
  IkOptions options = self.problem ? self.problem->spec().ik : IkOptions{};
  options.all = all;
  const nb::gil_scoped_release released;
  return inverse_kinematics(self.arm, region, options);
}

Array<double> rows(const std::vector<Eigen::VectorXd>& postures, int n_joints) {
  Eigen::MatrixXd matrix(static_cast<Eigen::Index>(postures.size()), n_joints);
  for (std::size_t i = 0; i < postures.size(); ++i) matrix.row(static_cast<Eigen::Index>(i)) = postures[i].transpose();
  return to_array(matrix);
}

}  // namespace

PoseRegion region_about(nb::handle target, double tolerance, double angle) {
  const Numbers values = numbers(target);
  if (values.ndim() == 1 && values.shape(0) == 3) {
    return PoseRegion::ball(Eigen::Map<const Eigen::Vector3d>(values.data()), tolerance);
  }
  return PoseRegion{to_pose(values, "goal"),
                    {{.projection = Projection::kRSph, .lower = 0.0, .upper = tolerance},
                     {.projection = Projection::kThetaR, .lower = 0.0, .upper = angle}}};
}

PlacedArm placed_arm(std::shared_ptr<const RobotProblem> problem, const Design& design) {
  check(problem->library(), design);
  std::shared_ptr<const Chain> chain = problem->chain(design.types());
  Arm arm = chain->at(design.parameters());
  return {std::move(chain), std::move(arm), std::move(problem)};
}

PlacedArm placed_arm(const ModuleLibrary& library, const Design& design, const Eigen::Isometry3d& X_WB) {
  check(library, design);
  auto chain = std::make_shared<const Chain>(library.assemble(design.types(), X_WB));
  Arm arm = chain->at(design.parameters());
  return {std::move(chain), std::move(arm)};
}

void bind_arm(nb::module_& m) {
  nb::class_<IkSolution>(m, "IkSolution",
                         "Postures that bring the tip as close to a goal as the arm can. True where it is reached.")
      .def_ro("reached", &IkSolution::reached, "The goal contains the tip at every one of the postures.")
      .def_ro("exact", &IkSolution::exact,
              "The verdict and `position_error` are exact, not those of a finite set of starts.")
      .def_ro("position_error", &IkSolution::position_error,
              "Distance of the tip from the nominal position at the first posture [m].")
      .def_ro("violation", &IkSolution::violation, "Norm of what the first posture misses beyond the tolerances.")
      .def_prop_ro(
          "postures",
          [](const IkSolution& self) {
            return rows(self.postures, self.postures.empty() ? 0 : static_cast<int>(self.postures.front().size()));
          },
          kFresh, "Equally close postures within the joint limits, at least one [n, n_joints], rad or m.")
      .def("__bool__", [](const IkSolution& self) { return self.reached; })
      .def("__repr__", [](const IkSolution& self) {
        return fmt::format("IkSolution({}{}, position_error={:.4g} m, {} posture{})",
                           self.reached ? "reached" : "not reached", self.exact ? "" : " by a search",
                           self.position_error, self.postures.size(), self.postures.size() == 1 ? "" : "s");
      });

  nb::class_<PlacedArm>(
      m, "Arm",
      "A robot arm that moves: a design with its lengths filled in, where it stands.\n\n"
      "Made by RobotProblem.arm and ModuleLibrary.arm. `q`: joint positions, base to tip, rad (m where "
      "a joint slides),\nof shape [n_joints], or [n, n_joints] for n postures at once; the base may "
      "have joints of its own. Poses are\nhomogeneous matrices in the world frame, lengths in m. A q "
      "of another shape, or with a number that is not\nfinite, raises ValueError. Joint limits are "
      "not looked at, unless it says so.")
      .def_prop_ro(
          "n_joints", [](const PlacedArm& self) { return self.arm.n_joints(); }, "Number of joints.")
      .def_prop_ro(
          "mass", [](const PlacedArm& self) { return self.arm.mass(); }, "Mass of the whole arm [kg].")
      .def_prop_ro(
          "reach", [](const PlacedArm& self) { return self.arm.reach(); },
          "No posture puts the tip farther than this from the first joint's axis origin [m].")
      .def_prop_ro(
          "joint_names",
          [](const PlacedArm& self) {
            std::vector<std::string> names;
            for (const Joint& joint : self.chain->joints()) names.push_back(joint.name);
            return names;
          },
          "Names of the joints, base to tip.")
      .def_prop_ro(
          "lower_limits", [](const PlacedArm& self) { return to_array(self.chain->lower_limits()); }, kFresh,
          "Lower joint limits [n_joints]; -inf for a continuous joint.")
      .def_prop_ro(
          "upper_limits", [](const PlacedArm& self) { return to_array(self.chain->upper_limits()); }, kFresh,
          "Upper joint limits [n_joints]; inf for a continuous joint.")
      .def_prop_ro(
          "home",
          [](const PlacedArm& self) {
            if (self.problem) return to_array(home_posture(self.problem->task(), self.arm, self.problem->scene()));
            return to_array(self.chain->clamped(Eigen::VectorXd::Zero(self.arm.n_joints())));
          },
          kFresh, "The posture that motions start from [n_joints].")
      .def("forward", &forward, "q"_a,
           nb::sig("def forward(self, q: numpy.typing.ArrayLike) -> numpy.typing.NDArray[numpy.float64]"),
           "Pose of the tip in the world, X_WE [4, 4], or [n, 4, 4] for n postures.")
      .def("frames", &frames, "q"_a,
           nb::sig("def frames(self, q: numpy.typing.ArrayLike) -> numpy.typing.NDArray[numpy.float64]"),
           "Poses of all frames in the world [n_joints + 1, 4, 4] for one posture: frame 0 is the world, frame j + 1\n"
           "moves with joint j, whose axis is its z axis.")
      .def("jacobian", &jacobian, "q"_a,
           nb::sig("def jacobian(self, q: numpy.typing.ArrayLike) -> numpy.typing.NDArray[numpy.float64]"),
           "Geometric Jacobian of the tip [6, n_joints], or [n, 6, n_joints]: linear velocity above [m/s], angular\n"
           "velocity below [rad/s], world frame.")
      .def("inverse", &inverse, "goal"_a, nb::kw_only(), "tolerance"_a = 1e-3,
           "angle"_a = 0.5 * std::numbers::pi / 180.0, "all"_a = false,
           nb::sig("def inverse(self, goal: numpy.typing.ArrayLike | str | int, *, tolerance: float = 0.001, angle: "
                   "float = 0.008726646259971648, all: bool = False) -> IkSolution"),
           "Inverse kinematics with joint limits. `goal`: a position [3], a pose [4, 4], or a goal of the problem by "
           "its\n"
           "ID or index, which has tolerances of its own. `tolerance` [m]: radius about the position that will do;\n"
           "`angle` [rad]: likewise about the orientation of a pose. `all`: all equally close postures, not one of "
           "them.\nA function of its arguments: nothing is drawn at random. Raises ValueError for another goal.")
      .def("clearance", &clearance, "q"_a,
           nb::sig("def clearance(self, q: numpy.typing.ArrayLike) -> float | numpy.typing.NDArray[numpy.float64]"),
           "Least signed distance between the arm and the obstacles that rest [m], a float or [n]; negative: overlap;\n"
           "inf: no obstacles.")
      .def("self_clearance", &self_distance, "q"_a,
           nb::sig("def self_clearance(self, q: numpy.typing.ArrayLike) -> float | "
                   "numpy.typing.NDArray[numpy.float64]"),
           "Least signed distance between two bodies of the arm that are no neighbours [m], a float or [n].")
      .def("static_torques", &torques, "q"_a, nb::kw_only(), "payload"_a = nb::none(), "force"_a = nb::none(),
           "torque"_a = nb::none(),
           nb::sig("def static_torques(self, q: numpy.typing.ArrayLike, *, payload: float | None = None, force: "
                   "numpy.typing.ArrayLike | None = None, torque: numpy.typing.ArrayLike | None = None) -> "
                   "numpy.typing.NDArray[numpy.float64]"),
           "Torques with which the joints hold the arm still (forces where they slide), along +q [n_joints] or "
           "[n, n_joints],\nN m or N. `payload`: point mass at the tip [kg] (default: the task's). `force` [3], N, and "
           "`torque` [3], N m, act on\nthe tip, world axes. Gravity is the task's.")
      .def("__repr__", [](const PlacedArm& self) {
        return fmt::format("Arm({} joints, {:.4f} kg, reach {:.3f} m)", self.arm.n_joints(), self.arm.mass(),
                           self.arm.reach());
      });
}

}  // namespace modsearch::python
