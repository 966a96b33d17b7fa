// SPDX-License-Identifier: Apache-2.0
// Fat borders: a ray that passes one of a surface's widened segments no further away than its width
// meets the surface there, so that solids whose faces do not quite meet stay closed.
//
// Why it closes. Between two faces, at an edge that both have, lies what lines from one border to
// the other cover. A point of it is nearer to one of the borders than half of their distance,
// whatever the angle of the faces is, and whether they overlap, gape or lie one above the other; so
// it is in the reach of both where the width is that distance. Surfaces that are only continued
// within themselves leave a slit where faces are tangent, and cannot be continued beyond the patch.
// (A. Balazs, M. Guthe, R. Klein, "Fat borders: gap filling for efficient view-dependent LOD NURBS
// rendering", Computers & Graphics 28, 2004, with triangles across the view; here it is the ray
// that asks, so no direction is preferred and nothing is tessellated.)
//
// The answer. Of the ball of the span's width about the point of the span that is nearest to the
// ray, t is where the ray leaves it, so what the ray meets within comes first and pictures change
// where rays would have passed. A ray that begins in the ball does not meet it: rays that leave a
// surface beside its border go on. u, v are the point's. The nearest point is found within 1/32 of
// the width: what a ray passes nearer than 31/32 of the width is met, what it passes further away
// than the width never is.
//
// A sub-patch stands for each run of spans, mostly one. Its frame is that of a parallelepiped about
// all where they are met, so kernels look for rays there as for those of others; its second
// derivative by x is infinite, so none is decided without patch_answer(). The others hold what
// that needs: the number of the first span, 16 bits in second[1][0] and [1][1] each; in
// second[1][2] and [2][0] by what lengths of spans grow in the world, and what comes on top; the
// bend c of the parabola y = c (x^2 - 1/2) that they follow in the frame, and how far in y what is
// met is from that at most, in second[2][1] and [2][2]; in second[0][1] and [0][2] the same of the
// quartic that goes on top (fat_border_frame.h). `column` is the number of spans after the first.
//
// Both faces of an edge have its border, so spans lie beside each other. One of them may stand for
// the others in the hierarchy (fat_borders_beside.h), and its bounds hold theirs: `row` says how
// many sub-patches on the next of them lies, as 16 bits with a sign, and is 0 at the last.
//
// Work. At most kFatEvaluationsMax points of the surface for each span of the run that a ray is
// asked for, none for most; at the bound the span's nearest point until then counts. The same bits
// on every instruction set: plain double.
//
// Threads. Pure functions.
#pragma once

#include <cstdint>
#include <limits>

#include "common/math/bounds3.h"
#include "common/math/transform.h"
#include "slave/core/primitive/patch/fat_border_spans.h"
#include "slave/core/primitive/patch/patch_layout.h"

namespace tessera::core {

inline constexpr int kFatEvaluationsMax = 64;

inline bool is_fat_border(const SubPatch& part) {
  return part.second[0][0] > std::numeric_limits<float>::max();
}

// The next of the borders that one in the hierarchy stands for; null after the last.
// Requires: is_fat_border(part), in the array of all.
inline const SubPatch* next_border_beside(const SubPatch& part) {
  return part.row == 0 ? nullptr : &part + static_cast<std::int16_t>(part.row);
}

// What a map does to widths: its largest stretch, and the roundings of points that it moves.
class FatPlacement {
 public:
  FatPlacement() = default;  // where a surface stands in its own place
  explicit FatPlacement(const Transform& to_world);

  // The run of spans [first, end) of a patch in the world, which has trims. Shape: box becomes that
  // of all where the surface may be met.
  SubPatch placed(const Patch& patch, FatBorders::Range run, Bounds3f& box) const;

 private:
  float stretch_ = 1;
  double rounding_ = 0;  // of the coordinates, what the ends of neighbours may differ by
};

struct FatHit {
  bool is_hit;
  float t;      // rounded to nearest
  double u, v;  // the patch's own
};

// Requires: is_fat_border(part). Rays with NaN, infinities or a zero direction miss.
FatHit fat_border_hit(const Patch& patch, const SubPatch& part, const float* origin,
                      const float* direction, float t_min);

}  // namespace tessera::core
