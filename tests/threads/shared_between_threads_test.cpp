// What the documentation says is safe to share between threads, or callable from any thread, used by several at once:
// made for the thread sanitizer (./test.sh --sanitize=thread), and worth a look at the results without it.
#include <gtest/gtest.h>

#include <barrier>
#include <functional>
#include <modsearch/baselines/per_sequence.hpp>
#include <modsearch/kinematics/path_planning.hpp>
#include <modsearch/kinematics/separation.hpp>
#include <modsearch/problem/files.hpp>
#include <modsearch/problem/geometry_internal.hpp>
#include <modsearch/problem/output_lock.hpp>
#include <modsearch/problem/problem_source.hpp>
#include <modsearch/rl/agents.hpp>
#include <modsearch/rl/learner.hpp>
#include <modsearch/solvers/meter.hpp>
#include <thread>
#include <vector>

#include "places.hpp"
#include "problem/temporary_folder.hpp"

namespace modsearch {
namespace {

constexpr int kThreads = 4;

/// What `work` gives in each of the threads, which begin together.
template <typename Result>
std::vector<Result> from_all_threads(const std::function<Result(int thread)>& work) {
  std::vector<Result> results(kThreads);
  std::barrier start{kThreads};
  {
    std::vector<std::jthread> threads;
    for (int i = 0; i < kThreads; ++i) {
      threads.emplace_back([&, i] {
        start.arrive_and_wait();
        results[static_cast<std::size_t>(i)] = work(i);
      });
    }
  }
  return results;
}

template <typename Result>
void expect_all_equal(const std::vector<Result>& results) {
  for (const Result& result : results) EXPECT_EQ(result, results.front());
}

Design random_design(const DesignProblem& problem, int n, Rng& rng) {
  Design design;
  for (int i = 0; i < n; ++i) {
    const std::vector<int> types = problem.successors(design.types());
    if (types.empty()) break;
    const int k = types[static_cast<std::size_t>(rng.uniform(0.0, 1.0) * static_cast<double>(types.size()))];
    const auto& ranges = problem.library().type(k).parameters;
    Placement placement{k, Parameters(static_cast<Eigen::Index>(ranges.size()))};
    for (std::size_t p = 0; p < ranges.size(); ++p) {
      placement.parameters[static_cast<Eigen::Index>(p)] = rng.uniform(ranges[p].lower, ranges[p].upper);
    }
    design.modules.push_back(std::move(placement));
  }
  return design;
}

std::vector<double> scores(const DesignProblem& problem, int n_designs) {
  Rng rng{7};
  std::vector<double> result;
  for (int i = 0; i < n_designs; ++i) result.push_back(problem.evaluate(random_design(problem, 1 + i % 4, rng)).score);
  return result;
}

class SharedProblem : public testing::TestWithParam<const char*> {};

TEST_P(SharedProblem, EvaluatesFromAnyThread) {
  const auto problem = load_problem(GetParam());
  expect_all_equal(from_all_threads<std::vector<double>>([&](int) { return scores(*problem, 12); }));
}

TEST_P(SharedProblem, ProvesAndBoundsFromAnyThread) {
  const auto problem = load_problem(GetParam());
  expect_all_equal(from_all_threads<std::vector<double>>([&](int) {
    std::vector<double> facts{problem->infeasible() ? 1.0 : 0.0};
    for (int n = 1; n < 4; ++n) facts.push_back(problem->optimism_of_length(n).score);
    for (const int k : problem->successors({})) facts.push_back(problem->optimism(std::vector<int>{k}).score);
    return facts;
  }));
}

TEST_P(SharedProblem, IsSolvedFromAnyThread) {
  const auto problem = load_problem(GetParam());
  const PerSequence solver{{.inner = Inner::kOwn}};
  expect_all_equal(from_all_threads<double>([&](int) {
    Meter meter{{.evaluations = 20}};
    return solver.solve(*problem, meter, Rng{1}).evaluation.score;
  }));
}

INSTANTIATE_TEST_SUITE_P(Threads, SharedProblem,
                         testing::Values("seed/fixed", "seed/random_obstacles", "workshop/reach", "workshop/cell"));

TEST(Threads, ShareTheTreesOfAMesh) {
  auto triangles = std::make_shared<TriangleMesh>();
  triangles->vertices = {{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}};
  triangles->triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
  const Shape mesh = Mesh{triangles};
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.translation() = Eigen::Vector3d{2.0, 0.1, 0.1};
  expect_all_equal(from_all_threads<double>([&](int) {
    double sum = 0.0;
    for (int i = 0; i < 50; ++i) {
      // One mesh that all share, and one that comes and goes.
      const Shape own = Mesh{std::make_shared<const TriangleMesh>(*triangles)};
      sum += separation(Sphere{0.1}, X, mesh, Eigen::Isometry3d::Identity()).distance;
      sum += separation(Sphere{0.1}, X, own, Eigen::Isometry3d::Identity()).distance;
    }
    return sum;
  }));
}

TEST(Threads, ReadFilesAndMeshesAtOnce) {
  const std::filesystem::path mesh = test::source_folder() / "tests/fuzz_corpus/mesh_stl/tetrahedron_ascii.stl";
  expect_all_equal(from_all_threads<std::size_t>([&](int) {
    std::size_t sum = 0;
    for (int i = 0; i < 5; ++i) {
      sum += detail::load_mesh(mesh, Eigen::Vector3d::Ones())->triangles.size();
      sum += load_library("workshop")->n_types();
      sum += load_task(test::source_folder() / "tests/fuzz_corpus/task/moving.json").goals.size();
    }
    return sum;
  }));
}

TEST(Threads, WriteFilesBesideEachOther) {
  const test::TemporaryFolder folder;
  expect_all_equal(from_all_threads<int>([&](int thread) {
    const std::filesystem::path own = folder.path() / std::to_string(thread);
    for (int i = 0; i < 20; ++i) {
      const OutputLock lock = OutputLock::of_file(own);
      write_file(own, "own");
      write_file(folder.path() / "shared", "the last one counts");
    }
    return 0;
  }));
}

TEST(Threads, DrawInstancesFromOneSource) {
  const ProblemSource source = problem_source(load_problem_file("seed/random_obstacles"));
  expect_all_equal(from_all_threads<double>([&](int) {
    double sum = 0.0;
    for (std::uint64_t i = 0; i < 10; ++i) sum += source(Rng{i})->context().sum();
    return sum;
  }));
}

TEST(Threads, SolveWithOnePolicy) {
  const ProblemSource source = problem_source(load_problem_file("seed/random_narrow"));
  LearnerSettings settings = settings_of(AgentKind::kMpdqn, Preset::kBest);
  settings.training.episodes = 20;
  Meter training_meter{{}};
  const Training training = AgentLearner{settings}.train(source, training_meter, Rng{2});
  const auto problem = source(Rng{3});
  expect_all_equal(from_all_threads<double>([&](int) {
    Meter meter{{}};
    return training.policy->solve(*problem, meter, Rng{0}).evaluation.score;
  }));
}

TEST(Threads, SolveWithLibrariesThatKeepOneStateForAll) {
  const auto problem = load_problem("seed/fixed");
  for (const Inner inner : {Inner::kIpopt, Inner::kIsres}) {
    const PerSequence solver{{.inner = inner}};
    expect_all_equal(from_all_threads<double>([&](int) {
      Meter meter{{.evaluations = 4}};
      return solver.solve(*problem, meter, Rng{1}).evaluation.score;
    }));
  }
}

}  // namespace
}  // namespace modsearch
