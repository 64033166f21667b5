#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <modsearch/problem/files.hpp>
#include <modsearch/study/environment_page.hpp>

namespace modsearch {
namespace {

TEST(Render, ShowsTheDesignOfEveryStateOfAnEpisode) {
  DesignEnvironment environment{load_problem_file("seed/random_obstacles")};
  environment.reset(Rng{1});
  const std::string nothing = render(environment);
  EXPECT_THAT(nothing, ::testing::HasSubstr("seed/random_obstacles"));
  // A link of 0.5 m, then another: neither reaches, so the episode goes on.
  HybridAction action;
  action.x = Eigen::VectorXf::Constant(environment.space().n_parameters(), -1.0F);
  environment.step(action);
  const std::string one = render(environment);
  environment.step(action);
  const std::string two = render(environment);
  const auto links = [](const std::string& page) {
    const std::string link = R"("type":"link")";
    int count = 0;
    for (std::size_t at = page.find(link); at != std::string::npos; at = page.find(link, at + 1)) ++count;
    return count;
  };
  EXPECT_EQ(links(nothing), 0);
  EXPECT_EQ(links(one), 1);
  EXPECT_EQ(links(two), 2);
  EXPECT_THAT(two, ::testing::HasSubstr(R"("name":"length","unit":"m","value":0.5)"));
  // A metre of links does not reach to (1, 0, 1).
  EXPECT_THAT(two, ::testing::HasSubstr(R"("reason":"proved infeasible")"));
}

}  // namespace
}  // namespace modsearch
