#include "app/solver_registry.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <modsearch/baselines/auto_solver.hpp>
#include <modsearch/baselines/per_sequence.hpp>
#include <modsearch/baselines/random_search.hpp>
#include <stdexcept>

namespace modsearch::app {
namespace {

std::string value_or(const OptionValues& values, const std::string& key, const std::string& otherwise) {
  const auto found = values.find(key);
  return found == values.end() ? otherwise : found->second;
}

int integer(const OptionValues& values, const std::string& key, int otherwise, int least, int most) {
  const auto found = values.find(key);
  if (found == values.end()) return otherwise;
  const std::string& text = found->second;
  int value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || value < least || value > most) {
    throw std::invalid_argument(fmt::format("option {}={}: not an integer in [{}, {}]", key, text, least, most));
  }
  return value;
}

std::string inner_names() {
  std::vector<std::string_view> names;
  for (const Inner inner : inner_solvers()) names.push_back(name(inner));
  return fmt::format("{}", fmt::join(names, "|"));
}

std::unique_ptr<Solver> make_per_sequence(const OptionValues& values) {
  PerSequenceOptions options;
  const std::string inner = value_or(values, "inner", std::string{name(options.inner)});
  const std::optional<Inner> known = inner_from_name(inner);
  if (!known) throw std::invalid_argument(fmt::format("option inner={}: not one of {}", inner, inner_names()));
  options.inner = *known;
  options.starts = integer(values, "starts", options.starts, 1, 100'000);
  return std::make_unique<PerSequence>(options);
}

std::vector<SolverEntry> make_entries() {
  const PerSequenceOptions defaults;
  std::vector<SolverEntry> entries;
  entries.push_back({"auto",
                     "the default: bounds first, then per-sequence optimisation with the fastest inner method",
                     {},
                     [](const OptionValues&) { return std::make_unique<AutoSolver>(); }});
  entries.push_back({"random",
                     "uniform over number of modules, types and parameters: the bar to clear",
                     {},
                     [](const OptionValues&) { return std::make_unique<RandomSearch>(); }});
  entries.push_back({"per-sequence",
                     "type sequences in order of an optimistic bound, each solved as a smooth program",
                     {{"inner", std::string{name(defaults.inner)}, inner_names()},
                      {"starts", std::to_string(defaults.starts), "low-discrepancy starts per sequence"}},
                     make_per_sequence});
  return entries;
}

const SolverEntry& entry_named(const std::string& name) {
  const std::vector<SolverEntry>& entries = solver_entries();
  const auto found = std::find_if(entries.begin(), entries.end(), [&](const auto& entry) { return entry.name == name; });
  if (found != entries.end()) return *found;
  std::vector<std::string> known;
  for (const SolverEntry& entry : entries) known.push_back(entry.name);
  throw std::invalid_argument(fmt::format("solver '{}' is not one of {}", name, fmt::join(known, ", ")));
}

}  // namespace

const std::vector<SolverEntry>& solver_entries() {
  static const std::vector<SolverEntry> entries = make_entries();
  return entries;
}

ChosenSolver choose_solver(const std::string& text) {
  const std::size_t colon = text.find(':');
  ChosenSolver chosen;
  chosen.name = text.substr(0, colon);
  const SolverEntry& entry = entry_named(chosen.name);
  OptionValues values;
  std::size_t at = colon == std::string::npos ? text.size() + 1 : colon + 1;
  while (at <= text.size()) {
    const std::size_t comma = std::min(text.find(',', at), text.size());
    const std::string pair = text.substr(at, comma - at);
    const std::size_t equals = pair.find('=');
    if (equals == std::string::npos || equals == 0) {
      throw std::invalid_argument(fmt::format("solver option '{}' is not of the form key=value", pair));
    }
    const std::string key = pair.substr(0, equals);
    const bool known = std::any_of(entry.options.begin(), entry.options.end(),
                                   [&](const OptionEntry& option) { return option.key == key; });
    if (!known) {
      std::vector<std::string> keys;
      for (const OptionEntry& option : entry.options) keys.push_back(option.key);
      throw std::invalid_argument(keys.empty()
                                      ? fmt::format("solver '{}' has no option '{}' (it has none)", chosen.name, key)
                                      : fmt::format("solver '{}' has no option '{}', only {}", chosen.name, key,
                                                    fmt::join(keys, ", ")));
    }
    if (!values.emplace(key, pair.substr(equals + 1)).second) {
      throw std::invalid_argument(fmt::format("solver option '{}' is given twice", key));
    }
    chosen.options.emplace_back(key, pair.substr(equals + 1));
    at = comma + 1;
  }
  chosen.solver = entry.make(values);
  return chosen;
}

}  // namespace modsearch::app
