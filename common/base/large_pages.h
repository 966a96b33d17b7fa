// SPDX-License-Identifier: Apache-2.0
// Memory of arrays. Large ones stand on large pages, where the system gives some on request: a
// first touch of 4 KiB costs as much as hundreds of operations, on virtual machines thousands, and
// a large page takes one for 512 of them.
//
// Only arrays of kLargePagesFromBytes and more: below that the C library keeps what is freed and
// hands it out again, touched already; above it maps memory anew each time. What lasts as long as a
// scene is taken once, and stands on large pages from kLastingFromBytes on.
//
// Threads. As operator new.
#pragma once

#include <cstddef>
#include <memory>

namespace tessera {

inline constexpr std::size_t kLargePageBytes = std::size_t{2} << 20;
// The most that glibc's bound between kept and mapped memory grows to.
inline constexpr std::size_t kLargePagesFromBytes = std::size_t{32} << 20;

// An array's last large page is half empty on the average, an eighth of as little as this.
inline constexpr std::size_t kLastingFromBytes = std::size_t{8} << 20;

// from: the bytes from which on an array stands on large pages. Requires: alignment is a power of
// two, at most a page. Throws: std::bad_alloc.
void* take_array(std::size_t bytes, std::size_t alignment, std::size_t from = kLargePagesFromBytes);
// Requires: take_array() gave it, for the same numbers.
void give_array_back(void* array, std::size_t bytes, std::size_t alignment,
                     std::size_t from = kLargePagesFromBytes) noexcept;

// An allocator of arrays that stand on large pages from kFrom bytes on.
template <typename T, std::size_t kFrom>
struct PagedAllocator : std::allocator<T> {
  template <typename U>
  struct rebind {
    using other = PagedAllocator<U, kFrom>;
  };
  // Requires: count * sizeof(T) can be counted, as std::vector sees to.
  T* allocate(std::size_t count) {
    return static_cast<T*>(take_array(count * sizeof(T), alignof(T), kFrom));
  }
  void deallocate(T* array, std::size_t count) noexcept {
    give_array_back(array, count * sizeof(T), alignof(T), kFrom);
  }
};
// Of arrays that last.
template <typename T>
using LastingAllocator = PagedAllocator<T, kLastingFromBytes>;

}  // namespace tessera
