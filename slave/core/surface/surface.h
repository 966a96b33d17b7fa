// SPDX-License-Identifier: Apache-2.0
// What shading needs to know of the point that a ray has hit.
// Threads. Plain values, made and used by one worker. All vectors are in world space.
#pragma once

#include <cstdint>

#include "common/scene/scene.h"
#include "slave/core/ray/horizon_layout.h"
#include "slave/core/surface/ray_cone.h"

namespace tessera::core {

inline constexpr std::uint16_t kNoLobes = 0xffff;

struct Surface {
  Vec3f point;
  Vec3f normal;          // geometric, unit, turned to the viewer
  Vec3f shading_normal;  // unit, on the viewer's side of the surface
  Vec3f albedo;
  // Throughput of the path up to here: the weight in the pixel of what the surface sends to the
  // viewer.
  Vec3f weight{1, 1, 1};
  float offset = 0;  // see surface_offset.h
  BsdfKind bsdf = BsdfKind::kDiffuse;
  // Light samples need the members above, and none below.

  Vec3f emission;  // towards the viewer; zero from behind
  const Material* material = nullptr;
  // The primitive that the point lies on, by its number in the scene, and how steep rays are that
  // do not meet it again (horizon_layout.h). None for slivers.
  std::uint32_t sound_primitive = 0xffffffffu;
  float horizon = kPlaneHorizon;
  bool is_front = true;            // the viewer is where the geometric normal of the mesh points
  bool passes_only = false;        // of glass: see slave/core/bsdf/transmission.h
  std::uint16_t lobes = kNoLobes;  // index in its batch (slave/core/scene/surface_batch.h)

  // The members below keep these values where the scene does not use them (SurfaceFeatures).
  Vec3f to_viewer;             // unit; set where the BSDF is not diffuse
  float roughness = 1;         // of a glossy one or glass, in [0, 1]
  float metalness = 0;         // of a glossy one, in [0, 1]
  std::uint32_t instance = 0;  // set where any BSDF of the scene is not diffuse
  RayCone cone;                // at the hit
};

// Mirror, glass and their like scatter into single directions: no light sample can meet them, so
// paths go through them (slave/core/integrate/specular_chain.h) and never rest there.
inline bool is_specular(const Surface& s) { return scattering_of(s.bsdf) == Scattering::kDelta; }

}  // namespace tessera::core
