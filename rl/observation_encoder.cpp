#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <modsearch/problem/robot_problem.hpp>
#include <modsearch/rl/observation_encoder.hpp>
#include <stdexcept>

namespace modsearch {
namespace {

constexpr int kSeedSlots = 10;             // the base and nine modules
constexpr int kSeedParameters = 2;         // per slot
constexpr float kSeedLargestId = 3.0F;     // the base's
constexpr double kCylindricalScale = 0.5;  // [1 / m]: that of Task::features

const RobotProblem* as_robot(const DesignProblem& problem) { return dynamic_cast<const RobotProblem*>(&problem); }

std::vector<int> parameters_by_type(const ModuleLibrary& library) {
  std::vector<int> result;
  for (int k = 0; k < library.n_types(); ++k) result.push_back(library.type(k).n_parameters());
  return result;
}

// The reference numbers its types link, hinge, rotary; other libraries keep their own order.
std::vector<float> seed36_ids(const ModuleLibrary& library) {
  std::vector<float> ids;
  for (int k = 0; k < library.n_types(); ++k) ids.push_back(static_cast<float>(k) / kSeedLargestId);
  const std::optional<int> link = library.find("link");
  const std::optional<int> hinge = library.find("hinge");
  const std::optional<int> rotary = library.find("rotary");
  if (link && hinge && rotary && library.n_types() == 3) {
    ids[static_cast<std::size_t>(*link)] = 0.0F;
    ids[static_cast<std::size_t>(*hinge)] = 1.0F / kSeedLargestId;
    ids[static_cast<std::size_t>(*rotary)] = 2.0F / kSeedLargestId;
  }
  return ids;
}

void check_box(const std::vector<double>& box) {
  if (box.empty()) return;
  if (box.size() != 6) {
    throw std::invalid_argument(fmt::format("observation: a goal box of {} numbers, there must be 6", box.size()));
  }
  for (std::size_t i = 0; i < 3; ++i) {
    if (box[i] < box[i + 3]) continue;
    throw std::invalid_argument(fmt::format("observation: a goal box from {} to {} along {}, must have a width above 0",
                                            box[i], box[i + 3], "xyz"[i]));
  }
}

void append(std::vector<double>& numbers, const Eigen::VectorXd& more) {
  numbers.insert(numbers.end(), more.begin(), more.end());
}

}  // namespace

std::string_view name(EncoderKind kind) {
  switch (kind) {
    case EncoderKind::kScaled:
      return "scaled";
    case EncoderKind::kSeed36:
      return "seed36";
  }
  return "";
}

double from_unit(const ParameterRange& range, double unit) {
  return std::lerp(range.lower, range.upper, 0.5 * (unit + 1.0));
}

double to_unit(const ParameterRange& range, double value) {
  if (range.upper == range.lower) return 0.0;
  return 2.0 * (value - range.lower) / (range.upper - range.lower) - 1.0;
}

ObservationEncoder::ObservationEncoder(EncoderOptions options, const DesignProblem& problem)
    : options_{options}, parameters_of_type_{parameters_by_type(problem.library())} {
  const ModuleLibrary& library = problem.library();
  const auto refuse = [&](const std::string& what) {
    throw std::invalid_argument(
        fmt::format("observation {}: problem '{}': {}", modsearch::name(options.kind), problem.name(), what));
  };
  check_box(options.goal_box);
  if (options.kind == EncoderKind::kSeed36) {
    if (as_robot(problem) == nullptr) refuse("is no robot problem, so there is no target to show");
    if (problem.max_modules() > kSeedSlots) {
      refuse(fmt::format("{} modules with the base, at most {}", problem.max_modules(), kSeedSlots));
    }
    if (library.max_parameters() > kSeedParameters) {
      refuse(fmt::format("a module with {} parameters, at most {}", library.max_parameters(), kSeedParameters));
    }
    seed36_ids_ = seed36_ids(library);
    design_size_ = kSeedSlots * (1 + kSeedParameters);
  } else {
    n_slots_ = problem.max_modules() - 1;
    n_parameters_ = library.max_parameters();
    design_size_ = n_slots_ * (library.n_types() + 1 + n_parameters_) + 1;
  }
  instance_size_ = n_instance_numbers_ = static_cast<int>(instance_numbers(problem).size());
  if (options_.whitening.empty()) return;
  if (options_.kind == EncoderKind::kSeed36) refuse("shows the report's numbers, which are not whitened");
  whitening_ = whitening_from(options_.whitening, n_instance_numbers_);
  instance_size_ = static_cast<int>(whitening_->A.rows());
}

std::vector<double> ObservationEncoder::instance_numbers(const DesignProblem& problem) const {
  const RobotProblem* robot = as_robot(problem);
  std::vector<double> numbers;
  if (options_.kind == EncoderKind::kSeed36) {
    append(numbers, robot->spec().X_WB.translation());
    append(numbers, robot->task().goals().front().position());
    return numbers;
  }
  append(numbers, problem.context());
  if (robot == nullptr) return numbers;
  if (options_.cylindrical) {
    const Eigen::Isometry3d X_BW = robot->spec().X_WB.inverse();
    for (const Goal& goal : robot->task().goals()) {
      const Eigen::Vector3d p_B = X_BW * goal.position();
      numbers.push_back(kCylindricalScale * std::hypot(p_B.x(), p_B.y()));
      numbers.push_back(kCylindricalScale * p_B.norm());
    }
  }
  if (!options_.axis_heights.empty()) {
    const Eigen::Isometry3d X_BW = robot->spec().X_WB.inverse();
    for (const Goal& goal : robot->task().goals()) {
      const Eigen::Vector3d p_B = X_BW * goal.position();
      for (const double height : options_.axis_heights) {
        numbers.push_back(kCylindricalScale * (p_B - height * Eigen::Vector3d::UnitZ()).norm());
      }
    }
  }
  if (!options_.goal_box.empty()) {
    const Eigen::Map<const Eigen::Array3d> lower{options_.goal_box.data()};
    const Eigen::Map<const Eigen::Array3d> upper{options_.goal_box.data() + 3};
    for (const Goal& goal : robot->task().goals()) {
      append(numbers, (2.0 * (goal.position().array() - lower) / (upper - lower) - 1.0).matrix());
    }
  }
  return numbers;
}

Eigen::VectorXf ObservationEncoder::instance(const DesignProblem& problem) const {
  const auto refuse = [&](const std::string& what) {
    throw std::invalid_argument(
        fmt::format("observation {}: problem '{}': {}", modsearch::name(options_.kind), problem.name(), what));
  };
  if (options_.kind == EncoderKind::kSeed36) {
    if (as_robot(problem) == nullptr) refuse("is no robot problem");
    if (problem.max_modules() > kSeedSlots) {
      refuse(fmt::format("{} modules with the base, at most {}", problem.max_modules(), kSeedSlots));
    }
  }
  if (options_.kind == EncoderKind::kScaled && problem.max_modules() - 1 != n_slots_) {
    refuse(fmt::format("at most {} modules, {} in its family", problem.max_modules(), n_slots_ + 1));
  }
  if (parameters_by_type(problem.library()) != parameters_of_type_) refuse("another library than its family's");
  const std::vector<double> numbers = instance_numbers(problem);
  if (static_cast<int>(numbers.size()) != n_instance_numbers_) {
    refuse(fmt::format("{} numbers describe it, {} the others of its family", numbers.size(), n_instance_numbers_));
  }
  const Eigen::Map<const Eigen::VectorXd> all{numbers.data(), n_instance_numbers_};
  if (!all.allFinite()) refuse("a number of its context is not finite");
  if (whitening_) return (*whitening_)(all).cast<float>();
  return all.cast<float>();
}

Eigen::VectorXf ObservationEncoder::encode(const ModuleLibrary& library, const Design& design,
                                           const Eigen::VectorXf& instance) const {
  Eigen::VectorXf observation = Eigen::VectorXf::Zero(size());
  if (options_.kind == EncoderKind::kSeed36) {
    encode_seed36(design, observation.data());
  } else {
    encode_scaled(library, design, observation.data());
  }
  observation.tail(instance_size_) = instance;
  return observation;
}

void ObservationEncoder::encode_scaled(const ModuleLibrary& library, const Design& design, float* out) const {
  const auto n_types = static_cast<int>(parameters_of_type_.size());
  const auto n_placed = static_cast<int>(design.modules.size());
  for (int slot = 0; slot < n_slots_; ++slot, out += n_types + 1 + n_parameters_) {
    if (slot >= n_placed) {
      out[n_types] = 1.0F;
      continue;
    }
    const Placement& placement = design.modules[static_cast<std::size_t>(slot)];
    const std::vector<ParameterRange>& ranges = library.type(placement.type).parameters;
    out[placement.type] = 1.0F;
    for (std::size_t p = 0; p < ranges.size(); ++p) {
      const double value = placement.parameters[static_cast<Eigen::Index>(p)];
      out[n_types + 1 + static_cast<int>(p)] = static_cast<float>(to_unit(ranges[p], value));
    }
  }
  *out = n_slots_ == 0 ? 0.0F : 2.0F * static_cast<float>(n_placed) / static_cast<float>(n_slots_) - 1.0F;
}

void ObservationEncoder::encode_seed36(const Design& design, float* out) const {
  float* ids = out;
  float* parameters = out + kSeedSlots;
  ids[0] = 1.0F;
  for (std::size_t i = 0; i < design.modules.size(); ++i) {
    const Placement& placement = design.modules[i];
    ids[i + 1] = seed36_ids_[static_cast<std::size_t>(placement.type)];
    for (Eigen::Index p = 0; p < placement.parameters.size(); ++p) {
      parameters[kSeedParameters * static_cast<Eigen::Index>(i + 1) + p] = static_cast<float>(placement.parameters[p]);
    }
  }
}

}  // namespace modsearch
