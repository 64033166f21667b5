#include "table1/fallible_reach.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <stdexcept>

namespace table1 {

using namespace modsearch;

namespace {

template <typename T>
T parsed(const std::string& key, const std::string& text) {
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) {
    throw std::invalid_argument(fmt::format("fallible inverse kinematics: {}={} is no such number", key, text));
  }
  return value;
}

// The stream a design's starts come from: its numbers, mixed by the generator itself.
Rng stream_of(const Arm& arm, std::uint64_t salt) {
  Rng rng = Rng{salt}.fork(static_cast<std::uint64_t>(arm.n_joints()));
  for (const double x : arm.parameters()) rng = rng.fork(std::bit_cast<std::uint64_t>(x));
  return rng;
}

Eigen::VectorXd random_start(const Chain& chain, Rng& rng) {
  Eigen::VectorXd q(chain.n_joints());
  for (Eigen::Index j = 0; j < q.size(); ++j) q[j] = rng.uniform(-M_PI, M_PI);
  return chain.clamped(q);
}

struct Descent {
  Eigen::VectorXd q;
  double error = 0.0;  // at q [m]
};

// Damped least squares from `q` until the tip is within `enough` of p_W; the closest posture on the way.
Descent descend(const Arm& arm, const Eigen::Vector3d& p_W, Eigen::VectorXd q, double enough, const FallibleIk& ik,
                Work& work) {
  Descent best{q, std::numeric_limits<double>::infinity()};
  Posture posture;
  for (int i = 0;; ++i) {
    arm.forward(q.data(), posture);
    ++work.forward;
    const Eigen::Vector3d e = p_W - posture.tip.translation();
    if (e.norm() < best.error) best = {q, e.norm()};
    if (best.error <= enough || i == ik.iterations || q.size() == 0) return best;
    ++work.ik_iterations;
    const Eigen::Matrix3Xd J = arm.tip_jacobian_q(posture).topRows<3>();
    Eigen::Matrix3d A = J * J.transpose();
    A.diagonal().array() += ik.damping * ik.damping;
    Eigen::VectorXd dq = J.transpose() * A.llt().solve(e);
    dq *= std::min(1.0, ik.longest / std::max(dq.norm(), 1e-12));
    q = arm.chain().clamped(q + dq);
  }
}

// Another scoring, but for reaching: only where the distance says so.
class PaidWithin final : public Scoring {
 public:
  PaidWithin(std::shared_ptr<const Scoring> scoring, double relative_error)
      : scoring_{std::move(scoring)}, relative_error_{relative_error} {}

  [[nodiscard]] std::string_view name() const override { return scoring_->name(); }
  [[nodiscard]] Terms terms(const Facts& facts) const override {
    Facts strict = facts;
    strict.reached = facts.reached && facts.relative_error <= relative_error_;
    strict.achieved = facts.achieved && strict.reached;
    return scoring_->terms(strict);
  }
  [[nodiscard]] double bound(int modules, double least_mass, double least_cost) const override {
    return scoring_->bound(modules, least_mass, least_cost);
  }
  [[nodiscard]] double mass_weight() const override { return scoring_->mass_weight(); }

 private:
  std::shared_ptr<const Scoring> scoring_;
  double relative_error_;
};

double tolerance_of(const Goal& goal) { return goal.region.tolerances().front().upper; }

}  // namespace

FallibleIk fallible_ik_from_text(const std::string& text) {
  FallibleIk ik;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find(',', at), text.size());
    const std::string part = text.substr(at, end - at);
    const std::size_t equals = std::min(part.find('='), part.size());
    const std::string key = part.substr(0, equals);
    const std::string value = equals < part.size() ? part.substr(equals + 1) : "";
    if (key == "starts") {
      ik.starts = parsed<int>(key, value);
    } else if (key == "iterations") {
      ik.iterations = parsed<int>(key, value);
    } else if (key == "damping") {
      ik.damping = parsed<double>(key, value);
    } else if (key == "salt") {
      ik.salt = parsed<std::uint64_t>(key, value);
    } else if (key == "per_episode" && (value == "true" || value == "false")) {
      ik.per_episode = value == "true";
    } else if (key == "done_within") {
      ik.done_within = parsed<double>(key, value);
    } else {
      throw std::invalid_argument(fmt::format("fallible inverse kinematics: '{}' is none of its options", part));
    }
    at = end + 1;
  }
  return ik;
}

FallibleReach::FallibleReach(Goal goal, FallibleIk ik)
    : goal_{std::move(goal)}, ik_{ik}, within_{ik.done_within.value_or(0.0)} {
  if (!goal_.region.is_ball()) throw std::invalid_argument("fallible reach: the goal is no ball");
  if (ik.starts < 1 || ik.iterations < 1) {
    throw std::invalid_argument(
        fmt::format("fallible reach: {} starts and {} iterations, at least 1 of each", ik.starts, ik.iterations));
  }
  within_ = std::max(within_, tolerance_of(goal_));
}

Attempt FallibleReach::attempt(const Arm& arm, const Scene& scene, const AttemptOptions& options) const {
  if (!scene.obstacles().empty()) throw std::invalid_argument("fallible reach: the scene has obstacles");
  Attempt attempt;
  const Eigen::Vector3d p_W = goal_.position();
  Rng rng = stream_of(arm, ik_.salt);
  Descent best{{}, std::numeric_limits<double>::infinity()};
  for (int start = 0; start < ik_.starts && !(best.error <= within_); ++start) {
    // On past the tolerance, as minimisers of the distance do: they stop where it no longer falls.
    Descent descent = descend(arm, p_W, random_start(arm.chain(), rng), 1e-6, ik_, attempt.work);
    if (descent.error < best.error) best = std::move(descent);
  }
  attempt.reached = attempt.achieved = best.error <= within_;
  attempt.why = attempt.reached ? Failure::kNone : Failure::kUnreachable;
  attempt.goal_error = best.error;
  if (!attempt.reached || ik_.done_within) {
    attempt.relative_error = best.error / std::max((p_W - options.p_WB).norm(), 1e-9);
  }
  attempt.postures = best.q.transpose();
  return attempt;
}

RobotProblemSpec with_fallible_ik(RobotProblemSpec problem, const FallibleIk& ik) {
  const Goal goal = problem.task->goals().front();
  if (ik.done_within) {
    const double distance = std::max((goal.position() - problem.X_WB.translation()).norm(), 1e-9);
    problem.scoring = std::make_shared<PaidWithin>(problem.scoring, tolerance_of(goal) / distance);
  }
  problem.task = std::make_shared<FallibleReach>(goal, ik);
  return problem;
}

}  // namespace table1
