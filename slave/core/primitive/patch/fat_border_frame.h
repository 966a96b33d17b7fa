// SPDX-License-Identifier: Apache-2.0
// The sub-patch that stands for a run of spans of a widened border: its frame and its bounds
// (fat_border.h says what is stored where).
//
// The frame has x along the chord, y towards where the run bends to, n across both. Where a ray
// passes the plane n = 0, it is compared with the parabola y = c (x^2 - 1/2), and then with
// y = c (x^2 - 1/2) + e (x^4 - x^2), which is some times nearer to arcs. Bounds are found at even
// steps of the span's parameter: between two of them it is within 1 / steps^2 of what the whole is
// away from its own chord, |C''| h^2 / 8 being of the second order.
//
// Threads. Pure functions.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "common/math/bounds3.h"
#include "common/math/vec3d.h"
#include "slave/core/primitive/patch/fat_border_spans.h"
#include "slave/core/primitive/patch/patch_layout.h"

namespace tessera::core {

// Lengths of spans in the world. A length is off by less than 2^-52 of it.
struct FatGrowth {
  double stretch, slack;
  double of(float size) const { return double{size} * stretch + slack; }
};
inline FatGrowth growth_of(const SubPatch& border) {
  return {double{border.second[1][2]}, double{border.second[2][0]}};
}

// The number of the first of a border's spans.
inline std::uint32_t first_span(const SubPatch& border) {
  return static_cast<std::uint32_t>(border.second[1][0]) |
         static_cast<std::uint32_t>(border.second[1][1]) << 16;
}
inline FatBorders::Range run_of(const SubPatch& border) {
  return {first_span(border), first_span(border) + border.column + 1};
}

// Steps of a span that is alone, and of one of a run.
inline constexpr int kStepsAlone = 16, kStepsInRun = 8;

// Places of a run of spans in the world.
class RunPlaces {
 public:
  // Requires: the patch has trims, and the run is one of its borders.
  RunPlaces(const Patch& patch, FatBorders::Range run);

  std::span<const Vec3d> places() const { return {places_, count_}; }
  double most() const { return most_; }  // the largest coordinate, by size
  // All that is met of the run is nearer than this to lines between its places.
  double radius(const FatGrowth& growth) const;

 private:
  static constexpr int kPlacesMax = kFatRunMax * (kStepsInRun + 1);
  static_assert(kPlacesMax > kStepsAlone);

  Vec3d places_[kPlacesMax];
  std::size_t count_ = 0;
  double most_ = 0, of_step_ = 0;
  float widest_ = 0, furthest_ = 0;
};

// How far what is met of a run lies from the middle of a frame, and from the curves in it.
struct FatReach {
  double of_row[3];  // beyond the square, for the first two
  double from_parabola, from_quartic;
};

// Sets frame, centre, bends and bounds of a border.
void set_frame(const RunPlaces& run, double radius, SubPatch& border);
// Of another run in the frame of a border. Requires: that was set.
FatReach reach_in(const SubPatch& border, const RunPlaces& run, double radius);
// Widens the bounds of a border to hold that, too.
void widen(const FatReach& reach, SubPatch& border);
// What holds all that is met of a run.
Bounds3f box_of(const RunPlaces& run, double radius);

}  // namespace tessera::core
