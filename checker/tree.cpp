#include <checker/tree.hpp>
#include <checker/twin.hpp>
#include <cmath>

namespace modsearch_check {
namespace {

constexpr std::size_t kMostRows = 64;

Row read_row(const Value& value, const Problem& problem, const Model& model) {
  const std::vector<Value> entries = value.items();
  if (entries.size() < 6) value.fail("a row is too short");
  Row row;
  row.goal = entries[0].natural(problem.task.goals.size() - 1);
  if (model.runs.empty() || problem.task.obstacles.empty()) value.fail("there is nothing that a row could be about");
  row.run = entries[1].natural(model.runs.size() - 1);
  row.tau = entries[2].hex();
  row.mu = entries[3].hex();
  row.shape = entries[4].natural(problem.task.obstacles.size() - 1);
  row.ball = entries[5].choice({"ball", "face"}) == 0;
  if (entries.size() != (row.ball ? 10U : 7U)) value.fail("a row is too long or too short");
  if (row.ball) {
    row.centre = {entries[6].hex(), entries[7].hex(), entries[8].hex()};
    row.radius = entries[9].hex();
  } else {
    row.face = entries[6].natural(5);
  }
  if (!(row.tau >= 0.0 && row.tau <= 1.0)) throw Rejected("a body point lies beyond its body");
  if (!(row.mu >= 0.0)) throw Rejected("the multiplier of a row is negative");
  if (!problem.sees_obstacles()) throw Rejected("a row is about an obstacle, which the collision level ignores");
  return row;
}

Leaf read_leaf(const Value& value, const Problem& problem, const Model& model) {
  const std::vector<Value> entries = value.items();
  const std::size_t kind = entries[0].choice({"m", "n", "mc", "nc"});
  const std::size_t n_goals = problem.task.goals.size();
  Leaf leaf{kind % 2 == 0, kind >= 2, {}, {}};
  if (entries.size() < 1 + 3 * n_goals) value.fail("a leaf needs three multipliers per goal");
  for (std::size_t g = 0; g < n_goals; ++g) {
    leaf.y.push_back({entries[1 + 3 * g].hex(), entries[2 + 3 * g].hex(), entries[3 + 3 * g].hex()});
  }
  for (std::size_t i = 1 + 3 * n_goals; i < entries.size(); ++i)
    leaf.rows.push_back(read_row(entries[i], problem, model));
  if (leaf.rows.size() > kMostRows) value.fail("a leaf has more than 64 rows");
  return leaf;
}

void check_bound(const Problem& problem, const Model& model, const Leaf& leaf, double bound, double upper) {
  if (!leaf.mass) {
    if (!(bound > 0.0)) throw Rejected("does not show that nothing there is achieved");
    return;
  }
  if (!(best_score(problem, model.types.size() + 1, model.costs, bound) <= upper)) {
    throw Rejected("shows a mass of " + in_digits(bound, 6) + " kg only, which is too little");
  }
}

void check_leaf(const Problem& problem, const Model& model, const Box& box, const Leaf& leaf, double upper) {
  check_bound(problem, model, leaf, lower_bound(problem, model, box, leaf), upper);
}

/// Of a list [leaf, part, part, ..] that the leaf closes every part, [variable, place, "above" or "below"], of `box`,
/// and cuts them off what is `left`.
void check_parts(const Problem& problem, const Model& model, const Box& box, const Value& parts, double upper,
                 Box& left) {
  const std::vector<Value> entries = parts.items();
  if (entries.size() < 2) parts.fail("a leaf and the parts that it closes are needed");
  const Leaf leaf = read_leaf(entries[0], problem, model);
  const Shown shown{problem, model, box, leaf};
  for (std::size_t i = 1; i < entries.size(); ++i) {
    const std::vector<Value> part = entries[i].items(3);
    const std::size_t v = part[0].natural(box.lower.size() - 1);
    const double at = part[1].hex();
    const bool above = part[2].choice({"above", "below"}) == 0;
    if (!(left.lower[v] <= at && at <= left.upper[v])) throw Rejected("a part begins outside what is left of its box");
    check_bound(problem, model, leaf, shown.in_part(v, at, above), upper);
    (above ? left.upper : left.lower)[v] = at;
  }
}

/// A split whose first half (or second) is being looked at.
struct Open {
  std::size_t variable = 0;
  double at = 0.0;
  Box box;  // that was split
  bool second = false;
};

}  // namespace

double best_score(const Problem& problem, std::size_t n, const Interval& costs, double mass) {
  const Interval head = problem.scoring.head(n, costs);
  // Without a price on mass, its bound may be anything.
  return problem.scoring.mass_weight > 0.0 ? (head - Interval{problem.scoring.mass_weight} * mass).upper()
                                           : head.upper();
}

void check_tree(const Problem& problem, const Model& model, const Value& tree, double upper, Count& count) {
  const std::size_t n_goals = problem.task.goals.size();
  Box box = root_box(model, n_goals);
  // First, ["h", variable]: half a circle is enough of an angle, in the order of variables, for the twins of one may
  // have any of the angles behind it. Then nodes in preorder: a split, ["s", variable, place]; parts that are cut off
  // the box and closed by what leaves show about all of it, ["c", [leaf, part, ..], ..]; or a leaf, which closes the
  // box.
  std::vector<Open> open;
  bool covered = false;
  const Json& nodes = tree.json();
  if (!nodes.is_array()) tree.fail("a tree is a list of nodes");
  const Box root = box;
  std::size_t halved = 0;
  std::size_t last_halved = 0;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const Value node{nodes[i], tree.place() + "/" + std::to_string(i)};
    if (covered) throw Rejected(node.place() + ": nodes are left over when everything is covered");
    if (!node.json().is_array() || node.json().empty()) node.fail("a node is a list that begins with its kind");
    if (node.json()[0] == Json("s")) {
      const std::vector<Value> parts = node.items(3);
      const std::size_t v = parts[1].natural(box.lower.size() - 1);
      const double at = parts[2].hex();
      if (!(box.lower[v] <= at && at <= box.upper[v])) throw Rejected(node.place() + ": the split is outside its box");
      open.push_back({v, at, box, false});
      box.upper[v] = at;
      continue;
    }
    try {
      if (node.json()[0] == Json("h")) {
        const std::size_t v = node.items(2)[1].natural(box.lower.size() - 1);
        if (halved < i) throw Rejected("half a circle is left out in the middle of a tree");
        if (halved > 0 && v <= last_halved) throw Rejected("half circles are left out in the wrong order");
        require_twins(model, root, v);
        box.lower[v] = -kPiUp;
        box.upper[v] = 0.0;
        ++halved;
        last_halved = v;
        continue;
      }
      if (node.json()[0] == Json("c")) {
        const std::vector<Value> groups = node.items();
        Box left = box;
        for (std::size_t k = 1; k < groups.size(); ++k) check_parts(problem, model, box, groups[k], upper, left);
        count.leaves += groups.size() - 1;
        box = std::move(left);
        continue;
      }
      check_leaf(problem, model, box, read_leaf(node, problem, model), upper);
    } catch (const Rejected& reason) {
      throw Rejected(node.place() + ": " + reason.what());
    }
    ++count.leaves;
    while (!open.empty() && open.back().second) open.pop_back();
    covered = open.empty();
    if (!covered) {
      open.back().second = true;
      box = open.back().box;
      box.lower[open.back().variable] = open.back().at;
    }
  }
  if (!covered) throw Rejected(tree.place() + ": the tree ends before everything is covered");
}

}  // namespace modsearch_check
