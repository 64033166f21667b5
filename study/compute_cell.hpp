#pragma once

#include <filesystem>
#include <modsearch/study/study.hpp>

namespace modsearch {

/// Computes `cell` of `study`, here and now: a record that is done. `folder`: where trainings leave their policies, in
/// policies/<ID of the training>.json, and where runs find them. A function of study and cell but for clock readings.
/// Throws what problem, solver or learner throw, and std::runtime_error for a training that diverged.
[[nodiscard]] CellRecord compute(const Study& study, const PlannedCell& cell, const std::filesystem::path& folder);

/// The policy of the training with this ID, relative to the study's folder.
[[nodiscard]] std::filesystem::path policy_path(const std::string& training);

}  // namespace modsearch
