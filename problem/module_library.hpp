#pragma once

#include <array>
#include <compare>
#include <modsearch/kinematics/chain.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace modsearch {

/// A continuous parameter of a module type, in a closed interval.
struct ParameterRange {
  std::string name;
  std::string unit = "m";  ///< "m" or "rad"
  double lower = 0.0;      ///< in that unit
  double upper = 0.0;
};

enum class Gender { kFemale, kMale, kHermaphroditic };

/// A place where a module can be joined to another. Its frame C points away from the body (z outwards), so joining A to
/// B turns the frame of A's connector by half a turn about x into the frame of B's.
struct Connector {
  std::string id;
  AffinePose X_BC;  ///< body -> connector
  Gender gender = Gender::kHermaphroditic;
  std::string type;  ///< "base" fixes the robot to the world, "eef" is the TCP; others join modules
  std::vector<double> size;

  /// Equal type and size, and genders that mate: f-m or h-h.
  [[nodiscard]] bool fits(const Connector& other) const;
};

/// A rigid part of a module, in its own frame B.
struct ModuleBody {
  std::string id;
  AffineScalar mass;                                  ///< [kg]
  AffineVector r_com;                                 ///< centre of mass [m]
  bool uniform_inertia = false;                       ///< derived from mass and collision geometry
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();  ///< about the centre of mass, axes of B [kg m^2]
  std::vector<Connector> connectors;
  std::vector<BodyGeometry> collision;  ///< X_FG is X_BG here, and affine
};

/// A joint between two bodies of one module: child = parent * X_PJ * (Rz(q) or Tz(q)) * X_JC. A fixed one may be turned
/// by an angular parameter (the twist of a link): child = parent * X_PJ * Rz(angle) * X_JC.
struct ModuleJoint {
  Joint joint;
  bool fixed = false;  ///< does not move: `joint` holds no limits
  AffineScalar angle;  ///< of a fixed joint [rad]
  int parent = 0;      ///< body indices within the module
  int child = 0;
  AffinePose X_PJ;
  AffinePose X_JC;
  double gear_ratio = 1.0;
  double motor_inertia = 0.0;
  double friction_coulomb = 0.0;
  double friction_viscous = 0.0;
};

/// What a module is there for, read off its connectors and joints.
enum class ModuleRole {
  kBase,         ///< has a connector of type "base"
  kLink,         ///< rigid
  kJoint,        ///< has joints that move
  kEndEffector,  ///< has a connector of type "eef"
};

/// One type of module, as a library describes it (Timor's format with continuous parameters).
struct ModuleType {
  std::string id;
  std::string name;
  double cost = 0.0;
  std::vector<ParameterRange> parameters;  ///< parameter index i in AffineScalar::Term is an index into this
  std::vector<ModuleBody> bodies;
  std::vector<ModuleJoint> joints;

  /// A base or an end effector may have joints too: the connectors decide first.
  [[nodiscard]] ModuleRole role() const;
  [[nodiscard]] int n_parameters() const { return static_cast<int>(parameters.size()); }
};

/// A set of module types and the rules by which they join (the format of Timor, Kuelz, Mayer and Althoff 2023, "Timor
/// Python: A Toolbox for Industrial Modular Robotics", IROS, doi:10.1109/IROS55552.2023.10341935, with parameters).
///
/// Serial chains of two-connector modules: a module is entered by its first declared connector that fits the free one
/// before it and left by the other. The tip is the frame of the end effector's `eef` connector, else of the last free
/// one. The base module is fixed and not counted among the types: type k = 0 .. n_types() - 1 are those a design
/// chooses from.
class ModuleLibrary {
 public:
  static constexpr int kMaxParameters = 8;  ///< per module: Parameters of a placement never touch the heap

  /// `name`: ID or file, for messages. The types keep the order of `modules`, the base left out.
  /// Throws std::invalid_argument (module, what, limit) unless there is exactly one base, without parameters, every
  /// module has two connectors with a serial chain of joints between them and at most kMaxParameters parameters, IDs
  /// are unique, and no mass or size becomes negative within the parameters' intervals.
  ModuleLibrary(std::string name, std::vector<ModuleType> modules, NeighbourRule rule = NeighbourRule::kViaJoint);

  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] int n_types() const { return static_cast<int>(types_.size()); }
  /// Throws std::invalid_argument for a type that is not in [0, n_types()).
  [[nodiscard]] const ModuleType& type(int k) const;
  [[nodiscard]] const ModuleType& base() const { return base_; }
  [[nodiscard]] NeighbourRule neighbour_rule() const { return rule_; }
  /// Index of the type with this ID (or, failing that, this name).
  [[nodiscard]] std::optional<int> find(std::string_view id) const;
  /// Largest number of parameters of any type.
  [[nodiscard]] int max_parameters() const;

  /// All that decides what may be attached to a free end: the number of the connector's (type, size), -1 where nothing
  /// joins, and its gender.
  struct Coupling {
    int mate = -1;
    Gender gender = Gender::kHermaphroditic;
    friend auto operator<=>(const Coupling&, const Coupling&) = default;
  };
  /// The free end of the base alone.
  [[nodiscard]] Coupling base_coupling() const { return {base_end_.mate, base_end_.gender}; }
  /// The free end after a module of type `k` was joined to `free`; empty if it does not fit.
  [[nodiscard]] std::optional<Coupling> coupling_after(const Coupling& free, int k) const;

  /// Which connectors of a module an arm goes through: indices of bodies, and of connectors within these.
  struct Passage {
    int entry_body = 0;
    int entry_connector = 0;
    int exit_body = 0;
    int exit_connector = 0;
    friend bool operator==(const Passage&, const Passage&) = default;
  };
  /// From the ground to the first module.
  [[nodiscard]] Passage base_passage() const;
  /// Through a module of type `k` that is joined to `free`; empty if it does not fit.
  [[nodiscard]] std::optional<Passage> passage(const Coupling& free, int k) const;

  /// Types whose connectors fit the free end of base + `types`, in rising order.
  /// Throws std::invalid_argument if `types` do not fit in turn.
  [[nodiscard]] std::vector<int> successors(std::span<const int> types) const;
  /// Whether each type may follow the one before.
  [[nodiscard]] bool fits_together(std::span<const int> types) const;
  /// A design has to end in one, see `complete`.
  [[nodiscard]] bool has_end_effectors() const { return has_end_effectors_; }
  /// Nothing is missing: the design ends in an end effector, or the library has none.
  [[nodiscard]] bool complete(std::span<const int> types) const;

  /// IDs of the connectors by which each module hangs on the one before it, (there, here) [n_types].
  /// Throws std::invalid_argument if `types` do not fit in turn.
  [[nodiscard]] std::vector<std::pair<std::string, std::string>> connections(std::span<const int> types) const;
  /// ID of the base's connector of type "base".
  [[nodiscard]] const std::string& ground_connector() const;

  /// The chain of base + `types`, base frame at `X_WB`; x is the concatenation of the modules' parameters, base to tip.
  /// Throws std::invalid_argument if the modules do not fit together.
  [[nodiscard]] Chain assemble(std::span<const int> types,
                               const Eigen::Isometry3d& X_WB = Eigen::Isometry3d::Identity()) const;

 private:
  // One of the two connectors of a module, reduced to what joining needs: sequences are checked in every step of a
  // search.
  struct End {
    int body = 0;
    int connector = 0;
    int mate = -1;  // number of the connector's (type, size), equal for those that can join; -1: joins nothing
    Gender gender = Gender::kHermaphroditic;
  };
  using Ends = std::array<End, 2>;  // in the order of declaration

  [[nodiscard]] Ends ends(const ModuleType& module);
  [[nodiscard]] const Ends& ends_of(int k) const;
  // Which end of type `k` is entered from the free end `previous`; -1: none.
  [[nodiscard]] int entry(const End& previous, int k) const;
  [[nodiscard]] int entry_or_throw(const End& previous, std::span<const int> types, std::size_t i) const;
  // The free end of base + `types`; empty if they do not fit together.
  [[nodiscard]] std::optional<End> free_end(std::span<const int> types) const;

  std::string name_;
  ModuleType base_;
  std::vector<ModuleType> types_;
  NeighbourRule rule_;
  bool has_end_effectors_ = false;
  std::vector<std::pair<std::string, std::vector<double>>> mates_;  // (type, size) by number
  End base_end_;                                                    // the base's connector for the first module
  End ground_end_;                                                  // the base's connector of type "base"
  std::vector<Ends> ends_;                                          // [n_types]
};

}  // namespace modsearch
