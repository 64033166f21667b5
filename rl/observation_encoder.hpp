#pragma once

#include <modsearch/problem/design_problem.hpp>
#include <modsearch/rl/whitening.hpp>
#include <optional>
#include <string_view>
#include <vector>

namespace modsearch {

/// How a design and its problem become numbers for an agent.
enum class EncoderKind {
  /// Per slot a one-hot type with a class "empty" and the parameters, scaled; the number of modules; the instance.
  kScaled,
  /// The 36 numbers of "Hybrid Reinforcement Learning for Modular Robot Optimization" (TU Munich, 2022), to reproduce
  /// it.
  kSeed36,
};
/// "scaled", "seed36".
[[nodiscard]] std::string_view name(EncoderKind kind);

struct EncoderOptions {
  EncoderKind kind = EncoderKind::kScaled;  ///< tells an empty slot from a link, and has every number near [-1, 1]
  /// kScaled only: for every goal its distance from the base's axis and from the base. A hinge on the turning base has
  /// to match these lengths; with them more targets were met to the millimetre (97-99 % instead of 96 % on random
  /// ones).
  bool cylindrical = true;
  /// kScaled only: lower x, y, z and upper x, y, z [m] of the box that goals are drawn from. Every goal's place in it
  /// is then shown once more, scaled to [-1, 1]: goals of a small box otherwise differ by a few tenths only, and
  /// networks learn slowly what follows from small differences. Empty: not shown.
  std::vector<double> goal_box{};
  /// kScaled only: heights on the base's axis [m] from which every goal's distance is shown. Where a joint sits at such
  /// a height the length of what it turns is one of these numbers, instead of a root that networks must bend towards.
  std::vector<double> axis_heights{};
  /// kScaled only: instead of the n numbers that tell instances apart their whitened ones, as numbers_of() writes it.
  /// Empty: as they are.
  std::vector<double> whitening{};
};

/// Turns designs of one family of problems into observations of one length.
///
/// kScaled: slot i = 0 .. max_modules - 2, base to tip: [one-hot type, n_types + 1 with "empty" last; parameters, as
/// many as the largest type has, scaled from the library's ranges to [-1, 1], 0 where there are none]; then the share
/// of modules placed, scaled to [-1, 1]; then problem.context(); then per goal (rho, |t|) / 2 m, for a target t in the
/// base's frame, per goal its distances from axis_heights / 2 m, and its place in goal_box (robot problems only). What
/// follows the share of modules placed may be whitened.
///
/// kSeed36: ten type IDs over 3 (slot 0 is the base, 1.0; link 0, hinge 1 / 3, rotary 2 / 3), ten pairs of parameters
/// in their own unit, the base's position, the first goal's position [m]. Empty slots look like a link of length 0;
/// nothing else is scaled; obstacles are absent. For robot problems whose types have at most two parameters and
/// max_modules <= 10.
class ObservationEncoder {
 public:
  /// For the family of `problem`. Throws std::invalid_argument (what, value, limit) if `problem` cannot be encoded so,
  /// or for a goal_box that is no box, or a whitening of other numbers.
  ObservationEncoder(EncoderOptions options, const DesignProblem& problem);

  [[nodiscard]] int size() const { return design_size_ + instance_size_; }

  /// What an episode's observations have in common: the numbers that speak of `problem` and of no design.
  /// Throws std::invalid_argument if the problem is no member of the family: another number of them, other types.
  [[nodiscard]] Eigen::VectorXf instance(const DesignProblem& problem) const;
  /// The observation [size()] of `design`, given instance() of its problem.
  [[nodiscard]] Eigen::VectorXf encode(const ModuleLibrary& library, const Design& design,
                                       const Eigen::VectorXf& instance) const;

 private:
  [[nodiscard]] std::vector<double> instance_numbers(const DesignProblem& problem) const;
  void encode_scaled(const ModuleLibrary& library, const Design& design, float* out) const;
  void encode_seed36(const Design& design, float* out) const;

  EncoderOptions options_;
  int n_slots_ = 0;       // of kScaled: placements
  int n_parameters_ = 0;  // per slot
  std::vector<int> parameters_of_type_;
  std::vector<float> seed36_ids_;  // by type
  std::optional<Whitening> whitening_;
  int design_size_ = 0;
  int n_instance_numbers_ = 0;  // before they are whitened
  int instance_size_ = 0;
};

/// A parameter from [-1, 1] to its range and back; a range of one point is 0 there. Ends go to ends exactly.
[[nodiscard]] double from_unit(const ParameterRange& range, double unit);
[[nodiscard]] double to_unit(const ParameterRange& range, double value);

}  // namespace modsearch
