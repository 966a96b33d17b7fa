// SPDX-License-Identifier: Apache-2.0
#include "common/base/large_pages.h"

#include <algorithm>
#include <new>

#if defined(__linux__)
#include <sys/mman.h>
#endif

namespace tessera {
namespace {

std::align_val_t alignment_of(std::size_t bytes, std::size_t alignment) {
  return std::align_val_t{bytes < kLargePagesFromBytes ? alignment
                                                       : std::max(alignment, kLargePageBytes)};
}

}  // namespace

void* take_array(std::size_t bytes, std::size_t alignment) {
  void* const array = ::operator new(bytes, alignment_of(bytes, alignment));
#if defined(__linux__)
  // A wish: where it is not granted, pages are small.
  if (bytes >= kLargePagesFromBytes) (void)::madvise(array, bytes, MADV_HUGEPAGE);
#endif
  return array;
}

void give_array_back(void* array, std::size_t bytes, std::size_t alignment) noexcept {
  // Without its size: clang has no sized deallocation unless asked.
  ::operator delete(array, alignment_of(bytes, alignment));
}

}  // namespace tessera
