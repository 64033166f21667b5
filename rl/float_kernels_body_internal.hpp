// The float kernels' source, included once per instruction set by float_kernels_<isa>.cpp, which define
//   kLanes                   floats in a vector;
//   kTileRows, kTileVectors  size of the tile of C that stays in registers;
//   kTable                   name of the table to fill.
// GCC's vector extensions, plain pointers, nothing from any library (see float_kernel_table_internal.hpp).

namespace modsearch {
namespace {

using Index = std::ptrdiff_t;
typedef float Vector __attribute__((vector_size(4 * kLanes)));
typedef float Unaligned __attribute__((vector_size(4 * kLanes), aligned(4), may_alias));
typedef float Four __attribute__((vector_size(16)));
typedef float UnalignedFour __attribute__((vector_size(16), aligned(4), may_alias));

inline Vector load(const float* p) { return *reinterpret_cast<const Unaligned*>(p); }
inline void store(float* p, Vector v) { *reinterpret_cast<Unaligned*>(p) = v; }

// The tile of C with its corner at (i, j), R rows and V vectors.
template <int R, int V>
void multiply_tile(const Product& p, Index i, Index j) {
  Vector sum[R][V];
#pragma GCC unroll 16
  for (int r = 0; r < R; ++r) {
#pragma GCC unroll 16
    for (int v = 0; v < V; ++v) {
      if (p.bias) {
        sum[r][v] = load(p.bias + j + v * kLanes);
      } else if (p.initial) {
        sum[r][v] = load(p.initial + (i + r) * p.initial_row + j + v * kLanes);
      } else {
        sum[r][v] = Vector{};
      }
    }
  }
  // Three rows of A per pointer: base, base + stride, base + 2 stride are addresses that an instruction holds.
  constexpr int kPointers = (R + 2) / 3;
  const float* a[kPointers];
#pragma GCC unroll 16
  for (int q = 0; q < kPointers; ++q) a[q] = p.a + (i + 3 * q) * p.a_row;
  const float* b = p.b + j;
  const Index stride = p.a_row;
  for (Index d = 0; d < p.depth; ++d) {
    Vector row[V];
#pragma GCC unroll 16
    for (int v = 0; v < V; ++v) row[v] = load(b + v * kLanes);
#pragma GCC unroll 16
    for (int r = 0; r < R; ++r) {
      const float x = a[r / 3][r % 3 * stride];
#pragma GCC unroll 16
      for (int v = 0; v < V; ++v) sum[r][v] += x * row[v];
    }
#pragma GCC unroll 16
    for (int q = 0; q < kPointers; ++q) a[q] += p.a_column;
    b += p.b_row;
  }
#pragma GCC unroll 16
  for (int r = 0; r < R; ++r) {
#pragma GCC unroll 16
    for (int v = 0; v < V; ++v) {
      Vector y = sum[r][v];
      if (p.mask) y = load(p.mask + (i + r) * p.mask_row + j + v * kLanes) > 0.0F ? y : p.leak * y;
      if (p.rectify) y = y > 0.0F ? y : p.leak * y;
      store(p.c + (i + r) * p.c_row + j + v * kLanes, y);
    }
  }
}

// Rows [begin, end) in strips of R; end - begin is a multiple of R. Panels of B outside: a panel stays in the cache.
template <int R, int V>
void multiply_rows(const Product& p, Index begin, Index end, Index first_vector) {
  const Index vectors = (p.columns + kLanes - 1) / kLanes;
  Index v = first_vector;
  for (; v + V <= vectors; v += V) {
    for (Index i = begin; i < end; i += R) multiply_tile<R, V>(p, i, v * kLanes);
  }
  if constexpr (V > 1) {
    if (v < vectors) multiply_rows<R, V / 2>(p, begin, end, v);
  }
}

void multiply(const Product& p) {
  Index done = p.rows / kTileRows * kTileRows;
  if (done > 0) multiply_rows<kTileRows, kTileVectors>(p, 0, done, 0);
  if constexpr (kTileRows > 8) {
    if (p.rows - done >= 8) {
      multiply_rows<8, 2>(p, done, done + 8, 0);
      done += 8;
    }
  }
  if (p.rows - done >= 4) {
    multiply_rows<4, 2>(p, done, done + 4, 0);
    done += 4;
  }
  if (p.rows - done >= 2) {
    multiply_rows<2, 4>(p, done, done + 2, 0);
    done += 2;
  }
  if (p.rows - done >= 1) multiply_rows<1, 8>(p, done, done + 1, 0);
}

// The sums of the numbers in each of four vectors.
#if MODSEARCH_LANES == 16
inline Four quarter_sums(Vector v) {
  typedef float Eight __attribute__((vector_size(32)));
  const Eight half = __builtin_shufflevector(v, v, 0, 1, 2, 3, 4, 5, 6, 7) +
                     __builtin_shufflevector(v, v, 8, 9, 10, 11, 12, 13, 14, 15);
  return __builtin_shufflevector(half, half, 0, 1, 2, 3) + __builtin_shufflevector(half, half, 4, 5, 6, 7);
}
#elif MODSEARCH_LANES == 8
inline Four quarter_sums(Vector v) {
  return __builtin_shufflevector(v, v, 0, 1, 2, 3) + __builtin_shufflevector(v, v, 4, 5, 6, 7);
}
#else
inline Four quarter_sums(Vector v) { return v; }
#endif

inline Four sums(Vector a, Vector b, Vector c, Vector d) {
  const Four p = quarter_sums(a), q = quarter_sums(b), r = quarter_sums(c), s = quarter_sums(d);
  const Four pq = __builtin_shufflevector(p, q, 0, 4, 1, 5) + __builtin_shufflevector(p, q, 2, 6, 3, 7);
  const Four rs = __builtin_shufflevector(r, s, 0, 4, 1, 5) + __builtin_shufflevector(r, s, 2, 6, 3, 7);
  return __builtin_shufflevector(pq, rs, 0, 1, 4, 5) + __builtin_shufflevector(pq, rs, 2, 3, 6, 7);
}

// R rows of A (4 or 1) with N rows of B. A row alone is summed in the same order as among four.
template <int R, int N>
void dots_tile(const RowDots& p, Index i, Index j) {
  const float* a = p.a + i * p.a_row;
  const float* b = p.b + j * p.b_row;
  Vector sum[4][N] = {};
  for (Index d = 0; d < p.depth; d += kLanes) {
#pragma GCC unroll 4
    for (int n = 0; n < N; ++n) {
      const Vector y = load(b + n * p.b_row + d);
#pragma GCC unroll 4
      for (int r = 0; r < R; ++r) sum[r][n] += load(a + r * p.a_row + d) * y;
    }
  }
#pragma GCC unroll 4
  for (int n = 0; n < N; ++n) {
    const float bias = p.bias ? p.bias[j + n] : 0.0F;
    const Four y = sums(sum[0][n], sum[1][n], sum[2][n], sum[3][n]) + bias;
    for (int r = 0; r < R; ++r) p.c[(i + r) * p.c_row + j + n] = y[r];
  }
}

template <int N>
void dots_columns(const RowDots& p, Index j) {
  Index i = 0;
  for (; i + 4 <= p.rows; i += 4) dots_tile<4, N>(p, i, j);
  for (; i < p.rows; ++i) dots_tile<1, N>(p, i, j);
}

void row_dots(const RowDots& p) {
  Index j = 0;
  for (; j + 3 <= p.columns; j += 3) dots_columns<3>(p, j);
  if (p.columns - j == 2) dots_columns<2>(p, j);
  if (p.columns - j == 1) dots_columns<1>(p, j);
}

template <int V>
void add_sums_panel(Index rows, const float* a, Index a_row, float* to) {
  Vector sum[V] = {};
  for (Index i = 0; i < rows; ++i) {
#pragma GCC unroll 8
    for (int v = 0; v < V; ++v) sum[v] += load(a + i * a_row + v * kLanes);
  }
#pragma GCC unroll 8
  for (int v = 0; v < V; ++v) store(to + v * kLanes, load(to + v * kLanes) + sum[v]);
}

void add_column_sums(Index rows, Index columns, const float* a, Index a_row, float* to) {
  const Index vectors = (columns + kLanes - 1) / kLanes;
  Index v = 0;
  for (; v + 8 <= vectors; v += 8) add_sums_panel<8>(rows, a + v * kLanes, a_row, to + v * kLanes);
  for (; v < vectors; ++v) add_sums_panel<1>(rows, a + v * kLanes, a_row, to + v * kLanes);
}

void transpose(Index rows, Index columns, const float* from, Index from_row, float* to, Index to_row) {
  const auto block = [&](const float* f, float* t) {
    const auto row = [&](Index r) { return Four{*reinterpret_cast<const UnalignedFour*>(f + r * from_row)}; };
    const Four a = row(0), b = row(1), c = row(2), d = row(3);
    const Four ab = __builtin_shufflevector(a, b, 0, 4, 1, 5), ab2 = __builtin_shufflevector(a, b, 2, 6, 3, 7);
    const Four cd = __builtin_shufflevector(c, d, 0, 4, 1, 5), cd2 = __builtin_shufflevector(c, d, 2, 6, 3, 7);
    const auto put = [&](Index r, Four v) { *reinterpret_cast<UnalignedFour*>(t + r * to_row) = v; };
    put(0, __builtin_shufflevector(ab, cd, 0, 1, 4, 5));
    put(1, __builtin_shufflevector(ab, cd, 2, 3, 6, 7));
    put(2, __builtin_shufflevector(ab2, cd2, 0, 1, 4, 5));
    put(3, __builtin_shufflevector(ab2, cd2, 2, 3, 6, 7));
  };
  Index i = 0;
  for (; i + 4 <= rows; i += 4) {
    Index j = 0;
    for (; j + 4 <= columns; j += 4) block(from + i * from_row + j, to + j * to_row + i);
    for (; j < columns; ++j) {
      for (Index r = i; r < i + 4; ++r) to[j * to_row + r] = from[r * from_row + j];
    }
  }
  for (; i < rows; ++i) {
    for (Index j = 0; j < columns; ++j) to[j * to_row + i] = from[i * from_row + j];
  }
}

float squared_norm(Index n, const float* a) {
  Vector sum[4] = {};
  Index i = 0;
  for (; i + 4 * kLanes <= n; i += 4 * kLanes) {
#pragma GCC unroll 4
    for (int v = 0; v < 4; ++v) {
      const Vector x = load(a + i + v * kLanes);
      sum[v] += x * x;
    }
  }
  const Four four = sums(sum[0], sum[1], sum[2], sum[3]);
  float rest = 0.0F;
  for (; i < n; ++i) rest += a[i] * a[i];
  return (four[0] + four[1]) + (four[2] + four[3]) + rest;
}

void adam_step(const AdamStep& s) {
  float* __restrict w = s.weights;
  float* __restrict m = s.m;
  float* __restrict v = s.v;
  const float* __restrict g = s.gradient;
  const AdamStep c = s;  // a copy cannot alias the arrays
  for (Index i = 0; i < c.n; ++i) {
    const float slope = c.scale * g[i];
    m[i] = c.beta1 * m[i] + c.rest1 * slope;
    v[i] = c.beta2 * v[i] + c.rest2 * slope * slope;
    w[i] -= c.rate * m[i] / (__builtin_sqrtf(c.v_correction * v[i]) + c.epsilon);
  }
}

void soft_update(Index n, float* __restrict target, const float* __restrict source, float tau) {
  for (Index i = 0; i < n; ++i) target[i] += tau * (source[i] - target[i]);
}

}  // namespace

constinit const FloatKernels kTable{.multiply = multiply,
                                    .row_dots = row_dots,
                                    .add_column_sums = add_column_sums,
                                    .transpose = transpose,
                                    .squared_norm = squared_norm,
                                    .adam_step = adam_step,
                                    .soft_update = soft_update};

}  // namespace modsearch
