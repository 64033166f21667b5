#include <algorithm>
#include <array>
#include <modsearch/problem/attempt.hpp>
#include <utility>

namespace modsearch {
namespace {

constexpr std::array<std::pair<Level, std::string_view>, 4> kLevels{{{Level::kNone, "none"},
                                                                     {Level::kPosture, "posture"},
                                                                     {Level::kPostureSelf, "posture+self"},
                                                                     {Level::kPath, "path"}}};

}  // namespace

std::string_view name(Level level) {
  return std::find_if(kLevels.begin(), kLevels.end(), [&](const auto& entry) { return entry.first == level; })->second;
}

std::optional<Level> level_from_name(std::string_view name) {
  const auto found =
      std::find_if(kLevels.begin(), kLevels.end(), [&](const auto& entry) { return entry.second == name; });
  return found == kLevels.end() ? std::nullopt : std::optional{found->first};
}

std::string_view name(Failure failure) {
  switch (failure) {
    case Failure::kNone:
      return "none";
    case Failure::kIncomplete:
      return "incomplete";
    case Failure::kUnreachable:
      return "unreachable";
    case Failure::kProvedInfeasible:
      return "proved infeasible";
    case Failure::kLimit:
      return "limit";
    case Failure::kJump:
      return "jump";
    case Failure::kTorque:
      return "torque";
    case Failure::kObstacle:
      return "obstacle";
    case Failure::kSelfCollision:
      return "self collision";
    case Failure::kHomeInCollision:
      return "home in collision";
    case Failure::kNoPath:
      return "no path found";
    case Failure::kThrew:
      return "exception";
    case Failure::kNotANumber:
      return "not a number";
  }
  return "";
}

}  // namespace modsearch
