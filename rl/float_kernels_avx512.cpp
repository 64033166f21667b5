// The float kernels for AVX-512; see float_kernels_body_internal.hpp.
#include <modsearch/rl/float_kernel_table_internal.hpp>

#define MODSEARCH_LANES 16
#define kTable kFloatKernelsAvx512

namespace {
constexpr int kLanes = MODSEARCH_LANES;
constexpr int kTileRows = 12;
constexpr int kTileVectors = 2;
}  // namespace

#include <modsearch/rl/float_kernels_body_internal.hpp>
