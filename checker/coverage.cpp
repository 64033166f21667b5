#include <checker/coverage.hpp>
#include <cmath>

namespace modsearch_check {
namespace {

constexpr std::size_t kMostSequences = 200'000;  // enumerated, as far as connectors let them begin

Interval least_mass(const Module& module) {
  Interval mass = 0.0;
  for (const Body& body : module.bodies) {
    mass += body.mass.offset;
    for (std::size_t i = 0; i < module.parameters.size(); ++i) {
      mass += body.mass.columns[i] * Interval{module.parameters[i].lower - kSlack, module.parameters[i].upper + kSlack};
    }
  }
  return mass.lower();
}

/// Upper bound of the score of all designs of `n` modules behind the base, whichever they are.
double best_of_length(const Problem& problem, std::size_t n) {
  if (n > 0 && problem.library.types.empty()) return -INFINITY;
  double mass = INFINITY;
  double cost = INFINITY;
  for (const Module& module : problem.library.types) {
    mass = std::min(mass, least_mass(module).lower());
    cost = std::min(cost, module.cost);
  }
  const auto count = static_cast<double>(n);
  const Module& base = problem.library.base;
  if (n == 0) return best_score(problem, 1, base.cost, least_mass(base).lower());
  return best_score(problem, n + 1, Interval{base.cost} + Interval{count} * cost,
                    (least_mass(base) + Interval{count} * mass).lower());
}

/// The reach test. With the arm stretched out, every length s_i above its least takes the tip at most rho_i s_i further
/// and weighs m_i s_i more. So for any lambda >= 0
///     mass >= m + lambda (distance - reach) + sum_i min(0, m_i - lambda rho_i) w_i,   0 <= s_i <= w_i,
/// and without masses the goal is out of reach if distance > reach + sum_i rho_i w_i.
bool out_of_the_running(const Problem& problem, const Model& model, double upper) {
  Interval distance = 0.0;
  const Frame& ground = model.frames.front();
  for (const Goal& goal : problem.task.goals) {
    const Interval away = norm(vector_of(goal.position) - ground.v.offset) - (Interval{goal.radius} + kSlack);
    distance = {std::max(distance.lower(), away.lower()), std::max(distance.upper(), away.upper())};
  }
  const std::size_t n = model.n_lengths();
  Interval reach = 0.0;
  Interval mass = model.mass.offset;
  std::vector<Interval> farther(n);
  for (std::size_t j = 0; j < model.frames.size(); ++j) {
    AffineVector piece = model.frames[j].v;
    if (j == 0) piece.offset = Vector{};  // taken off above
    reach += norm(piece.at(model.lower));
    for (std::size_t i = 0; i < n; ++i) farther[i] += norm(piece.columns[i]);
  }
  Interval longest = reach;
  for (std::size_t i = 0; i < n; ++i) {
    mass += model.mass.columns[i] * model.lower[i];
    longest += farther[i] * (Interval{model.upper[i]} - model.lower[i]);
  }
  if (distance.lower() > longest.upper()) return true;

  const auto least_mass_for = [&](double lambda) {
    Interval least = mass + Interval{lambda} * (Interval{distance.lower()} - reach);
    for (std::size_t i = 0; i < n; ++i) {
      const Interval gain =
          (model.mass.columns[i] - Interval{lambda} * farther[i]) * (Interval{model.upper[i]} - model.lower[i]);
      least += std::min(0.0, gain.lower());
    }
    return least.lower();
  };
  double best = least_mass_for(0.0);
  for (std::size_t i = 0; i < n; ++i) {
    if (!(farther[i].lower() > 0.0)) continue;
    const double price = model.mass.columns[i].middle() / farther[i].middle();
    if (price > 0.0) best = std::max(best, least_mass_for(price));
  }
  return best_score(problem, model.types.size() + 1, model.costs, best) <= upper;
}

/// Goes through fitting sequences in order and through the file beside them.
class Enumeration {
 public:
  Enumeration(const Problem& problem, const Value& sequences, double upper)
      : problem_{problem}, assembler_{problem}, given_{sequences.items()}, upper_{upper} {}

  void all_of_length(std::size_t n) {
    if (best_of_length(problem_, n) <= upper_) return;
    std::vector<std::size_t> types;
    extend(types, n);
  }

  [[nodiscard]] Count finish() const {
    if (next_ < given_.size()) {
      throw Rejected(given_[next_].place() + ": the sequence is not needed, not possible or not in its place");
    }
    return count_;
  }

 private:
  void extend(std::vector<std::size_t>& types, std::size_t n) {  // at most 63 deep
    if (++steps_ > kMostSequences) throw Rejected("there are too many sequences to go through");
    if (types.size() == n) {
      const bool complete =
          !problem_.library.has_tips || (n > 0 && problem_.library.types[types.back()].has_connector("eef"));
      if (complete) look_at(types);
      return;
    }
    for (std::size_t k = 0; k < problem_.library.types.size(); ++k) {
      types.push_back(k);
      if (assembler_.fits(types)) extend(types, n);
      types.pop_back();
    }
  }

  void look_at(const std::vector<std::size_t>& types) {
    const Model model = assembler_.model(types);
    ++count_.sequences;
    if (next_ < given_.size() && is_next(types)) {
      check_tree(problem_, model, given_[next_++]["tree"], upper_, count_);
      return;
    }
    if (!out_of_the_running(problem_, model, upper_)) {
      std::string names;
      for (const std::size_t k : types) names += " " + problem_.library.types[k].id;
      throw Rejected("a sequence is missing:" + (names.empty() ? " the base alone" : names));
    }
    ++count_.excluded;
  }

  [[nodiscard]] bool is_next(const std::vector<std::size_t>& types) const {
    const Value& entry = given_[next_];
    entry.only({"types", "tree"});
    const std::vector<Value> ids = entry["types"].items();
    if (ids.size() != types.size()) return false;
    for (std::size_t i = 0; i < ids.size(); ++i) {
      if (ids[i].text() != problem_.library.types[types[i]].id) return false;
    }
    return true;
  }

  const Problem& problem_;
  Assembler assembler_;
  std::vector<Value> given_;
  double upper_;
  std::size_t next_ = 0;
  std::size_t steps_ = 0;
  Count count_;
};

}  // namespace

Count check_sequences(const Problem& problem, const Value& sequences, double upper) {
  Enumeration enumeration{problem, sequences, upper};
  for (std::size_t n = 0; n < problem.max_modules; ++n) enumeration.all_of_length(n);
  return enumeration.finish();
}

}  // namespace modsearch_check
