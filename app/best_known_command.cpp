#include <fmt/format.h>

#include <modsearch/study/best_known.hpp>

#include "app/commands.hpp"
#include "app/output_internal.hpp"

namespace modsearch::app {

Status best_known(const BestKnownArguments& arguments, const CommonArguments& common) {
  const std::vector<std::filesystem::path> files{arguments.files.begin(), arguments.files.end()};
  const BestKnownMerge merge = merge_best_known(arguments.tables, files);
  if (common.json) {
    nlohmann::ordered_json json;
    json["families"] = nlohmann::ordered_json::array();
    for (const BestKnownCounts& counts : merge.counts) {
      json["families"].push_back(
          {{"family", counts.family}, {"added", counts.added}, {"improved", counts.improved}, {"kept", counts.kept}});
    }
    json["refused"] = merge.refused;
    json["files"] = nlohmann::ordered_json::array();
    for (const std::filesystem::path& file : merge.written) json["files"].push_back(file.string());
    print(json);
  } else {
    for (const BestKnownCounts& counts : merge.counts) {
      say("{}: {} added, {} improved, {} not better than the known one\n", counts.family, counts.added, counts.improved,
          counts.kept);
    }
    for (const std::string& sentence : merge.refused) say("refused      {}\n", sentence);
    for (const std::filesystem::path& file : merge.written) say("wrote        {}\n", file.string());
  }
  return merge.refused.empty() ? Status::kSuccess : Status::kNegative;
}

}  // namespace modsearch::app
