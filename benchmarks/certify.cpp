// What branch and bound proves, how much processor time that takes, and how much the checker (docs/certificates.md):
// one row per family of random problems, every certificate put before modsearch-check.
//
//   certify [--rows A B ..] [--instances N] [--first I] [--seconds S] [--verbose]
#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <map>
#include <modsearch/baselines/branch_and_bound.hpp>
#include <modsearch/baselines/certificate.hpp>
#include <modsearch/problem/files.hpp>
#include <modsearch/problem/rng.hpp>

namespace modsearch {
namespace {

using Eigen::Vector3d;

// Processor time of this process, or of those it has waited for [s]: what a core of one's own takes, however many
// share it.
double processor_time(int who) {
  rusage usage{};
  getrusage(who, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

// A problem as a file has it.
struct Scene {
  std::string library = "seed";
  int max_modules = 10;
  std::vector<Vector3d> targets{};
  struct Obstacle {
    Vector3d centre;
    Vector3d size;  // edges; a sphere: its radius three times, negative
  };
  std::vector<Obstacle> obstacles{};

  [[nodiscard]] std::string json() const {
    const auto pose = [](const Vector3d& p) {
      return fmt::format("[[1,0,0,{:.6f}],[0,1,0,{:.6f}],[0,0,1,{:.6f}],[0,0,0,1]]", p.x(), p.y(), p.z());
    };
    std::string shapes;
    for (const Obstacle& o : obstacles) {
      const std::string shape =
          o.size.x() < 0.0 ? fmt::format("\"type\":\"sphere\",\"parameters\":{{\"r\":{:.6f}}}", -o.size.x())
                           : fmt::format("\"type\":\"box\",\"parameters\":{{\"x\":{:.6f},\"y\":{:.6f},\"z\":{:.6f}}}",
                                         o.size.x(), o.size.y(), o.size.z());
      shapes += fmt::format("{}{{\"ID\":\"{}\",\"name\":\"o\",\"collision\":[{{{},\"pose\":{}}}]}}",
                            shapes.empty() ? "" : ",", shapes.size(), shape, pose(o.centre));
    }
    std::string goals;
    for (const Vector3d& t : targets) {
      goals += fmt::format(
          "{}{{\"ID\":\"{}\",\"type\":\"reach\",\"goalPose\":{{\"nominal\":{},\"toleranceProjection\":"
          "[\"r_sph\"],\"tolerance\":[[0,0.001]]}}}}",
          goals.empty() ? "" : ",", goals.size(), pose(t));
    }
    return fmt::format(
        "{{\"modsearch\":1,\"task\":{{\"header\":{{\"ID\":\"drawn\",\"version\":\"1\",\"taskName\":\"drawn\","
        "\"timeStepSize\":0.01,\"gravity\":[0,0,-9.81]}},\"obstacles\":[{}],\"constraints\":[{{\"type\":"
        "\"basePlacement\",\"pose\":{{\"nominal\":{}}}}}],\"goals\":[{}]}},\"library\":\"{}\",\"maxModules\":{},"
        "\"collision\":\"posture\",\"scoring\":{{\"type\":\"algorithm1\"}}}}",
        shapes, pose(Vector3d::Zero()), goals, library, max_modules);
  }
};

double distance_to(const Scene::Obstacle& o, const Vector3d& p) {
  if (o.size.x() < 0.0) return (p - o.centre).norm() + o.size.x();
  const Vector3d beyond = (p - o.centre).cwiseAbs() - 0.5 * o.size;
  return beyond.cwiseMax(0.0).norm() + std::min(beyond.maxCoeff(), 0.0);
}

// Keeps clear of the targets and of the first half metre above the base, where every arm stands.
bool fair(const Scene::Obstacle& o, const Scene& scene, double column) {
  for (const Vector3d& t : scene.targets) {
    if (distance_to(o, t) < 0.08) return false;
  }
  for (int i = 0; i <= 10; ++i) {
    if (distance_to(o, {0.0, 0.0, 0.1 * column * i}) < 0.1) return false;
  }
  return true;
}

Vector3d in_box(const Vector3d& lower, const Vector3d& upper, Rng& rng) {
  return {rng.uniform(lower.x(), upper.x()), rng.uniform(lower.y(), upper.y()), rng.uniform(lower.z(), upper.z())};
}

// Uniform in a quarter of the shell between two radii, above the floor.
Vector3d in_shell(double least, double most, Rng& rng) {
  for (;;) {
    const Vector3d p = in_box({0.0, 0.0, 0.0}, {most, most, most}, rng);
    if (p.norm() >= least && p.norm() <= most && p.head<2>().norm() > 0.15) return p;
  }
}

void add_obstacle(Scene& scene, const Vector3d& lower, const Vector3d& upper, double column, Rng& rng) {
  for (;;) {
    Scene::Obstacle o;
    o.centre = in_box(lower, upper, rng);
    o.size = rng.uniform() < 0.5 ? Vector3d{Vector3d::Constant(-rng.uniform(0.1, 0.3))}
                                 : in_box(Vector3d::Constant(0.15), Vector3d::Constant(0.6), rng);
    if (!fair(o, scene, column)) continue;
    scene.obstacles.push_back(o);
    return;
  }
}

int between(int least, int most, Rng& rng) {
  return least + std::min(static_cast<int>(rng.uniform() * (most - least + 1)), most - least);
}

// A sphere or a box across the way to the target.
void block(Scene& scene, double from, double to, double column, Rng& rng) {
  for (int attempt = 0; attempt < 200; ++attempt) {
    Scene::Obstacle o;
    const double t = rng.uniform(from, to);
    o.centre = t * scene.targets[0] + Vector3d{0.0, 0.0, (1.0 - t) * column} +
               in_box(Vector3d::Constant(-0.1), Vector3d::Constant(0.1), rng);
    o.size = rng.uniform() < 0.5 ? Vector3d{Vector3d::Constant(-rng.uniform(0.1, 0.2))}
                                 : in_box(Vector3d::Constant(0.15), Vector3d::Constant(0.4), rng);
    if (!fair(o, scene, column)) continue;
    scene.obstacles.push_back(o);
    return;
  }
}

struct Row {
  std::string name;
  double gap = 1e-4;
  std::string builtin{};  // a sampled problem, else
  std::function<Scene(Rng&)> draw{};
  std::optional<int> fewer{};
  int forced = 0;  // drawn again until so many modules reach without the obstacles, and were not seen to among them
};

// Whether a short search, the same on every machine, finds a design of at most `most` modules.
bool found_quickly(Scene scene, int most, const std::string& file) {
  scene.max_modules = most + 1;
  write_file(file, scene.json());
  Meter meter{{.evaluations = 1'000'000'000}};
  const Solution solution = BranchAndBound{{.gap = 0.05, .boxes = 300}}.solve(*load_problem(file), meter, Rng{0});
  return solution.evaluation.attempt.achieved;
}

Scene drawn(const Row& row, Rng& rng, const std::string& file) {
  for (;;) {
    Scene scene = row.draw(rng);
    if (row.forced == 0) return scene;
    Scene empty = scene;
    empty.obstacles.clear();
    if (found_quickly(empty, row.forced, file) && !found_quickly(scene, row.forced, file)) return scene;
  }
}

std::vector<Row> rows() {
  std::vector<Row> all;
  for (const char* id : {"seed/fixed", "seed/random_narrow", "seed/random_wide", "seed/random_obstacles"}) {
    all.push_back({.name = id, .gap = 1e-4, .builtin = id});
  }
  all.push_back({.name = "free", .gap = 1e-3, .draw = [](Rng& rng) {
                   return Scene{.library = "seed/short", .max_modules = 7, .targets = {in_shell(0.6, 3.2, rng)}};
                 }});
  all.push_back({.name = "two goals", .gap = 1e-2, .draw = [](Rng& rng) {
                   Scene scene{.targets = {in_shell(0.7, 2.2, rng)}};
                   scene.targets.push_back(in_shell(0.7, 2.2, rng));
                   return scene;
                 }});
  all.push_back({.name = "two goals, short", .gap = 1e-2, .draw = [](Rng& rng) {
                   Scene scene{.library = "seed/short", .max_modules = 7, .targets = {in_shell(0.7, 1.7, rng)}};
                   scene.targets.push_back(in_shell(0.7, 1.7, rng));
                   return scene;
                 }});
  all.push_back({.name = "cluttered", .gap = 1e-2, .draw = [](Rng& rng) {
                   Scene scene{.targets = {in_shell(0.8, 2.2, rng)}};
                   for (int n = between(2, 4, rng); n > 0; --n) {
                     add_obstacle(scene, {-0.6, -0.6, 0.0}, {1.4, 1.4, 1.8}, 0.5, rng);
                   }
                   return scene;
                 }});
  all.push_back({.name = "blocked", .gap = 1e-2, .draw = [](Rng& rng) {
                   Scene scene{.targets = {in_shell(0.9, 2.0, rng)}};
                   for (int n = between(1, 2, rng); n > 0; --n) block(scene, 0.3, 0.8, 0.5, rng);
                   add_obstacle(scene, {-0.6, -0.6, 0.0}, {1.4, 1.4, 1.8}, 0.5, rng);
                   return scene;
                 }});
  all.push_back({.name = "blocked, short", .gap = 1e-2, .draw = [](Rng& rng) {
                   Scene scene{.library = "seed/short", .max_modules = 7, .targets = {in_shell(0.9, 1.7, rng)}};
                   for (int n = between(2, 4, rng); n > 0; --n) block(scene, 0.3, 0.85, 0.2, rng);
                   return scene;
                 }});
  all.push_back({.name = "wall and roof", .gap = 1e-2, .draw = [](Rng& rng) {
                   Scene scene{.library = "seed/short", .max_modules = 7};
                   const double x = rng.uniform(0.35, 0.6);
                   const double height = rng.uniform(0.4, 0.9);
                   scene.targets = {{x + rng.uniform(0.25, 0.5), rng.uniform(0.0, 0.4), rng.uniform(0.1, 0.4)}};
                   scene.obstacles.push_back({{x, 0.0, 0.5 * height}, {0.08, 2.0, height}});
                   scene.obstacles.push_back({{x, 0.0, height + rng.uniform(0.6, 0.9)}, {2.0, 2.0, 0.08}});
                   return scene;
                 }});
  const auto in_the_way = [](double least, double most) {
    return [=](Rng& rng) {
      Scene scene{.library = "seed/short", .max_modules = 7, .targets = {in_shell(least, most, rng)}};
      for (int n = between(2, 5, rng); n > 0; --n) block(scene, 0.2, 0.85, 0.3, rng);
      return scene;
    };
  };
  all.push_back({.name = "3 modules, obstacles", .gap = 5e-2, .draw = in_the_way(1.2, 1.75), .forced = 2});
  all.push_back({.name = "fewer than 2, obstacles", .draw = in_the_way(0.6, 1.1), .fewer = 1, .forced = 1});
  all.push_back({.name = "fewer than 3, obstacles", .draw = in_the_way(1.2, 1.75), .fewer = 2, .forced = 2});
  all.push_back({.name = "4 to 6 modules", .gap = 1e-3, .draw = [](Rng& rng) {
                   return Scene{.library = "seed/short", .max_modules = 7, .targets = {in_shell(3.7, 6.0, rng)}};
                 }});
  return all;
}

double quantile(std::vector<double> values, double q) {
  if (values.empty()) return std::nan("");
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(std::lround(q * static_cast<double>(values.size() - 1)))];
}

struct Arguments {
  std::vector<std::string> rows;
  std::uint64_t instances = 15;
  std::uint64_t first = 0;
  double seconds = 30.0;
  bool verbose = false;
  std::filesystem::path folder =
      std::filesystem::temp_directory_path() / fmt::format("modsearch-certify-{}", ::getpid());
  std::string checker;
};

void run_row(const Row& row, const Arguments& arguments) {
  std::vector<double> found, checked, bytes, leaves;
  std::string modules;
  int proved = 0, closed = 0, refuted = 0, accepted = 0;
  std::map<std::size_t, int> lengths;
  for (std::uint64_t i = arguments.first; i < arguments.first + arguments.instances; ++i) {
    Rng rng = Rng{2024}.fork(row.name).fork(i);
    std::string name = row.builtin;
    std::optional<Instance> instance;
    if (name.empty()) {
      name = (arguments.folder / fmt::format("problem-{}.json", i)).string();
      const std::string file = name;
      write_file(file, drawn(row, rng, file).json());
    } else if (load_problem_file(name).sampling) {
      instance = Instance{2022, i};
    } else if (i > arguments.first) {
      break;
    }
    const auto problem = load_problem(name, instance.value_or(Instance{}));
    const double start = processor_time(RUSAGE_SELF);
    Meter meter{{.evaluations = 1'000'000'000, .seconds = arguments.seconds}};
    const Certificate certificate = make_certificate(*problem, {.gap = row.gap, .fewer = row.fewer},
                                                     {name, instance, R"({"type":"algorithm1"})"}, meter);
    const double seconds = processor_time(RUSAGE_SELF) - start;
    double checking = std::nan("");
    if (!certificate.json.empty()) {
      ++proved;
      const std::string file = (arguments.folder / "certificate.json").string();
      write_file(file, certificate.json);
      const double before = processor_time(RUSAGE_CHILDREN);
      const bool good = std::system(fmt::format("'{}' '{}' > '{}.txt'", arguments.checker, file, file).c_str()) == 0;
      checking = processor_time(RUSAGE_CHILDREN) - before;
      accepted += good ? 1 : 0;
      checked.push_back(checking);
      bytes.push_back(static_cast<double>(certificate.json.size()));
      leaves.push_back(static_cast<double>(certificate.leaves));
      if (!good) fmt::print("  REJECTED {} {}\n", row.name, i);
    }
    closed += certificate.closed || certificate.refuted_by ? 1 : 0;
    refuted += certificate.refuted_by ? 1 : 0;
    found.push_back(seconds);
    if (arguments.verbose) {
      fmt::print(
          "  {:<24} {:>3}: {:.3f} s, check {:.3f} s, boxes {}, leaves {}, lower {:.6f}, upper {:.6f}, gap {:.4f} % "
          "{}\n",
          row.name, i, seconds, checking, certificate.boxes, certificate.leaves,
          certificate.lower.value_or(std::nan("")), certificate.upper, 100.0 * certificate.gap.value_or(std::nan("")),
          certificate.open);
      std::fflush(stdout);
    }
  }
  if (refuted > 0) fmt::print("  {}: {} refuted by a design\n", row.name, refuted);
  fmt::print(
      "| {} | {:.3g} % | {} | {} | {} | {:.4f} / {:.4f} | {:.4f} / {:.4f} | {:.0f} / {:.0f} | {:.1f} / {:.1f} |\n",
      row.name, 100.0 * row.gap, found.size(), closed, accepted, quantile(found, 0.5), quantile(found, 1.0),
      quantile(checked, 0.5), quantile(checked, 1.0), quantile(leaves, 0.5), quantile(leaves, 1.0),
      1e-3 * quantile(bytes, 0.5), 1e-3 * quantile(bytes, 1.0));
  std::fflush(stdout);
}

}  // namespace
}  // namespace modsearch

int main(int argc, char** argv) {
  using namespace modsearch;
  CLI::App app{"what branch and bound proves, and how fast"};
  Arguments arguments;
  arguments.checker = (std::filesystem::read_symlink("/proc/self/exe").parent_path() / "modsearch-check").string();
  app.add_option("--rows", arguments.rows, "some of the rows");
  app.add_option("--instances", arguments.instances);
  app.add_option("--first", arguments.first);
  app.add_option("--seconds", arguments.seconds, "per instance, search and certificate, of the clock on the wall");
  app.add_option("--folder", arguments.folder);
  app.add_flag("--verbose", arguments.verbose, "a line per instance");
  CLI11_PARSE(app, argc, argv);
  std::filesystem::create_directories(arguments.folder);
  fmt::print("| row | gap | instances | closed | accepted | found [s] median / worst | checked [s] | leaves | kB |\n");
  fmt::print("|---|---|---|---|---|---|---|---|---|\n");
  for (const Row& row : rows()) {
    if (!arguments.rows.empty() &&
        std::find(arguments.rows.begin(), arguments.rows.end(), row.name) == arguments.rows.end())
      continue;
    run_row(row, arguments);
  }
}
