// SPDX-License-Identifier: Apache-2.0
#include "common/base/entropy.h"

#include <atomic>
#include <random>

namespace tessera {
namespace {

std::atomic<EntropySource> source{nullptr};

std::uint64_t of_the_system() {
  static thread_local std::random_device device;
  return std::uint64_t{device()} << 32 | device();
}

}  // namespace

std::uint64_t entropy() {
  const EntropySource draw = source.load(std::memory_order_relaxed);
  std::uint64_t value = 0;
  while (value == 0) value = draw == nullptr ? of_the_system() : draw();
  return value;
}

void set_entropy_source(EntropySource s) { source.store(s, std::memory_order_relaxed); }

}  // namespace tessera
