#pragma once

#include <modsearch/study/records.hpp>
#include <string>
#include <vector>

namespace modsearch {

/// A file to be written: its path relative to a folder, and its text.
struct NamedText {
  std::string path;
  std::string text;
};

/// The runs of a study as IOHprofiler keeps them (Doerr et al. 2018), for IOHanalyzer and iohinspector: a folder per
/// solver, in it a JSON file per problem and the improvements of its runs (evaluations, score, seconds, whether
/// achieved, modules, mass [kg]), each as good as or better than those before it. What they call a function is a
/// problem of the study, numbered from 1; its instances are numbered from 1 in the study's order and occur once per
/// seed; its dimension is the largest number of types and parameters among the best designs. Scores are maximised.
///
/// Readers tell runs apart by evaluation 1, so every run has such a line: with the least double where the first
/// evaluation scored nothing, which is all there is of a run that failed.
[[nodiscard]] std::vector<NamedText> iohprofiler_files(const StudyRecord& record);

}  // namespace modsearch
