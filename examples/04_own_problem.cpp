// Step 4: a search problem of your own. Whatever can score a design can be searched; nothing else is needed.
#include <algorithm>
#include <cmath>
#include <iostream>
#include <modsearch/modsearch.hpp>

namespace {

using namespace modsearch;

/// The tallest mast for a given mass: stretched straight up, an arm of the library `seed` is as high as its lengths and as
/// heavy, so the optimum is the mass that is allowed.
class Mast final : public DesignProblem {
 public:
  explicit Mast(double most_mass) : library_{load_library("seed")}, most_mass_{most_mass} {}

  std::string name() const override { return "mast"; }
  const ModuleLibrary& library() const override { return *library_; }
  int max_modules() const override { return 4; }
  Eigen::VectorXd context() const override { return Eigen::VectorXd::Constant(1, most_mass_); }

 private:
  Evaluation do_evaluate(const Design& design, Fidelity) const override {
    const Chain chain = library_->assemble(design.types());
    const Arm arm = chain.at(design.parameters());
    const double height = arm.forward(Eigen::VectorXd::Zero(arm.n_joints())).tip.translation().z();
    Evaluation evaluation;
    evaluation.attempt.achieved = arm.mass() <= most_mass_;
    evaluation.score = evaluation.attempt.achieved ? height : most_mass_ - arm.mass();
    return evaluation;
  }

  std::shared_ptr<const ModuleLibrary> library_;
  double most_mass_;
};

}  // namespace

int main() {
  const Mast problem{4.0};
  Meter meter{{.evaluations = 50'000, .target_score = 3.95}};
  const Solution solution = AutoSolver{}.solve(problem, meter, Rng{1});
  std::cout << to_string(problem.library(), solution.design) << " is " << solution.evaluation.score
            << " m high, at most 4 m are possible\n"
            << (solution.evaluation.score > 3.95 && solution.evaluation.score <= 4.0 ? "as expected" : "unexpected") << '\n';
}
