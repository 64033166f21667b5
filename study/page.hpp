#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace modsearch {

/// A point or vector [m], world frame unless said otherwise.
using PagePoint = std::array<double, 3>;

/// A homogeneous transform, row-major 4x4, translation in m.
using PagePose = std::array<double, 16>;

/// The pose that changes nothing: the default of every pose below.
inline constexpr PagePose kPageIdentity{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};

/// What a shape is; it decides what the numbers of `PageShape::size` mean.
enum class PageShapeKind { kSphere, kBox, kCylinder, kCapsule, kMesh };

/// A solid fixed to a body.
struct PageShape {
  PageShapeKind kind = PageShapeKind::kSphere;
  /// Sphere: {radius}; box: {x, y, z}, full edges; cylinder and capsule: {radius, length} along z, centred, where the
  /// caps of a capsule stick out beyond `length`; mesh: empty [m].
  std::vector<double> size{};
  PagePose X_BG = kPageIdentity;                ///< pose of the shape in its body
  std::vector<PagePoint> vertices{};            ///< mesh only, shape frame [m]
  std::vector<std::array<int, 3>> triangles{};  ///< mesh only, indices into `vertices`
  std::string name{};                           ///< shown where the pointer rests on it; may be empty
};

/// How a joint moves, which decides the symbol that is drawn for it.
enum class PageJointKind { kRevolute, kPrismatic, kFixed };

/// A joint's symbol: it is drawn about the z axis of its frame and moves with its body.
struct PageJoint {
  std::string name{};
  PageJointKind kind = PageJointKind::kRevolute;
  PagePose X_BJ = kPageIdentity;  ///< pose of the joint frame in the body that carries the symbol; its axis is z
};

/// Shapes that move as one, and where they are along the path.
struct PageBody {
  std::string name{};
  int module = -1;                  ///< index into `Page::modules`, which decides the colour; -1: of no module
  std::vector<PageShape> shapes{};  ///< may be empty, e.g. for a body that only carries a joint
  std::vector<PageJoint> joints{};
  std::vector<PagePose> keyframes{};  ///< pose in the world, one per sample of the path; a single one: it never moves
};

/// Where the tool centre point is to go.
struct PageTarget {
  std::string name{};
  PagePoint position{};
  double tolerance = 0.0;           ///< radius of the accepted ball [m]
  std::optional<PagePose> frame{};  ///< pose asked for, in the world, where the orientation matters
  std::string miss{};               ///< what keeps the design from it, in words; empty: nothing
};

/// A body of the robot that overlaps an obstacle, or another body, in the posture that is shown.
struct PageTouch {
  int body = 0;          ///< index into `Page::bodies`
  bool obstacle = true;  ///< whether `other` counts obstacles or bodies
  int other = 0;
  PagePoint position{};  ///< between the deepest points of the two
  double depth = 0.0;    ///< [m]
};

/// The box that targets of a sampled problem are drawn from.
struct PageRegion {
  PagePoint lower{};
  PagePoint upper{};
};

/// A moment of the path worth a mark: home, a goal.
struct PageMilestone {
  std::string name{};
  int sample = 0;  ///< index into the samples of the path
};

/// One parameter of a module as placed.
struct PageParameter {
  std::string name{};
  double value = 0.0;
  std::string unit{};  ///< "m" or "rad"
};

/// A module of the design, base to tip.
struct PageModule {
  std::string type{};
  std::vector<PageParameter> parameters{};
};

/// One summand of the score.
struct PageTerm {
  std::string name{};
  double value = 0.0;
};

/// One improvement of the best design during the search. A design that achieves the task outranks one that does not,
/// so the score may fall where `achieved` first becomes true.
struct PageImprovement {
  std::int64_t evaluations = 0;  ///< evaluations spent so far, this one included
  double seconds = 0.0;
  double score = 0.0;
  bool achieved = false;
};

/// Everything the page shows. Numbers that are not known stay empty or NaN and are shown as a dash.
struct Page {
  std::string title{};    ///< of the window; e.g. "seed/fixed by per-sequence"
  std::string problem{};  ///< ID or file
  std::string solver{};   ///< name with its options
  std::string seed{};
  std::string command{};  ///< what reproduces the solution

  double score = std::numeric_limits<double>::quiet_NaN();
  bool achieved = false;
  std::string verified = "none";  ///< "none", "posture" or "path"
  std::string reason{};           ///< why the task is not achieved or not verified; may be empty
  std::vector<PageTerm> terms{};  ///< add up to `score`

  std::vector<PageModule> modules{};                       ///< base first
  double mass = std::numeric_limits<double>::quiet_NaN();  ///< [kg]
  std::int64_t evaluations = 0;
  double seconds = std::numeric_limits<double>::quiet_NaN();
  std::optional<double> clearance{};   ///< least distance to an obstacle [m]; empty without obstacles
  std::optional<double> goal_error{};  ///< largest distance of the TCP to its target [m]

  std::vector<PageBody> bodies{};     ///< of the robot
  std::vector<PageBody> obstacles{};  ///< one keyframe each unless they move
  std::vector<PageTarget> targets{};
  std::vector<PageTouch> touches{};
  std::optional<PageRegion> region{};
  std::optional<PagePose> base{};  ///< pose of the robot's base in the world
  std::vector<PagePoint> tip{};    ///< TCP at each sample of the path; empty: no line is drawn
  std::vector<double> times{};     ///< of the samples [s], increasing; empty: evenly spread over four seconds
  std::vector<PageMilestone> milestones{};

  std::vector<PageImprovement> trace{};  ///< in order of evaluations
};

/// The page as one HTML document that needs no other file and no network: the robot, its scene and its path in 3-D,
/// the design, the terms of its score, and how the solver got there. Poses and vertices are rounded to a micrometre.
/// Any text may stand in the fields: none of it is ever read as markup or script. Without WebGL the page says so and
/// shows the rest.
/// The hash of the page's address sets its state: `t` the moment of the path as a fraction of its duration, `play` to
/// start it, `view` (iso, front, side or top), `theme` (light or dark): `view.html#t=0.5&view=top`.
/// Throws std::invalid_argument if a shape has the wrong number of sizes, a size or pose is not finite, an index is
/// out of range, or the numbers of samples differ.
[[nodiscard]] std::string write_page(const Page& page);

}  // namespace modsearch
