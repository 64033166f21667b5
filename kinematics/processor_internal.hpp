#pragma once

namespace modsearch::detail {

/// The processor has what code compiled for x86-64-v3 (AVX2, FMA) asks for.
[[nodiscard]] inline bool processor_has_v3() {
#if defined(__clang__) && __clang_major__ < 18  // does not know the levels; these came together with the rest of theirs
  return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi2");
#else
  return __builtin_cpu_supports("x86-64-v3") != 0;
#endif
}

/// The processor has what code compiled for x86-64-v4 (AVX-512 F, BW, CD, DQ, VL) asks for.
[[nodiscard]] inline bool processor_has_v4() {
#if defined(__clang__) && __clang_major__ < 18
  return processor_has_v3() && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
         __builtin_cpu_supports("avx512cd") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl");
#else
  return __builtin_cpu_supports("x86-64-v4") != 0;
#endif
}

}  // namespace modsearch::detail
