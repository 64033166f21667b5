#include <fmt/format.h>

#include <atomic>
#include <cstdlib>
#include <modsearch/kinematics/processor_internal.hpp>
#include <modsearch/rl/float_kernels.hpp>
#include <modsearch/rl/float_kernels_internal.hpp>
#include <stdexcept>
#include <string>

namespace modsearch {
namespace {

constexpr Isa kAll[] = {Isa::kSse2, Isa::kAvx2, Isa::kAvx512};

bool supported(Isa isa) {
  switch (isa) {
    case Isa::kSse2:
      return true;
    case Isa::kAvx2:
      return detail::processor_has_v3();
    case Isa::kAvx512:
      return detail::processor_has_v4();
  }
  return false;
}

std::atomic<const FloatKernels*>& in_use() {
  static std::atomic<const FloatKernels*> kernels{&float_kernels(chosen_isa(std::getenv("MODSEARCH_ISA")))};
  return kernels;
}

}  // namespace

std::string_view name(Isa isa) {
  switch (isa) {
    case Isa::kSse2:
      return "sse2";
    case Isa::kAvx2:
      return "avx2";
    case Isa::kAvx512:
      return "avx512";
  }
  return "";
}

std::vector<Isa> supported_isas() {
  std::vector<Isa> result;
  for (const Isa isa : kAll) {
    if (supported(isa)) result.push_back(isa);
  }
  return result;
}

Isa chosen_isa(const char* wish) {
  if (wish == nullptr) return supported_isas().back();
  for (const Isa isa : kAll) {
    if (name(isa) != wish) continue;
    if (supported(isa)) return isa;
    throw std::runtime_error(fmt::format("environment variable MODSEARCH_ISA = '{}', this processor has up to {}", wish,
                                         name(supported_isas().back())));
  }
  throw std::runtime_error(
      fmt::format("environment variable MODSEARCH_ISA = '{}', must be sse2, avx2 or avx512", wish));
}

std::string_view kernel_isa() {
  const FloatKernels* const kernels = &float_kernels();
  if (kernels == &kFloatKernelsAvx512) return name(Isa::kAvx512);
  return name(kernels == &kFloatKernelsAvx2 ? Isa::kAvx2 : Isa::kSse2);
}

const FloatKernels& float_kernels() { return *in_use().load(std::memory_order_relaxed); }

const FloatKernels& float_kernels(Isa isa) {
  if (!supported(isa)) {
    throw std::runtime_error(
        fmt::format("this processor has no {}; it has up to {}", name(isa), name(supported_isas().back())));
  }
  switch (isa) {
    case Isa::kSse2:
      return kFloatKernelsSse2;
    case Isa::kAvx2:
      return kFloatKernelsAvx2;
    case Isa::kAvx512:
      return kFloatKernelsAvx512;
  }
  return kFloatKernelsSse2;
}

void use_float_kernels(Isa isa) { in_use().store(&float_kernels(isa), std::memory_order_relaxed); }

}  // namespace modsearch
