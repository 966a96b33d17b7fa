// SPDX-License-Identifier: Apache-2.0
// The border of scenes and cameras: what passes here is trusted behind it. The functions are called
// once where a scene enters: by the session for applications, by the decoder for peers, by the
// import process for files.
// Threads. Pure functions.
#pragma once

#include "common/base/api.h"
#include "common/base/status.h"
#include "common/math/bounds3.h"
#include "common/scene/scene.h"

namespace tessera {

// Checks counts against limits.h, indices, array lengths, and that every number is finite.
// Returns: kInvalidArgument or kResourceExhausted naming the element.
TESSERA_API Status validate_scene(const Scene& scene);

// Returns: kInvalidArgument saying which rule of Camera is broken.
TESSERA_API Status validate_camera(const Camera& camera);

// Box of all flattened triangles, and of the control points of all flattened patches, between which
// the patches lie; empty for a scene without any.
TESSERA_API Bounds3f scene_bounds(const Scene& scene);

}  // namespace tessera
