// SPDX-License-Identifier: Apache-2.0
// Memory of arrays. Large ones stand on large pages, where the system gives some on request: a
// first touch of 4 KiB costs as much as hundreds of operations, on virtual machines thousands, and
// a large page takes one for 512 of them.
//
// Only arrays of kLargePagesFromBytes and more: below that the C library keeps what is freed and
// hands it out again, touched already; above it maps memory anew each time.
//
// Threads. As operator new.
#pragma once

#include <cstddef>

namespace tessera {

inline constexpr std::size_t kLargePageBytes = std::size_t{2} << 20;
// The most that glibc's bound between kept and mapped memory grows to.
inline constexpr std::size_t kLargePagesFromBytes = std::size_t{32} << 20;

// Requires: alignment is a power of two, at most a page. Throws: std::bad_alloc.
void* take_array(std::size_t bytes, std::size_t alignment);
// Requires: take_array() gave it, for as many bytes and as great an alignment.
void give_array_back(void* array, std::size_t bytes, std::size_t alignment) noexcept;

}  // namespace tessera
