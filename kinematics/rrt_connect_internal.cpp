#include <ompl/base/MotionValidator.h>
#include <ompl/base/ProblemDefinition.h>
#include <ompl/base/SpaceInformation.h>
#include <ompl/base/StateSampler.h>
#include <ompl/base/spaces/RealVectorStateSpace.h>
#include <ompl/datastructures/NearestNeighborsLinear.h>
#include <ompl/geometric/PathGeometric.h>
#include <ompl/geometric/planners/rrt/RRTConnect.h>
#include <ompl/util/Console.h>

#include <algorithm>
#include <modsearch/kinematics/fixed_stream_internal.hpp>
#include <modsearch/kinematics/interruption.hpp>
#include <modsearch/kinematics/rrt_connect_internal.hpp>
#include <mutex>

namespace modsearch {
namespace {

namespace ob = ompl::base;
namespace og = ompl::geometric;

using RealState = ob::RealVectorStateSpace::StateType;

const double* values(const ob::State* state) { return state->as<RealState>()->values; }
double* values(ob::State* state) { return state->as<RealState>()->values; }

// The joint box, in which rounding never leads out of an edge. OMPL's own class would also register a random
// projection, which draws from its global generator and serves no purpose here.
class JointSpace final : public ob::RealVectorStateSpace {
 public:
  JointSpace(const Eigen::VectorXd& lower, const Eigen::VectorXd& upper)
      : RealVectorStateSpace(static_cast<unsigned>(lower.size())), lower_{lower}, upper_{upper} {
    ob::RealVectorBounds bounds(getDimension());
    for (unsigned j = 0; j < getDimension(); ++j) {
      constexpr double kLeastWidth = 1e-9;  // OMPL refuses an empty interval, which a joint that is held still has
      bounds.setLow(j, lower[j]);
      bounds.setHigh(j, std::max(upper[j], lower[j] + kLeastWidth));
    }
    setBounds(bounds);
  }

  void registerProjections() override {}

  void interpolate(const ob::State* from, const ob::State* to, double t, ob::State* state) const override {
    for (unsigned j = 0; j < getDimension(); ++j) {
      const double a = values(from)[j];
      const double b = values(to)[j];
      values(state)[j] = std::clamp(a + (b - a) * t, std::min(a, b), std::max(a, b));
    }
  }

  [[nodiscard]] double lower(unsigned j) const { return lower_[j]; }
  [[nodiscard]] double upper(unsigned j) const { return upper_[j]; }

 private:
  Eigen::VectorXd lower_;
  Eigen::VectorXd upper_;
};

// States of a fixed stream. Counts those it has given to `drawn`, by which the planner is ended.
class FixedSampler final : public ob::StateSampler {
 public:
  FixedSampler(const JointSpace& space, std::uint64_t stream, std::int64_t& drawn)
      : StateSampler(&space), joints_{space}, numbers_{stream}, drawn_{drawn} {}

  void sampleUniform(ob::State* state) override {
    ++drawn_;
    for (unsigned j = 0; j < joints_.getDimension(); ++j) {
      put(state, j, joints_.lower(j) + numbers_.next() * (joints_.upper(j) - joints_.lower(j)));
    }
  }

  void sampleUniformNear(ob::State* state, const ob::State* near, double distance) override {
    ++drawn_;
    for (unsigned j = 0; j < joints_.getDimension(); ++j) {
      put(state, j, values(near)[j] + (2.0 * numbers_.next() - 1.0) * distance);
    }
  }

  // Bell-shaped and bounded: the sum of twelve uniform numbers less six has variance 1.
  void sampleGaussian(ob::State* state, const ob::State* mean, double deviation) override {
    ++drawn_;
    for (unsigned j = 0; j < joints_.getDimension(); ++j) {
      double sum = -6.0;
      for (int i = 0; i < 12; ++i) sum += numbers_.next();
      put(state, j, values(mean)[j] + sum * deviation);
    }
  }

 private:
  void put(ob::State* state, unsigned j, double value) const {
    values(state)[j] = std::clamp(value, joints_.lower(j), joints_.upper(j));
  }

  const JointSpace& joints_;
  FixedStream numbers_;
  std::int64_t& drawn_;
};

// Asks the checker on behalf of the planner, through which no exception may pass: it would lose its states. Once the
// checker has been interrupted, nothing is free any more.
class Questions {
 public:
  explicit Questions(MotionChecker& checker) : checker_{checker} {}

  template <typename Ask>
  [[nodiscard]] bool is_free(Ask&& ask) {
    if (interrupted_) return false;
    try {
      return ask(checker_);
    } catch (const Interrupted&) {
      interrupted_ = true;
      return false;
    }
  }
  [[nodiscard]] bool interrupted() const { return interrupted_; }

 private:
  MotionChecker& checker_;
  bool interrupted_ = false;
};

class Validity final : public ob::StateValidityChecker {
 public:
  Validity(const ob::SpaceInformationPtr& si, Questions& questions) : StateValidityChecker(si), questions_{questions} {}
  bool isValid(const ob::State* state) const override {
    return questions_.is_free([&](MotionChecker& checker) { return checker.state_free(values(state)); });
  }

 private:
  Questions& questions_;
};

class Motions final : public ob::MotionValidator {
 public:
  Motions(const ob::SpaceInformationPtr& si, Questions& questions) : MotionValidator(si), questions_{questions} {}
  bool checkMotion(const ob::State* a, const ob::State* b) const override {
    return questions_.is_free([&](MotionChecker& checker) { return checker.edge_free(values(a), values(b)); });
  }
  bool checkMotion(const ob::State* a, const ob::State* b, std::pair<ob::State*, double>& last) const override {
    const bool free = checkMotion(a, b);
    last.second = free ? 1.0 : 0.0;
    if (last.first != nullptr) si_->copyState(last.first, free ? b : a);
    return free;
  }

 private:
  Questions& questions_;
};

// OMPL reports every plan on the console, through one handler for the whole process.
void silence_ompl() {
  static std::once_flag once;
  std::call_once(once, [] { ompl::msg::setLogLevel(ompl::msg::LOG_NONE); });
}

}  // namespace

RrtConnectResult rrt_connect(const Eigen::VectorXd& q_start, const Eigen::VectorXd& q_goal,
                             const Eigen::VectorXd& lower, const Eigen::VectorXd& upper, std::int64_t max_iterations,
                             std::uint64_t stream, MotionChecker& checker) {
  silence_ompl();
  RrtConnectResult result;
  const auto space = std::make_shared<JointSpace>(lower, upper);
  space->setStateSamplerAllocator([&](const ob::StateSpace*) -> ob::StateSamplerPtr {
    return std::make_shared<FixedSampler>(*space, stream, result.iterations);
  });
  const auto si = std::make_shared<ob::SpaceInformation>(space);
  Questions questions{checker};
  si->setStateValidityChecker(std::make_shared<Validity>(si, questions));
  si->setMotionValidator(std::make_shared<Motions>(si, questions));
  si->setup();

  ob::ScopedState<ob::RealVectorStateSpace> start(si);
  ob::ScopedState<ob::RealVectorStateSpace> goal(si);
  std::copy_n(q_start.data(), q_start.size(), start->values);
  std::copy_n(q_goal.data(), q_goal.size(), goal->values);
  const auto definition = std::make_shared<ob::ProblemDefinition>(si);
  definition->setStartAndGoalStates(start, goal);

  og::RRTConnect planner(si);
  planner.setRange(0.2 * space->getMaximumExtent());
  planner.setNearestNeighbors<ompl::NearestNeighborsLinear>();
  planner.setProblemDefinition(definition);
  planner.setup();
  const ob::PlannerTerminationCondition enough(
      [&] { return result.iterations >= max_iterations || questions.interrupted(); });
  const ob::PlannerStatus status = planner.solve(enough);
  if (questions.interrupted()) throw Interrupted{};
  if (status != ob::PlannerStatus::EXACT_SOLUTION) return result;

  const auto path = std::static_pointer_cast<og::PathGeometric>(definition->getSolutionPath());
  for (const ob::State* state : path->getStates()) {
    result.waypoints.emplace_back(Eigen::Map<const Eigen::VectorXd>(values(state), q_start.size()));
  }
  return result;
}

}  // namespace modsearch
