#include <fmt/format.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <limits>

#include "arrays.hpp"
#include "bindings.hpp"
#include "environment.hpp"
#include "environment_options.hpp"
#include "named_design.hpp"
#include "worker_pool.hpp"

namespace modsearch::python {
namespace {

using namespace nb::literals;

using Types = nb::ndarray<const std::int64_t, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Slots = nb::ndarray<const float, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
using Flags = nb::ndarray<const bool, nb::ndim<1>, nb::c_contig, nb::device::cpu>;

enum class Autoreset { kNextStep, kSameStep, kDisabled };

Autoreset autoreset_named(const std::string& text) {
  if (text == "NextStep") return Autoreset::kNextStep;
  if (text == "SameStep") return Autoreset::kSameStep;
  if (text == "Disabled") return Autoreset::kDisabled;
  throw std::invalid_argument(fmt::format("autoreset '{}' is not one of NextStep, SameStep, Disabled", text));
}

/// Many environments that take a step at once. Each has its own stream of random numbers, so that what it does depends
/// on no other and on no number of threads.
class VectorEpisodes {
 public:
  VectorEpisodes(const ProblemSource& source, const DesignEnvironmentOptions& options, int n, int max_steps,
                 int threads, Autoreset autoreset)
      : autoreset_{autoreset}, pool_{threads} {
    for (int i = 0; i < n; ++i) episodes_.push_back(std::make_unique<Episodes>(source, options, max_steps));
    ended_.assign(static_cast<std::size_t>(n), 0);
  }

  [[nodiscard]] std::size_t n() const { return episodes_.size(); }
  [[nodiscard]] Episodes& at(std::size_t i) { return *episodes_[i]; }

  void seed(const std::vector<std::uint64_t>& seeds) {
    if (seeds.size() != n())
      throw std::invalid_argument(fmt::format("{} seeds for {} environments", seeds.size(), n()));
    for (std::size_t i = 0; i < n(); ++i) at(i).seed(seeds[i]);
  }

  /// Begins an episode in all of them, or in those that `which` marks; (observations, masks).
  nb::tuple reset(const std::optional<Flags>& which) {
    if (which && which->shape(0) != n()) {
      throw std::invalid_argument(fmt::format("a mask of {} for {} environments", which->shape(0), n()));
    }
    const Views views = new_views(n());
    const bool* marked = which ? which->data() : nullptr;
    run([&](std::size_t i) {
      if (marked == nullptr || marked[i]) {
        at(i).reset();
        ended_[i] = 0;
      }
      views.write(at(i), i);
    });
    return nb::make_tuple(views.observations, views.masks);
  }

  /// (observations, rewards, terminations, truncations, masks, masked, failed, scores, achieved, failures, final
  /// observations or None).
  nb::tuple step(const Types& types, const Slots& parameters) {
    if (types.shape(0) != n() || parameters.shape(0) != n()) {
      throw std::invalid_argument(fmt::format("{} actions with parameters for {} of {} environments", types.shape(0),
                                              parameters.shape(0), n()));
    }
    const bool same_step = autoreset_ == Autoreset::kSameStep;
    const Views views = new_views(n());
    const Views last = new_views(same_step ? n() : 0);  // of episodes that ended, before the next began
    Array<double> rewards = new_array<double>({n()});
    Array<bool> terminations = new_array<bool>({n()});
    Array<bool> truncations = new_array<bool>({n()});
    Array<bool> masked = new_array<bool>({n()});
    Array<bool> failed = new_array<bool>({n()});
    Array<double> scores = new_array<double>({n()});
    Array<bool> achieved = new_array<bool>({n()});
    std::vector<std::string> failures(n());
    const std::size_t width = parameters.shape(1);
    const auto take = [&](std::size_t i) {
      Outcome outcome;
      if (autoreset_ == Autoreset::kNextStep && ended_[i] != 0) {
        at(i).reset();
        ended_[i] = 0;
      } else {
        const std::int64_t k = types.data()[i];
        constexpr std::int64_t kMost = HybridSpace::kMaxActions;
        outcome = at(i).step(static_cast<int>(std::clamp<std::int64_t>(k, -1, kMost)),
                             {parameters.data() + width * i, width});
        ended_[i] = outcome.terminated || outcome.truncated ? 1 : 0;
        if (same_step && ended_[i] != 0) {
          last.write(at(i), i);
          at(i).reset();
        }
      }
      rewards.data()[i] = outcome.reward;
      terminations.data()[i] = outcome.terminated;
      truncations.data()[i] = outcome.truncated;
      masked.data()[i] = outcome.masked;
      failed.data()[i] = outcome.failed;
      scores.data()[i] = outcome.score.value_or(std::numeric_limits<double>::quiet_NaN());
      achieved.data()[i] = outcome.achieved;
      failures[i] = std::move(outcome.failure);
      views.write(at(i), i);
    };
    run(take);
    const nb::object final_views = same_step ? nb::object(nb::make_tuple(last.observations, last.masks)) : nb::none();
    return nb::make_tuple(views.observations, rewards, terminations, truncations, views.masks, masked, failed, scores,
                          achieved, failures, final_views);
  }

 private:
  // What environments look like, to be filled in.
  struct Views {
    Array<float> observations;
    Array<std::int8_t> masks;

    void write(const Episodes& episodes, std::size_t i) const {
      episodes.observe(observations.data() + static_cast<std::size_t>(episodes.observation_size()) * i);
      const auto n_actions = static_cast<std::size_t>(episodes.space().n_actions());
      const ActionMask mask = episodes.mask();
      for (std::size_t k = 0; k < n_actions; ++k) {
        masks.data()[n_actions * i + k] = static_cast<std::int8_t>(mask >> k & 1);
      }
    }
  };

  [[nodiscard]] Views new_views(std::size_t n_views) {
    return {new_array<float>({n_views, static_cast<std::size_t>(at(0).observation_size())}),
            new_array<std::int8_t>({n_views, static_cast<std::size_t>(at(0).space().n_actions())})};
  }

  template <typename Each>
  void run(Each&& each) {
    const OneAtATime::Inside inside{door_, "the environment"};
    const nb::gil_scoped_release released;
    pool_.run(static_cast<int>(n()), [&](int i) { each(static_cast<std::size_t>(i)); });
  }

  std::vector<std::unique_ptr<Episodes>> episodes_;
  std::vector<char> ended_;  // [n], with the last step
  Autoreset autoreset_;
  OneAtATime door_;
  WorkerPool pool_;
};

}  // namespace

void bind_vector_environment(nb::module_& m) {
  nb::class_<VectorEpisodes>(m, "_VectorEpisodes")
      .def(
          "__init__",
          [](VectorEpisodes* self, nb::handle problem, nb::handle instance, const std::string& reward,
             const std::string& end_on, const std::string& fidelity, const std::optional<std::string>& level,
             int max_steps, int n, int threads, const std::string& autoreset) {
            if (n < 1) throw std::invalid_argument(fmt::format("num_envs is {}, at least 1 is needed", n));
            constexpr int kMostThreads = 1024;
            if (threads < 1 || threads > kMostThreads) {
              throw std::invalid_argument(fmt::format("threads is {}, not in [1, {}]", threads, kMostThreads));
            }
            new (self)
                VectorEpisodes(source_from(problem, instance), environment_options(reward, end_on, fidelity, level), n,
                               max_steps, std::min(threads, n), autoreset_named(autoreset));
          },
          "problem"_a, "instance"_a.none(), "reward"_a, "end_on"_a, "fidelity"_a, "level"_a.none(), "max_steps"_a,
          "n"_a, "threads"_a, "autoreset"_a)
      .def("seed", &VectorEpisodes::seed, "seeds"_a)
      .def("reset", &VectorEpisodes::reset, "which"_a = nb::none())
      .def("step", &VectorEpisodes::step, "types"_a, "parameters"_a)
      .def(
          "design",
          [](VectorEpisodes& self, std::size_t i) {
            if (i >= self.n()) throw nb::index_error("no such environment");
            const DesignEnvironment& environment = self.at(i).environment();
            return named(environment.problem().library(), environment.design());
          },
          "index"_a);
}

}  // namespace modsearch::python
