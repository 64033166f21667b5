#pragma once

#include <modsearch/study/report.hpp>
#include <nlohmann/json.hpp>

namespace modsearch {

/// Everything that the report's script draws. Numbers have six digits; what is infinite is null, which in regrets and
/// runtimes means "never".
[[nodiscard]] nlohmann::json report_data(const StudyRecord& record, const ViewLinks& views,
                                         const ReportOptions& options);

}  // namespace modsearch
