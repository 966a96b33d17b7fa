// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cmath>

#include "master/loader/builtin.h"
#include "master/loader/builtin_teapot_data.h"
#include "master/loader/mesh_maker.h"

namespace tessera::master {
namespace {

std::array<float, 4> bernstein(float t) {
  const float s = 1 - t;
  return {s * s * s, 3 * t * s * s, 3 * t * t * s, t * t * t};
}

std::array<float, 4> bernstein_slope(float t) {
  const float s = 1 - t;
  return {-3 * s * s, 3 * s * s - 6 * t * s, 6 * t * s - 3 * t * t, 3 * t * t};
}

// A control point, turned from z up to y up.
Vec3f control_point(const std::uint16_t (&patch)[16], std::size_t i) {
  const float(&p)[3] = kTeapotPoints[patch[i]];
  return {p[0], p[2], -p[1]};
}

Vec3f evaluate(const std::uint16_t (&patch)[16], const std::array<float, 4>& u,
               const std::array<float, 4>& v) {
  Vec3f sum;
  for (std::size_t i = 0; i < 4; ++i) {
    Vec3f row;
    for (std::size_t j = 0; j < 4; ++j) row = row + v[j] * control_point(patch, 4 * i + j);
    sum = sum + u[i] * row;
  }
  return sum;
}

// Neighbouring patches store a shared border in the same or in opposite order, and Bernstein sums
// of reversed points round differently; snapping to a grid of 2^-20 makes shared border points the
// same bits.
Vec3f snapped(Vec3f p) {
  const auto snap = [](float x) { return std::nearbyint(x * 1048576.0f) * 0x1p-20f; };
  return {snap(p.x), snap(p.y), snap(p.z)};
}

// Where the tangent plane collapses (knob, bottom), the normal a little inside stands in.
Vec3f normal_at(const std::uint16_t (&patch)[16], float u, float v, float inside) {
  const auto cross_at = [&](float a, float b) {
    return cross(evaluate(patch, bernstein_slope(a), bernstein(b)),
                 evaluate(patch, bernstein(a), bernstein_slope(b)));
  };
  const Vec3f n = cross_at(u, v);
  if (length(n) > 1e-6f) return normalize(n);
  return normalize(cross_at(u + (0.5f - u) * inside, v + (0.5f - v) * inside));
}

// A table and a wall, lamps and a camera; mesh 0. The teapot's material is the first.
LoadedScene make_stage() {
  LoadedScene loaded;
  Scene& scene = loaded.scene;
  scene.materials = {matte("porcelain", {0.75f, 0.72f, 0.66f}),
                     matte("table", {0.34f, 0.22f, 0.14f}), glowing("lamp", {14, 13, 11}),
                     matte("wall", {0.35f, 0.42f, 0.5f})};
  MeshMaker surroundings;
  surroundings.quad({-12, 0, 12}, {12, 0, 12}, {12, 0, -9}, {-12, 0, -9}, 1);
  surroundings.quad({-12, 0, -9}, {12, 0, -9}, {12, 12, -9}, {-12, 12, -9}, 3);
  add_ceiling_light(surroundings, {-3.5f, 9, 4}, 1.5f, 1.5f, 2);
  scene.meshes = {surroundings.finish()};
  scene.instances = {{0, {}}};
  Light fill;
  fill.position = {7, 6, 8};
  fill.intensity = {25, 28, 34};
  scene.lights = {fill};
  scene.camera = Camera{{1.5f, 4.6f, 9.5f}, {0.1f, 1.4f, 0}, {0, 1, 0}, 34};
  return loaded;
}

}  // namespace

std::shared_ptr<const Mesh> teapot_mesh(std::uint32_t cells) {
  const auto share = [&](std::uint32_t i) {
    return static_cast<float>(i) / static_cast<float>(cells);
  };
  const std::uint32_t stride = cells + 1;
  auto mesh = std::make_shared<Mesh>();
  for (const auto& patch : kTeapotPatches) {
    const auto first = static_cast<std::uint32_t>(mesh->positions.size());
    for (std::uint32_t i = 0; i <= cells; ++i) {
      for (std::uint32_t j = 0; j <= cells; ++j) {
        const float u = share(i), v = share(j);
        mesh->positions.push_back(snapped(evaluate(patch, bernstein(u), bernstein(v))));
        mesh->normals.push_back(normal_at(patch, u, v, share(1) / 4));
      }
    }
    for (std::uint32_t i = 0; i < cells; ++i) {
      for (std::uint32_t j = 0; j < cells; ++j) {
        const std::uint32_t a = first + i * stride + j, b = a + stride;
        mesh->triangles.push_back({a, b, b + 1});
        mesh->triangles.push_back({a, b + 1, a + 1});
      }
    }
  }
  mesh->materials = {0};
  return mesh;
}

std::shared_ptr<const PatchSurface> teapot_surface() {
  auto surface = std::make_shared<PatchSurface>();
  for (const auto& patch : kTeapotPatches) {
    surface->patches.push_back({3, 3, 0, 0});
    for (std::size_t i = 0; i < 16; ++i) {
      const Vec3f p = control_point(patch, i);
      surface->numbers.insert(surface->numbers.end(), {p.x, p.y, p.z});
    }
  }
  surface->materials = {0};
  return surface;
}

LoadedScene make_teapot() {
  LoadedScene loaded = make_stage();
  loaded.scene.surfaces = {teapot_surface()};
  loaded.scene.instances.insert(loaded.scene.instances.begin(), {0, {}, ObjectKind::kPatchSurface});
  return loaded;
}

LoadedScene make_teapot_mesh() {
  LoadedScene loaded = make_stage();
  loaded.scene.meshes.insert(loaded.scene.meshes.begin(), teapot_mesh(28));
  loaded.scene.instances = {{0, {}}, {1, {}}};
  return loaded;
}

}  // namespace tessera::master
