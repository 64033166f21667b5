#include "app/chosen_problem_internal.hpp"

#include <fmt/format.h>

#include <stdexcept>

namespace modsearch::app {

ChosenProblem choose_problem(const std::string& name, const std::optional<Instance>& asked,
                             const FileOptions& options) {
  if (name.empty()) throw std::invalid_argument("PROBLEM is empty: neither a file nor the ID of a built-in problem");
  ChosenProblem chosen{load_problem_file(name, options), std::nullopt, nullptr};
  const Instance instance = asked.value_or(Instance{});
  if (chosen.file.sampled()) {
    chosen.instance = instance;
  } else if (instance.seed != 0 || instance.index != 0) {
    throw std::invalid_argument(fmt::format("--instance {}:{}: {} is not sampled, so its only instance is 0:0",
                                            instance.seed, instance.index, name));
  }
  try {
    chosen.problem = chosen.file.instance(instance);
  } catch (const std::exception& error) {
    // No such instance: a fault of the file, such as a box that lies within an obstacle.
    const std::string what = error.what();
    const std::string place = name + ": ";
    if (what.starts_with(place)) throw FileError(what);
    throw FileError(fmt::format("{}instance {}:{}: {}", place, instance.seed, instance.index, what));
  }
  return chosen;
}

}  // namespace modsearch::app
