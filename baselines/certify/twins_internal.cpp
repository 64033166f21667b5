#include <algorithm>
#include <modsearch/baselines/certify/twins_internal.hpp>
#include <numbers>
#include <optional>

namespace modsearch::certify {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

// Half a turn about an axis of coordinates, as the signs that it gives to them.
using Signs = Eigen::Vector3d;

bool keeps(const Signs& signs, const Eigen::Vector3d& v) { return signs.cwiseProduct(v) == v; }

bool keeps(const Signs& signs, const AffineVector& v) {
  return keeps(signs, v.offset) &&
         std::all_of(v.terms.begin(), v.terms.end(), [&](const auto& term) { return keeps(signs, term.direction); });
}

bool keeps(const Signs& signs, const StraightRun& run) {
  return keeps(signs, run.start) && keeps(signs, run.end) && keeps(signs, Eigen::Vector3d{run.radius * run.axis});
}

// T' S T, where that is such a half turn again; T may turn by quarters.
std::optional<Signs> seen_from(const Eigen::Matrix3d& T, const Signs& signs) {
  for (const double entry : T.reshaped()) {
    if (entry != 0.0 && entry != 1.0 && entry != -1.0) return std::nullopt;
  }
  return Signs{(T.transpose() * signs.asDiagonal() * T).diagonal()};
}

bool full_circle(const Box& root, int variable) {
  return root.lower[at(variable)] <= -std::numbers::pi && root.upper[at(variable)] >= std::numbers::pi;
}

// `root`: of one goal.
bool has_twins(const SequenceModel& model, const Box& root, int joint) {
  const int first = model.n_lengths();
  if (!full_circle(root, first + joint)) return false;
  Signs signs{-1.0, -1.0, 1.0};
  for (int j = joint + 1; j <= model.n_joints(); ++j) {
    if (!keeps(signs, model.frames[at(j)].v)) return false;
    for (const StraightRun& run : model.runs) {
      if (run.frame == j && run.usable && !keeps(signs, run)) return false;
    }
    if (j == model.n_joints()) return true;
    const std::optional<Signs> next = seen_from(model.frames[at(j)].turn, signs);
    if (!next) return false;
    signs = *next;
    const int variable = first + j;
    if (signs.z() > 0.0) {
      if (full_circle(root, variable)) return true;  // half a turn there undoes it
    } else if (!full_circle(root, variable) && root.lower[at(variable)] != -root.upper[at(variable)]) {
      return false;
    }
  }
  return false;
}

}  // namespace

std::vector<int> half_circles(const SequenceModel& model, int n_goals) {
  const Box root = root_box(model, 1);
  std::vector<int> variables;
  for (int g = 0; g < n_goals; ++g) {
    for (int j = 0; j < model.n_joints(); ++j) {
      if (has_twins(model, root, j)) variables.push_back(model.n_lengths() + g * model.n_joints() + j);
    }
  }
  return variables;
}

Box box_without_twins(const SequenceModel& model, int n_goals) {
  Box box = root_box(model, n_goals);
  for (const int variable : half_circles(model, n_goals)) {
    box.lower[at(variable)] = -std::numbers::pi;
    box.upper[at(variable)] = 0.0;
  }
  return box;
}

}  // namespace modsearch::certify
