#include <gtest/gtest.h>

#include <modsearch/baselines/certify/obstacle_rows_internal.hpp>
#include <modsearch/problem/files.hpp>

namespace modsearch::certify {
namespace {

// A link that stands upright, 1 m long, and a large box, tilted so that one edge is 1 mm inside the link at any height:
// in a box of a millimetre there is a row that says so, although the link is clear of the box a little above and below.
TEST(ObstacleRows, AreFoundWhereverAnEdgeTouchesABody) {
  const auto problem = load_problem("seed/random_obstacles");
  const SequenceModel model{*problem, std::vector<int>{0}};
  ASSERT_EQ(model.runs.size(), 1u);
  const double radius = model.runs[0].radius;
  const Eigen::AngleAxisd tilt{0.35, Eigen::Vector3d::UnitY()};
  const Eigen::Vector3d edge = tilt * Eigen::Vector3d{-0.3, 0.0, -0.3};  // from the middle
  for (const double height : {0.10, 0.18, 0.30, 0.36, 0.44, 0.55, 0.63, 0.71, 0.82, 0.90}) {
    Eigen::Isometry3d X_WG{tilt};
    X_WG.translation() = Eigen::Vector3d{radius - 1e-3, 0.0, height} - edge;
    const Scenery scenery{{{{0.0, 0.0, 1.0}, 1e-3}}, {{modsearch::Box{{0.6, 0.6, 0.6}}, X_WG}}};
    NodeBound bound{model, scenery};
    bound.set_box({{0.9998, -2e-4}, {1.0002, 2e-4}});
    std::vector<RowCandidate> rows;
    find_rows(bound, model, scenery, {}, rows);
    ASSERT_EQ(rows.size(), 1u) << height;
    EXPECT_TRUE(rows[0].inside) << height;
    EXPECT_NEAR(radius + rows[0].row.tau * (1.0 - 2.0 * radius), height, 0.01);
  }
}

}  // namespace
}  // namespace modsearch::certify
