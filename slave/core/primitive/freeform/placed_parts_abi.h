// SPDX-License-Identifier: Apache-2.0
// Sub-patches of shared surfaces in world space, made by the operations that flatten a scene when
// somebody asks for them. A thread keeps what it made last, in a table of a fixed size that is
// dropped as a whole when it is full.
//
// Declarations only: kernel files, which are compiled once per instruction set, may include this.
// Threads. Each thread has a table of its own.
#pragma once

#include <stdint.h>

#include "slave/core/primitive/instance_layout.h"
#include "slave/core/primitive/patch/patch_layout.h"

namespace tessera::core {

// Bytes of a thread's table, which is there from the first question on; with room for the patch of
// the most control points (scene_footprint.h reckons them).
inline constexpr int kPlacedPartsMax = 2048;
inline constexpr int kPlacedNumbersMax = 48 * kPlacedPartsMax + 4 * kPatchPointsMax;

// Both are the thread's, until it asks for one that it has no room for.
struct PartInWorld {
  const Patch* patch;
  const SubPatch* part;
};

// place_number: of the place among those of all scenes. patch and part: the surface's. Returns: the
// part with a `patch` of 0, so that it names the patch returned, and with the number that it has in
// the flattened scene.
PartInWorld part_in_world(const InstanceBlock& place, uint64_t place_number, const Patch& patch,
                          const SubPatch& part);

// Whether the next part will leave the others where they are.
bool has_room_for_part();

}  // namespace tessera::core
