// SPDX-License-Identifier: Apache-2.0
// The kernels of scenes whose places share surfaces of patches, by instruction set. They stand
// apart from the kernel table, so that no other scene has to do with them.
//
// Threads. Pure function.
#pragma once

#include "common/base/isa.h"
#include "slave/core/kernels/view_tables_layout.h"
#include "slave/core/primitive/places_layout.h"

namespace tessera::core {

template <int W>
using PlacedView = BvhView<W, TrianglesAndPlaces<W>>;

// Requires: the set is compiled in.
const ViewTables<PlacedView>& place_kernels(Isa isa);

}  // namespace tessera::core
