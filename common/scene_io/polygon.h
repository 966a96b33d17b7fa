// SPDX-License-Identifier: Apache-2.0
// Cuts polygons of files into triangles, always corners - 2 of them, so that numbers of primitives
// depend on the file alone.
//
// Where the fan of the first corner covers the polygon (every convex one), it is taken. Others lose
// one ear after the other (G. H. Meisters, "Polygons have ears", 1975; D. Eberly, "Triangulation by
// ear clipping", 2002), seen along the normal of M. Newell (I. Sutherland, R. Sproull,
// R. Schumacker, "A characterization of ten hidden-surface algorithms", 1974). Corners that lie at
// one place, as holes cut open have them, are no obstacle. A polygon without area is fanned. One
// that crosses itself has a point at which no ear is left: any corner is cut off then, so its
// picture is one of several that it could mean.
//
// Threads. Plain value; one at a time.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/math/vec3.h"

namespace tessera {

class PolygonCutter {
 public:
  using Triangle = std::array<std::uint32_t, 3>;  // numbers of corners, in the polygon's sense

  // Whether triangles (0, i - 1, i) cover the polygon without overlap. Requires: at least 3
  // corners, finite.
  static bool is_fan(std::span<const Vec3f> corners);

  // Cuts a polygon that is no fan. Returns: corners.size() - 2 triangles, valid until the next
  // call.
  // Requires: as is_fan().
  std::span<const Triangle> cut(std::span<const Vec3f> corners);
  // Whether the last cut had to be guessed at: the polygon crosses itself or has no area, or the
  // file's polygons together are too much work.
  bool is_guessed() const { return is_guessed_; }

 private:
  struct Point {
    double x, y;
  };
  // What is asked of an ear; corners that surely are ears are cut off first.
  enum class Demand { kClean, kTouched, kAny };

  double twice_area(std::uint32_t a, std::uint32_t b, std::uint32_t c) const;
  bool is_ear(std::uint32_t corner, Demand demand);
  void cut_off(std::uint32_t corner);
  void fan(std::size_t count);

  // Tests of a point against a triangle that are left for all polygons of a file; 2^31 take a few
  // seconds.
  std::uint64_t work_left_ = std::uint64_t{1} << 31;
  bool is_guessed_ = false;
  std::vector<Point> points_;
  std::vector<std::uint32_t> next_, previous_;
  std::vector<std::uint32_t> reflex_;  // corners that may stand inside of an ear
  std::vector<Triangle> triangles_;
};

}  // namespace tessera
