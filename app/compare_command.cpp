#include <algorithm>
#include <modsearch/study/iohprofiler.hpp>
#include <modsearch/study/report.hpp>
#include <modsearch/study/run_matrix.hpp>
#include <modsearch/study/run_study.hpp>
#include <modsearch/study/study_csv.hpp>
#include <modsearch/study/study_file.hpp>
#include <modsearch/study/summary_markdown.hpp>
#include <nlohmann/json.hpp>

#include "app/commands.hpp"
#include "app/output_internal.hpp"
#include "app/study_display.hpp"
#include "app/study_names.hpp"
#include "app/study_table.hpp"

namespace modsearch::app {
namespace {

// What is made of the journal, relative to the folder of the study.
std::vector<NamedText> derived_files(const StudyRecord& record) {
  std::vector<NamedText> files{{"runs.csv", runs_csv(record)},
                               {"traces.csv", traces_csv(record)},
                               {"scores.csv", score_matrix_csv(record)},
                               {"regrets.csv", regret_matrix_csv(record)},
                               {"tables.md", summary_markdown(record)}};
  for (NamedText& file : iohprofiler_files(record)) {
    files.push_back({"iohprofiler/" + file.path, std::move(file.text)});
  }
  return files;
}

}  // namespace

Status compare(const CompareArguments& arguments, const CommonArguments& common, std::stop_token stop) {
  const Study study = load_study(arguments.study, study_names());
  const OutputLock lock = claim_folder(arguments.out);
  StudyDisplay display{common.quiet};
  const StudyRecord record = run(study, {.folder = arguments.out,
                                         .jobs = arguments.jobs,
                                         .resume = arguments.resume,
                                         .recheck = arguments.recheck,
                                         .command = common.command,
                                         .progress = [&](const StudyProgress& progress) { display.update(progress); },
                                         .stop = stop,
                                         .lock = &lock});
  display.finish();

  std::vector<std::string> written{(arguments.out / "events.jsonl").string()};
  for (const auto& [path, text] : derived_files(record)) {
    const std::filesystem::path file = arguments.out / path;
    make_folder(file.parent_path());
    write_file(file, text);
    // Of a folder its name is enough.
    const std::string name = (arguments.out / *std::filesystem::path{path}.begin()).string();
    if (written.back() != name) written.push_back(name);
  }
  write_report(record, arguments.out / "report.html");
  written.push_back((arguments.out / "report.html").string());
  if (common.json) {
    nlohmann::ordered_json json = study_json(record);
    json["files"] = written;
    print(json);
  } else {
    write_out(study_text(record));
    write_out("\n");
    for (const std::string& path : written) say("wrote        {}\n", path);
  }
  if (stop.stop_requested()) return Status::kInterrupted;
  const bool failed = std::any_of(record.cells.begin(), record.cells.end(),
                                  [](const CellRecord& cell) { return cell.state == CellState::kFailed; });
  return failed ? Status::kNegative : Status::kSuccess;
}

}  // namespace modsearch::app
