#include <fmt/format.h>

#include <algorithm>
#include <modsearch/problem/task_frames_internal.hpp>

namespace modsearch::detail {
namespace {

void check_name(const std::string& name, const JsonCursor& frame) {
  if (name == "world" || name == "nominal") frame.fail(fmt::format("the frame \"{}\" is there already", name));
  if (name.find('.') != std::string::npos) {
    frame.fail(fmt::format("the name {} has a dot, which is kept for the frames of goals (goal.ID)", preview(name)));
  }
}

}  // namespace

TaskFrames::TaskFrames(const JsonCursor& frames) {
  std::vector<std::pair<std::string, JsonCursor>> open = frames.members();
  for (const auto& [name, frame] : open) {
    frame.expect_keys({"parent", "transformation"});
    check_name(name, frame);
  }
  while (!open.empty()) {
    // Those whose parents are known. What never gets one hangs on itself, or on a frame that does not exist.
    const auto rest = std::stable_partition(open.begin(), open.end(), [&](const auto& each) {
      return X_WF_.contains(each.second.text_or("parent", "world"));
    });
    if (rest == open.begin()) {
      const JsonCursor parent = open.front().second.at("parent");
      const bool exists = frames.has(parent.text());
      parent.fail_value(exists ? "a frame that leads to the world: it hangs on itself" : "the name of a frame");
    }
    std::map<std::string, Eigen::Isometry3d> added;
    std::for_each(open.begin(), rest, [&](const auto& each) {
      const std::optional<JsonCursor> X = each.second.find("transformation");
      const Eigen::Isometry3d X_PF = X ? X->pose() : Eigen::Isometry3d::Identity();
      added[each.first] = X_WF_.at(each.second.text_or("parent", "world")) * X_PF;
    });
    X_WF_.merge(added);
    open.erase(open.begin(), rest);
  }
}

Eigen::Isometry3d TaskFrames::at(const JsonCursor& name) const {
  const auto found = X_WF_.find(name.text());
  if (found != X_WF_.end()) return found->second;
  std::string known;
  for (const auto& [each, X] : X_WF_) known += (known.empty() ? "" : ", ") + each;
  name.fail_value(fmt::format("the name of a frame (known here: {})", known));
}

}  // namespace modsearch::detail
