#include <fmt/format.h>

#include <algorithm>
#include <modsearch/problem/markup.hpp>
#include <modsearch/study/html_internal.hpp>
#include <modsearch/study/page_assets_internal.hpp>
#include <modsearch/study/report.hpp>
#include <modsearch/study/report_data_internal.hpp>
#include <modsearch/study/solution_page.hpp>
#include <modsearch/study/study_runs.hpp>

namespace modsearch {
namespace {

// ID or path from which the problem of a journal in `folder` can be loaded.
std::string located(const std::string& location, const std::filesystem::path& folder) {
  const std::vector<std::string> builtin = builtin_problems();
  if (std::find(builtin.begin(), builtin.end(), location) != builtin.end()) return location;
  return (folder / location).string();
}

// The 3-D page of the result of `cell`, computed anew from its design.
std::string view_page(const StudyFacts& study, const CellRecord& cell, const ProblemFile& file) {
  const std::shared_ptr<const RobotProblem> problem = file.instance(cell.key.instance.value_or(Instance{}));
  SolutionRecord solution;
  solution.problem = cell.key.problem;
  solution.instance = cell.key.instance;
  solution.design = design_of(problem->library(), cell.outcome->design);
  solution.X_WB = problem->spec().X_WB;
  solution.evaluation = problem->evaluate(solution.design, Fidelity::kFull, cell.outcome->witness);
  solution.solver = cell.key.label;
  solution.seed = cell.key.seed;
  solution.evaluations = cell.outcome->spent.evaluations;
  solution.seconds = cell.outcome->spent.seconds;
  PageContext context{
      .path = solution.evaluation.attempt.path, .sampling = file.sampling, .trace = {}, .command = study.command};
  for (const Improvement& found : cell.trace) {
    context.trace.push_back({found.evaluations, found.seconds, found.score, found.achieved});
  }
  return write_page(page_of_solution(*problem, solution, context));
}

// Writes the view of the best design of every instance whose problem can be loaded.
ViewLinks write_views(const StudyRecord& record, const std::filesystem::path& folder) {
  ViewLinks links;
  std::map<std::string, std::optional<ProblemFile>> files;
  for (const ProblemFacts& problem : record.study.problems) {
    if (problem.location.empty()) continue;
    try {
      files[problem.name] = load_problem_file(located(problem.location, folder));
    } catch (const FileError&) {
      // The journal may have travelled without the problem's file; the numbers stand all the same.
    }
  }
  for (const InstanceFacts& facts : runs_of(record).instances) {
    if (facts.best == nullptr || !files[facts.problem]) continue;
    const std::string link = fmt::format("views/{}.html", facts.best->id);
    std::filesystem::create_directories(folder / "views");
    write_file(folder / link, view_page(record.study, *facts.best, *files[facts.problem]));
    links[facts.best->id] = link;
  }
  return links;
}

}  // namespace

std::string report_page(const StudyRecord& record, const ViewLinks& views, const ReportOptions& options) {
  const std::string title = markup_safe(record.study.name + ": a comparison of solvers");
  const std::string data = script_safe(report_data(record, views, options));
  const std::pair<std::string_view, std::string_view> parts[] = {{"title", title},
                                                                 {"css", page_assets::report_css},
                                                                 {"data", data},
                                                                 {"chart", page_assets::chart},
                                                                 {"script", page_assets::report_script}};
  return fill_html(page_assets::report_html, parts);
}

void write_report(const StudyRecord& record, const std::filesystem::path& file, const ReportOptions& options) {
  const std::filesystem::path folder = file.parent_path();
  const ViewLinks views = options.views ? write_views(record, folder) : ViewLinks{};
  write_file(file, report_page(record, views, options));
}

}  // namespace modsearch
