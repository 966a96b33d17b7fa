// SPDX-License-Identifier: Apache-2.0
// Adds parametric shapes to a mesh, in float32 and in a fixed order of operations, so that a scene
// has the same bits everywhere. For the scenes of the benchmark.
//
// Threads. One at a time.
#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <utility>

#include "common/scene/scene.h"

namespace tessera::bench {

inline constexpr float kPi = 3.14159265358979f;

using Surface = std::function<Vec3f(float u, float v)>;  // u, v in [0, 1]
using Curve = std::function<Vec3f(float s)>;             // s in [0, 1]

class ShapeBuilder {
 public:
  // Shapes that follow are scaled, turned about z by `yaw` radians and moved to `origin`.
  void set_frame(Vec3f origin, float yaw = 0, float scale = 1);

  // Adds nu * nv cells of two triangles each, without those triangles that have no area.
  void add_surface(int nu, int nv, const Surface& surface);
  void add_quad(Vec3f corner, Vec3f a, Vec3f b);
  void add_box(Vec3f low, Vec3f high);
  // A round tube along a curve; its ends are open.
  void add_tube(const Curve& curve, float radius, int segments, int sides);
  void add_rod(Vec3f from, Vec3f to, float radius, int segments, int sides);
  // Exponents below 1 make the shape boxy, above 1 pointed.
  void add_superellipsoid(Vec3f centre, Vec3f radii, float e1, float e2, int nu, int nv);

  Mesh take() { return std::move(mesh_); }

 private:
  std::uint32_t add_vertex(Vec3f local);
  void add_triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c);
  void add_triangle_with_area(std::uint32_t a, std::uint32_t b, std::uint32_t c);

  Mesh mesh_;
  Vec3f origin_;
  float cosine_ = 1, sine_ = 0, scale_ = 1;
};

}  // namespace tessera::bench
