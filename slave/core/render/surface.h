// The surface that a ray has hit: geometry, then what its program fills in.
// Threads. Pure function.
#pragma once

#include <cstdint>

#include "slave/core/render/prepared_scene_impl.h"
#include "slave/core/surface/surface.h"

namespace tessera::core {

// `to_surface`: direction of the ray that hit; `cone`: the ray's, at the hit. Requires: triangle <
// triangle count, u and v of its hit.
Surface surface_at(const PreparedScene::Impl& scene, std::uint32_t triangle, float u, float v,
                   Vec3f to_surface, RayCone cone = {});

}  // namespace tessera::core
