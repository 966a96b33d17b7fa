// SPDX-License-Identifier: Apache-2.0
// An allocator that leaves new elements uninitialised, for large arrays of which every element is
// written once: zeroing them first would hold up the thread that does it, and that thread would
// touch all of their memory first. Large ones stand on large pages (large_pages.h).
//
// Threads. As std::allocator.
#pragma once

#include <new>
#include <utility>

#include "common/base/large_pages.h"

namespace tessera {

template <typename T>
struct UninitializedAllocator : PagedAllocator<T, kLargePagesFromBytes> {
  template <typename U>
  struct rebind {
    using other = UninitializedAllocator<U>;
  };
  template <typename U>
  void construct(U* place) noexcept {
    ::new (static_cast<void*>(place)) U;
  }
  template <typename U, typename... Args>
  void construct(U* place, Args&&... args) {
    ::new (static_cast<void*>(place)) U(std::forward<Args>(args)...);
  }
};

}  // namespace tessera
