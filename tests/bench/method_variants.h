// SPDX-License-Identifier: Apache-2.0
// Variants of the methods for patches that only their table needs: two triangles for a facet,
// bounds of slopes by interval arithmetic and by second derivatives, starts of Newton for lanes.
// Threads. Pure functions, but for counts, which are one thread's.
#pragma once

#include <cstdint>

#include "slave/core/primitive/patch/methods/clip.h"
#include "slave/core/primitive/patch/methods/newton.h"
#include "slave/core/primitive/patch/methods/patch_method_abi.h"
#include "slave/core/primitive/patch/methods/refine_walk.h"

namespace tessera::bench {

enum class SlopeBounds { kClipped, kInterval, kSecond };

// Settings of a variant, and what its calls have done: boxes that were looked at, or steps.
struct CountedHow {
  core::RefineHow refine{};
  core::NewtonHow newton{};
  core::ClipHow clip{};
  mutable std::uint64_t work = 0;
};

// Calls that use the settings. Requires: these outlive them.
core::PatchMethodCall refine_call(const CountedHow& how, bool is_bilinear);
core::PatchMethodCall newton_call(const CountedHow& how);
core::PatchMethodCall krawczyk_call(const CountedHow& how, SlopeBounds bounds);
core::PatchMethodCall clip_call(const CountedHow& how);

// Places from which Newton is safe, by clipped bounds: the serial part of a method whose Newton
// runs in lanes. Shape: u, v [most]. Returns: how many there are, at most `most`.
int safe_starts(const core::Patch& patch, const core::SubPatch& whole, const float* origin,
                const float* direction, int most, float* u, float* v);

}  // namespace tessera::bench
