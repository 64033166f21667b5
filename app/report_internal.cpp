#include "app/report_internal.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace modsearch::app {
namespace {

nlohmann::ordered_json finite_or_null(double value) {
  return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json(nullptr);
}

double mass_of(const RobotProblem& problem, const Design& design) {
  return problem.chain(design.types())->mass(design.parameters());
}

std::string metres(double value) { return fmt::format("{:.4g} mm", 1000.0 * value); }

std::string misses_text(const NearestMiss& missed) {
  std::string text;
  for (const Miss& miss : missed.misses) text += fmt::format("missed       {}\n", miss.words);
  return text;
}

// The overlapping pair, by the names of the bodies and the obstacle.
void add_touch(const RobotProblem& problem, const Chain& chain, const Touch& touch, nlohmann::ordered_json& json) {
  const auto body = [&](int index) { return chain.bodies()[static_cast<std::size_t>(index)].name; };
  json["body"] = body(touch.body);
  if (touch.obstacle) {
    json["obstacle"] = problem.scene().obstacles()[static_cast<std::size_t>(touch.other)].name;
  } else {
    json["otherBody"] = body(touch.other);
  }
  json["depth_m"] = touch.depth;
}

}  // namespace

std::string standing(const Attempt& attempt) {
  if (attempt.achieved) return "achieved";
  return fmt::format("{}, not achieved: {}", attempt.reached ? "reached" : "not reached", name(attempt.why));
}

nlohmann::ordered_json evaluation_json(const RobotProblem& problem, const Design& design,
                                       const Evaluation& evaluation) {
  const Attempt& attempt = evaluation.attempt;
  nlohmann::ordered_json json;
  json["score"] = finite_or_null(evaluation.score);
  json["terms"] = nlohmann::ordered_json::array();
  for (const Term& term : evaluation.terms.items()) {
    json["terms"].push_back({{"name", name(term.id)}, {"value", term.value}});
  }
  json["modules"] = problem.n_modules(design);
  json["mass_kg"] = mass_of(problem, design);
  json["reached"] = attempt.reached;
  json["achieved"] = attempt.achieved;
  json["why"] = name(attempt.why);
  json["goalError_m"] = finite_or_null(attempt.goal_error);
  json["clearance_m"] = finite_or_null(attempt.clearance);
  if (attempt.torque_share > 0.0) json["torqueShare"] = attempt.torque_share;
  if (!attempt.achieved) json["misses"] = misses_json(problem, design, nearest_miss(problem, design, evaluation));
  json["design"] = nlohmann::ordered_json::parse(design_to_json(problem.library(), design));
  return json;
}

nlohmann::ordered_json misses_json(const RobotProblem& problem, const Design& design, const NearestMiss& missed) {
  const std::shared_ptr<const Chain> chain = problem.chain(design.types());
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  for (const Miss& miss : missed.misses) {
    nlohmann::ordered_json entry;
    entry["why"] = name(miss.why);
    if (miss.goal >= 0) entry["goal"] = problem.task().goals()[static_cast<std::size_t>(miss.goal)].id;
    if (!miss.place.empty()) entry["place"] = miss.place;
    if (miss.distance > 0.0 || miss.angle > 0.0) {
      entry["outside_m"] = miss.distance;
      entry["outside_rad"] = miss.angle;
      entry["away_m"] = miss.away;
    }
    if (miss.touch) add_touch(problem, *chain, *miss.touch, entry);
    if (!miss.joint.empty()) entry["joint"] = miss.joint;
    if (miss.torque_share > 0.0) entry["torqueShare"] = miss.torque_share;
    if (!miss.to.empty()) {
      entry["from"] = miss.from;
      entry["to"] = miss.to;
    }
    entry["words"] = miss.words;
    json.push_back(std::move(entry));
  }
  return json;
}

std::string evaluation_text(const RobotProblem& problem, const Design& design, const Evaluation& evaluation,
                            std::string_view label) {
  const Attempt& attempt = evaluation.attempt;
  std::string text;
  text += fmt::format("{:<13}{}\n", label, to_string(problem.library(), design));
  text += fmt::format("score        {:.6f}   {}\n", evaluation.score, standing(attempt));
  for (const Term& term : evaluation.terms.items()) {
    text += fmt::format("  {:<11}{:+.6f}\n", name(term.id), term.value);
  }
  text +=
      fmt::format("modules      {} (with the base), {:.4f} kg\n", problem.n_modules(design), mass_of(problem, design));
  text += fmt::format("goal error   {}\n", metres(attempt.goal_error));
  if (attempt.torque_share > 0.0) {
    text +=
        fmt::format("torque       {:.0f} % of what the most burdened joint can hold\n", 100.0 * attempt.torque_share);
  }
  if (std::isfinite(attempt.clearance)) text += fmt::format("clearance    {}\n", metres(attempt.clearance));
  if (!attempt.achieved) text += misses_text(nearest_miss(problem, design, evaluation));
  return text;
}

namespace {

NearestMiss missed_at_path_level(const RobotProblem& problem, const Design& design, const Verification& verification) {
  return nearest_miss(problem.with_level(Level::kPath), design, verification.path_evaluation);
}

}  // namespace

nlohmann::ordered_json verification_json(const RobotProblem& problem, const Design& design,
                                         const Verification& verification) {
  nlohmann::ordered_json json;
  json["verified"] = verification.verified;
  json["level"] = verification.level;
  json["score"] = finite_or_null(verification.evaluation.score);
  json["achieved"] = verification.evaluation.attempt.achieved;
  json["why"] = name(verification.path_evaluation.attempt.why);
  json["findings"] = verification.findings;
  if (!verification.path_evaluation.attempt.achieved) {
    json["misses"] = misses_json(problem, design, missed_at_path_level(problem, design, verification));
  }
  if (verification.check) {
    json["states"] = verification.check->states;
    json["pathClearance_m"] = finite_or_null(verification.check->clearance);
    json["selfClearance_m"] = finite_or_null(verification.check->self_clearance);
  }
  return json;
}

std::string home_text(const RobotProblem& problem, const std::optional<Path>& path) {
  if (!path || path->waypoints.rows() == 0 || problem.task().home().size() > 0) return {};
  const Eigen::RowVectorXd home = path->waypoints.row(0);
  if ((home.array() == 0.0).all()) return {};
  std::string joints;
  for (const double q : home) joints += fmt::format("{}{:.4g}", joints.empty() ? "" : ", ", q);
  return fmt::format("home         ({}), because all joints at 0 are not free or not within the limits\n", joints);
}

std::string verification_text(const RobotProblem& problem, const Design& design, const Verification& verification) {
  std::string text = verification.verified
                         ? "verified: achieved, and a collision-free path from home through all goals exists\n"
                         : fmt::format("not verified (level {})\n", verification.level);
  text += fmt::format("score        {:.6f}\n", verification.evaluation.score);
  for (const std::string& finding : verification.findings) text += fmt::format("finding      {}\n", finding);
  text += misses_text(missed_at_path_level(problem, design, verification));
  if (verification.check) {
    text += fmt::format("path         {} waypoints, {} states looked at\n", verification.path->waypoints.rows(),
                        verification.check->states);
    if (std::isfinite(verification.check->clearance)) {
      text += fmt::format("clearance    {} along the path\n", metres(verification.check->clearance));
    }
    if (std::isfinite(verification.check->self_clearance)) {
      text += fmt::format("to itself    {} along the path\n", metres(verification.check->self_clearance));
    }
  }
  return text;
}

nlohmann::ordered_json infeasibility_json(const Infeasibility& infeasibility) {
  nlohmann::ordered_json json;
  json["reason"] = infeasibility.reason;
  if (infeasibility.goal >= 0) json["goal"] = infeasibility.goal_id;
  if (infeasibility.obstacle >= 0) {
    json["obstacle"] = infeasibility.obstacle_name;
    json["module"] = infeasibility.module_id;
    json["depth_m"] = infeasibility.depth;
  }
  return json;
}

std::string trace_csv(const std::vector<TracePoint>& trace) {
  std::string text = "evaluations,seconds,score,achieved\n";
  for (const TracePoint& point : trace) {
    text +=
        fmt::format("{},{:.6f},{:.17g},{}\n", point.evaluations, point.seconds, point.score, point.achieved ? 1 : 0);
  }
  return text;
}

nlohmann::ordered_json outcomes_json(const Progress& spent) {
  nlohmann::ordered_json json = nlohmann::ordered_json::object();
  for (std::size_t i = 0; i < spent.outcomes.size(); ++i) {
    const auto failure = static_cast<Failure>(i);
    if (spent.outcomes[i] > 0) json[failure == Failure::kNone ? "achieved" : name(failure)] = spent.outcomes[i];
  }
  return json;
}

std::string outcomes_text(const Progress& spent) {
  std::string text;
  const nlohmann::ordered_json outcomes = outcomes_json(spent);
  for (const auto& [outcome, count] : outcomes.items()) {
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", count.get<std::int64_t>(), outcome);
  }
  return text.empty() ? "none" : text;
}

std::string failures_text(const Progress& spent, std::size_t most) {
  std::vector<std::pair<std::int64_t, Failure>> counts;
  for (std::size_t i = 0; i < spent.outcomes.size(); ++i) {
    const auto failure = static_cast<Failure>(i);
    if (failure != Failure::kNone && spent.outcomes[i] > 0) counts.emplace_back(spent.outcomes[i], failure);
  }
  std::stable_sort(counts.begin(), counts.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  if (counts.size() > most) counts.resize(most);
  std::string text;
  for (const auto& [count, failure] : counts) {
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", count, name(failure));
  }
  return text;
}

}  // namespace modsearch::app
