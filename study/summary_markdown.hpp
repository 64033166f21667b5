#pragma once

#include <modsearch/study/records.hpp>
#include <string>

namespace modsearch {

/// The tables of a comparison as Markdown, one per problem, for a README or a paper: a row per solver with the share of
/// runs that achieved the task, the interquartile mean of regret with its 95 % interval, and for the targets of 10 and
/// 1 % excess mass (all targets of mass where the study has neither) the share of runs that met it and the expected
/// evaluations and seconds to it. Below, for each trained solver and target, from how many tasks on it costs less than
/// the cheapest solver without training, and its seconds per task where 1 to 1000 tasks share the training; and what
/// regret is measured from. Resamples are drawn with a fixed seed.
[[nodiscard]] std::string summary_markdown(const StudyRecord& record);

}  // namespace modsearch
