// The kernel of simultaneous inverse kinematics for AVX2; see simultaneous_ik_body_internal.hpp.
#include <modsearch/kinematics/simultaneous_ik_kernel_internal.hpp>

#define kTable kIkKernelAvx2

#include <modsearch/kinematics/simultaneous_ik_body_internal.hpp>
