#pragma once

#include <modsearch/study/study_file.hpp>

namespace modsearch::app {

/// Solvers and agents of study files are those of the command line.
[[nodiscard]] StudyNames study_names();

}  // namespace modsearch::app
