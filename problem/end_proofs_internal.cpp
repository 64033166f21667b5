#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <modsearch/problem/end_proofs_internal.hpp>
#include <modsearch/problem/reach_bound.hpp>
#include <modsearch/problem/sure_overlap_internal.hpp>
#include <numbers>

namespace modsearch::detail {
namespace {

constexpr double kMargin = 1e-6;  // [m] and [rad]: far above what rounding adds

constexpr double kQuarter = 0.5 * std::numbers::pi;  // [rad]

// From one pose of the tip to another, as all arms see it.
struct Way {
  double turn = 0.0;  // [rad]
  Eigen::Vector3d axis_W = Eigen::Vector3d::UnitZ();
  double loose = 0.0;                                 // how far the tolerances may change the turn [rad]
  Eigen::Vector3d shift_W = Eigen::Vector3d::Zero();  // [m]
  double slack = 0.0;                                 // and the shift [m]

  Way(const PoseEnclosure& from, const PoseEnclosure& to)
      : loose{from.angle + to.angle + kMargin},
        shift_W{to.X_WC.translation() - from.X_WC.translation()},
        slack{from.position_radius + to.position_radius + kMargin} {
    const Eigen::AngleAxisd turned{Eigen::Matrix3d{to.X_WC.linear() * from.X_WC.linear().transpose()}};
    turn = std::abs(turned.angle());
    axis_W = turned.axis();
  }
  [[nodiscard]] bool turns() const { return turn > loose; }
  [[nodiscard]] bool moves() const { return turns() || shift_W.norm() > slack; }
  // How far the axis of a single joint may be off axis_W: a direction w that the true turn leaves in place is carried
  // by 2 sin(turn / 2) sin(angle to the axis) by this one, and by no more than `loose`. 90 degrees: anything goes.
  [[nodiscard]] double off_axis() const {
    if (!turns()) return kQuarter;
    const double sine = loose / (2.0 * std::sin(0.5 * std::min(turn, 2.0 * kQuarter)));
    return sine < 1.0 ? std::asin(sine) : kQuarter;
  }
  // No turn about one axis does this: it would move the tip along the axis.
  [[nodiscard]] bool is_a_screw() const {
    const double off = off_axis();
    if (off >= kQuarter) return false;
    return std::abs(axis_W.dot(shift_W)) - 2.0 * std::sin(0.5 * off) * shift_W.norm() > slack;
  }
};

bool share_an_axis(const Way& a, const Way& b) {
  const double between = std::acos(std::min(1.0, std::abs(a.axis_W.dot(b.axis_W))));
  return between <= a.off_axis() + b.off_axis() + kMargin;
}

bool moves(const ModuleType& module) {
  return std::any_of(module.joints.begin(), module.joints.end(), [](const ModuleJoint& joint) { return !joint.fixed; });
}

// Rounded downwards.
std::string millimetres(double depth) { return fmt::format("{:.2f} mm", std::floor(1e5 * depth) / 100.0); }

bool deeper(const CertainOverlap& a, const CertainOverlap& b) { return a.depth > b.depth; }

}  // namespace

std::vector<std::optional<PoseEnclosure>> enclosures(const Task& task) {
  std::vector<std::optional<PoseEnclosure>> result;
  for (const Goal& goal : task.goals()) result.push_back(enclosure(goal.region));
  return result;
}

int least_joints(const std::vector<std::optional<PoseEnclosure>>& goals) {
  std::vector<Way> ways;
  for (std::size_t a = 0; a < goals.size(); ++a) {
    for (std::size_t b = a + 1; b < goals.size(); ++b) {
      if (goals[a] && goals[b]) ways.emplace_back(*goals[a], *goals[b]);
    }
  }
  if (std::none_of(ways.begin(), ways.end(), [](const Way& way) { return way.moves(); })) return 0;
  if (std::none_of(ways.begin(), ways.end(), [](const Way& way) { return way.turns(); })) return 1;  // one may slide
  for (const Way& way : ways) {
    if (way.is_a_screw()) return 2;
    if (std::any_of(ways.begin(), ways.end(), [&](const Way& other) { return !share_an_axis(way, other); })) return 2;
  }
  return 1;
}

EndProofs::EndProofs(const ModuleLibrary& library, const RigidEnds& ends, const Task& task, const Scene& scene,
                     const Eigen::Isometry3d& X_WB, const std::vector<std::optional<PoseEnclosure>>& goals)
    : library_{library}, ends_{ends}, task_{task}, scene_{scene}, last_(goals.size()) {
  // The base alone, which comes last: out of reach of a goal it is no design that matters.
  const double reach = module_span(library.base()).greatest_length() + kMargin;
  const bool bare_reaches = std::all_of(goals.begin(), goals.end(), [&](const std::optional<PoseEnclosure>& goal) {
    return !goal || (goal->X_WC.translation() - X_WB.translation()).norm() - goal->position_radius <= reach;
  });
  n_last_ = ends.n_last - (library.complete({}) && !bare_reaches ? 1 : 0);
  needs_joint_ = !moves(library.base()) && least_joints(goals) > 0;
  judge_heads(X_WB);
  judge_tails(goals);
  conclude();
}

std::optional<CertainOverlap> EndProofs::overlap(const RigidModule& module, const PoseEnclosure& poses,
                                                 int goal) const {
  std::optional<CertainOverlap> deepest;
  for (std::size_t i = 0; i < scene_.obstacles().size(); ++i) {
    const std::optional<double> depth = sure_overlap(module, poses, scene_.obstacles()[i]);
    if (!depth || (deepest && deepest->depth >= *depth)) continue;
    deepest = CertainOverlap{.goal = goal, .obstacle = static_cast<int>(i), .module = module.type, .depth = *depth};
  }
  return deepest;
}

void EndProofs::judge_heads(const Eigen::Isometry3d& X_WB) {
  if (!is_rotation(X_WB.linear())) return;
  const std::vector<Place> here{{PoseEnclosure{.X_WC = X_WB}, -1}};
  heads_.resize(ends_.heads.size());
  judge(ends_.heads, 0, here, false, heads_);
  if (std::none_of(heads_.begin(), heads_.end(), [](const auto& verdict) { return verdict.has_value(); })) {
    heads_.clear();
  }
}

void EndProofs::judge_tails(const std::vector<std::optional<PoseEnclosure>>& goals) {
  std::vector<Place> places;
  for (std::size_t goal = 0; goal < goals.size(); ++goal) {
    if (!goals[goal]) continue;
    const PoseEnclosure& poses = *goals[goal];
    // Where the tip may point anywhere, nothing but the tip itself stays where it is.
    const bool any_direction = poses.turn >= 1.0 && poses.off_axis.minCoeff() >= 1.0;
    if (any_direction && !(scene_.clearance(poses.X_WC.translation()) < 0.0)) continue;
    places.push_back({poses, static_cast<int>(goal)});
  }
  if (places.empty()) return;
  tails_.resize(ends_.tails.size());
  for (int i = 0; i < n_last_; ++i) judge(ends_.tails, i, places, true, tails_);
  if (std::none_of(tails_.begin(), tails_.end(), [](const auto& verdict) { return verdict.has_value(); })) {
    tails_.clear();
  }
}

// A module is ruled out by an overlap of its own, or with all that may come next to it. What is next to the first
// module is judged in any case, because it may rule out arms of its own; what lies deeper only for this conclusion.
void EndProofs::judge(const std::vector<RigidModule>& tree, int at, const std::vector<Place>& places, bool tail,
                      Verdicts& verdicts) {
  const RigidModule& module = tree[static_cast<std::size_t>(at)];
  std::optional<CertainOverlap>& verdict = verdicts[static_cast<std::size_t>(at)];
  for (const Place& place : places) {
    const std::optional<CertainOverlap> found = overlap(module, place.poses, place.goal);
    if (!found) continue;
    if (tail && module.outer < 0) last_[static_cast<std::size_t>(place.goal)].push_back(*found);
    if (!verdict || deeper(*found, *verdict)) verdict = found;
  }
  if (verdict) return;
  // Arms of a library without end effectors end anywhere, and so may begin with this module and nothing else.
  const bool may_be_all = tail ? module.whole_arm && !needs_joint_ : !library_.has_end_effectors();
  bool all = module.extended && !module.inner.empty() && !may_be_all;
  std::optional<CertainOverlap> shallowest;
  for (const int inner : module.inner) {
    if (!all && module.outer >= 0) break;
    judge(tree, inner, places, tail, verdicts);
    const std::optional<CertainOverlap>& theirs = verdicts[static_cast<std::size_t>(inner)];
    all = all && theirs;
    if (theirs && (!shallowest || deeper(*shallowest, *theirs))) shallowest = theirs;
  }
  if (all) verdict = shallowest;
}

bool EndProofs::rules_out_end(int k) const {
  for (int i = 0; i < n_last_ && !tails_.empty(); ++i) {
    if (ends_.tails[static_cast<std::size_t>(i)].type == k) return tails_[static_cast<std::size_t>(i)].has_value();
  }
  return false;
}

std::string EndProofs::ruled_out(std::span<const int> types, bool whole) const {
  if (infeasible_) return infeasible_->reason;
  if (!heads_.empty()) {
    std::string why = reason(ends_.heads, heads_, 0, std::vector<int>(types.begin(), types.end()));
    if (!why.empty()) return why;
  }
  if (tails_.empty() || !whole) return "";
  const int last = types.empty() ? RigidModule::kBase : types.back();
  int at = 0;
  while (at < n_last_ && ends_.tails[static_cast<std::size_t>(at)].type != last) ++at;
  if (at == n_last_) return "";
  std::vector<int> inwards(types.rbegin(), types.rend());
  if (!inwards.empty()) inwards.erase(inwards.begin());
  return reason(ends_.tails, tails_, at, inwards);
}

// Of the innermost module that is ruled out: the others are for what follows from it, or before it.
std::string EndProofs::reason(const std::vector<RigidModule>& tree, const Verdicts& verdicts, int at,
                              const std::vector<int>& inwards) const {
  const std::optional<CertainOverlap>* found = nullptr;
  for (std::size_t i = 0;; ++i) {
    const std::optional<CertainOverlap>& verdict = verdicts[static_cast<std::size_t>(at)];
    if (verdict) found = &verdict;
    const std::vector<int>& inner = tree[static_cast<std::size_t>(at)].inner;
    const auto next = std::find_if(inner.begin(), inner.end(), [&](int j) {
      return i < inwards.size() && tree[static_cast<std::size_t>(j)].type == inwards[i];
    });
    if (next == inner.end()) return found == nullptr ? "" : described(**found);
    at = *next;
  }
}

void EndProofs::conclude() {
  if (!heads_.empty() && heads_.front()) {
    infeasible_ = infeasibility(*heads_.front(), "whatever the arm: " + described(*heads_.front()));
    return;
  }
  if (tails_.empty() || n_last_ == 0) return;
  const auto n_last = static_cast<std::size_t>(n_last_);
  const std::string_view end = library_.has_end_effectors() ? "end effector" : "last module";
  const auto list = [&](std::vector<CertainOverlap> overlaps, const auto& words) {
    constexpr std::size_t kShown = 4;
    std::string text;
    for (std::size_t i = 0; i < std::min(kShown, overlaps.size()); ++i) {
      text += (i == 0 ? "" : ", ") + words(overlaps[i]);
    }
    if (overlaps.size() > kShown) text += fmt::format(" and {} more", overlaps.size() - kShown);
    return text;
  };
  for (std::vector<CertainOverlap> overlaps : last_) {
    if (overlaps.size() < n_last) continue;
    std::stable_sort(overlaps.begin(), overlaps.end(), [](const auto& a, const auto& b) { return deeper(b, a); });
    const CertainOverlap& shallowest = overlaps.front();
    const std::string& goal = task_.goals()[static_cast<std::size_t>(shallowest.goal)].id;
    const std::string& obstacle = scene_.obstacles()[static_cast<std::size_t>(shallowest.obstacle)].name;
    const bool one = std::all_of(overlaps.begin(), overlaps.end(),
                                 [&](const CertainOverlap& each) { return each.obstacle == shallowest.obstacle; });
    if (one) {
      const std::string ends = list(overlaps, [&](const CertainOverlap& each) {
        return fmt::format("{} overlaps it by at least {}", name_of(each.module), millimetres(each.depth));
      });
      infeasible_ = infeasibility(
          shallowest, fmt::format("goal '{}' lies in obstacle '{}' for every {}: {}", goal, obstacle, end, ends));
    } else {
      const std::string ends = list(overlaps, [&](const CertainOverlap& each) {
        return fmt::format("{} overlaps '{}' by at least {}", name_of(each.module),
                           scene_.obstacles()[static_cast<std::size_t>(each.obstacle)].name, millimetres(each.depth));
      });
      infeasible_ =
          infeasibility(shallowest, fmt::format("goal '{}' lies in an obstacle for every {}: {}", goal, end, ends));
    }
    return;
  }
  // At different goals, or for what may come next to them.
  std::string reasons;
  const CertainOverlap* shallowest = nullptr;
  for (std::size_t i = 0; i < n_last; ++i) {
    if (!tails_[i]) return;
    const CertainOverlap& overlap = *tails_[i];
    if (shallowest == nullptr || deeper(*shallowest, overlap)) shallowest = &overlap;
    if (i > 0) reasons += "; ";
    const int last = ends_.tails[i].type;
    if (overlap.module != last) reasons += fmt::format("with {}, what is before it: at best ", name_of(last));
    reasons += described(overlap);
  }
  infeasible_ = infeasibility(*shallowest, fmt::format("no {} is possible: {}", end, reasons));
}

std::string EndProofs::name_of(int module) const {
  return module == RigidModule::kBase ? fmt::format("the base {}", library_.base().id) : library_.type(module).id;
}

std::string EndProofs::described(const CertainOverlap& overlap) const {
  const std::string& obstacle = scene_.obstacles()[static_cast<std::size_t>(overlap.obstacle)].name;
  const std::string where =
      overlap.goal < 0 ? "" : fmt::format(" at goal '{}'", task_.goals()[static_cast<std::size_t>(overlap.goal)].id);
  return fmt::format("{} overlaps obstacle '{}'{} by at least {}", name_of(overlap.module), obstacle, where,
                     millimetres(overlap.depth));
}

Infeasibility EndProofs::infeasibility(const CertainOverlap& overlap, std::string reason) const {
  Infeasibility result{.reason = std::move(reason)};
  result.goal = overlap.goal;
  if (overlap.goal >= 0) result.goal_id = task_.goals()[static_cast<std::size_t>(overlap.goal)].id;
  result.obstacle = overlap.obstacle;
  result.obstacle_name = scene_.obstacles()[static_cast<std::size_t>(overlap.obstacle)].name;
  result.module = overlap.module;
  result.module_id = overlap.module == RigidModule::kBase ? library_.base().id : library_.type(overlap.module).id;
  result.depth = overlap.depth;
  return result;
}

}  // namespace modsearch::detail
