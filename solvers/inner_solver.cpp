#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <modsearch/solvers/inner_solver.hpp>
#include <modsearch/solvers/watched_program_internal.hpp>
#include <stdexcept>
#include <utility>

namespace modsearch {
namespace {

constexpr std::array<std::pair<Inner, std::string_view>, 9> kNames{{{Inner::kOwn, "own"},
                                                                    {Inner::kIpopt, "ipopt"},
                                                                    {Inner::kSlsqp, "slsqp"},
                                                                    {Inner::kCobyla, "cobyla"},
                                                                    {Inner::kDirect, "direct"},
                                                                    {Inner::kCrs2, "crs2"},
                                                                    {Inner::kIsres, "isres"},
                                                                    {Inner::kMlsl, "mlsl"},
                                                                    {Inner::kCeres, "ceres"}}};

void check(const SmoothProgram& program, const Eigen::VectorXd& start, const InnerOptions& options) {
  if (start.size() != program.n_variables()) {
    throw std::invalid_argument(
        fmt::format("minimise: start has {} entries, the program {} variables", start.size(), program.n_variables()));
  }
  if (!start.allFinite()) throw std::invalid_argument("minimise: start has an entry that is not finite");
  if (options.max_iterations < 1 || options.max_evaluations < 1) {
    throw std::invalid_argument(fmt::format("minimise: max_iterations {} and max_evaluations {} must be at least 1",
                                            options.max_iterations, options.max_evaluations));
  }
  if (!(options.tolerance > 0.0) || !(options.first_penalty > 0.0)) {
    throw std::invalid_argument(fmt::format("minimise: tolerance {} and first_penalty {} must be positive",
                                            options.tolerance, options.first_penalty));
  }
}

// Every variable is fixed by its bounds: there is one point, and packages need not be asked about it.
InnerResult only_point(SmoothProgram& program, const Eigen::VectorXd& v, const InnerOptions& options, Meter& meter) {
  WatchedProgram watched{program, options, meter};
  SmoothProgram::Values values;
  try {
    watched.evaluate(v, values);
  } catch (const NotANumber&) {
    return watched.result(InnerStatus::kFailed);
  }
  return watched.result(InnerStatus::kConverged);
}

InnerResult dispatch(Inner inner, SmoothProgram& program, const Eigen::VectorXd& start, const InnerOptions& options,
                     Meter& meter) {
  switch (inner) {
    case Inner::kOwn:
      return minimise_own(program, start, options, meter);
    case Inner::kIpopt:
      return minimise_ipopt(program, start, options, meter);
    case Inner::kSlsqp:
    case Inner::kCobyla:
    case Inner::kDirect:
    case Inner::kCrs2:
    case Inner::kIsres:
    case Inner::kMlsl:
      return minimise_nlopt(inner, program, start, options, meter);
    case Inner::kCeres:
      return minimise_ceres(program, start, options, meter);
  }
  throw std::invalid_argument("minimise: no such inner solver");
}

// What the program with the rows it has got since says of `result`.
void judge_again(InnerResult& result, SmoothProgram& program, const InnerOptions& options, Meter& meter) {
  ++result.evaluations;
  meter.count_program(1);
  SmoothProgram::Values values;
  program.evaluate(result.v, values);
  result.violation = program.violation(result.v, values.rows);
  if (result.violation > options.tolerance && result.status == InnerStatus::kConverged) {
    result.status = InnerStatus::kInfeasible;
  }
}

// Solves with the rows that the program has near the start, then lets it look at those it left out, and solves again
// from there with the rows that this added. Every round adds a row, so that there is a last one.
InnerResult minimise_growing(Inner inner, SmoothProgram& program, Eigen::VectorXd start, const InnerOptions& options,
                             Meter& meter) {
  const bool fixed = (program.lower().array() == program.upper().array()).all();
  program.shrink();
  (void)program.grow(start);
  for (std::int64_t evaluations = 0;;) {
    InnerResult result =
        fixed ? only_point(program, start, options, meter) : dispatch(inner, program, start, options, meter);
    evaluations += result.evaluations;
    result.evaluations = evaluations;
    if (result.v.size() != start.size() || program.grow(result.v) == 0) return result;
    if (meter.stopped()) {
      judge_again(result, program, options, meter);
      return result;
    }
    start = result.v;
  }
}

}  // namespace

std::string_view name(Inner inner) {
  const auto* const found = std::ranges::find(kNames, inner, &std::pair<Inner, std::string_view>::first);
  if (found == kNames.end()) throw std::invalid_argument("name: no such inner solver");
  return found->second;
}

std::optional<Inner> inner_from_name(std::string_view name) {
  const auto* const found = std::ranges::find(kNames, name, &std::pair<Inner, std::string_view>::second);
  if (found == kNames.end()) return std::nullopt;
  return found->first;
}

std::vector<Inner> inner_solvers() {
  std::vector<Inner> all;
  for (const auto& [inner, word] : kNames) all.push_back(inner);
  return all;
}

std::string_view name(InnerStatus status) {
  switch (status) {
    case InnerStatus::kConverged:
      return "converged";
    case InnerStatus::kLimit:
      return "limit";
    case InnerStatus::kInfeasible:
      return "infeasible";
    case InnerStatus::kStopped:
      return "stopped";
    case InnerStatus::kFailed:
      return "failed";
  }
  throw std::invalid_argument("name: no such InnerStatus");
}

InnerResult minimise(Inner inner, SmoothProgram& program, const Eigen::VectorXd& start, const InnerOptions& options,
                     Meter& meter) {
  check(program, start, options);
  const Eigen::VectorXd inside = start.cwiseMax(program.lower()).cwiseMin(program.upper());
  InnerResult nothing{.status = InnerStatus::kStopped,
                      .v = inside,
                      .objective = std::numeric_limits<double>::infinity(),
                      .violation = std::numeric_limits<double>::infinity()};
  if (meter.stopped()) return nothing;
  InnerResult result = minimise_growing(inner, program, inside, options, meter);
  if (result.v.size() == inside.size()) return result;
  // The program was not a number anywhere it was tried: the start has to do for a point.
  nothing.status = result.status == InnerStatus::kStopped ? InnerStatus::kStopped : InnerStatus::kFailed;
  nothing.evaluations = result.evaluations;
  return nothing;
}

}  // namespace modsearch
