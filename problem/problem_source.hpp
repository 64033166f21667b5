#pragma once

#include <functional>
#include <memory>
#include <modsearch/problem/files.hpp>

namespace modsearch {

/// A family of problems: always the same one, or a new instance for every random stream. All members have one library,
/// one greatest number of modules and contexts of one length. A function of the stream, safe to call from any thread.
using ProblemSource = std::function<std::shared_ptr<const DesignProblem>(Rng)>;

/// Instances of `file` for learning: a new one for every stream, or the one problem that the file describes.
/// Seed and index are drawn from all 64-bit numbers: those that people name for comparing solvers do not come up.
[[nodiscard]] ProblemSource problem_source(ProblemFile file);

/// Always instance `instance` of `file`: one of a held-out set, by its name.
[[nodiscard]] ProblemSource problem_source(const ProblemFile& file, Instance instance);

}  // namespace modsearch
