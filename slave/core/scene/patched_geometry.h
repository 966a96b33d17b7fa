// SPDX-License-Identifier: Apache-2.0
// The patches and triangles of a scene that has patches, with their structure: triangles are
// flattened, and patches where their surface is not shared (primitive/placed).
//
// Threads. Plain functions; the calling thread and up to thread_count - 1 more work.
#pragma once

#include "common/base/status.h"
#include "common/scene/scene.h"
#include "slave/core/accel/build_control.h"
#include "slave/core/scene/geometry.h"

namespace tessera::core {

// Fills in triangles, patches, numbers, index and what was built. `other`: another version of the
// scene, or null; what it has of shared surfaces is taken where they are the same. Requires:
// meshes, instances, structure and is_shareable of the geometry are set. Returns: kCancelled;
// kResourceExhausted.
template <int W>
Status build_patched_geometry(const Scene& scene, const Geometry* other,
                              const BuildControl& control, Geometry& geometry);

}  // namespace tessera::core
