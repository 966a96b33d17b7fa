// What shading needs to know of the point that a ray has hit.
// Threads. Plain values, made and used by one worker. All vectors are in world space.
#pragma once

#include <cstdint>

#include "slave/core/render/prepared_scene_impl.h"

namespace tessera::core {

struct Surface {
  Vec3f point;
  Vec3f normal;          // geometric, unit, turned to the viewer
  Vec3f shading_normal;  // unit, on the viewer's side of the surface
  Vec3f albedo;
  Vec3f emission;    // towards the viewer; zero from behind
  float offset = 0;  // see surface_offset.h
  std::uint32_t material = 0;
};

// `to_surface`: direction of the ray that hit. Requires: triangle < triangle count, u and v of its
// hit.
Surface surface_at(const PreparedScene::Impl& scene, std::uint32_t triangle, float u, float v,
                   Vec3f to_surface);

// Bilinear, repeating; linear RGB. uv need not be in [0, 1].
Vec3f sample_texture(const Texture& texture, Vec2f uv);

}  // namespace tessera::core
