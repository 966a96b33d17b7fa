// SPDX-License-Identifier: Apache-2.0
// Every use of random numbers in a picture: the dimensions of the sample sequence. A point of the
// sequence is shuffled_2d(hash_combine(key, dimension), index); two uses are independent where
// their keys or their dimensions differ (core_dimensions_test draws every pair).
//
// Threads. Constants.
#pragma once

#include <cstddef>
#include <cstdint>

#include "common/base/limits.h"

namespace tessera::core {

enum class Dimension : std::uint32_t {
  // Used with the key of a pixel, which its seed and place make.
  kLens = 0,
  kSurface = 1,  // gives the key of the first surface that is seen

  // Used with the key of a surface.
  kEmitter = 0,               // + 2 for each emitter that is sampled by itself
  kBiasRay = 0x10000001,      // towards light that the bound of VPLs has cut
  kBiasPath = 0x10000003,     // gives the key of what that ray meets
  kSpecular = 0x20000001,     // + the number of surfaces in the chain
  kScatter = 0x40000001,      // direction of a path
  kNextSurface = 0x40000003,  // + depth; gives the key of the path's next surface
  kEnvironment = 0x80000001,
  kGlossy = 0x80000003,

  // Used with the key of a frame, for light subpaths.
  kVplPlace = 0,
  kVplPick,
  kVplFirst,
  kVplPilotPick,
  kVplPilotFirst,
  kVplBounce,  // + depth
};

constexpr std::uint32_t dimension(Dimension d, std::uint32_t number = 0) {
  return static_cast<std::uint32_t>(d) + number;
}

// The dimensions of a use that has several. Requires: the ranges of one key are in rising order.
struct DimensionRange {
  Dimension first;
  std::uint32_t count;
};
inline constexpr DimensionRange kSurfaceDimensions[] = {
    {Dimension::kEmitter, 128},  // of at most 64 emitters, light_set.h
    {Dimension::kBiasRay, 1},     {Dimension::kBiasPath, 1},
    {Dimension::kSpecular, 17},  // specular_chain.h
    {Dimension::kScatter, 1},     {Dimension::kNextSurface, kBouncesMax + 2},
    {Dimension::kEnvironment, 1}, {Dimension::kGlossy, 1},
};
inline constexpr DimensionRange kLightPathDimensions[] = {
    {Dimension::kVplPlace, 1},      {Dimension::kVplPick, 1},
    {Dimension::kVplFirst, 1},      {Dimension::kVplPilotPick, 1},
    {Dimension::kVplPilotFirst, 1}, {Dimension::kVplBounce, kBouncesMax + 2},
};

template <std::size_t kCount>
constexpr bool are_disjoint(const DimensionRange (&ranges)[kCount]) {
  for (std::size_t i = 1; i < kCount; ++i) {
    if (dimension(ranges[i - 1].first, ranges[i - 1].count) > dimension(ranges[i].first))
      return false;
  }
  return true;
}
static_assert(are_disjoint(kSurfaceDimensions) && are_disjoint(kLightPathDimensions));

}  // namespace tessera::core
