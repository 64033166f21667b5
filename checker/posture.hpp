#pragma once

#include <checker/model.hpp>
#include <checker/trigonometry.hpp>

namespace modsearch_check {

/// Where the frames of an arm are at the angles `q` [n_joints].
struct Posture {
  std::vector<Matrix> turn;  // R_j [n_joints + 1]
  std::vector<Vector> axis;  // of each joint, in the world [n_joints]

  Posture(const Model& model, const double* q) {
    Matrix R = identity();
    turn.push_back(R);
    for (std::size_t j = 0; j < model.n_joints(); ++j) {
      const Matrix before = R * model.frames[j].turn;
      const SinCos angle = sin_cos(q[j]);
      for (std::size_t i = 0; i < 3; ++i) {
        R[i][0] = before[i][0] * angle.cos + before[i][1] * angle.sin;
        R[i][1] = before[i][1] * angle.cos - before[i][0] * angle.sin;
        R[i][2] = before[i][2];
      }
      axis.push_back(column(before, 2));
      turn.push_back(R);
    }
  }
};

}  // namespace modsearch_check
