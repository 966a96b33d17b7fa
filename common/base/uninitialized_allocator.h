// SPDX-License-Identifier: Apache-2.0
// An allocator that leaves new elements uninitialised, for large arrays of which every element is
// written once: zeroing them first would hold up the thread that does it, and that thread would
// touch all of their memory first.
//
// Threads. As std::allocator.
#pragma once

#include <memory>
#include <new>
#include <utility>

namespace tessera {

template <typename T>
struct UninitializedAllocator : std::allocator<T> {
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
