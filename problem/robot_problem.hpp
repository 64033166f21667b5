#pragma once

#include <memory>
#include <modsearch/kinematics/scene.hpp>
#include <modsearch/problem/design_problem.hpp>
#include <modsearch/problem/reach_bound.hpp>
#include <modsearch/problem/task.hpp>
#include <string>
#include <vector>

namespace modsearch {

class ChainCache;
class TaskProofs;

/// Everything a robot problem is made of.
struct RobotProblemSpec {
  std::string name;  ///< ID or file, for messages and records
  std::shared_ptr<const ModuleLibrary> library;
  std::shared_ptr<const Task> task;
  std::shared_ptr<const Scene> scene = std::make_shared<Scene>();
  std::shared_ptr<const Scoring> scoring = std::make_shared<Algorithm1>();
  Level level = Level::kPosture;
  int max_modules = 10;  ///< in [1, 64], the base included
  /// The base may be placed: `library` comes from with_placed_base, the first module of every design is the base
  /// itself, with its place as its parameters, and X_WB is where all of these are 0.
  bool placed_base = false;
  Eigen::Isometry3d X_WB = Eigen::Isometry3d::Identity();  ///< pose of the base
  double time_step = 0.01;  ///< between the rows of a trajectory in a solution file [s]; CoBRA's timeStepSize
  IkOptions ik;
  PlanOptions planner;
  /// Chains of type sequences met lately, shared by the instances of a family (RobotProblem::spec() has them); null, or
  /// those of another library or base pose: the problem keeps its own.
  std::shared_ptr<ChainCache> chains;
};

/// Library + scene + task + scoring: the design problem everybody uses. Keeps the chains of type sequences it has met
/// lately, and what it has proved of its arms (docs/infeasible.md): which ends and beginnings overlap an obstacle
/// whatever the arm, how many joints it needs, what a complete one has to contain.
class RobotProblem final : public DesignProblem {
 public:
  /// Throws std::invalid_argument for a missing part or max_modules outside [1, 64].
  explicit RobotProblem(RobotProblemSpec spec);

  [[nodiscard]] std::string name() const override { return spec_.name; }
  [[nodiscard]] const ModuleLibrary& library() const override { return *spec_.library; }
  [[nodiscard]] int max_modules() const override { return spec_.max_modules + (spec_.placed_base ? 1 : 0); }
  [[nodiscard]] bool staged() const override { return spec_.level == Level::kPath; }
  [[nodiscard]] std::vector<Fidelity> stages() const override;
  [[nodiscard]] Eigen::VectorXd context() const override;
  [[nodiscard]] std::unique_ptr<SmoothProgram> relax(std::span<const int> types,
                                                     const Relaxation& relaxation = {}) const override;
  [[nodiscard]] std::unique_ptr<PoseProgram> pose_program(std::span<const int> types) const override;
  /// The end of every possible arm overlaps an obstacle at a goal, or its beginning does. Proved at the first call, in
  /// less than a millisecond, and known from then on.
  [[nodiscard]] std::optional<Infeasibility> infeasible() const override;
  [[nodiscard]] Optimism optimism(std::span<const int> types) const override;
  [[nodiscard]] Optimism optimism_of_length(int n) const override;
  [[nodiscard]] Optimism optimism_of_prefix(std::span<const int> types, int n) const override;

  [[nodiscard]] const RobotProblemSpec& spec() const { return spec_; }
  [[nodiscard]] const Task& task() const { return *spec_.task; }
  [[nodiscard]] const Scene& scene() const { return *spec_.scene; }
  /// #module of a design, the base included.
  [[nodiscard]] int n_modules(const Design& design) const;
  /// Where the base of a design stands.
  [[nodiscard]] Eigen::Isometry3d base_pose(const Design& design) const;
  /// The same problem with another collision level.
  [[nodiscard]] RobotProblem with_level(Level level) const;

  /// The chain of base + `types`, from the problem's memory where it is still there. An arm made of it does not keep it
  /// alive; the caller has to.
  [[nodiscard]] std::shared_ptr<const Chain> chain(std::span<const int> types) const;

 private:
  [[nodiscard]] std::vector<int> do_successors(std::span<const int> types) const override;
  [[nodiscard]] Evaluation do_evaluate(const Design& design, Fidelity fidelity) const override;
  [[nodiscard]] Evaluation do_evaluate_with(const Design& design, Fidelity fidelity,
                                            const Witness& witness) const override;

  [[nodiscard]] double farthest_goal() const;
  [[nodiscard]] Optimism judged(const ReachBound& bound, int n, double least_cost) const;

  RobotProblemSpec spec_;               // its `chains` are never null
  std::shared_ptr<TaskProofs> proofs_;  // null: there is nothing to prove but reach
};

}  // namespace modsearch
