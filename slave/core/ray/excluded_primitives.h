// SPDX-License-Identifier: Apache-2.0
// What the rays of a list are known not to meet (ManyRays::excluded): a primitive each, or none.
//
// Threads. One owner.
#pragma once

#include <algorithm>
#include <cstdint>
#include <iterator>

#include "slave/core/ray/packet_layout.h"

namespace tessera::core {

// Lists of which no ray excludes anything pay nothing. kMost: rays of the list.
template <int kMost>
class ExcludedPrimitives {
 public:
  void clear() { is_set_ = false; }
  // Requires: 0 <= ray < kMost. primitive: may be kNoPrimitive.
  void exclude(int ray, std::uint32_t primitive) {
    if (primitive == kNoPrimitive) return;
    if (!is_set_) std::fill(std::begin(number_), std::end(number_), kNoPrimitive);
    is_set_ = true;
    number_[ray] = primitive;
  }
  std::uint32_t of(int ray) const { return is_set_ ? number_[ray] : kNoPrimitive; }
  // By ray; null where none excludes anything.
  const std::uint32_t* numbers() const { return is_set_ ? number_ : nullptr; }

 private:
  bool is_set_ = false;  // else the numbers are not
  alignas(64) std::uint32_t number_[kMost];
};

}  // namespace tessera::core
