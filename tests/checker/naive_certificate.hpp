#pragma once

#include <checker/certificate.hpp>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>

namespace modsearch_check {

inline std::string hex(double number) {
  char text[40];
  std::snprintf(text, sizeof text, "%a", number);
  return text;
}

/// A file that is gone when the test is over.
class TemporaryFile {
 public:
  explicit TemporaryFile(const std::string& name)
      : path_{std::filesystem::temp_directory_path() / (std::to_string(::getpid()) + "_" + name)} {}
  ~TemporaryFile() { std::filesystem::remove(path_); }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;

  [[nodiscard]] std::string path() const { return path_.string(); }
  void write(const std::string& text) const { std::ofstream{path_, std::ios::binary} << text; }

 private:
  std::filesystem::path path_;
};

/// Writes certificates the slow and simple way: boxes are halved where they are widest until some multiplier, found by
/// trial, closes them.
class NaiveSearch {
 public:
  NaiveSearch(const Problem& problem, double upper) : problem_{problem}, upper_{upper} {}

  /// The tree of one sequence.
  [[nodiscard]] Json tree(const std::vector<std::size_t>& types) {
    const Model model = Assembler{problem_}.model(types);
    Json nodes = Json::array();
    close(model, root_box(model, problem_.task.goals.size()), nodes, Numbers{0.0, 0.0, 1.0}, 0);
    return nodes;
  }

 private:
  void close(const Model& model, Box box, Json& nodes, Numbers y, int depth) {
    if (depth > 60) throw std::logic_error("the naive search does not close this tree");
    for (const bool mass : {false, true}) {
      Leaf leaf{mass, false, std::vector<Numbers>(problem_.task.goals.size(), y), obstacle_rows(model, box)};
      for (const bool cap : {true, false}) {
        leaf.cap = cap;
        if (climb(model, box, leaf)) {
          nodes.push_back(node(leaf));
          return;
        }
      }
      y = leaf.y[0];
    }
    std::size_t widest = 0;
    double most = -1.0;
    for (std::size_t v = 0; v < box.lower.size(); ++v) {
      const double width = (box.upper[v] - box.lower[v]) * (v < model.n_lengths() ? 0.3 : 1.0);
      if (width > most) {
        most = width;
        widest = v;
      }
    }
    const double at = 0.5 * (box.lower[widest] + box.upper[widest]);
    nodes.push_back({"s", widest, hex(at)});
    Box half = box;
    half.upper[widest] = at;
    close(model, half, nodes, y, depth + 1);
    half = box;
    half.lower[widest] = at;
    close(model, half, nodes, y, depth + 1);
  }

  [[nodiscard]] bool closes(const Model& model, const Leaf& leaf, double bound) const {
    if (!leaf.mass) return bound > 0.0;
    return best_score(problem_, model.types.size() + 1, model.costs, bound) <= upper_;
  }

  /// Moves the multipliers uphill, one coordinate after the other.
  bool climb(const Model& model, const Box& box, Leaf& leaf) const {
    const auto bound = [&] { return lower_bound(problem_, model, box, leaf); };
    double best = bound();
    for (double step = 1.0; step > 0.02; step *= 0.5) {
      for (int round = 0; round < 2; ++round) {
        std::vector<double*> multipliers;
        for (Numbers& y : leaf.y) {
          for (double& entry : y) multipliers.push_back(&entry);
        }
        for (Row& row : leaf.rows) multipliers.push_back(&row.mu);
        for (double* multiplier : multipliers) {
          for (const double sign : {1.0, -1.0}) {
            const double before = *multiplier;
            *multiplier += sign * step;
            const bool negative =
                std::any_of(leaf.rows.begin(), leaf.rows.end(), [](const Row& r) { return r.mu < 0.0; });
            const double moved = negative ? -INFINITY : bound();
            if (moved > best) {
              best = moved;
            } else {
              *multiplier = before;
            }
            if (closes(model, leaf, best)) return true;
          }
        }
      }
    }
    return false;
  }

  /// One row per usable run and sphere, at the middle of the run, multiplier 0.
  [[nodiscard]] std::vector<Row> obstacle_rows(const Model& model, const Box& box) const {
    std::vector<Row> rows;
    if (!problem_.sees_obstacles()) return rows;
    for (std::size_t g = 0; g < problem_.task.goals.size(); ++g) {
      for (std::size_t r = 0; r < model.runs.size(); ++r) {
        for (std::size_t s = 0; s < problem_.task.obstacles.size(); ++s) {
          const Shape& shape = problem_.task.obstacles[s];
          if (shape.kind != Kind::kSphere) continue;
          Row row{g, r, 0.5, 0.0, s, true, middle(shape.pose.move.offset), shape.size[0].offset.lower(), 0};
          try {
            static_cast<void>(lower_bound(problem_, model, box, {true, false, {Numbers{}}, {row}}));
            rows.push_back(row);
          } catch (const Rejected&) {  // the body may be too short here
          }
        }
      }
    }
    return rows;
  }

  static Json node(const Leaf& leaf) {
    Json json{leaf.mass ? (leaf.cap ? "mc" : "m") : (leaf.cap ? "nc" : "n")};
    for (const Numbers& y : leaf.y) {
      for (const double entry : y) json.push_back(hex(entry));
    }
    for (const Row& row : leaf.rows) {
      if (row.mu == 0.0) continue;
      json.push_back({row.goal, row.run, hex(row.tau), hex(row.mu), row.shape, "ball", hex(row.centre[0]),
                      hex(row.centre[1]), hex(row.centre[2]), hex(row.radius)});
    }
    return json;
  }

  const Problem& problem_;
  double upper_;
};

/// The part of a certificate that repeats the problem.
inline Json statement_of(const Problem& problem) {
  Json statement{{"scoring", problem.scoring_text},
                 {"maxModules", problem.max_modules},
                 {"collision", problem.level},
                 {"obstacles", problem.task.obstacles.size()},
                 {"goals", Json::array()}};
  for (const Goal& goal : problem.task.goals) {
    statement["goals"].push_back({{"position", {hex(goal.position[0]), hex(goal.position[1]), hex(goal.position[2])}},
                                  {"radius", hex(goal.radius)}});
  }
  for (const Module& module : problem.library.types) {
    statement["library"][module.id] = Json::object();
    for (const Parameter& p : module.parameters) statement["library"][module.id][p.name] = {hex(p.lower), hex(p.upper)};
  }
  return statement;
}

/// A certificate of `problem` (as a file would name it) with bound `upper`; trees for all sequences of at most
/// `n_modules` modules behind the base.
inline Json naive_certificate(const std::string& name, const Problem& problem, double upper, std::size_t n_modules) {
  Json certificate{{"modsearch", 1},
                   {"problem", name},
                   {"statement", statement_of(problem)},
                   {"claim", {{"upper", upper}}},
                   {"sequences", Json::array()}};
  NaiveSearch search{problem, upper};
  const std::function<void(std::vector<std::size_t>, std::size_t)> extend = [&](std::vector<std::size_t> types,
                                                                                std::size_t n) {
    if (types.size() == n) {
      Json entry{{"types", Json::array()}, {"tree", search.tree(types)}};
      for (const std::size_t k : types) entry["types"].push_back(problem.library.types[k].id);
      certificate["sequences"].push_back(entry);
      return;
    }
    for (std::size_t k = 0; k < problem.library.types.size(); ++k) {
      types.push_back(k);
      extend(types, n);
      types.pop_back();
    }
  };
  for (std::size_t n = 1; n <= n_modules; ++n) extend({}, n);
  return certificate;
}

/// The closed form for `seed/fixed`: a hinge whose proximal part is as short as it may be. The distal one spans what is
/// left to the near side of the tolerance.
inline void add_incumbent_of_seed_fixed(Json& certificate) {
  const double distal = std::sqrt(1.25) - 0.001 + 1e-12;
  const double hinge = std::atan2(1.0, 0.5);  // leans from z towards x after a quarter turn of the base
  const double lower = 350.0 - 5.0 * (0.5 + distal);
  certificate["claim"]["lower"] = lower;
  certificate["claim"]["gap"] = (certificate["claim"]["upper"].get<double>() - lower) / (5.0 * (0.5 + distal));
  const Json placement{{"type", "hinge"}, {"parameters", {{"proximal", hex(0.5)}, {"distal", hex(distal)}}}};
  certificate["incumbent"]["design"] = Json::array({placement});
  certificate["incumbent"]["postures"] = Json::array({Json::array({hex(std::acos(0.0)), hex(hinge)})});
}

}  // namespace modsearch_check
