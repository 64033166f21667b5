#pragma once

#include <modsearch/rl/float_kernel_table_internal.hpp>
#include <modsearch/rl/float_kernels.hpp>

namespace modsearch {

/// Those in use: the widest that the processor has, or what the environment variable MODSEARCH_ISA names.
/// Throws std::runtime_error if it names something unknown or unsupported.
[[nodiscard]] const FloatKernels& float_kernels();
/// What a value of MODSEARCH_ISA chooses; null: not set. Throws std::runtime_error as float_kernels() does.
[[nodiscard]] Isa chosen_isa(const char* wish);
/// Those of one instruction set. Throws std::runtime_error if the processor lacks it.
[[nodiscard]] const FloatKernels& float_kernels(Isa isa);
/// From now on float_kernels() gives those of `isa`: for tests and benchmarks that compare instruction sets.
/// Throws std::runtime_error if the processor lacks it.
void use_float_kernels(Isa isa);

}  // namespace modsearch
