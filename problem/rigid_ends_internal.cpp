#include <algorithm>
#include <modsearch/problem/pose_enclosure_internal.hpp>
#include <modsearch/problem/rigid_ends_internal.hpp>
#include <optional>
#include <set>
#include <variant>

namespace modsearch::detail {
namespace {

using Coupling = ModuleLibrary::Coupling;
using Passage = ModuleLibrary::Passage;

constexpr int kDeepest = 3;          // modules of an end: of the built-in libraries, few deeper ones ever overlap first
constexpr std::size_t kMost = 2000;  // modules in a tree, which bounds the work on libraries of many types

Eigen::Isometry3d facing() {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.linear() = Eigen::Vector3d(1.0, -1.0, -1.0).asDiagonal();
  return X;
}

const Connector& connector_of(const ModuleType& module, int body, int connector) {
  return module.bodies[static_cast<std::size_t>(body)].connectors[static_cast<std::size_t>(connector)];
}

bool turns_by_rotations(const ParametricPose& X) {
  return is_rotation(X.head.rotation) &&
         std::all_of(X.turns.begin(), X.turns.end(), [](const auto& turn) { return is_rotation(turn.after.rotation); });
}

// The bodies of a module that one of them carries, and where they are in R. Parameters are counted from `shift` on.
class Carried {
 public:
  Carried(const ModuleType& module, int shift) : module_{module}, shift_{shift}, X_RB_(module.bodies.size()) {}

  void add(int body, const ParametricPose& X_RB) {
    const ModuleBody& given = module_.bodies[static_cast<std::size_t>(body)];
    X_RB_[static_cast<std::size_t>(body)] = X_RB;
    for (const BodyGeometry& geometry : given.collision) {
      RigidPart part{geometry.shape.shifted(shift_), X_RB * geometry.X_FG.shifted(shift_)};
      if (turns_by_rotations(part.X_RG)) parts_.push_back(std::move(part));
    }
    for (const ModuleJoint& joint : module_.joints) {
      if (!joint.fixed || (joint.parent != body && joint.child != body)) continue;
      const int other = joint.parent == body ? joint.child : joint.parent;
      if (X_RB_[static_cast<std::size_t>(other)]) continue;
      const ParametricPose X_PC = ParametricPose{joint.X_PJ} * ParametricPose::turn(joint.angle) * joint.X_JC;
      add(other, X_RB * (joint.parent == body ? X_PC : X_PC.inverse()).shifted(shift_));
    }
  }
  /// Where a body is; empty if a joint lies before it.
  [[nodiscard]] const std::optional<ParametricPose>& at(int body) const {
    return X_RB_[static_cast<std::size_t>(body)];
  }
  [[nodiscard]] std::vector<RigidPart> parts() && { return std::move(parts_); }

 private:
  const ModuleType& module_;
  int shift_;
  std::vector<std::optional<ParametricPose>> X_RB_;
  std::vector<RigidPart> parts_;
};

// A module that is to be added: what is beyond it in the tree, and where it is joined.
struct Open {
  int index = 0;
  int depth = 1;
  ParametricPose X_RO;  // the free connector of the module `index`, facing the next
  Coupling free{};      // heads: the same for the library's rules
};

class Growing {
 public:
  explicit Growing(const ModuleLibrary& library)
      : library_{library}, passages_(static_cast<std::size_t>(library.n_types())) {
    find_couplings();
  }

  RigidEnds ends() && {
    grow_tails();
    grow_heads();
    return std::move(ends_);
  }

 private:
  [[nodiscard]] const ModuleType& type(int k) const {
    return k == RigidModule::kBase ? library_.base() : library_.type(k);
  }

  // Free ends that an arm can have, and how each type is gone through: only where that is the same at all of them.
  void find_couplings() {
    std::vector<Coupling> open{library_.base_coupling()};
    couplings_.insert(open.front());
    std::vector<bool> ambiguous(passages_.size(), false);
    while (!open.empty()) {
      const Coupling free = open.back();
      open.pop_back();
      for (int k = 0; k < library_.n_types(); ++k) {
        const std::optional<Passage> passage = library_.passage(free, k);
        if (!passage) continue;
        std::optional<Passage>& known = passages_[static_cast<std::size_t>(k)];
        if (known && !(*known == *passage)) ambiguous[static_cast<std::size_t>(k)] = true;
        known = passage;
        const Coupling next = *library_.coupling_after(free, k);
        if (couplings_.insert(next).second) open.push_back(next);
      }
    }
    for (std::size_t k = 0; k < passages_.size(); ++k) {
      if (ambiguous[k]) passages_[k].reset();
    }
  }

  // Adds a module behind `outer` and says where the next one joins it; empty if a joint lies between.
  std::optional<ParametricPose> add(std::vector<RigidModule>& tree, int k, int outer, int from_body,
                                    const AffinePose& X_BC_from, const ParametricPose& X_RC, int to_body,
                                    const AffinePose& X_BC_to) {
    RigidModule added{.type = k, .outer = outer};
    const ModuleType& module = type(k);
    const Eigen::Index before = outer < 0 ? 0 : tree[static_cast<std::size_t>(outer)].lower.size();
    added.lower.resize(before + module.n_parameters());
    added.upper.resize(before + module.n_parameters());
    if (before > 0) {
      added.lower.head(before) = tree[static_cast<std::size_t>(outer)].lower;
      added.upper.head(before) = tree[static_cast<std::size_t>(outer)].upper;
    }
    for (int i = 0; i < module.n_parameters(); ++i) {
      added.lower[before + i] = module.parameters[static_cast<std::size_t>(i)].lower;
      added.upper[before + i] = module.parameters[static_cast<std::size_t>(i)].upper;
    }
    const int shift = static_cast<int>(before);
    Carried carried{module, shift};
    carried.add(from_body, X_RC * X_BC_from.shifted(shift).inverse());
    std::optional<ParametricPose> X_RO = carried.at(to_body);
    if (X_RO) X_RO = *X_RO * X_BC_to.shifted(shift);
    added.parts = std::move(carried).parts();
    tree.push_back(std::move(added));
    return X_RO;
  }

  // From the tip inwards: entered by the exit.
  std::optional<ParametricPose> add_tail(int k, const Passage& p, int outer, const ParametricPose& X_RC) {
    const ModuleType& module = type(k);
    return add(ends_.tails, k, outer, p.exit_body, connector_of(module, p.exit_body, p.exit_connector).X_BC, X_RC,
               p.entry_body, connector_of(module, p.entry_body, p.entry_connector).X_BC);
  }

  void grow_tails() {
    std::vector<Open> open;
    const auto begin = [&](int k, const std::optional<Passage>& passage) {
      const int index = static_cast<int>(ends_.tails.size());
      if (!passage) {  // nothing is known of it: never ruled out
        ends_.tails.push_back({.type = k});
        return;
      }
      const std::optional<ParametricPose> X_RI = add_tail(k, *passage, -1, ParametricPose{});
      if (X_RI && k != RigidModule::kBase) open.push_back({index, 1, *X_RI * ParametricPose{facing()}});
    };
    for (int k = 0; k < library_.n_types(); ++k) {
      const bool reached = std::any_of(couplings_.begin(), couplings_.end(),
                                       [&](const Coupling& free) { return library_.passage(free, k).has_value(); });
      if (reached && library_.complete(std::span{&k, 1})) begin(k, passages_[static_cast<std::size_t>(k)]);
    }
    if (library_.complete({})) begin(RigidModule::kBase, library_.base_passage());
    ends_.n_last = static_cast<int>(ends_.tails.size());
    for (std::size_t i = 0; i < open.size(); ++i) extend_tail(Open{open[i]}, open);
  }

  void extend_tail(const Open& at, std::vector<Open>& open) {
    const int k = ends_.tails[static_cast<std::size_t>(at.index)].type;
    const bool whole_arm = library_.coupling_after(library_.base_coupling(), k).has_value();
    ends_.tails[static_cast<std::size_t>(at.index)].whole_arm = whole_arm;
    const std::vector<int> before = types_before(k);
    const bool known = std::all_of(before.begin(), before.end(),
                                   [&](int j) { return passages_[static_cast<std::size_t>(j)].has_value(); });
    if (at.depth >= kDeepest || !known || ends_.tails.size() + before.size() > kMost) return;
    ends_.tails[static_cast<std::size_t>(at.index)].extended = true;
    for (const int j : before) {
      const int index = static_cast<int>(ends_.tails.size());
      const std::optional<ParametricPose> X_RI =
          add_tail(j, *passages_[static_cast<std::size_t>(j)], at.index, at.X_RO);
      ends_.tails[static_cast<std::size_t>(at.index)].inner.push_back(index);
      if (X_RI) open.push_back({index, at.depth + 1, *X_RI * ParametricPose{facing()}});
    }
  }

  // Types whose free end, somewhere in an arm, takes type `k`.
  [[nodiscard]] std::vector<int> types_before(int k) const {
    std::vector<int> result;
    for (int j = 0; j < library_.n_types(); ++j) {
      const bool joins = std::any_of(couplings_.begin(), couplings_.end(), [&](const Coupling& free) {
        const std::optional<Coupling> after = library_.coupling_after(free, j);
        return after && library_.coupling_after(*after, k);
      });
      if (joins) result.push_back(j);
    }
    return result;
  }

  void grow_heads() {
    const auto add_head = [&](int k, const Passage& p, int outer, const ParametricPose& X_RC) {
      const ModuleType& module = type(k);
      return add(ends_.heads, k, outer, p.entry_body, connector_of(module, p.entry_body, p.entry_connector).X_BC, X_RC,
                 p.exit_body, connector_of(module, p.exit_body, p.exit_connector).X_BC);
    };
    std::vector<Open> open;
    const std::optional<ParametricPose> X_RO =
        add_head(RigidModule::kBase, library_.base_passage(), -1, ParametricPose{facing()});
    if (X_RO) open.push_back({0, 1, *X_RO * ParametricPose{facing()}, library_.base_coupling()});
    for (std::size_t i = 0; i < open.size(); ++i) {
      const Open at = open[i];
      if (at.depth >= kDeepest || ends_.heads.size() + static_cast<std::size_t>(library_.n_types()) > kMost) continue;
      ends_.heads[static_cast<std::size_t>(at.index)].extended = true;
      for (int k = 0; k < library_.n_types(); ++k) {
        const std::optional<Passage> passage = library_.passage(at.free, k);
        if (!passage) continue;
        const int index = static_cast<int>(ends_.heads.size());
        const std::optional<ParametricPose> X_next = add_head(k, *passage, at.index, at.X_RO);
        ends_.heads[static_cast<std::size_t>(at.index)].inner.push_back(index);
        const Coupling free = *library_.coupling_after(at.free, k);
        if (X_next) open.push_back({index, at.depth + 1, *X_next * ParametricPose{facing()}, free});
      }
    }
  }

  const ModuleLibrary& library_;
  std::set<Coupling> couplings_;
  std::vector<std::optional<Passage>> passages_;  // [n_types]
  RigidEnds ends_;
};

}  // namespace

RigidEnds rigid_ends(const ModuleLibrary& library) { return Growing{library}.ends(); }

}  // namespace modsearch::detail
