// SPDX-License-Identifier: Apache-2.0
// Points that gather the light of virtual point lights (VPLs), and the planes of the filter that
// smooths the result.
// Fixed-size types only and no functions.
#pragma once

#include <stdint.h>

#include "slave/core/light/light_point_layout.h"
#include "slave/core/ray/packet_layout.h"

namespace tessera::core {

inline constexpr int kGatherMax = kFanTargetsMax;
inline constexpr int kGatherRoom = kGatherMax + 16;  // registers are stored whole

// Points of surfaces that gather from the same lights. Shape: [count], of [kGatherMax].
struct alignas(64) GatherPoints {
  int count;
  alignas(64) float point[3][kGatherRoom];
  alignas(64) float normal[3][kGatherRoom];   // geometric, unit, on the viewer's side
  alignas(64) float shading[3][kGatherRoom];  // unit
  alignas(64) float offset[kGatherRoom];      // see surface_offset.h
  uint32_t key[kGatherRoom];                  // pixel_key() of the caller's choice
  // The primitive that the point lies on, and how steep rays are that do not meet it again
  // (horizon_layout.h); kNoPrimitive where that is a sliver, whose normal says little.
  alignas(64) uint32_t primitive[kGatherRoom];
  alignas(64) float horizon[kGatherRoom];
  // Irradiance over pi: times the albedo it is the radiance that a diffuse surface reflects.
  alignas(64) float light[3][kGatherRoom];
  // Bounds of the points and of their shading normals; see bound_points().
  float lower[3], upper[3], normal_lower[3], normal_upper[3];
};

// Shadow rays of one VPL, one for each point that it may light.
struct alignas(64) GatherRays {
  FanTargets targets;                       // seen from the VPL, to just above the points
  alignas(64) int32_t point[kGatherRoom];   // by ray: the point that it goes to
  bool is_origin_excluded;                  // whether no ray can meet the VPL's own primitive
  uint32_t excluded[kGatherRoom];           // by ray: the primitive of its point, or kNoPrimitive
  alignas(64) float strength[kGatherRoom];  // by point: factor of the VPL's rgb; 0: gets none
};

// Pixels of a part of the picture with a border, for the discontinuity buffer. A pixel that shows
// no surface to gather light has distance NaN, so that no comparison holds; its other values are
// not looked at.
inline constexpr int kFilterRadiusMax = 2;
inline constexpr int kFilterEdgeMax = 64 + 2 * kFilterRadiusMax;
inline constexpr int kFilterStride = 96;  // registers read beyond the border
inline constexpr int kFilterPixels = kFilterStride * (kFilterEdgeMax + 2 * kFilterRadiusMax);
struct alignas(64) FilterPlanes {
  float light[3][kFilterPixels];  // as GatherPoints::light
  float point[3][kFilterPixels];
  float normal[3][kFilterPixels];
  float distance[kFilterPixels];
  int32_t material[kFilterPixels];
  float albedo[3][kFilterPixels];
  float sum[3][kFilterPixels];  // over a pixel's samples
};
// Index of pixel (x, y) of the part.
constexpr int filter_index(int x, int y) {
  return (y + kFilterRadiusMax) * kFilterStride + x + kFilterRadiusMax;
}

}  // namespace tessera::core
