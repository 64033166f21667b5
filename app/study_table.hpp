#pragma once

#include <modsearch/study/records.hpp>
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace modsearch::app {

/// What a study came to, one object per problem: for each solver its runs, those that achieved the task, medians of
/// score, regret of those, evaluations and seconds, and what its training took. Regret is as in the report: against the
/// bound of the instance where there is one, else against the best score of the study.
[[nodiscard]] nlohmann::ordered_json study_json(const StudyRecord& record);

/// The same for people, a table per problem.
[[nodiscard]] std::string study_text(const StudyRecord& record);

}  // namespace modsearch::app
