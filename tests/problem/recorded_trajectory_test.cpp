#include <gtest/gtest.h>

#include <modsearch/problem/files.hpp>

#include "places.hpp"

namespace modsearch {
namespace {

// A recorded task of CoBRA's with Timor's modules, and a design that evolution found for it.
class RecordedTrajectory : public ::testing::Test {
 protected:
  void SetUp() override {
    const std::filesystem::path timor = test::shared_folder() / "data/timor";
    if (!std::filesystem::exists(timor)) GTEST_SKIP() << "no recorded tasks under " << test::shared_folder();
    const TaskFile task = load_task(timor / "tasks/simple/traj_1.json");
    RobotProblemSpec spec;
    spec.name = "traj_1";
    spec.library = load_library(timor / "geometric_primitive_modules/modules.json");
    spec.task = task.task;
    spec.scene = task.scene;
    spec.X_WB = task.X_WB;
    problem_.emplace(std::move(spec));
    for (const char* id : {"J2", "J1", "l_30", "J2", "l_30", "J2", "eef"}) {
      design_.modules.push_back({problem_->library().find(id).value(), Parameters(0)});
    }
  }
  std::optional<RobotProblem> problem_;
  Design design_;
};

TEST_F(RecordedTrajectory, OfAThousandPosesIsFollowedOnOneBranch) {
  const Evaluation evaluation = problem_->evaluate(design_);
  ASSERT_TRUE(evaluation.attempt.achieved) << name(evaluation.attempt.why);
  const Eigen::MatrixXd& rows = evaluation.attempt.trajectories.at(0);
  const std::vector<PoseRegion>& poses = problem_->task().steps()[0].trajectory->poses;
  ASSERT_EQ(rows.rows(), static_cast<Eigen::Index>(poses.size()));
  const std::shared_ptr<const Chain> chain = problem_->chain(design_.types());
  const Arm arm = chain->at(design_.parameters());
  for (Eigen::Index k = 0; k < rows.rows(); ++k) {
    // The file's tolerances, by hand: 1 mm and 0.001 rad about each pose.
    const Eigen::Isometry3d X_WE = arm.forward(rows.row(k).transpose()).tip;
    const Eigen::Isometry3d& X_WN = poses[static_cast<std::size_t>(k)].nominal();
    EXPECT_LE((X_WE.translation() - X_WN.translation()).norm(), 0.001 + 1e-9);
    EXPECT_LE(Eigen::AngleAxisd{X_WN.linear().transpose() * X_WE.linear()}.angle(), 0.001 + 1e-9);
    if (k == 0) continue;
    EXPECT_LE((rows.row(k) - rows.row(k - 1)).cwiseAbs().maxCoeff(), 0.3);
  }
}

TEST_F(RecordedTrajectory, IsLeftWhereAModuleIsMissing) {
  design_.modules.erase(design_.modules.begin() + 1);
  const Attempt attempt = problem_->evaluate(design_).attempt;
  EXPECT_FALSE(attempt.reached);
  EXPECT_GT(attempt.relative_error, 0.0);
}

}  // namespace
}  // namespace modsearch
