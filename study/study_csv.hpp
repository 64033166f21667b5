#pragma once

#include <modsearch/study/records.hpp>
#include <string>

namespace modsearch {

/// Every cell that has ended, one row each, with a header: what was asked, what came of it, what it cost. For pandas
/// and R. Fields that a cell does not have are empty.
[[nodiscard]] std::string runs_csv(const StudyRecord& record);

/// Every improvement of every run, one row each, with a header.
[[nodiscard]] std::string traces_csv(const StudyRecord& record);

}  // namespace modsearch
