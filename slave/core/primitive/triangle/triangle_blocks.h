// SPDX-License-Identifier: Apache-2.0
// The blocks of a structure's leaves. New ones are not initialised: their writer fills every lane.
//
// Threads. Plain values.
#pragma once

#include <vector>

#include "common/base/uninitialized_allocator.h"
#include "slave/core/primitive/triangle/triangle_layout.h"

namespace tessera::core {

template <int W>
using TriangleBlocks = std::vector<TriangleBlock<W>, UninitializedAllocator<TriangleBlock<W>>>;

}  // namespace tessera::core
