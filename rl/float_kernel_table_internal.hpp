#pragma once

#include <cstddef>

// What the kernels of all instruction sets have in common. Sources compiled for a wide instruction set include this
// header and no other: an inline function of a library, compiled for it here, could be the copy that the linker keeps
// for the whole program. For the same reason the functions below are static.
namespace modsearch {

/// Rows of matrices that a kernel reads or writes as vectors are this many floats apart, or a multiple: the widest
/// vector. The padding is 0 and stays 0.
static constexpr std::ptrdiff_t kFloatPadding = 16;
[[nodiscard]] static constexpr std::ptrdiff_t padded(std::ptrdiff_t n) {
  return (n + kFloatPadding - 1) / kFloatPadding * kFloatPadding;
}

/// C = A B, what goes before it and what comes after it:
///   C[i][j] = f( start + sum_p A[i][p] B[p][j] ),  i < rows, j < columns, p < depth,
/// summed in the order of p whatever the sizes, so that a row's result does not depend on the other rows.
/// start: `bias`[j] if given, else `initial`[i][j] if given (C itself: accumulates), else 0.
/// f: if `mask` is given, times 1 where mask[i][j] > 0 and `leak` elsewhere (the slope of a leaky ReLU whose output is
/// `mask`); if `rectify`, a leaky ReLU.
/// A is read number by number with any strides. B, C, bias, initial and mask are read as vectors up to padded(columns).
struct Product {
  std::ptrdiff_t rows = 0, columns = 0, depth = 0;
  const float* a = nullptr;
  std::ptrdiff_t a_row = 0, a_column = 1;  ///< A[i][p] = a[i * a_row + p * a_column]
  const float* b = nullptr;
  std::ptrdiff_t b_row = 0;
  float* c = nullptr;
  std::ptrdiff_t c_row = 0;
  const float* bias = nullptr;
  const float* initial = nullptr;
  std::ptrdiff_t initial_row = 0;
  const float* mask = nullptr;
  std::ptrdiff_t mask_row = 0;
  float leak = 0.0F;
  bool rectify = false;
};

/// C[i][j] = bias[j] + <row i of A, row j of B>: the product for few columns. Rows of A and B are read as vectors up to
/// padded(depth), C and bias number by number. Null bias: 0.
struct RowDots {
  std::ptrdiff_t rows = 0, columns = 0, depth = 0;
  const float* a = nullptr;
  std::ptrdiff_t a_row = 0;
  const float* b = nullptr;
  std::ptrdiff_t b_row = 0;
  float* c = nullptr;
  std::ptrdiff_t c_row = 0;
  const float* bias = nullptr;
};

struct AdamStep {
  std::ptrdiff_t n = 0;
  float* weights = nullptr;
  const float* gradient = nullptr;
  float* m = nullptr;
  float* v = nullptr;
  float scale = 1.0F;                ///< of the gradient
  float beta1 = 0.0F, rest1 = 1.0F;  ///< rest = 1 - beta, rounded once
  float beta2 = 0.0F, rest2 = 1.0F;
  float rate = 0.0F;          ///< divided by 1 - beta1^t
  float v_correction = 1.0F;  ///< 1 / (1 - beta2^t)
  float epsilon = 0.0F;
};

/// One instruction set's versions of the loops in which learning spends its time. Sums run in an order that depends on
/// sizes only: equal inputs give equal bits.
struct FloatKernels {
  void (*multiply)(const Product&) = nullptr;
  void (*row_dots)(const RowDots&) = nullptr;
  /// sums[j] += sum_i a[i * a_row + j], j < padded(columns).
  void (*add_column_sums)(std::ptrdiff_t rows, std::ptrdiff_t columns, const float* a, std::ptrdiff_t a_row,
                          float* sums) = nullptr;
  /// to[j * to_row + i] = from[i * from_row + j] for i < rows, j < columns.
  void (*transpose)(std::ptrdiff_t rows, std::ptrdiff_t columns, const float* from, std::ptrdiff_t from_row, float* to,
                    std::ptrdiff_t to_row) = nullptr;
  float (*squared_norm)(std::ptrdiff_t n, const float* a) = nullptr;
  void (*adam_step)(const AdamStep&) = nullptr;
  /// target += tau (source - target).
  void (*soft_update)(std::ptrdiff_t n, float* target, const float* source, float tau) = nullptr;
};

extern const FloatKernels kFloatKernelsSse2;
extern const FloatKernels kFloatKernelsAvx2;
extern const FloatKernels kFloatKernelsAvx512;

}  // namespace modsearch
