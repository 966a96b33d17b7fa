// SPDX-License-Identifier: Apache-2.0
// How this process's heap treats large blocks, which is the C library's affair otherwise.
// Threads. Before others are started.
#pragma once

#if __has_include(<malloc.h>)
#include <malloc.h>
#endif

namespace tessera {

// Gives blocks of 1 MiB and more back to the system when they are freed. Left alone, glibc raises
// that bound with each such block, up to 32 MiB, and keeps what is below it. For a daemon that gets
// such blocks from peers, rarely; a program that takes and frees them all the time loses by it.
// To be called once, before threads are started; does nothing where the library is another one.
inline void give_large_blocks_back() {
#if defined(__GLIBC__)
  constexpr int kMib = 1 << 20;
  (void)mallopt(M_MMAP_THRESHOLD, kMib);
  (void)mallopt(M_TRIM_THRESHOLD, 2 * kMib);
#endif
}

}  // namespace tessera
