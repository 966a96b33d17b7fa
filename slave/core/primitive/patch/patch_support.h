// SPDX-License-Identifier: Apache-2.0
// Whether the core knows patches and their trims. It may be built without, to measure what scenes
// of triangles pay for what asks whether a surface is one
// (tests/bench/feature_cost/core_cost.sh).
// Threads. A constant.
#pragma once

namespace tessera::core {

#ifdef TESSERA_WITHOUT_PATCHES
inline constexpr bool kKnowsPatches = false;
#else
inline constexpr bool kKnowsPatches = true;
#endif

}  // namespace tessera::core
