#include <fmt/format.h>

#include <algorithm>
#include <modsearch/problem/json_internal.hpp>
#include <modsearch/study/study.hpp>
#include <stdexcept>

namespace modsearch {
namespace {

// The texts that a problem file is made of: its own and those of the task and the library it names. Of a built-in one
// nothing: the version says it.
std::string content_of(const std::string& file_or_id) {
  const std::vector<std::string> builtin = builtin_problems();
  if (std::find(builtin.begin(), builtin.end(), file_or_id) != builtin.end()) return {};
  const detail::JsonDocument document = detail::load_json(file_or_id);
  std::string content = document.root.dump();
  for (const char* part : {"task", "library"}) {
    if (!document.root.contains(part) || !document.root[part].is_string()) continue;
    const std::filesystem::path file = document.source->directory / document.root[part].get<std::string>();
    if (std::filesystem::is_regular_file(file)) content += '\n' + detail::read_text(file, file.string());
  }
  return content;
}

}  // namespace

StudyProblem study_problem(const std::string& file_or_id, std::optional<InstanceRange> instances) {
  ProblemFile file = load_problem_file(file_or_id);
  if (instances && !file.sampled()) {
    throw std::invalid_argument(fmt::format("study: problem '{}' is not sampled: it has no instances", file_or_id));
  }
  if (!instances && file.sampled()) instances = InstanceRange{.count = 1};
  return {.name = file_or_id,
          .instances = instances,
          .make = [file = std::move(file)](Instance instance) -> std::shared_ptr<const DesignProblem> {
            return file.instance(instance);
          },
          .location = file_or_id,
          .content = content_of(file_or_id)};
}

}  // namespace modsearch
