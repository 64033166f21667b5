#include <gmock/gmock.h>

#include <modsearch/rl/float_buffer.hpp>
#include <modsearch/rl/float_kernels_internal.hpp>

#include "rl/reference_network.hpp"

namespace modsearch {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using reference::random_rows;
using testing::HasSubstr;
using testing::ThrowsMessage;

// A matrix whose rows are padded with zeros.
struct Padded {
  Padded(Index rows, Index columns, Rng& rng)
      : n_rows{rows}, n_columns{columns}, stride{padded(columns)}, memory(static_cast<std::size_t>(rows * stride)) {
    view() = random_rows(rows, columns, rng);
  }
  Eigen::Map<RowMatrixXf, Eigen::Unaligned, Eigen::OuterStride<>> view() {
    return {memory.data(), n_rows, n_columns, Eigen::OuterStride<>{stride}};
  }
  MatrixXd exact() { return view().cast<double>(); }
  bool padding_is_zero() {
    for (Index row = 0; row < n_rows; ++row) {
      for (Index j = n_columns; j < stride; ++j) {
        if (memory[static_cast<std::size_t>(row * stride + j)] != 0.0F) return false;
      }
    }
    return true;
  }

  Index n_rows, n_columns, stride;
  FloatBuffer memory;
};

double error(const MatrixXd& a, const MatrixXd& b) { return (a - b).cwiseAbs().maxCoeff(); }

// Sums of at most 150 products below 1 in float.
constexpr double kTolerance = 2e-5;

class FloatKernelsOf : public testing::TestWithParam<Isa> {
 protected:
  const FloatKernels& kernels = float_kernels(GetParam());
  Rng rng{1};
};

INSTANTIATE_TEST_SUITE_P(Supported, FloatKernelsOf, testing::ValuesIn(supported_isas()),
                         [](const auto& instance) { return std::string{name(instance.param)}; });

TEST_P(FloatKernelsOf, MultiplyEqualsTheProductInDoubleForAllSizes) {
  for (const Index rows : {1, 2, 3, 7, 8, 13, 23, 128}) {
    for (const Index columns : {1, 5, 16, 17, 33, 64, 100, 130}) {
      for (const Index depth : {0, 1, 6, 19, 128}) {
        Padded a{rows, depth, rng}, b{depth, columns, rng}, c{rows, columns, rng}, bias{1, columns, rng};
        kernels.multiply({.rows = rows,
                          .columns = columns,
                          .depth = depth,
                          .a = a.memory.data(),
                          .a_row = a.stride,
                          .b = b.memory.data(),
                          .b_row = b.stride,
                          .c = c.memory.data(),
                          .c_row = c.stride,
                          .bias = bias.memory.data()});
        const MatrixXd expected = (a.exact() * b.exact()).rowwise() + bias.exact().row(0);
        ASSERT_LT(error(c.exact(), expected), kTolerance) << rows << " " << columns << " " << depth;
        ASSERT_TRUE(c.padding_is_zero()) << rows << " " << columns << " " << depth;
      }
    }
  }
}

TEST_P(FloatKernelsOf, MultiplyReadsATransposedAndAddsToC) {
  Padded a{128, 22, rng}, b{128, 70, rng}, c{22, 70, rng};
  const MatrixXd expected = c.exact() + a.exact().transpose() * b.exact();
  kernels.multiply({.rows = 22,
                    .columns = 70,
                    .depth = 128,
                    .a = a.memory.data(),
                    .a_row = 1,
                    .a_column = a.stride,
                    .b = b.memory.data(),
                    .b_row = b.stride,
                    .c = c.memory.data(),
                    .c_row = c.stride,
                    .initial = c.memory.data(),
                    .initial_row = c.stride});
  EXPECT_LT(error(c.exact(), expected), kTolerance);
  EXPECT_TRUE(c.padding_is_zero());
}

TEST_P(FloatKernelsOf, MultiplyRectifiesAndMasks) {
  Padded a{9, 4, rng}, b{4, 21, rng}, c{9, 21, rng}, mask{9, 21, rng};
  Product product{.rows = 9,
                  .columns = 21,
                  .depth = 4,
                  .a = a.memory.data(),
                  .a_row = a.stride,
                  .b = b.memory.data(),
                  .b_row = b.stride,
                  .c = c.memory.data(),
                  .c_row = c.stride,
                  .leak = 0.25F,
                  .rectify = true};
  const MatrixXd sums = a.exact() * b.exact();
  kernels.multiply(product);
  EXPECT_LT(error(c.exact(), sums.cwiseMax(0.25 * sums)), kTolerance);
  product.rectify = false;
  product.mask = mask.memory.data();
  product.mask_row = mask.stride;
  kernels.multiply(product);
  EXPECT_LT(error(c.exact(), (mask.exact().array() > 0.0).select(sums, 0.25 * sums)), kTolerance);
}

TEST_P(FloatKernelsOf, ARowOfAProductIsTheSameBitsAloneAndAmongOthers) {
  Padded a{37, 50, rng}, b{50, 70, rng}, all{37, 70, rng}, one{1, 70, rng};
  Product product{.rows = 37,
                  .columns = 70,
                  .depth = 50,
                  .a = a.memory.data(),
                  .a_row = a.stride,
                  .b = b.memory.data(),
                  .b_row = b.stride,
                  .c = all.memory.data(),
                  .c_row = all.stride};
  kernels.multiply(product);
  for (Index row = 0; row < 37; ++row) {
    product.rows = 1;
    product.a = a.memory.data() + row * a.stride;
    product.c = one.memory.data();
    kernels.multiply(product);
    ASSERT_EQ(one.view().row(0), all.view().row(row));
  }
}

TEST_P(FloatKernelsOf, RowDotsEqualTheProductInDouble) {
  for (const Index rows : {1, 3, 4, 21}) {
    for (const Index columns : {1, 2, 3, 4, 5, 8}) {
      for (const Index depth : {1, 16, 30, 128}) {
        Padded a{rows, depth, rng}, b{columns, depth, rng}, bias{1, columns, rng};
        RowMatrixXf c(rows, columns);
        kernels.row_dots({.rows = rows,
                          .columns = columns,
                          .depth = depth,
                          .a = a.memory.data(),
                          .a_row = a.stride,
                          .b = b.memory.data(),
                          .b_row = b.stride,
                          .c = c.data(),
                          .c_row = columns,
                          .bias = bias.memory.data()});
        const MatrixXd expected = (a.exact() * b.exact().transpose()).rowwise() + bias.exact().row(0);
        ASSERT_LT(error(c.cast<double>(), expected), kTolerance) << rows << " " << columns << " " << depth;
      }
    }
  }
}

TEST_P(FloatKernelsOf, TransposeAndColumnSumsAreExactToTheLastRows) {
  for (const Index rows : {1, 4, 11}) {
    for (const Index columns : {3, 8, 130}) {
      Padded a{rows, columns, rng}, t{columns, rows, rng}, sums{1, columns, rng};
      const MatrixXd expected = sums.exact() + a.exact().colwise().sum();
      kernels.transpose(rows, columns, a.memory.data(), a.stride, t.memory.data(), t.stride);
      ASSERT_EQ(t.exact(), a.exact().transpose());
      kernels.add_column_sums(rows, columns, a.memory.data(), a.stride, sums.memory.data());
      ASSERT_LT(error(sums.exact(), expected), kTolerance);
      ASSERT_TRUE(sums.padding_is_zero());
    }
  }
}

TEST_P(FloatKernelsOf, SquaredNormEqualsTheSumInDouble) {
  for (const Index n : {1, 63, 64, 1000}) {
    const RowMatrixXf a = random_rows(1, n, rng);
    EXPECT_NEAR(kernels.squared_norm(n, a.data()), a.cast<double>().squaredNorm(), 1e-6 * static_cast<double>(n));
  }
}

TEST_P(FloatKernelsOf, SoftUpdateMovesTheTargetByTau) {
  RowMatrixXf target = random_rows(1, 37, rng);
  const RowMatrixXf source = random_rows(1, 37, rng);
  const MatrixXd expected = 0.75 * target.cast<double>() + 0.25 * source.cast<double>();
  kernels.soft_update(37, target.data(), source.data(), 0.25F);
  EXPECT_LT(error(target.cast<double>(), expected), 1e-6);
}

TEST(FloatKernels, WithoutAWishAreTheWidestSupported) { EXPECT_EQ(chosen_isa(nullptr), supported_isas().back()); }

TEST(FloatKernels, AreThoseThatTheEnvironmentNames) {
  for (const Isa isa : supported_isas()) EXPECT_EQ(chosen_isa(std::string{name(isa)}.c_str()), isa);
}

TEST(FloatKernels, RefuseAnUnknownName) {
  EXPECT_THAT([] { static_cast<void>(chosen_isa("sse3")); },
              ThrowsMessage<std::runtime_error>(HasSubstr("MODSEARCH_ISA = 'sse3', must be sse2, avx2 or avx512")));
}

TEST(FloatKernels, SayWhichAreInUse) {
  const Isa before = chosen_isa(std::string{kernel_isa()}.c_str());
  for (const Isa isa : supported_isas()) {
    use_float_kernels(isa);
    EXPECT_EQ(kernel_isa(), name(isa));
  }
  use_float_kernels(before);
}

}  // namespace
}  // namespace modsearch
