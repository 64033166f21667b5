#include <gmock/gmock.h>

#include <cfenv>

#include "naive_certificate.hpp"

namespace modsearch_check {
namespace {

/// Problems in a file of their own, from `seed/fixed` with changes.
class Scenes : public testing::Test {
 protected:
  void write(const std::function<void(Json&)>& change) {
    problem_ = {{"modsearch", 1},
                {"library", "seed"},
                {"maxModules", 2},
                {"collision", "posture"},
                {"scoring", {{"type", "algorithm1"}}},
                {"task", {{"header", {{"ID", "scene"}}}, {"obstacles", Json::array()}, {"goals", Json::array()}}}};
    change(problem_);
    file_.write(problem_.dump());
  }

  static Json pose(double x, double y, double z) {
    Json matrix = Json::array();
    matrix.push_back({1, 0, 0, x});
    matrix.push_back({0, 1, 0, y});
    matrix.push_back({0, 0, 1, z});
    matrix.push_back({0, 0, 0, 1});
    return matrix;
  }

  static void add_goal(Json& problem, double x, double y, double z) {
    Json& goals = problem["task"]["goals"];
    goals.push_back({{"ID", std::to_string(goals.size() + 1)},
                     {"type", "reach"},
                     {"goalPose",
                      {{"nominal", pose(x, y, z)},
                       {"toleranceProjection", Json::array({"r_sph"})},
                       {"tolerance", Json::array({Json::array({0, 0.001})})}}}});
  }

  static void add_sphere(Json& problem, double x, double y, double z, double r) {
    const Json shape{{"type", "sphere"}, {"parameters", {{"r", r}}}, {"pose", pose(x, y, z)}};
    problem["task"]["obstacles"].push_back({{"ID", "1"}, {"collision", Json::array({shape})}});
  }

  [[nodiscard]] Json certificate(double upper) const {
    const Rounding up{FE_UPWARD};
    return naive_certificate(file_.path(), read_problem(file_.path(), "", 0, 0), upper,
                             problem_["maxModules"].get<std::size_t>() - 1);
  }

  static std::string verdict(const Json& certificate) {
    const TemporaryFile file{"scene_certificate.json"};
    file.write(certificate.dump());
    try {
      static_cast<void>(check_certificate(file.path()));
      return "accepted";
    } catch (const Rejected& reason) {
      return reason.what();
    }
  }

  /// A hinge whose distal part goes straight from (0, 0, p) to (1, 0, 1), as an incumbent.
  static void add_hinge(Json& certificate, double p) {
    const double distal = std::hypot(1.0, 1.0 - p);
    const Json placement{{"type", "hinge"}, {"parameters", {{"proximal", hex(p)}, {"distal", hex(distal)}}}};
    certificate["incumbent"]["design"] = Json::array({placement});
    certificate["incumbent"]["postures"] =
        Json::array({Json::array({hex(std::acos(0.0)), hex(std::atan2(1.0, 1.0 - p))})});
    const double score = 350.0 - 5.0 * (p + distal);
    certificate["claim"]["lower"] = score;
    certificate["claim"]["gap"] = (certificate["claim"]["upper"].get<double>() - score) / (5.0 * (p + distal));
  }

  Json problem_;
  TemporaryFile file_{"scene.json"};
};

TEST_F(Scenes, WithASphereInTheWayAreProvedByRows) {
  // Halfway between (0, 0, 1/2) and (1, 0, 1), 0.1 m thick: the lightest free arm, 341.91, has to give way.
  write([](Json& problem) {
    add_goal(problem, 1.0, 0.0, 1.0);
    add_sphere(problem, 0.5, 0.0, 0.75, 0.1);
  });
  Json proof = certificate(341.4);
  const std::string rows = proof.dump();
  EXPECT_THAT(rows, testing::HasSubstr("ball"));
  EXPECT_EQ(verdict(proof), "accepted");

  // p = 0.9: the distal part passes 0.2 m / sqrt(1.01) above the sphere's centre, further than 0.1 m and the body's
  // 0.055 m.
  Json found = proof;
  add_hinge(found, 0.9);
  EXPECT_EQ(verdict(found), "accepted");
  // p = 0.7: it passes 0.1 m / sqrt(1.09) above.
  add_hinge(found, 0.7);
  EXPECT_THAT(verdict(found), testing::HasSubstr("is not shown to be clear of obstacle shape 0"));

  for (Json& sequence : proof["sequences"]) {
    for (Json& node : sequence["tree"]) {
      while (node[0] != "s" && node.size() > 4) node.erase(node.size() - 1);
    }
  }
  EXPECT_THAT(verdict(proof), testing::AnyOf(testing::HasSubstr("too little"), testing::HasSubstr("does not show")));
}

TEST_F(Scenes, WhoseLevelIgnoresObstaclesAllowNoRows) {
  write([](Json& problem) {
    add_goal(problem, 1.0, 0.0, 1.0);
    add_sphere(problem, 0.5, 0.0, 0.75, 0.1);
  });
  Json proof = certificate(341.4);
  problem_["collision"] = "none";
  file_.write(problem_.dump());
  proof["statement"]["collision"] = "none";
  EXPECT_THAT(verdict(proof), testing::HasSubstr("the collision level ignores"));
}

TEST_F(Scenes, WithTwoGoalsAreProvedByAMultiplierForEach) {
  // One hinge for both goals: (1 - p)^2 + 1 = (3/2 - p)^2 + 0.36, so p = 0.61, d = 1.073 and the score is 341.58,
  // less than the 341.91 for the first alone.
  write([](Json& problem) {
    add_goal(problem, 1.0, 0.0, 1.0);
    add_goal(problem, 0.6, 0.0, 1.5);
  });
  EXPECT_EQ(verdict(certificate(341.85)), "accepted");
}

TEST_F(Scenes, WithAGoalBeyondAllReachAreProvedUnreachableWithoutATree) {
  // Two modules of two lengths of 1.5 m reach 6 m.
  write([](Json& problem) {
    add_goal(problem, 0.0, 6.2, 0.0);
    problem["maxModules"] = 3;
  });
  Json proof = certificate(0.0);
  proof["claim"] = {{"unreachable", true}};
  proof["sequences"] = Json::array();
  EXPECT_EQ(verdict(proof), "accepted");
  problem_["maxModules"] = 4;
  file_.write(problem_.dump());
  proof["statement"]["maxModules"] = 4;
  EXPECT_THAT(verdict(proof), testing::HasSubstr("a sequence is missing"));
}

TEST_F(Scenes, ThatAreNotProvedAboutAreRejectedWithTheReason) {
  const auto reason = [&](const std::function<void(Json&)>& change) {
    write([&](Json& problem) {
      add_goal(problem, 1.0, 0.0, 1.0);
      change(problem);
    });
    const Rounding up{FE_UPWARD};
    try {
      static_cast<void>(read_problem(file_.path(), "", 0, 0));
      return std::string{"read"};
    } catch (const Rejected& rejected) {
      return std::string{rejected.what()};
    } catch (const Malformed& malformed) {
      return std::string{malformed.what()};
    }
  };
  EXPECT_EQ(reason([](Json&) {}), "read");
  EXPECT_THAT(reason([](Json& p) { p["task"]["goals"][0]["goalPose"]["toleranceProjection"][0] = "x"; }),
              testing::HasSubstr("not balls"));
  EXPECT_THAT(reason([](Json& p) { p["task"]["goals"][0]["goalPose"]["tolerance"][0][0] = 0.0005; }),
              testing::HasSubstr("hollow"));
  EXPECT_THAT(reason([](Json& p) { p["task"]["goals"][0]["type"] = "follow"; }), testing::HasSubstr("other types"));
  EXPECT_THAT(reason([](Json& p) {
                p["task"]["obstacles"].push_back({{"motion", 1}});
              }),
              testing::HasSubstr("not known here"));
  EXPECT_THAT(reason([](Json& p) {
                p["task"]["constraints"] = {{"type", "gripperForce"}};
              }),
              testing::HasSubstr("not one of the words"));
  EXPECT_THAT(reason([](Json& p) {
                p["scoring"] = {{"type", "weighted"}, {"mass", -1}};
              }),
              testing::HasSubstr("negative"));
  EXPECT_THAT(reason([](Json& p) { p["maxModules"] = 65; }), testing::HasSubstr("[0, 64]"));
  EXPECT_THAT(reason([](Json& p) { p["library"] = "nowhere.json"; }), testing::HasSubstr("no such file"));
}

TEST_F(Scenes, ScoredByWeightsAreProved) {
  // 10 for reaching, 1 per module behind the base, 2 per kilogram: the hinge of 1.617 kg scores 5.766.
  write([](Json& problem) {
    add_goal(problem, 1.0, 0.0, 1.0);
    problem["scoring"] = {{"type", "weighted"}, {"reached", 10}, {"module", 1}, {"mass", 2}};
  });
  EXPECT_EQ(verdict(certificate(5.8)), "accepted");
  EXPECT_THROW(static_cast<void>(certificate(5.75)), std::logic_error) << "the naive search proves what is false";
}

}  // namespace
}  // namespace modsearch_check
