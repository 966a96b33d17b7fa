// SPDX-License-Identifier: Apache-2.0
#include "common/base/sparse_bytes.h"

#include <sys/mman.h>

#include <new>

#include "common/base/check.h"

namespace tessera {

SparseBytes::SparseBytes(std::uint64_t size_bytes) {
  TESSERA_CHECK_GE(size_bytes, 1u);
  const auto size = static_cast<std::size_t>(size_bytes);
  void* const begin = ::mmap(nullptr, size, PROT_READ | PROT_WRITE,
                             MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (begin == MAP_FAILED) throw std::bad_alloc();
  // A kernel without huge pages refuses the advice, and has no need of it.
  (void)::madvise(begin, size, MADV_NOHUGEPAGE);
  bytes_ = {static_cast<std::byte*>(begin), size};
}

SparseBytes::~SparseBytes() { ::munmap(bytes_.data(), bytes_.size()); }

}  // namespace tessera
