#pragma once

#include <string_view>
#include <vector>

namespace modsearch {

/// Instruction sets for which the networks' arithmetic is compiled, each wider than the one before.
enum class Isa {
  kSse2,    ///< every x86-64 processor
  kAvx2,    ///< x86-64-v3
  kAvx512,  ///< x86-64-v4
};

/// "sse2", "avx2", "avx512".
[[nodiscard]] std::string_view name(Isa isa);
/// Those that this processor has, narrowest first.
[[nodiscard]] std::vector<Isa> supported_isas();
/// Name of the one that networks compute with: the widest supported, unless the environment variable MODSEARCH_ISA
/// names another when the first network is used. Results differ between instruction sets in the last bits, and training
/// amplifies that: a report of a training run says which one it was.
/// Throws std::runtime_error if MODSEARCH_ISA names something unknown or unsupported.
[[nodiscard]] std::string_view kernel_isa();

}  // namespace modsearch
