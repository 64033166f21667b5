// The search beside the checker, which shares no code with it: equal arms, equal bounds, certificates that are
// accepted.
#include <gmock/gmock.h>

#include <cfenv>
#include <checker/bound.hpp>
#include <checker/twin.hpp>
#include <modsearch/baselines/branch_and_bound.hpp>
#include <modsearch/baselines/certificate.hpp>
#include <modsearch/baselines/certify/node_bound_internal.hpp>
#include <modsearch/baselines/certify/twins_internal.hpp>
#include <modsearch/problem/files.hpp>
#include <modsearch/problem/rng.hpp>

#include "naive_certificate.hpp"

namespace modsearch_check {
namespace {

namespace certify = modsearch::certify;

constexpr const char* kScenes[] = {"seed/random_obstacles", "breakeven/short", "breakeven/two_goals"};

certify::Row in_search(const Row& row) {
  return {.goal = static_cast<int>(row.goal),
          .run = static_cast<int>(row.run),
          .tau = row.tau,
          .shape = static_cast<int>(row.shape),
          .ball = row.ball,
          .centre = {row.centre[0], row.centre[1], row.centre[2]},
          .radius = row.radius,
          .face = static_cast<int>(row.face)};
}

/// Random boxes, multipliers and rows.
class Draw {
 public:
  explicit Draw(std::uint64_t seed) : rng_{seed} {}

  double uniform(double lower, double upper) { return rng_.uniform(lower, upper); }

  std::vector<std::size_t> types(std::size_t most) {
    std::vector<std::size_t> types;
    for (int n = 1 + rng_.index(static_cast<int>(most)); n > 0; --n)
      types.push_back(static_cast<std::size_t>(rng_.index(3)));
    return types;
  }

  Box box(const Box& root) {
    Box box = root;
    const double scale = std::exp2(uniform(-10.0, 0.0));
    for (std::size_t v = 0; v < box.lower.size(); ++v) {
      const double width = (root.upper[v] - root.lower[v]) * scale * uniform(0.2, 1.0);
      box.lower[v] += uniform(0.0, 1.0) * (root.upper[v] - root.lower[v] - width);
      box.upper[v] = box.lower[v] + width;
    }
    return box;
  }

  Row row(const Problem& problem, const Model& model) {
    Row row{0,
            static_cast<std::size_t>(rng_.index(static_cast<int>(model.runs.size()))),
            uniform(0.0, 1.0),
            0.0,
            static_cast<std::size_t>(rng_.index(3)),
            true,
            {},
            0.0,
            static_cast<std::size_t>(rng_.index(6))};
    const Shape& shape = problem.task.obstacles[row.shape];
    row.centre = middle(shape.pose.move.offset);
    if (shape.kind == Kind::kSphere) {
      row.radius = shape.size[0].offset.lower();
    } else if (rng_.uniform() < 0.5) {
      row.ball = false;
    } else {
      row.radius = 0.1;
    }
    return row;
  }

 private:
  modsearch::Rng rng_;
};

TEST(SearchAndChecker, SeeEqualArms) {
  for (const char* id : kScenes) {
    const auto toolkit = modsearch::load_problem(id);
    const Rounding up{FE_UPWARD};
    const Problem problem = read_problem(id, "", 0, 0);
    Draw draw{1};
    for (int i = 0; i < 60; ++i) {
      const std::vector<std::size_t> types = draw.types(4);
      const Model theirs = Assembler{problem}.model(types);
      const Rounding nearest{FE_TONEAREST};
      const certify::SequenceModel ours{*toolkit, std::vector<int>(types.begin(), types.end())};
      const certify::Box box = certify::root_box(ours, static_cast<int>(problem.task.goals.size()));
      const Box root = root_box(theirs, problem.task.goals.size());
      ASSERT_EQ(box.lower.size(), root.lower.size());
      for (std::size_t v = 0; v < root.lower.size(); ++v) {
        EXPECT_NEAR(box.lower[v], root.lower[v], 1e-15 * 16);
        EXPECT_NEAR(box.upper[v], root.upper[v], 1e-15 * 16);
      }
      ASSERT_EQ(ours.runs.size(), theirs.runs.size());
      for (std::size_t r = 0; r < ours.runs.size(); ++r) {
        EXPECT_EQ(ours.runs[r].usable, theirs.runs[r].usable);
        EXPECT_EQ(static_cast<std::size_t>(ours.runs[r].frame), theirs.runs[r].frame);
      }
      for (std::size_t j = 0; j < ours.frames.size(); ++j) {
        EXPECT_EQ(static_cast<std::size_t>(ours.frames[j].acting), theirs.frames[j].acting);
      }
    }
  }
}

TEST(SearchAndChecker, LeaveOutEqualTwins) {
  int halved = 0;
  for (const char* id : kScenes) {
    const auto toolkit = modsearch::load_problem(id);
    const Rounding up{FE_UPWARD};
    const Problem problem = read_problem(id, "", 0, 0);
    const std::size_t n_goals = problem.task.goals.size();
    Draw draw{4};
    for (int i = 0; i < 60; ++i) {
      const std::vector<std::size_t> types = draw.types(4);
      const Model theirs = Assembler{problem}.model(types);
      const Box root = root_box(theirs, n_goals);
      const std::vector<int> ours = [&] {
        const Rounding nearest{FE_TONEAREST};
        const certify::SequenceModel model{*toolkit, std::vector<int>(types.begin(), types.end())};
        return certify::half_circles(model, static_cast<int>(n_goals));
      }();
      for (std::size_t v = 0; v < root.lower.size(); ++v) {
        if (std::count(ours.begin(), ours.end(), static_cast<int>(v)) > 0) {
          EXPECT_NO_THROW(require_twins(theirs, root, v));
          ++halved;
        } else {
          EXPECT_THROW(require_twins(theirs, root, v), Rejected);
        }
      }
    }
  }
  EXPECT_GT(halved, 50);
}

TEST(SearchAndChecker, GiveEqualBounds) {
  int with_rows = 0;
  for (const char* id : kScenes) {
    const auto toolkit = modsearch::load_problem(id);
    const certify::Scenery scenery = certify::scenery_of(*toolkit);
    const Rounding up{FE_UPWARD};
    const Problem problem = read_problem(id, "", 0, 0);
    Draw draw{2};
    for (int i = 0; i < 1500; ++i) {
      const std::vector<std::size_t> types = draw.types(3);
      const Model theirs = Assembler{problem}.model(types);
      const Box box = draw.box(root_box(theirs, problem.task.goals.size()));
      Leaf leaf{draw.uniform(0.0, 1.0) < 0.5, draw.uniform(0.0, 1.0) < 0.3, {}, {}};
      for (std::size_t g = 0; g < problem.task.goals.size(); ++g) {
        leaf.y.push_back({draw.uniform(-2.0, 2.0), draw.uniform(-2.0, 2.0), draw.uniform(-2.0, 2.0)});
      }

      const certify::SequenceModel ours = [&] {
        const Rounding nearest{FE_TONEAREST};
        return certify::SequenceModel{*toolkit, std::vector<int>(types.begin(), types.end())};
      }();
      double bound = 0.0;
      {
        const Rounding nearest{FE_TONEAREST};
        certify::NodeBound node{ours, scenery};
        node.set_box({box.lower, box.upper});
        std::vector<double> multipliers;
        for (const Numbers& y : leaf.y) multipliers.insert(multipliers.end(), y.begin(), y.end());
        if (!problem.task.obstacles.empty()) {
          for (int k = 0; k < 3; ++k) {
            Row row = draw.row(problem, theirs);
            if (!node.add_row(in_search(row))) continue;
            const double multiplier = draw.uniform(0.0, 1.0);
            row.mu = multiplier / node.normal_length(node.n_rows() - 1);
            multipliers.push_back(multiplier);
            leaf.rows.push_back(row);
          }
        }
        const auto objective = leaf.mass ? certify::Objective::kMass : certify::Objective::kNothing;
        bound = node.value(multipliers.data(), leaf.cap, objective, nullptr);
      }
      with_rows += leaf.rows.empty() ? 0 : 1;
      EXPECT_NEAR(bound, lower_bound(problem, theirs, box, leaf), 1e-9 * (1.0 + std::abs(bound)));
    }
  }
  EXPECT_GT(with_rows, 300);
}

TEST(NodeBound, GradientsAreThoseOfDifferences) {
  for (const char* id : kScenes) {
    const auto toolkit = modsearch::load_problem(id);
    const certify::Scenery scenery = certify::scenery_of(*toolkit);
    const Problem problem = [&] {
      const Rounding up{FE_UPWARD};
      return read_problem(id, "", 0, 0);
    }();
    Draw draw{3};
    int smooth = 0;
    for (int i = 0; i < 300; ++i) {
      const std::vector<std::size_t> types = draw.types(3);
      const certify::SequenceModel model{*toolkit, std::vector<int>(types.begin(), types.end())};
      const certify::Box root = certify::root_box(model, static_cast<int>(scenery.targets.size()));
      const Box box = draw.box({root.lower, root.upper});
      certify::NodeBound node{model, scenery};
      node.set_box({box.lower, box.upper});
      if (!scenery.obstacles.empty()) {
        const Model theirs = [&] {
          const Rounding up{FE_UPWARD};
          return Assembler{problem}.model(types);
        }();
        for (int k = 0; k < 3; ++k) static_cast<void>(node.add_row(in_search(draw.row(problem, theirs))));
      }
      const auto n = static_cast<std::size_t>(node.n_multipliers());
      std::vector<double> multipliers;
      for (std::size_t m = 0; m < n; ++m) multipliers.push_back(draw.uniform(0.1, 2.0));
      const bool cap = draw.uniform(0.0, 1.0) < 0.3;
      std::vector<double> gradient(n);
      const double value = node.value(multipliers.data(), cap, certify::Objective::kMass, gradient.data());
      for (std::size_t m = 0; m < n; ++m) {
        constexpr double kStep = 1e-6;
        const auto moved = [&](double step) {
          std::vector<double> there = multipliers;
          there[m] += step;
          return node.value(there.data(), cap, certify::Objective::kMass, nullptr);
        };
        const double up = (moved(kStep) - value) / kStep;
        const double down = (value - moved(-kStep)) / kStep;
        // A concave function with corners: the gradient lies between the slopes to both sides.
        const double tolerance = 1e-4 * (1.0 + std::abs(gradient[m]));
        if (!cap) {
          EXPECT_GE(gradient[m], up - tolerance);
          EXPECT_LE(gradient[m], down + tolerance);
        }
        if (std::abs(up - down) < tolerance) {
          EXPECT_NEAR(gradient[m], up, 2.0 * tolerance);
          ++smooth;
        }
      }
    }
    EXPECT_GT(smooth, 300);
  }
}

class Certificates : public testing::Test {
 protected:
  static modsearch::Certificate made(const std::string& id, std::uint64_t index, double gap) {
    const modsearch::ProblemFile file = modsearch::load_problem_file(id);
    std::optional<modsearch::Instance> instance;
    if (file.sampling) instance = modsearch::Instance{7, index};
    const auto problem = file.instance(instance.value_or(modsearch::Instance{}));
    modsearch::Meter meter;
    return modsearch::make_certificate(*problem, {.gap = gap}, {id, instance, R"({"type":"algorithm1"})"}, meter);
  }

  Proof checked(const std::string& text) {
    file_.write(text);
    return check_certificate(file_.path());
  }

  TemporaryFile file_{"search.json"};
};

TEST_F(Certificates, OfTheReferenceScenariosAreAccepted) {
  for (const char* id : {"seed/fixed", "seed/random_narrow", "seed/random_wide", "seed/random_obstacles"}) {
    for (std::uint64_t index = 0; index < 10; ++index) {
      const modsearch::Certificate certificate = made(id, index, 1e-4);
      ASSERT_TRUE(certificate.closed) << id << ' ' << index;
      const Proof proof = checked(certificate.json);
      EXPECT_EQ(proof.upper, certificate.upper);
      EXPECT_LE(*proof.gap, 1e-4 * (1.0 + 1e-6));
    }
  }
}

TEST_F(Certificates, OfHarderFamiliesAreAccepted) {
  for (const char* id : {"breakeven/short", "breakeven/clutter"}) {
    const modsearch::Certificate certificate = made(id, 1, 0.05);
    ASSERT_TRUE(certificate.closed) << id;
    EXPECT_EQ(checked(certificate.json).upper, certificate.upper);
  }
}

TEST_F(Certificates, OfTwoGoalsThatOneModuleNearlyReachesTakeFewBoxes) {
  const modsearch::Certificate certificate = made("breakeven/two_goals", 1, 0.05);
  ASSERT_TRUE(certificate.closed);
  EXPECT_LT(certificate.boxes, 1000);
  EXPECT_EQ(checked(certificate.json).upper, certificate.upper);
}

TEST_F(Certificates, ThatAreChangedAreRejectedWhereTheyClaimTooMuch) {
  const Json good = Json::parse(made("seed/random_obstacles", 1, 1e-3).json);
  EXPECT_NO_THROW(static_cast<void>(checked(good.dump())));
  Json lowered = good;  // consistent in itself, but not proved
  const double mass = (350.0 - good["claim"]["lower"].get<double>()) / 5.0;
  lowered["claim"]["upper"] = good["claim"]["lower"].get<double>() + 5.0 * mass * 1e-6;
  lowered["claim"]["gap"] = 1e-6;
  EXPECT_THROW(static_cast<void>(checked(lowered.dump())), Rejected);
  Json without = good;
  without["sequences"].erase(without["sequences"].size() - 1);
  EXPECT_THROW(static_cast<void>(checked(without.dump())), Rejected);
  Json open = good;
  Json& tree = open["sequences"][0]["tree"];
  tree.erase(tree.size() - 1);
  EXPECT_THROW(static_cast<void>(checked(open.dump())), Rejected);
  Json wider = good;  // a part that reaches into what holds the best design
  for (Json& sequence : wider["sequences"]) {
    for (Json& node : sequence["tree"]) {
      if (node[0] != "c") continue;
      Json& part = node[1][1];
      const double place = std::strtod(part[1].get<std::string>().c_str(), nullptr);
      part[1] = hex(part[2] == "above" ? place - 0.05 : place + 0.05);
    }
  }
  ASSERT_NE(wider, good);
  EXPECT_THROW(static_cast<void>(checked(wider.dump())), Rejected);
  Json moved = good;
  moved["incumbent"]["postures"][0][0] = hex(0.1);
  EXPECT_THROW(static_cast<void>(checked(moved.dump())), Rejected);
}

TEST_F(Certificates, LeaveOutHalfACircleOnlyWhereItsTwinsAre) {
  const Json good = Json::parse(made("seed/random_wide", 2, 1e-4).json);
  EXPECT_NO_THROW(static_cast<void>(checked(good.dump())));
  const auto tree_of = [](Json& certificate, const char* first) -> Json& {
    for (Json& sequence : certificate["sequences"]) {
      if (sequence["types"][0] == first) return sequence["tree"];
    }
    throw std::logic_error("no such sequence");
  };
  Json with = good;
  Json& hinge = tree_of(with, "hinge");
  ASSERT_EQ(hinge[0], Json({"h", 2}));  // lengths: proximal, distal; then the base
  const auto reason = [&](const Json& certificate) -> std::string {
    try {
      static_cast<void>(checked(certificate.dump()));
    } catch (const Rejected& why) {
      return why.what();
    }
    return "accepted";
  };
  Json other = good;  // of the hinge itself
  tree_of(other, "hinge")[0] = {"h", 3};
  EXPECT_THAT(reason(other), testing::HasSubstr("half a circle is not enough"));
  Json length = good;
  tree_of(length, "hinge")[0] = {"h", 0};
  EXPECT_THAT(reason(length), testing::HasSubstr("half a circle is asked of a length"));
  Json twice = good;
  tree_of(twice, "hinge").insert(tree_of(twice, "hinge").begin(), Json({"h", 2}));
  EXPECT_THAT(reason(twice), testing::HasSubstr("in the wrong order"));
  Json late = good;
  tree_of(late, "hinge").erase(0);
  tree_of(late, "hinge").insert(tree_of(late, "hinge").begin(), {Json({"s", 0, hex(0.8)}), Json({"h", 2})});
  EXPECT_THAT(reason(late), testing::HasSubstr("in the middle of a tree"));
  Json elbow = good;  // a rotary's arm has no twin
  for (std::size_t v : {2U, 3U}) {
    elbow = good;
    tree_of(elbow, "rotary").insert(tree_of(elbow, "rotary").begin(), Json({"h", v}));
    EXPECT_THAT(reason(elbow), testing::HasSubstr("half a circle is"));
  }
}

TEST_F(Certificates, SayThatFewerModulesDoNotSuffice) {
  // 1 + 0.6 + 0.6 m reach the corner at sqrt(3) m, one short module does not.
  const std::string id = "breakeven/short";
  const auto problem = modsearch::load_problem(id, {7, 2});
  modsearch::Meter meter;
  const modsearch::Certificate certificate = modsearch::make_certificate(
      *problem, {.fewer = 1}, {id, modsearch::Instance{7, 2}, R"({"type":"algorithm1"})"}, meter);
  ASSERT_TRUE(certificate.closed) << certificate.open;
  EXPECT_LT(checked(certificate.json).upper, 200.0);
}

TEST_F(Certificates, NameADesignOfFewerModulesWhereThereIsOne) {
  // One hinge reaches the target of seed/fixed.
  const auto problem = modsearch::load_problem("seed/fixed");
  modsearch::Meter meter;
  const modsearch::Certificate certificate =
      modsearch::make_certificate(*problem, {.fewer = 1}, {"seed/fixed", {}, R"({"type":"algorithm1"})"}, meter);
  EXPECT_FALSE(certificate.closed);
  EXPECT_TRUE(certificate.json.empty());
  ASSERT_TRUE(certificate.refuted_by);
  EXPECT_EQ(certificate.refuted_by->modules.size(), 1U);
  EXPECT_TRUE(problem->evaluate(*certificate.refuted_by).attempt.achieved);
  EXPECT_THAT(certificate.open, testing::HasSubstr("a design of 1 module does: it scores 341.91"));
}

// Rounding leaves about 2e-7 of the mass open.
TEST_F(Certificates, OfAGapThatIsTooSmallProveALooserOne) {
  for (const char* id : {"seed/fixed", "seed/random_obstacles"}) {
    const modsearch::Certificate certificate = made(id, 1, 1e-7);
    EXPECT_FALSE(certificate.closed);
    EXPECT_FALSE(certificate.open.empty());
    const Proof proof = checked(certificate.json);
    EXPECT_EQ(proof.upper, certificate.upper);
    EXPECT_GT(*proof.gap, 1e-7);
    EXPECT_LT(*proof.gap, 1e-4);
  }
}

TEST_F(Certificates, StopInTimeAndStillProveWhatTheySay) {
  const std::string id = "breakeven/clutter";
  const auto problem = modsearch::load_problem(id, {7, 0});
  modsearch::Meter meter{{.seconds = 0.4}};
  const modsearch::Certificate certificate = modsearch::make_certificate(
      *problem, {.gap = 1e-7}, {id, modsearch::Instance{7, 0}, R"({"type":"algorithm1"})"}, meter);
  EXPECT_LT(meter.progress().seconds, 1.0);
  if (!certificate.json.empty()) {
    EXPECT_EQ(checked(certificate.json).upper, certificate.upper);
  }
}

TEST_F(Certificates, AreRefusedForWhatTheyCannotBeAbout) {
  modsearch::RobotProblemSpec spec = modsearch::load_problem("seed/fixed")->spec();
  spec.task = std::make_shared<modsearch::GoalTask>(
      "pose",
      std::vector<modsearch::Goal>{{"here", modsearch::GoalType::kReach,
                                    modsearch::PoseRegion::with_default_tolerances(Eigen::Isometry3d::Identity())}});
  modsearch::Meter meter;
  EXPECT_THAT(
      [&] {
        static_cast<void>(
            modsearch::make_certificate(modsearch::RobotProblem{spec}, {}, {"p", std::nullopt, "{}"}, meter));
      },
      testing::ThrowsMessage<std::invalid_argument>(testing::HasSubstr("goal here is not a ball about a position")));
}

TEST_F(Certificates, AreRefusedForTorquesStepsAndObstaclesThatMove) {
  const modsearch::RobotProblemSpec plain = modsearch::load_problem("seed/fixed")->spec();
  const modsearch::GoalTaskSpec task{.name = "t", .goals = {plain.task->goals()[0]}};
  const auto refusal = [&](const modsearch::GoalTaskSpec& asked, const modsearch::Scene& scene) -> std::string {
    modsearch::RobotProblemSpec spec = plain;
    spec.task = std::make_shared<modsearch::GoalTask>(asked);
    spec.scene = std::make_shared<modsearch::Scene>(scene);
    modsearch::Meter meter;
    try {
      static_cast<void>(
          modsearch::make_certificate(modsearch::RobotProblem{spec}, {}, {"p", std::nullopt, "{}"}, meter));
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  };
  modsearch::GoalTaskSpec heavy = task;
  heavy.statics.limited = true;
  EXPECT_THAT(refusal(heavy, {}), testing::HasSubstr("joint torques are limited"));
  modsearch::GoalTaskSpec resting = task;
  resting.steps = {{.id = "go"}, {.id = "rest", .kind = modsearch::TaskStep::Kind::kPause, .duration = 1.0}};
  EXPECT_THAT(refusal(resting, {}), testing::HasSubstr("trajectories, pauses or returns"));
  modsearch::Obstacle ball{"ball", {{modsearch::Sphere{0.1}, Eigen::Isometry3d::Identity()}}};
  ball.motion = {{0.0}, {Eigen::Isometry3d::Identity()}};
  EXPECT_THAT(refusal(task, modsearch::Scene{{ball}}), testing::HasSubstr("an obstacle moves"));
}

}  // namespace
}  // namespace modsearch_check
