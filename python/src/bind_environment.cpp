#include <fmt/format.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <modsearch/study/environment_page.hpp>

#include "arrays.hpp"
#include "bindings.hpp"
#include "environment.hpp"
#include "environment_options.hpp"
#include "named_design.hpp"

namespace modsearch::python {
namespace {

using namespace nb::literals;

using Parameters32 = nb::ndarray<const float, nb::ndim<1>, nb::c_contig, nb::device::cpu>;

Array<float> observation_of(const Episodes& self) {
  Array<float> array = new_array<float>({static_cast<std::size_t>(self.observation_size())});
  self.observe(array.data());
  return array;
}

// As Gymnasium's Discrete.sample takes it.
Array<std::int8_t> mask_of(const Episodes& self) {
  const auto n = static_cast<std::size_t>(self.space().n_actions());
  Array<std::int8_t> array = new_array<std::int8_t>({n});
  const ActionMask mask = self.mask();
  for (std::size_t k = 0; k < n; ++k) array.data()[k] = static_cast<std::int8_t>(mask >> k & 1);
  return array;
}

nb::tuple step(Episodes& self, int k, const Parameters32& x_k) {
  Outcome outcome;
  {
    const nb::gil_scoped_release released;
    outcome = self.step(k, {x_k.data(), x_k.size()});
  }
  return nb::make_tuple(observation_of(self), outcome.reward, outcome.terminated, outcome.truncated, mask_of(self),
                        outcome.masked, outcome.failed, outcome.score, outcome.achieved, outcome.failure);
}

std::vector<int> counts_of(const HybridSpace& space) {
  std::vector<int> counts;
  for (int k = 0; k < space.n_actions(); ++k) counts.push_back(space.count(k));
  return counts;
}

}  // namespace

ProblemSource source_from(nb::handle problem, nb::handle instance) {
  const std::optional<Instance> asked = instance_from(instance);
  std::shared_ptr<const DesignProblem> known;
  if (nb::try_cast(problem, known) && known != nullptr) {
    if (asked) throw std::invalid_argument("instance: goes with the name of a problem, not with a problem");
    return [known](Rng) { return known; };
  }
  const ProblemFile file = load_problem_file(reference_from(problem));
  return asked ? problem_source(file, *asked) : problem_source(file);
}

DesignEnvironmentOptions environment_options(const std::string& reward, const std::string& end_on,
                                             const std::string& fidelity, const std::optional<std::string>& level) {
  DesignEnvironmentOptions options;
  const auto choice = [](const char* what, const std::string& text, const char* first, const char* second) {
    if (text != first && text != second) {
      throw std::invalid_argument(fmt::format("{} '{}' is not one of {}, {}", what, text, first, second));
    }
    return text == first;
  };
  options.reward = choice("reward", reward, "score", "difference") ? RewardKind::kScore : RewardKind::kDifference;
  options.end_on = choice("end_on", end_on, "reached", "achieved") ? EndOn::kReached : EndOn::kAchieved;
  options.fidelity = choice("fidelity", fidelity, "full", "screen") ? Fidelity::kFull : Fidelity::kScreen;
  if (level) {
    options.level = level_from_name(*level);
    if (!options.level) {
      throw std::invalid_argument(fmt::format("level '{}' is not one of none, posture, posture+self, path", *level));
    }
  }
  return options;
}

void bind_environment(nb::module_& m) {
  nb::class_<Episodes>(m, "_Episodes")
      .def(
          "__init__",
          [](Episodes* self, nb::handle problem, nb::handle instance, const std::string& reward,
             const std::string& end_on, const std::string& fidelity, const std::optional<std::string>& level,
             int max_steps) {
            new (self) Episodes(source_from(problem, instance), environment_options(reward, end_on, fidelity, level),
                                max_steps);
          },
          "problem"_a, "instance"_a.none(), "reward"_a, "end_on"_a, "fidelity"_a, "level"_a.none(), "max_steps"_a)
      .def_prop_ro("observation_size", &Episodes::observation_size)
      .def_ro_static("bound", &Episodes::kBound)
      .def_prop_ro("counts", [](const Episodes& self) { return counts_of(self.space()); })
      .def_prop_ro("max_modules", [](const Episodes& self) { return self.environment().problem().max_modules(); })
      .def_prop_ro("name", [](const Episodes& self) { return self.environment().problem().name(); })
      .def_prop_ro("design",
                   [](const Episodes& self) {
                     return named(self.environment().problem().library(), self.environment().design());
                   })
      .def_prop_ro("evaluation", [](const Episodes& self) { return self.environment().evaluation(); })
      .def("seed", &Episodes::seed, "seed"_a)
      .def("reset",
           [](Episodes& self) {
             {
               const nb::gil_scoped_release released;
               self.reset();
             }
             return nb::make_tuple(observation_of(self), mask_of(self));
           })
      .def(
          "reset_to",
          [](Episodes& self, nb::handle problem, nb::handle instance) {
            self.reset_to(source_from(problem, instance));
            return nb::make_tuple(observation_of(self), mask_of(self));
          },
          "problem"_a, "instance"_a.none())
      .def("step", &step, "k"_a, "x_k"_a)
      .def("mask", &mask_of)
      .def("render", [](const Episodes& self) { return render(self.environment()); });
}

}  // namespace modsearch::python
