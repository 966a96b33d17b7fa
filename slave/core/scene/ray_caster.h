// SPDX-License-Identifier: Apache-2.0
// Casts rays that a caller brings, with one answer for each: for tools and for measuring. Renderers
// trace packets of their own making.
//
// Threads. cast_rays() may be called by any number of threads; it starts CastOptions::threads of
// them.
#pragma once

#include <span>

#include "common/base/isa.h"
#include "common/frame/patch_method.h"
#include "slave/core/scene/prepared_scene.h"

namespace tessera::core {

// P(t) = origin + t * direction, a hit needs t_min <= t <= t_max. A ray with a component that is
// not finite, a zero direction or limits that are NaN is a miss.
struct CastRay {
  Vec3f origin, direction;
  float t_min = 0, t_max = 0;
};

struct CastHit {
  bool is_hit = false;
  std::uint32_t primitive = 0;  // triangle in the scene's numbering
  float t = 0, u = 0, v = 0;    // P = (1 - u - v) A + u B + v C
  Vec3f normal;                 // unit, along (B - A) x (C - A)
};

struct CastOptions {
  Isa isa = Isa::kScalar;  // in supported_isas()
  int bundle = 64;         // rays traced together: 1, 4, 16 or 64; answers do not depend on it
  int threads = 1;         // at least 1; answers do not depend on it
  bool is_any = false;     // only whether something is hit: the rest of CastHit stays 0
  PatchMethod patch_method = PatchMethod::kAuto;  // how rays meet patches
};

// Shape: hits [rays.size()]. Neighbours in `rays` should be neighbours in space.
void cast_rays(const PreparedScene& scene, std::span<const CastRay> rays,
               const CastOptions& options, std::span<CastHit> hits);

}  // namespace tessera::core
