#pragma once

#include <functional>
#include <modsearch/problem/problem_source.hpp>
#include <modsearch/rl/design_model.hpp>
#include <modsearch/rl/environment.hpp>
#include <modsearch/rl/observation_encoder.hpp>
#include <optional>

namespace modsearch {

/// What a placement pays.
enum class RewardKind {
  kScore,       ///< the score of the design so far: the return is the sum over all prefixes, as in the report
  kDifference,  ///< what the placement has added to the score: the return is the design's score less that of nothing
};

/// What ends an episode as it should.
enum class EndOn {
  kReached,   ///< every goal is reached, whatever collides: the report
  kAchieved,  ///< and the collision level is met
};

struct DesignEnvironmentOptions {
  EncoderOptions encoder = {};
  RewardKind reward = RewardKind::kScore;  ///< the report
  EndOn end_on = EndOn::kReached;          ///< the report
  Fidelity fidelity = Fidelity::kFull;     ///< kScreen: no path is planned; much cheaper at level path
  std::optional<Level> level = {};         ///< collision level instead of the problem's own (robot problems only)
  int model_joints = 3;  ///< no models beyond that many joints: up to three the least distance is exact (PROBLEM 3)
  /// Where hindsight may move the goal to; anywhere if empty.
  std::optional<Sampling> hindsight_region = {};
  /// Instances from which encoder.whitening is taken where it is empty; 0: none is.
  int whiten = 0;
};

/// The search for a design as a Markov decision process, one placement per step: begins with the empty design, ends
/// with success when the design reaches (or achieves) its goals, and is cut off when nothing may follow any more, when
/// an evaluation was refused, or when it gave no finite score (the reward is 0 then). A design that lacks its end
/// effector has not reached anything.
class DesignEnvironment final : public Environment {
 public:
  /// Evaluates a design, or refuses to (a budget is spent); the fidelity is DesignEnvironmentOptions::fidelity.
  using Evaluate = std::function<std::optional<Evaluation>(const DesignProblem&, const Design&, Fidelity)>;

  /// Draws one problem to see what its family looks like.
  /// Throws std::invalid_argument without a source, for a problem that cannot be encoded (ObservationEncoder), has more
  /// than 64 types, or allows no module at all, and for a `level` of a problem that is no robot problem.
  explicit DesignEnvironment(ProblemSource source, DesignEnvironmentOptions options = {});
  /// Instances of `file`; hindsight stays within the region its goal is drawn from.
  explicit DesignEnvironment(const ProblemFile& file, DesignEnvironmentOptions options = {});

  /// Other problems of the same family, from the next reset on: held-out ones, or the one that a policy is to solve.
  void set_source(ProblemSource source);
  /// How designs are evaluated from now on (through a Meter, say); empty: DesignProblem::evaluate. Clones share it.
  void set_evaluate(Evaluate evaluate);

  /// The problem of the present episode; before the first, the one drawn at construction.
  [[nodiscard]] const DesignProblem& problem() const { return *problem_; }
  /// The design so far, the placement of a refused evaluation included.
  [[nodiscard]] const Design& design() const { return design_; }
  /// What design() is worth; nothing before the first step and after a refused one.
  [[nodiscard]] const std::optional<Evaluation>& evaluation() const { return evaluation_; }
  /// As given, and encoder.whitening as taken from the first source.
  [[nodiscard]] const DesignEnvironmentOptions& options() const { return options_; }

  [[nodiscard]] std::string name() const override { return problem_->name(); }
  [[nodiscard]] const HybridSpace& space() const override { return space_; }
  [[nodiscard]] int observation_size() const override { return encoder_.size(); }
  [[nodiscard]] std::unique_ptr<Environment> clone() const override;
  /// Null for problems that are no robot problems, that have goals other than balls, or another library or base pose
  /// than the first of their family.
  [[nodiscard]] std::shared_ptr<const ActionModel> model() const override;
  [[nodiscard]] std::shared_ptr<const ActionModel> restore_model(std::span<const double> key) const override;
  [[nodiscard]] std::optional<double> preview(int k, std::span<const float> x_k) const override;
  /// The last placement in tasks whose goal lies where a random posture of the design puts the tip, within
  /// `hindsight_region`, and not where the design before it ends already; at most 16 postures are tried for each. Only
  /// for robot problems with one goal that is a ball. Evaluated beside the budget: other problems than the one to be
  /// solved. Of the action's parameters those of k are filled in, the others 0.
  [[nodiscard]] std::vector<Transition> hindsight(int n, Rng& rng) const override;
  /// Work of the evaluations, previews and hindsight included.
  [[nodiscard]] Work work() const override { return work_; }

 private:
  View do_reset(Rng rng) override;
  Step do_step(int k, std::span<const float> x_k, View& next) override;

  [[nodiscard]] std::shared_ptr<const DesignProblem> drawn(std::uint64_t seed) const;
  [[nodiscard]] EncoderOptions with_whitening(EncoderOptions encoder) const;
  [[nodiscard]] Placement placement(int k, std::span<const float> x_k) const;
  [[nodiscard]] std::optional<Evaluation> evaluated(const DesignProblem& problem, const Design& design) const;
  [[nodiscard]] ActionMask mask_after(const DesignProblem& problem, const Design& design) const;
  [[nodiscard]] std::optional<std::vector<DesignModel::Target>> targets(const DesignProblem& problem) const;
  [[nodiscard]] std::optional<Eigen::Vector3d> hindsight_target(const RobotProblem& problem, Rng& rng) const;
  [[nodiscard]] std::optional<Transition> relabelled(const RobotProblem& problem, const Eigen::Vector3d& p_W) const;
  [[nodiscard]] bool ends(const Evaluation& evaluation) const;
  /// What the reward of a placement is counted from: 0, or the score of design_; nothing if that evaluation is refused.
  [[nodiscard]] std::optional<double> paid_before() const;

  ProblemSource source_;
  DesignEnvironmentOptions options_;
  Evaluate evaluate_;
  std::shared_ptr<const DesignProblem> problem_;
  std::shared_ptr<const RobotProblem>
      family_;  // the first problem, whose chains the models use; null: no robot problem
  HybridSpace space_;
  ObservationEncoder encoder_;

  std::optional<std::vector<DesignModel::Target>> targets_;  // of problem_; nothing: it has no models
  Eigen::VectorXf instance_;                                 // the encoder's, of problem_
  Design design_;
  std::optional<Evaluation> evaluation_;
  mutable std::optional<double> score_;  // of design_; of the empty one only once it was needed
  mutable Work work_;
};

}  // namespace modsearch
