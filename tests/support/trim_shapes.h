// SPDX-License-Identifier: Apache-2.0
// Trimming loops to test with, and the points at which they are asked: the hard classes of trims.
//
// Threads. Owned by one test.
#pragma once

#include <vector>

#include "common/scene/patch_surface.h"
#include "tests/support/choices.h"

namespace tessera::test {

struct TrimAsk {
  double u = 0, v = 0;
};

enum class TrimClass {
  kSmooth,       // closed curves of random degrees and weights, which may cross themselves
  kLevel,        // corners of many loops at the same few values of v, asked level with them
  kCusps,        // cusps and spikes, pointing in all directions
  kTouching,     // circles that are tangent to each other, and squares that share sides
  kTiny,         // diameters of 1e-5
  kNested,       // one in the other
  kBorder,       // sides that lie on the border of the square
  kStrips,       // widths from 3e-6 to 1e-3
  kMany,         // hundreds beside each other
  kDegrees,      // degrees 6 to 15
  kWeights,      // weights from 1e-12 to 1e12
  kWildWeights,  // weights from 1e-37 to 1e37
  kCrossing,     // loops that cross each other
  kCrowd,        // dozens of rings and slanted strips through the same places, in order or not
};

// Makes the loops of one patch.
class TrimShapes {
 public:
  TrimShapes(TrimClass kind, Choices& choices);

  const PatchSurface& surface() const { return surface_; }

  // A point of the square: anywhere; level with a control point, to the bit or by 2^-30; or at a
  // distance of 2^-23 to 1/4 from a loop, half of these within 2^-20.
  TrimAsk ask();

  // A point of a loop, but for roundings of double.
  TrimAsk on_loop();

 private:
  Choices& choices_;
  PatchSurface surface_;
};

// Adds a loop to the last patch. points: as PatchSurface has them.
void add_loop(PatchSurface& surface, const std::vector<TrimPoint>& points,
              const std::vector<int>& degrees);
void add_circle(PatchSurface& surface, float u, float v, float radius);
void add_rectangle(PatchSurface& surface, float u0, float v0, float u1, float v1);

// One untrimmed patch, to which loops are added.
PatchSurface plain_patch(bool keeps_outside);

}  // namespace tessera::test
