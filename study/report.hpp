#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <modsearch/study/bootstrap.hpp>
#include <modsearch/study/records.hpp>
#include <string>

namespace modsearch {

struct ReportOptions {
  BootstrapOptions bootstrap{};  ///< of the intervals
  std::uint64_t seed = 0;        ///< of the intervals: the same journal gives the same page
  /// A 3-D page of the best design of every instance, views/CELL.html beside the report. Problems that were made by a
  /// program and not loaded from a file have none.
  bool views = true;
};

/// Where the 3-D page of a cell's result is, relative to the report: cell ID to link.
using ViewLinks = std::map<std::string, std::string>;

/// The report of a study as one HTML document that needs no other file and no network: the summary with regret and
/// certificates, distributions of runtimes against evaluations and seconds, convergence, performance and data profiles,
/// the cost of learning per task with its break-even points, every pair of solvers, every instance, and what it was
/// made with. Any text may stand in the record: none of it is read as markup or script. The hash of the page's address
/// sets its state: `theme` (light or dark), `problem` (its number, 0 for all) and `measure` (evaluations or seconds):
/// `report.html#theme=dark&measure=seconds`.
[[nodiscard]] std::string report_page(const StudyRecord& record, const ViewLinks& views,
                                      const ReportOptions& options = {});

/// Writes the report to `file` and the 3-D pages to views/ beside it. Files that the record's problems name are looked
/// for relative to the folder of `file`, where the study's journal lies; a problem that cannot be loaded has no view.
/// Throws FileError where a file cannot be written.
void write_report(const StudyRecord& record, const std::filesystem::path& file, const ReportOptions& options = {});

}  // namespace modsearch
