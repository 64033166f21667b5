// Table I of "Hybrid Reinforcement Learning for Modular Robot Optimization" (TU Munich, 2022) once more: one training,
// or what many of them show.
#include <fmt/format.h>

#include <charconv>
#include <iostream>
#include <modsearch/rl/training_csv.hpp>
#include <stdexcept>
#include <system_error>

#include "table1/cell.hpp"
#include "table1/curve_lines.hpp"
#include "table1/summary.hpp"

namespace {

using namespace modsearch;
using namespace table1;

constexpr const char* kUsage = R"(usage: table1 [OPTION ..] [SETTING=VALUE ..]   one training, its result as a line
       table1 --summary FILE ..               the table of many results, as Markdown
       table1 --failure-rate --ik OPTIONS     how often that inverse kinematics misses what is reachable
  --agent pdqn|mpdqn|spdqn|paddpg|dqn   default mpdqn
  --preset report|report-code|best      default report
  --seed N                              default 0
  --problem ID                          default seed/fixed
  --tolerance METRES                    of the goal, instead of the problem's
  --types ID,..                         only these modules may be chosen
  --ik starts=1,iterations=20,damping=0.1,salt=0,per_episode=false,done_within=METRES
                                        a numeric inverse kinematics that may fail, instead of the exact one
  --row NAME                            under which the table collects the result; default: the agent
  --csv FILE                            the result, as a table of one row
  --log FILE                            the training's evaluations
  --lines FILE                          random actions and optimum on the problems of these evaluations
)";

struct Request {
  CellRequest cell;
  std::string csv;
  std::string log;
  std::string lines;
  bool failure_rate = false;
  std::vector<std::string> summary;
};

template <typename T>
T number(const std::string& option, const std::string& text) {
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) {
    throw std::invalid_argument(fmt::format("{} {}: no such number", option, text));
  }
  return value;
}

template <typename T>
T known(const std::string& option, const std::string& text, const std::optional<T>& value) {
  if (!value) throw std::invalid_argument(fmt::format("{} {}: unknown", option, text));
  return *value;
}

std::vector<std::string> parts(const std::string& text) {
  std::vector<std::string> result;
  for (std::size_t at = 0; at <= text.size();) {
    const std::size_t end = std::min(text.find(',', at), text.size());
    result.push_back(text.substr(at, end - at));
    at = end + 1;
  }
  return result;
}

void apply(Request& request, const std::string& option, const std::string& value) {
  CellRequest& cell = request.cell;
  if (option == "--agent") {
    cell.agent = known(option, value, agent_kind_from_name(value));
  } else if (option == "--preset") {
    cell.preset = known(option, value, preset_from_name(value));
  } else if (option == "--seed") {
    cell.seed = number<std::uint64_t>(option, value);
  } else if (option == "--problem") {
    cell.problem = value;
  } else if (option == "--tolerance") {
    cell.tolerance = number<double>(option, value);
  } else if (option == "--types") {
    cell.types = parts(value);
  } else if (option == "--ik") {
    cell.ik = fallible_ik_from_text(value);
  } else if (option == "--row") {
    cell.row = value;
  } else if (option == "--csv") {
    request.csv = value;
  } else if (option == "--log") {
    request.log = value;
  } else if (option == "--lines") {
    request.lines = value;
  } else {
    throw std::invalid_argument(fmt::format("there is no option {}", option));
  }
}

Request parse(const std::vector<std::string>& arguments) {
  Request request;
  if (!arguments.empty() && arguments[0] == "--summary") {
    request.summary.assign(arguments.begin() + 1, arguments.end());
    if (request.summary.empty()) throw std::invalid_argument("--summary needs files");
    return request;
  }
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    const std::string& argument = arguments[i];
    const std::size_t equals = argument.find('=');
    if (argument == "--failure-rate") {
      request.failure_rate = true;
    } else if (argument.starts_with("--")) {
      if (i + 1 == arguments.size()) throw std::invalid_argument(fmt::format("{} needs a value", argument));
      apply(request, argument, arguments[++i]);
    } else if (equals != std::string::npos) {
      request.cell.settings.emplace_back(argument.substr(0, equals), argument.substr(equals + 1));
    } else {
      throw std::invalid_argument(fmt::format("'{}' is neither an option nor a setting", argument));
    }
  }
  if (request.cell.row.empty()) request.cell.row = name(request.cell.agent);
  return request;
}

void summarise(const std::vector<std::string>& files) {
  std::vector<CellResult> cells;
  for (const std::string& file : files) {
    for (CellResult& cell : load_cells(file)) cells.push_back(std::move(cell));
  }
  std::cout << summary_markdown(cells);
}

void train(const Request& request) {
  std::vector<EvaluationPoint> history;
  const CellResult result = run_cell(request.cell, history);
  std::cout << fmt::format(
      "{} seed {}: {} episodes, {}, best return {:.3f}, final return {:.3f}, one-step evaluations {}, {}, exact "
      "{:.3f}, "
      "{:.2f} s per 1000 episodes\n",
      result.row, result.seed, result.episodes,
      result.stabilised_after ? fmt::format("stabilised after {}", *result.stabilised_after) : "never stabilised",
      result.best_return, result.final_return, result.one_step_evaluations, result.design, result.exact_score,
      result.seconds_per_1000);
  if (!request.log.empty()) {
    TrainingCsv log{request.log};
    for (const EvaluationPoint& point : history) log.append(point);
  }
  if (!request.lines.empty()) write_file(request.lines, curve_lines_csv(request.cell, history));
  if (!request.csv.empty()) write_file(request.csv, csv_columns() + csv_row(result));
}

}  // namespace

int main(int argc, char** argv) {
  Request request;
  try {
    request = parse({argv + 1, argv + argc});
    if (!request.summary.empty()) {
      summarise(request.summary);
    } else if (request.failure_rate) {
      std::cout << failure_rates_markdown(request.cell);
    } else {
      train(request);
    }
  } catch (const std::invalid_argument& error) {
    std::cerr << "table1: " << error.what() << '\n' << kUsage;
    return 2;
  } catch (const std::exception& error) {
    std::cerr << "table1: " << error.what() << '\n';
    return 1;
  }
}
