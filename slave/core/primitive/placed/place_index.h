// SPDX-License-Identifier: Apache-2.0
// Scenes in which places share surfaces of patches, in two levels: each such surface has one
// hierarchy, in its own coordinates; a hierarchy over its places, and over what is flattened,
// stands above.
//
// Threads. Built by the calling thread and up to thread_count - 1 more.
#pragma once

#include <memory>

#include "common/base/status.h"
#include "slave/core/primitive/freeform/patched_index.h"
#include "slave/core/primitive/primitive_index.h"

namespace tessera::core {

// known: another version of the scene, whose surfaces are taken where they are the same; or null.
// Requires: the store has places, and its sub-patches and places have their numbers. Returns:
// kCancelled; kResourceExhausted.
template <int W>
Result<PlacedBvh<W>> index_places(const PatchedParts& parts,
                                  std::shared_ptr<const PatchStore> patches,
                                  const PlacedBvh<W>* known, const BuildControl& control);

}  // namespace tessera::core
