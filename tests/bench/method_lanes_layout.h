// SPDX-License-Identifier: Apache-2.0
// Bicubic patches and bundles of camera rays in float32, as the methods' variants for bundles take
// them: up to 16 rays side by side, one to a lane.
// Fixed-size types only and no functions.
#pragma once

#include <stdint.h>

namespace tessera::bench {

inline constexpr int kLaneRays = 16;

// Points [axis][4 i + j] of P_ij, and coefficients of u^(3-i) v^(3-j), both relative to the eye.
struct LanePatch {
  float points[3][16], powers[3][16];
  float extent;
};

struct LanePart {
  uint32_t patch;
  float low[2], high[2];  // of u and v
};

// Inner nodes have their children side by side; leaves have one part.
struct LaneNode {
  float low[3], high[3];  // relative to the eye
  uint32_t child_or_part;
  uint32_t is_leaf;
};

// Where a ray enters Newton, by the serial part of a method. Returns: how many places there are.
inline constexpr int kLaneStartsMax = 4;
using LaneStarts = int (*)(const void* scene, uint32_t patch, const float* direction, float* u,
                           float* v);

struct LaneScene {
  const LaneNode* nodes;  // root first
  const LanePart* parts;
  const LanePatch* patches;
  const void* owner;  // for `starts`
  LaneStarts starts;
  float* last;  // [part][2]: u, v of the last root of a part; NaN before there is one
};

struct LaneHow {
  int level = 0;  // halvings in all
  bool is_bilinear = true;
  float accuracy = 0x1p-20f;  // of a patch's extent
};

// Rays from the eye. t: infinite where nothing is hit.
struct LaneBundle {
  alignas(64) float direction[3][kLaneRays];
  alignas(64) float t[kLaneRays];
  alignas(64) float u[kLaneRays], v[kLaneRays];
  uint32_t part[kLaneRays];
};

using TraceLanes = void (*)(const LaneScene& scene, const LaneHow& how, LaneBundle& rays);

// For bundles of 1, 4 and 16 rays, the first of LaneBundle. Narrower registers take fewer.
inline constexpr int kLaneSizes = 3;
struct LaneKernels {
  TraceLanes newton[kLaneSizes];      // from the middle of a part
  TraceLanes neighbours[kLaneSizes];  // from the last root of the part
  TraceLanes refine[kLaneSizes];      // one subdivision for all rays
  TraceLanes serial[kLaneSizes];      // from `starts`
  int lanes[kLaneSizes];              // rays that there are
};

}  // namespace tessera::bench
