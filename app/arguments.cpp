#include "app/arguments.hpp"

#include <fmt/format.h>

#include <charconv>
#include <limits>
#include <stdexcept>

namespace modsearch::app {
namespace {

std::optional<std::uint64_t> whole_number(std::string_view text) {
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

}  // namespace

std::uint64_t parse_whole_number(std::string_view option, std::string_view text, std::uint64_t most) {
  const std::optional<std::uint64_t> value = whole_number(text);
  if (!value || *value > most) {
    throw std::invalid_argument(fmt::format("{} {}: not a whole number in [0, {}]", option, text, most));
  }
  return *value;
}

double parse_seconds(std::string_view option, std::string_view text) {
  constexpr double kMost = 1e9;  // thirty years
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || !(value >= 0.0 && value <= kMost)) {
    throw std::invalid_argument(fmt::format("{} {}: not a number in [0, {:g}]", option, text, kMost));
  }
  return value;
}

std::string shell_word(std::string_view word) {
  const bool plain = !word.empty() && word.find_first_of(" \t\n'\"\\$`*?[](){}<>|&;#~!") == std::string_view::npos;
  if (plain) return std::string{word};
  std::string quoted;
  for (const char c : word) quoted += c == '\'' ? std::string{"'\\''"} : std::string{c};
  return '\'' + quoted + '\'';
}

Instance parse_instance(std::string_view text) {
  const std::size_t colon = text.find(':');
  const auto seed = whole_number(text.substr(0, colon));
  const auto index = colon == std::string_view::npos ? std::nullopt : whole_number(text.substr(colon + 1));
  if (!seed || !index) {
    throw std::invalid_argument(
        fmt::format("--instance {}: not of the form SEED:INDEX with whole numbers >= 0, such as 0:17", text));
  }
  return {*seed, *index};
}

Budget budget_of(const SolveArguments& arguments) {
  constexpr double kPatience = 30.0;
  Budget budget{.evaluations = std::numeric_limits<std::int64_t>::max()};
  if (!arguments.evaluations && !arguments.seconds) budget.seconds = kPatience;
  if (arguments.evaluations) budget.evaluations = *arguments.evaluations;
  if (arguments.seconds) budget.seconds = *arguments.seconds;
  if (arguments.until_achieved) budget.target_score = Budget::kFirstAchieved;
  return budget;
}

}  // namespace modsearch::app
