#pragma once

#include <cstddef>
#include <new>
#include <vector>

namespace modsearch {

/// Memory that begins at a cache line: a vector load across two lines takes twice as long.
template <typename T>
struct CacheLineAllocator {
  using value_type = T;
  static constexpr std::align_val_t kLine{64};

  CacheLineAllocator() = default;
  template <typename U>
  explicit CacheLineAllocator(const CacheLineAllocator<U>&) {}
  [[nodiscard]] T* allocate(std::size_t n) { return static_cast<T*>(::operator new(n * sizeof(T), kLine)); }
  void deallocate(T* memory, std::size_t) { ::operator delete(memory, kLine); }
  friend bool operator==(CacheLineAllocator, CacheLineAllocator) { return true; }
};

using FloatBuffer = std::vector<float, CacheLineAllocator<float>>;

}  // namespace modsearch
