#pragma once

#include <functional>
#include <modsearch/baselines/pose_first.hpp>
#include <modsearch/baselines/pose_first/sequence_belief_internal.hpp>
#include <modsearch/solvers/search.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace modsearch::detail {

/// A search of `PoseFirst` under way.
class PoseSearch final : public Search {
 public:
  /// `problem` must outlive it.
  PoseSearch(const PoseFirstOptions& options, const DesignProblem& problem, Rng rng);

  /// One try of one sequence.
  [[nodiscard]] std::optional<SearchEnd> step(Meter& meter) override;
  void save(Archive& archive) const override;
  void restore(const Archive& archive) override;

 private:
  [[nodiscard]] std::optional<SearchEnd> go_on(Meter& meter);
  /// A design whose postures are free, with these.
  struct Elite {
    std::vector<int> types;
    Eigen::VectorXd v;  ///< as in its pose program
    double score = 0.0;
  };
  /// A point at which all poses are met.
  struct Arrival {
    Eigen::VectorXd v;
    Evaluation screen;
  };
  /// A sequence that is tried, with what it may score and where its starts come from.
  struct Try {
    std::vector<int> types;
    double bound = 0.0;
    int n_starts = 0;
    std::function<void(int i, Eigen::Ref<Eigen::VectorXd> v, const PoseProgram& program)> start;
  };

  [[nodiscard]] double to_beat(const Meter& meter) const;
  bool explore(Meter& meter);
  bool improve(Meter& meter);
  /// What came of a try.
  struct Outcome {
    double work = 0.0;
    double success = 0.0;  ///< in [0, 1]
  };
  [[nodiscard]] Outcome attempt(const Try& what, Meter& meter);
  [[nodiscard]] std::vector<Arrival> arrivals(const Try& what, PoseProgram& program, Meter& meter, double& work);
  void settle(const Try& what, const PoseProgram& program, std::vector<Arrival> here, Meter& meter);
  void settle(const Try& what, const PoseProgram& program, const Arrival& arrival, Meter& meter);
  void finish(const Try& what, const PoseProgram& program, const Eigen::VectorXd& v, const Evaluation& screen,
              Meter& meter);
  void refine(const Try& what, const PoseProgram& program, const Eigen::VectorXd& v, double clearance, Meter& meter);
  void keep(const std::vector<int>& types, const Eigen::VectorXd& v, double score);
  void tell(std::string_view stage, Meter& meter) const;

  PoseFirstOptions options_;
  const DesignProblem& problem_;
  Rng rng_;
  SequenceBelief belief_;
  bool covered_;
  bool begun_ = false;
  double floor_ = 0.0;  // score of the empty design
  std::vector<Elite> elites_;
  double explored_ = 0.0;  // work spent on drawn sequences, and on changes of what was found
  double improved_ = 0.0;
  int idle_ = 0;            // steps in a row that found nothing to try
  int no_path_ = 0;         // planned in vain in the try under way
  double patience_ = 0.05;  // with the planner, see Witness: 250 of its 5000 iterations (most paths take fewer)
  std::int64_t tried_ = 0, met_ = 0, free_ = 0, refined_ = 0, planned_ = 0, achieved_ = 0;
};

}  // namespace modsearch::detail
