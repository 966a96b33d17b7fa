// SPDX-License-Identifier: Apache-2.0
#include "common/base/large_pages.h"

#include <algorithm>
#include <new>

#if defined(__linux__)
#include <sys/mman.h>
#endif

namespace tessera {
namespace {

std::align_val_t alignment_of(std::size_t bytes, std::size_t alignment, std::size_t from) {
  return std::align_val_t{bytes < from ? alignment : std::max(alignment, kLargePageBytes)};
}

}  // namespace

void* take_array(std::size_t bytes, std::size_t alignment, std::size_t from) {
  void* const array = ::operator new(bytes, alignment_of(bytes, alignment, from));
#if defined(__linux__)
  // A wish: where it is not granted, pages are small.
  if (bytes >= from) (void)::madvise(array, bytes, MADV_HUGEPAGE);
#endif
  return array;
}

void give_array_back(void* array, std::size_t bytes, std::size_t alignment,
                     std::size_t from) noexcept {
  // Without its size: clang has no sized deallocation unless asked.
  ::operator delete(array, alignment_of(bytes, alignment, from));
}

}  // namespace tessera
