#pragma once

#include <modsearch/study/records.hpp>
#include <string>

namespace modsearch {

/// Runs x tasks as CSV: a row per solver and seed, a column per instance, for rliable and R. Final scores as they are;
/// -Inf for a run that failed or achieved nothing, NaN where there is no such run.
[[nodiscard]] std::string score_matrix_csv(const StudyRecord& record);

/// The same with the regrets of study/targets.hpp; Inf for a run that failed or achieved nothing.
[[nodiscard]] std::string regret_matrix_csv(const StudyRecord& record);

}  // namespace modsearch
