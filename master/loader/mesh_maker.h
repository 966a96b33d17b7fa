// SPDX-License-Identifier: Apache-2.0
// Small tools for procedural meshes: boxes, quads, lathes, tubes, with materials. Deterministic:
// randomness is an integer hash. Threads. Plain values.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "common/scene/scene.h"

namespace tessera::master {

// A pseudo-random number in [0, 1) from two integers, the same on every machine.
inline float hash_unit(std::uint32_t a, std::uint32_t b) {
  std::uint32_t h = a * 0x9e3779b9u ^ (b + 0x7f4a7c15u) * 0x85ebca6bu;
  h = (h ^ h >> 15) * 0x2c1b3c6du;
  h = (h ^ h >> 12) * 0x297a2d39u;
  h ^= h >> 15;
  return static_cast<float>(h >> 8) * 0x1p-24f;
}

class MeshMaker {
 public:
  // A flat triangle, and a quad with corners a, b, c, d around it; normal along (b - a) x (c - a).
  void triangle(Vec3f a, Vec3f b, Vec3f c, std::uint32_t material);
  void quad(Vec3f a, Vec3f b, Vec3f c, Vec3f d, std::uint32_t material);
  // Axis-parallel box, faces outwards; turned by `angle` around the vertical axis through its
  // centre.
  void box(Vec3f lower, Vec3f upper, std::uint32_t material, float angle = 0);
  // Profile of (radius, height) pairs turned around the vertical axis through `base`; smooth
  // normals.
  void lathe(Vec3f base, const std::vector<Vec2f>& profile, int segments, std::uint32_t material);
  // A tube of `sides` around a path.
  void tube(const std::vector<Vec3f>& path, float radius, int sides, std::uint32_t material);
  // Grid of (rows + 1) x (columns + 1) points, row by row; smooth normals; uv over [0, 1]^2 times
  // `uv_scale`.
  void grid(int rows, int columns, const std::vector<Vec3f>& points, std::uint32_t material,
            float uv_scale = 1);

  std::size_t triangle_count() const { return mesh_.triangles.size(); }
  // The mesh of all that was made. Requires: something was made.
  std::shared_ptr<const Mesh> finish() { return std::make_shared<const Mesh>(std::move(mesh_)); }

 private:
  std::uint32_t vertex(Vec3f position, Vec3f normal, Vec2f uv);
  void face(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t material);

  Mesh mesh_;
};

}  // namespace tessera::master
