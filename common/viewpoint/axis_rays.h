// SPDX-License-Identifier: Apache-2.0
// What rays along the three axes hit, from every point of a lattice in a scene's box. So the walls
// of rooms are seen from all over at once.
//
// The rays of one axis are parallel, so that each triangle is drawn once onto the lattice of each
// axis, as a rasteriser would, and no spatial index is needed: one pass over all triangles,
// whatever their number, on the machine that asks. Which side of a surface is met is known, which
// no picture of distances tells.
//
// Threads. Immutable after construction.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/math/bounds3.h"
#include "common/math/vec3d.h"
#include "common/scene/scene.h"

namespace tessera {

// Along +x, -x, +y, -y, +z, -z.
enum class Axis : std::uint8_t { kRight, kLeft, kUp, kDown, kBack, kAhead };
inline constexpr std::array<Axis, 6> kAxes{Axis::kRight, Axis::kLeft, Axis::kUp,
                                           Axis::kDown,  Axis::kBack, Axis::kAhead};

class AxisRays {
 public:
  // Lattice points along each axis. 48: a wall's opening of a fiftieth of the scene is found, and
  // 3 x 48^2 rays and 48^3 points take some milliseconds and 3 MB.
  static constexpr int kSide = 48;
  static constexpr int kPoints = kSide * kSide * kSide;

  // Triangles are met by their front or back (Material::is_double_sided: always the front).
  // Freeform surfaces are not seen; meshes stand for them (patch_net.h).
  // Requires: a valid scene, and its box.
  AxisRays(const Scene& scene, const Bounds3f& bounds);

  // Whether there are no rays: the scene has no volume, or its triangles cross the rays more than
  // kCrossingsMax times.
  bool is_empty() const { return met_[0].empty(); }

  static int index(int x, int y, int z) { return (z * kSide + y) * kSide + x; }
  static std::array<int, 3> place(int index) {
    return {index % kSide, index / kSide % kSide, index / (kSide * kSide)};
  }
  Vec3d point(int index) const;         // in the world
  Vec3d step() const { return step_; }  // from point to point
  const Bounds3f& bounds() const { return bounds_; }

  // What the ray from a point meets first. Distances: world units; infinite where it leaves.
  struct Met {
    float distance;
    bool is_front;
    bool is_any() const { return distance < Bounds3f::kInf; }
  };
  Met met(int index, Axis axis) const {
    const float d = met_[static_cast<std::size_t>(axis)][static_cast<std::size_t>(index)];
    return {std::abs(d), !std::signbit(d)};
  }

  // What the ray along `axis` that goes through a point meets first when it comes from outside the
  // box; its distance is from the box's side.
  Met met_from_outside(int index, Axis axis) const;

  static constexpr std::uint64_t kCrossingsMax = std::uint64_t{1} << 28;  // about a second

 private:
  // The nearest of the surfaces between two neighbours on a ray, or before the first or behind the
  // last point, as seen from one of the two.
  struct GapEnd {
    float at;  // lattice units along the ray; infinite: there is none
    bool is_front;
  };
  struct Gaps {
    std::vector<GapEnd> seen_from_below, seen_from_above;  // [line][kSide + 1]
  };
  using Triangle = std::array<Vec3d, 3>;  // lattice units

  Triangle on_lattice(const Mesh& mesh, std::size_t triangle, const Transform& transform) const;
  static std::uint64_t draw(const Triangle& triangle, bool is_double_sided,
                            std::array<Gaps, 3>& gaps);
  static void draw_along(int axis, const Triangle& triangle, int u_first, int u_last,
                         bool is_double_sided, Gaps& gaps);
  void sweep(int axis, const Gaps& gaps);

  Bounds3f bounds_;
  Vec3d origin_, step_, per_step_;  // point (x, y, z) is origin + (x, y, z) * step
  // [axis][kPoints]: distance, negative (-0 too) where a back is met.
  std::array<std::vector<float>, 6> met_;
  // [axis][kSide * kSide]: likewise from outside, by line_of().
  std::array<std::vector<float>, 6> met_outside_;
};

}  // namespace tessera
