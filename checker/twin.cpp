#include <checker/twin.hpp>

namespace modsearch_check {
namespace {

/// Half a turn about an axis of coordinates, as the signs that it gives to them.
using Signs = std::array<int, 3>;

bool keeps(const Signs& signs, const Vector& v) {
  for (std::size_t k = 0; k < 3; ++k) {
    if (signs[k] < 0 && !v[k].is_zero()) return false;
  }
  return true;
}

bool keeps(const Signs& signs, const AffineVector& v) {
  return keeps(signs, v.offset) &&
         std::all_of(v.columns.begin(), v.columns.end(), [&](const Vector& c) { return keeps(signs, c); });
}

/// The points start + tau (end - start) + (1 - 2 tau) radius axis.
bool keeps(const Signs& signs, const Run& run) {
  return keeps(signs, run.start) && keeps(signs, run.end) && (run.radius == 0.0 || keeps(signs, run.axis));
}

/// T' S T for a T of zeros and one entry of 1 or -1 in each row and column.
Signs seen_from(const Matrix& T, const Signs& signs) {
  Signs result{};
  std::array<int, 3> in_row{};
  for (std::size_t k = 0; k < 3; ++k) {
    int in_column = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      if (T[i][k].is_zero()) continue;
      if (!abs(T[i][k]).same_as(1.0)) throw Rejected("half a circle is not enough: a frame is turned by odd angles");
      result[k] = signs[i];
      ++in_column;
      ++in_row[i];
    }
    if (in_column != 1) throw Rejected("half a circle is not enough: a frame is not turned by quarters");
  }
  if (in_row != std::array<int, 3>{1, 1, 1}) throw Rejected("half a circle is not enough: a frame is not turned");
  return result;
}

bool full_circle(const Box& root, std::size_t variable) {
  return root.lower[variable] <= -kPiUp && root.upper[variable] >= kPiUp;
}

}  // namespace

void require_twins(const Model& model, const Box& root, std::size_t variable) {
  const std::size_t n = model.n_joints();
  if (variable < model.n_lengths() || variable >= root.lower.size())
    throw Rejected("half a circle is asked of a length");
  const std::size_t joint = (variable - model.n_lengths()) % n;
  const std::size_t first = variable - joint;  // of the goal's angles
  if (!full_circle(root, variable)) throw Rejected("half a circle is asked of a joint that does not turn all round");
  Signs signs{-1, -1, 1};
  for (std::size_t j = joint + 1; j <= n; ++j) {
    if (!keeps(signs, model.frames[j].v)) throw Rejected("half a circle is not enough: a vector would change");
    for (const Run& run : model.runs) {
      if (run.frame == j && run.usable && !keeps(signs, run)) {
        throw Rejected("half a circle is not enough: a body would change");
      }
    }
    if (j == n) return;
    signs = seen_from(model.frames[j].turn, signs);
    const double lower = root.lower[first + j];
    const double upper = root.upper[first + j];
    if (signs[2] > 0) {
      if (full_circle(root, first + j)) return;  // half a turn there undoes it
    } else if (!full_circle(root, first + j) && lower != -upper) {
      throw Rejected("half a circle is not enough: a joint does not turn to both sides alike");
    }
  }
}

}  // namespace modsearch_check
