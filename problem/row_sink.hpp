#pragma once

#include <Eigen/Core>
#include <functional>

namespace modsearch {

/// Takes the rows that a task adds to the smooth program beyond its goals. Variables are v = (x, q_1, q_2, ..).
class RowSink {
 public:
  /// Value of the row at `v`; fills d row / d v [1 x n_variables], which comes in as zeros.
  using Row = std::function<double(const Eigen::VectorXd& v, Eigen::Ref<Eigen::RowVectorXd> gradient)>;

  virtual ~RowSink() = default;
  /// Adds lower <= row(v) <= upper; counted as linear in the Hessian.
  virtual void add(double lower, double upper, Row row) = 0;
  /// Index in v of parameter `i`, and of joint `j` at goal `g`.
  [[nodiscard]] virtual int parameter(int i) const = 0;
  [[nodiscard]] virtual int joint(int g, int j) const = 0;
};

}  // namespace modsearch
