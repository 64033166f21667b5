#include <checker/certificate.hpp>
#include <checker/incumbent.hpp>
#include <cmath>

namespace modsearch_check {
namespace {

/// The numbers that the certificate says it is about have to be those of the problem.
void compare_statement(const Value& statement, const Problem& problem) {
  statement.only({"library", "goals", "scoring", "maxModules", "collision", "obstacles"});
  const auto differs = [](const std::string& what) {
    throw Rejected("the statement's " + what + " is not the problem's");
  };

  const Value library = statement["library"];
  if (library.members().size() != problem.library.types.size()) differs("list of module types");
  for (const Module& module : problem.library.types) {
    if (!library.has(module.id)) differs("list of module types");
    const Value given = library[module.id];
    if (given.members().size() != module.parameters.size()) differs("list of parameters of " + module.id);
    for (const Parameter& parameter : module.parameters) {
      if (!given.has(parameter.name)) differs("list of parameters of " + module.id);
      const std::vector<Value> ends = given[parameter.name].items(2);
      if (ends[0].hex() != parameter.lower || ends[1].hex() != parameter.upper) {
        differs("interval of " + module.id + "." + parameter.name);
      }
    }
  }
  const std::vector<Value> goals = statement["goals"].items();
  if (goals.size() != problem.task.goals.size()) differs("number of goals");
  for (std::size_t g = 0; g < goals.size(); ++g) {
    goals[g].only({"position", "radius"});
    const std::vector<Value> position = goals[g]["position"].items(3);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (position[axis].hex() != problem.task.goals[g].position[axis]) differs("goal " + problem.task.goals[g].id);
    }
    if (goals[g]["radius"].hex() != problem.task.goals[g].radius)
      differs("tolerance of goal " + problem.task.goals[g].id);
  }
  if (statement["scoring"].json() != problem.scoring_text) differs("scoring");
  if (statement["maxModules"].natural(64) != problem.max_modules) differs("number of modules");
  if (statement["collision"].text() != problem.level) differs("collision level");
  if (statement["obstacles"].natural(1'000'000) != problem.task.obstacles.size()) differs("number of obstacle shapes");
}

/// What is claimed of the incumbent's score, and how far the bound is from it.
void compare_claim(const Value& claim, const Problem& problem, const Incumbent& incumbent, Proof& proof) {
  proof.lower = claim["lower"].number();
  proof.gap = claim["gap"].number();
  constexpr double kRounding = 1e-9;  // decimal numbers of a score and of a share
  if (!(std::abs(*proof.lower - incumbent.score.middle()) <= kRounding)) {
    throw Rejected("the incumbent scores " + in_digits(incumbent.score.middle(), 12) + ", not what is claimed");
  }
  if (!(incumbent.score.lower() <= proof.upper)) throw Rejected("the incumbent scores more than the claimed bound");
  const double weight = problem.scoring.mass_weight * incumbent.mass.middle();
  const double unit = weight > 0.0 ? weight : std::max(1.0, std::abs(*proof.lower));
  const double gap = (proof.upper - *proof.lower) / unit;
  if (!(std::abs(*proof.gap - gap) <= kRounding * std::max(1.0, std::abs(gap)))) {
    throw Rejected("the gap is " + in_digits(gap, 6) + ", not what is claimed");
  }
}

/// A bound in twelve digits, never less than it is.
std::string rounded_up(double bound) {
  constexpr int kDigits = 12;
  if (bound == 0.0 || !std::isfinite(bound)) return in_digits(bound, kDigits);
  const double unit = std::pow(10.0, std::floor(std::log10(std::abs(bound))) + 1 - kDigits);
  return in_digits(std::ceil(bound / unit) * unit, kDigits);
}

/// Everything but reading: calls arithmetic that rounds up.
Proof check(const Value& value, const std::string& file) {
  value.only({"modsearch", "problem", "instance", "statement", "claim", "incumbent", "sequences"});
  if (value["modsearch"].natural(1) != 1) value["modsearch"].fail("is not 1");
  Proof proof;
  proof.problem = value["problem"].text();
  std::uint64_t seed = 0;
  std::uint64_t index = 0;
  if (value.has("instance")) {
    value["instance"].only({"seed", "index"});
    seed = value["instance"]["seed"].natural(UINT64_MAX);
    index = value["instance"]["index"].natural(UINT64_MAX);
  }
  const Problem problem = read_problem(proof.problem, file, seed, index);
  if (problem.sampled) proof.problem += ", instance " + std::to_string(seed) + ":" + std::to_string(index);
  proof.level = problem.level;
  proof.max_modules = problem.max_modules;
  compare_statement(value["statement"], problem);

  const Value claim = value["claim"];
  proof.unreachable = claim.has("unreachable");
  if (proof.unreachable) {
    claim.only({"unreachable"});
    if (!claim["unreachable"].boolean()) claim.fail("claims nothing");
    if (value.has("incumbent")) throw Rejected("a design is given although none is said to exist");
    proof.upper = -INFINITY;
  } else {
    claim.only({"upper", "lower", "gap"});
    proof.upper = claim["upper"].number();
    if (value.has("incumbent")) {
      compare_claim(claim, problem, check_incumbent(problem, value["incumbent"]), proof);
    } else if (claim.has("lower") || claim.has("gap")) {
      throw Rejected("a score is claimed, and no design is given that has it");
    }
  }
  proof.count = check_sequences(problem, value["sequences"], proof.upper);
  return proof;
}

}  // namespace

Proof check_certificate(const std::string& file) {
  const Json json = parse(read_file(file), file);
  try {
    const Rounding up{FE_UPWARD};
    return check({json, file}, file);
  } catch (const std::domain_error& error) {
    throw Rejected(std::string{"the arithmetic fails: "} + error.what());
  }
}

std::string printable(const std::string& text) {
  std::string result;
  for (const char c : text) {
    const auto code = static_cast<unsigned char>(c);
    if (code >= 0x20 && code != 0x7f) {
      result += c;
      continue;
    }
    constexpr const char* kDigits = "0123456789abcdef";
    result += "\\x";
    result += kDigits[code / 16];
    result += kDigits[code % 16];
  }
  return result;
}

std::string in_words(const Proof& proof) {
  const bool obstacles = proof.level != "none";
  std::string text = "accepted: " + printable(proof.problem) + ": no design with at most " +
                     std::to_string(proof.max_modules) + (proof.max_modules == 1 ? " module" : " modules") +
                     " (the base counted) ";
  const std::string achieves =
      std::string{"reaches every goal"} + (obstacles ? " without touching an obstacle there" : "");
  if (proof.unreachable) {
    text += achieves + ".\n";
  } else {
    text += "that " + achieves + " scores above " + rounded_up(proof.upper) + ".\n";
  }
  if (proof.lower) {
    text += "One that does so scores " + in_digits(*proof.lower, 12) + ": the gap is " +
            in_digits(100.0 * *proof.gap, 4) + " %.\n";
  }
  text += "Checked: " + std::to_string(proof.count.sequences) + " sequences of module types, " +
          std::to_string(proof.count.excluded) + " of them by their reach alone, and " +
          std::to_string(proof.count.leaves) + " leaves.\n";
  text += "No part of the proof: torques, speeds";
  if (!obstacles) text += ", obstacles";
  text += ", bodies of the arm that touch each other, and paths between postures";
  if (proof.level == "posture+self" || proof.level == "path") {
    text +=
        "; the problem forbids more than was proved, so the bound holds, and the design given was checked against "
        "obstacles only";
  }
  return text + ".\n";
}

}  // namespace modsearch_check
