// The kernel of simultaneous inverse kinematics for SSE2, which every x86-64 processor has; see
// simultaneous_ik_body_internal.hpp.
#include <modsearch/kinematics/simultaneous_ik_kernel_internal.hpp>

#define kTable kIkKernelSse2

#include <modsearch/kinematics/simultaneous_ik_body_internal.hpp>
