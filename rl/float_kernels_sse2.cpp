// The float kernels for SSE2; see float_kernels_body_internal.hpp.
#include <modsearch/rl/float_kernel_table_internal.hpp>

#define MODSEARCH_LANES 4
#define kTable kFloatKernelsSse2

namespace {
constexpr int kLanes = MODSEARCH_LANES;
constexpr int kTileRows = 4;
constexpr int kTileVectors = 2;
}  // namespace

#include <modsearch/rl/float_kernels_body_internal.hpp>
