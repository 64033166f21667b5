// The float kernels for AVX2 with FMA; see float_kernels_body_internal.hpp.
#include <modsearch/rl/float_kernel_table_internal.hpp>

#define MODSEARCH_LANES 8
#define kTable kFloatKernelsAvx2

namespace {
constexpr int kLanes = MODSEARCH_LANES;
constexpr int kTileRows = 6;
constexpr int kTileVectors = 2;
}  // namespace

#include <modsearch/rl/float_kernels_body_internal.hpp>
