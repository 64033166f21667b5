#include <fmt/format.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <modsearch/problem/convert.hpp>
#include <modsearch/problem/nearest_miss.hpp>
#include <modsearch/solvers/verification.hpp>
#include <modsearch/study/page.hpp>
#include <modsearch/study/solution_page.hpp>

#include "arrays.hpp"
#include "bindings.hpp"
#include "named_design.hpp"

namespace modsearch::python {
namespace {

using namespace nb::literals;

std::optional<Eigen::Vector3d> target_of(const RobotProblem& problem, const std::optional<Origin>& origin) {
  if (!origin || !origin->sampling) return std::nullopt;
  for (const Goal& goal : problem.task().goals()) {
    if (goal.id == origin->sampling->goal) return goal.position();
  }
  return std::nullopt;
}

/// A solution as its file says it. `facts`: what Solution knows of the search.
SolutionRecord record_of(nb::handle problem_object, const std::string& reference, nb::handle design,
                         const Evaluation& evaluation, const nb::dict& facts) {
  const auto& problem = nb::cast<const RobotProblem&>(problem_object);
  const std::optional<Origin> origin = origin_of(problem_object);
  SolutionRecord record;
  record.problem = reference;
  if (origin) record.instance = origin->instance;
  record.target = target_of(problem, origin);
  record.design = design_from(problem.library(), design);
  record.X_WB = problem.base_pose(record.design);
  record.evaluation = evaluation;
  record.verified = nb::cast<std::string>(facts["verified"]);
  record.solver = nb::cast<std::string>(facts["solver"]);
  for (const auto& [key, value] : nb::cast<std::map<std::string, std::string>>(facts["options"])) {
    record.solver_options.emplace_back(key, value);
  }
  record.seed = nb::cast<std::uint64_t>(facts["seed"]);
  record.evaluations = nb::cast<std::int64_t>(facts["evaluations"]);
  record.seconds = nb::cast<double>(facts["seconds"]);
  return record;
}

std::string solution_json(nb::handle problem, const std::string& reference, nb::handle design,
                          const Evaluation& evaluation, const nb::dict& facts) {
  return solution_to_json(nb::cast<const RobotProblem&>(problem),
                          record_of(problem, reference, design, evaluation, facts));
}

std::string page(nb::handle problem_object, nb::handle design, const Evaluation& evaluation, const nb::dict& facts) {
  const auto& problem = nb::cast<const RobotProblem&>(problem_object);
  const std::optional<Origin> origin = origin_of(problem_object);
  const SolutionRecord record =
      record_of(problem_object, origin ? origin->reference : problem.name(), design, evaluation, facts);
  std::vector<TracePoint> trace;
  const Eigen::MatrixXd rows = to_matrix(facts["trace"], "trace");
  for (Eigen::Index i = 0; i < rows.rows() && rows.cols() == 4; ++i) {
    trace.push_back({static_cast<std::int64_t>(rows(i, 0)), rows(i, 1), rows(i, 2), rows(i, 3) != 0.0});
  }
  return write_page(page_of_solution(problem, record,
                                     {.path = evaluation.attempt.path,
                                      .sampling = origin ? origin->sampling : std::nullopt,
                                      .trace = trace,
                                      .command = nb::cast<std::string>(facts["command"]),
                                      .reason = nearest_miss(problem, record.design, evaluation).words()}));
}

Verification verified(const RobotProblem& problem, nb::handle design, std::optional<double> score,
                      std::optional<bool> achieved, nb::handle postures, const std::optional<Path>& path,
                      double refinement) {
  const Design resolved_design = design_from(problem.library(), design);
  Claims claims{.score = score, .achieved = achieved};
  if (!postures.is_none()) {
    Eigen::MatrixXd given = to_matrix(postures, "postures");
    if (given.rows() > 0) claims.postures = std::move(given);
  }
  claims.path = path;
  const nb::gil_scoped_release released;
  return verify(problem, resolved_design, claims, {.refinement = refinement});
}

nb::dict loaded(const std::string& file, const std::optional<std::string>& problem) {
  const LoadedSolution solution = load_solution(file, problem);
  const SolutionRecord& record = solution.record;
  nb::dict result;
  result["problem_reference"] = record.problem;
  result["instance"] =
      record.instance ? nb::object(nb::make_tuple(record.instance->seed, record.instance->index)) : nb::none();
  result["design"] = named(solution.problem->library(), record.design);
  result["evaluation"] = record.evaluation;
  result["claims"] = solution.claims;
  result["verified"] = record.verified;
  result["solver"] = record.solver;
  nb::dict options;
  for (const auto& [key, value] : record.solver_options) options[nb::str(key.c_str())] = value;
  result["options"] = options;
  result["seed"] = record.seed;
  result["evaluations"] = record.evaluations;
  result["seconds"] = record.seconds;
  return result;
}

std::string converted(nb::handle file, const std::string& to, nb::handle library, nb::handle folder) {
  const std::optional<FileFormat> format = file_format_from_name(to);
  if (!format) throw std::invalid_argument(fmt::format("to: '{}' is not one of modsearch, timor, cobra, urdf", to));
  ConvertOptions options{.to = *format};
  if (!library.is_none()) options.library = reference_from(library);
  options.folder = reference_from(folder);
  return convert(reference_from(file), options);
}

}  // namespace

void bind_files(nb::module_& m) {
  m.def(
      "convert", &converted, "file"_a, "to"_a, nb::kw_only(), "library"_a = nb::none(), "folder"_a = ".",
      nb::sig("def convert(file: str | os.PathLike[str], to: typing.Literal['modsearch', 'timor', 'cobra', 'urdf'], *, "
              "library: str | os.PathLike[str] | None = None, folder: str | os.PathLike[str] = '.') -> str"),
      "A file, or a built-in library or problem by its ID, as text of another format: libraries, tasks, problems, "
      "designs\nand solutions. `library`: of a design that names none. `folder`: where the text will lie, for the "
      "files it refers to.\nRaises FileError, one sentence, for what cannot be read or said in that format.");
  m.def("_solution_json", &solution_json, "problem"_a, "reference"_a, "design"_a, "evaluation"_a, "facts"_a);
  m.def("_solution_page", &page, "problem"_a, "design"_a, "evaluation"_a, "facts"_a);
  m.def("_load_solution", &loaded, "file"_a, "problem"_a.none());
  m.def(
      "_write_file", [](const std::string& file, const std::string& text) { write_file(file, text); }, "file"_a,
      "text"_a);
  m.def("_verify", &verified, "problem"_a, "design"_a, "score"_a.none(), "achieved"_a.none(), "postures"_a.none(),
        "path"_a.none(), "refinement"_a);
  m.def("_with_path", &with_path, "evaluation"_a, "verification"_a);
}

}  // namespace modsearch::python
