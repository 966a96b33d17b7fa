// SPDX-License-Identifier: Apache-2.0
// Which points trimming loops enclose, in long double: the oracle that the product's answers are
// measured against. It shares no code with them: no monotone pieces, no cells, no half-open rows of
// v, no weights left out. A part of a segment whose control points' box is away from the point is
// its chord, seen from the point (the box is convex, so the one can be moved into the other without
// passing the point), and chords are counted along +v; else the part is halved.
//
// A point is near where a part with a box of 2^-34 or less comes within `tolerance` of it. What is
// not near has an answer. Errors: 60 halves of 15 averages, 2^-53 together.
//
// Threads. An object is one thread's.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "common/scene/patch_surface.h"

namespace tessera::test {

class TrimReference {
 public:
  // Of one patch of a surface. tolerance: in the square's units.
  TrimReference(const PatchSurface& surface, std::size_t patch, double tolerance);

  // Returns: whether the point is kept, or nothing where it is near to a loop.
  std::optional<bool> is_kept(double u, double v);

 private:
  using Long = long double;
  struct Point {
    Long u, v, w;  // w u, w v, w
  };
  struct Segment {
    std::vector<Point> points;
    Long low[2], high[2];  // of its control points
    Long ends[2];          // their u
  };

  void bound(const Point* points, int degree, Long (&low)[2], Long (&high)[2]) const;
  // Of the segment or its part: whether it crosses, or that it is near.
  bool crosses(const Point* points, int degree, int depth);

  Long tolerance_, u_ = 0, v_ = 0;
  bool is_near_ = false, keeps_outside_, is_whole_;
  std::vector<Segment> segments_;
};

}  // namespace tessera::test
