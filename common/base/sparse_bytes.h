// SPDX-License-Identifier: Apache-2.0
// Memory that is there once it is written: an address range whose pages the system gives one by one
// (mmap, anonymous), so that a range of gigabytes costs what was written into it. No huge pages:
// one of those would be 2 MiB for a single byte.
//
// Threads. None of its own: who writes sees to it that nobody reads there.
// Invariant. Bytes that were never written are zero.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace tessera {

class SparseBytes {
 public:
  // Requires: size_bytes > 0. Throws: std::bad_alloc where there is no room for the addresses.
  explicit SparseBytes(std::uint64_t size_bytes);
  ~SparseBytes();
  SparseBytes(const SparseBytes&) = delete;
  SparseBytes& operator=(const SparseBytes&) = delete;

  std::span<std::byte> bytes() { return bytes_; }
  std::span<const std::byte> bytes() const { return bytes_; }

 private:
  std::span<std::byte> bytes_;
};

}  // namespace tessera
