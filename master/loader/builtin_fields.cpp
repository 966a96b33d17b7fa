// SPDX-License-Identifier: Apache-2.0
// The scenes of figures 7.5 and 7.6 of Benthin's thesis, "Realtime ray tracing on current CPU
// architectures", 2006: a field of waving cones, and a cube of teapots.
#include <algorithm>
#include <array>
#include <cmath>

#include "master/loader/builtin.h"
#include "master/loader/mesh_maker.h"

namespace tessera::master {
namespace {

constexpr int kConesPerSide = 12;
constexpr int kQuarters = 4;  // patches of a cone
constexpr int kCells = 12;    // of a patch, per direction, where it is triangles

using Net = std::array<Vec3f, 16>;  // rows go up the cone, columns around it

// A quarter of a cone that leans as far as its tip is moved.
Net quarter_cone(Vec3f base, Vec3f tip, float radius, int quarter) {
  // Cubics of these points are circles up to 0.03 % of the radius.
  constexpr float kKappa = 0.5522847498f;
  constexpr Vec2f kAround[4] = {{1, 0}, {1, kKappa}, {kKappa, 1}, {0, 1}};
  const auto turned = [quarter](Vec2f p) {
    for (int i = 0; i < quarter; ++i) p = {-p.y, p.x};
    return p;
  };
  const float height = tip.y - base.y;
  const Vec3f axis[4] = {
      base,
      {base.x, base.y + height / 3, base.z},
      {0.6f * base.x + 0.4f * tip.x, base.y + 2 * height / 3, 0.6f * base.z + 0.4f * tip.z},
      tip};
  Net net;
  for (std::size_t row = 0; row < 4; ++row) {
    const float r = radius * static_cast<float>(3 - row) / 3;
    for (std::size_t column = 0; column < 4; ++column) {
      const Vec2f p = turned(kAround[column]);
      net[4 * row + column] = axis[row] + Vec3f{r * p.x, 0, r * p.y};
    }
  }
  return net;
}

// The patches of all cones at a time, cone by cone.
std::vector<Net> cones_at(double seconds) {
  const auto t = static_cast<float>(seconds);
  std::vector<Net> nets;
  for (int i = 0; i < kConesPerSide * kConesPerSide; ++i) {
    const auto x = static_cast<float>(i % kConesPerSide) - 0.5f * (kConesPerSide - 1);
    const auto z = static_cast<float>(i / kConesPerSide) - 0.5f * (kConesPerSide - 1);
    const Vec3f base{x, 0, z};
    const Vec3f tip{x + 0.45f * std::sin(0.6f * x + 0.4f * z + 2.1f * t), 1.6f,
                    z + 0.3f * std::cos(0.5f * x - 0.7f * z + 1.7f * t)};
    for (int quarter = 0; quarter < kQuarters; ++quarter)
      nets.push_back(quarter_cone(base, tip, 0.36f, quarter));
  }
  return nets;
}

std::shared_ptr<const PatchSurface> cone_surface(double seconds) {
  auto surface = std::make_shared<PatchSurface>();
  for (const Net& net : cones_at(seconds)) {
    surface->patches.push_back({3, 3, 0, 0});
    for (const Vec3f p : net) surface->numbers.insert(surface->numbers.end(), {p.x, p.y, p.z});
  }
  surface->materials = {0};
  return surface;
}

std::array<float, 4> bernstein(float t) {
  const float s = 1 - t;
  return {s * s * s, 3 * t * s * s, 3 * t * t * s, t * t * t};
}

Vec3f evaluate(const Net& net, float u, float v) {
  const std::array<float, 4> up = bernstein(u), around = bernstein(v);
  Vec3f sum;
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = 0; j < 4; ++j) sum = sum + up[i] * around[j] * net[4 * i + j];
  }
  return sum;
}

// The same triangles at each time: only their corners move. The tips are cut off just below, since
// the triangles that meet in a tip have no area and no normal there.
std::shared_ptr<const Mesh> cone_mesh(double seconds) {
  MeshMaker maker;
  for (const Net& net : cones_at(seconds)) {
    std::vector<Vec3f> points;
    for (int i = 0; i <= kCells; ++i) {
      for (int j = 0; j <= kCells; ++j) {
        const float u = std::min(static_cast<float>(i) / kCells, 0.998f);
        points.push_back(evaluate(net, u, static_cast<float>(j) / kCells));
      }
    }
    maker.grid(kCells, kCells, points, 0);
  }
  return maker.finish();
}

// Ground, lights and a camera; mesh 0. The material of what stands there is the first.
LoadedScene make_ground(float size) {
  LoadedScene loaded;
  Scene& scene = loaded.scene;
  scene.materials = {matte("things", {0.7f, 0.55f, 0.3f}), matte("ground", {0.3f, 0.36f, 0.3f})};
  MeshMaker ground;
  ground.quad({-size, 0, size}, {size, 0, size}, {size, 0, -size}, {-size, 0, -size}, 1);
  scene.meshes = {ground.finish()};
  Light sun;
  sun.kind = LightKind::kDirectional;
  sun.direction = {-0.5f, -0.8f, -0.4f};
  sun.intensity = {2.6f, 2.5f, 2.3f};
  scene.lights = {sun};
  return loaded;
}

}  // namespace

LoadedScene make_cones() {
  LoadedScene loaded = make_ground(9);
  Scene& scene = loaded.scene;
  scene.surfaces = {cone_surface(0)};
  scene.instances = {{0, {}, ObjectKind::kPatchSurface}, {0, {}}};
  scene.camera = Camera{{0, 6.5f, 11}, {0, 0.3f, 0.8f}, {0, 1, 0}, 45};
  loaded.is_animated = true;
  loaded.at_time = [scene](double seconds) {
    Scene moved = scene;
    moved.surfaces[0] = cone_surface(seconds);
    return moved;
  };
  return loaded;
}

LoadedScene make_cones_mesh() {
  LoadedScene loaded = make_ground(9);
  Scene& scene = loaded.scene;
  scene.meshes.insert(scene.meshes.begin(), cone_mesh(0));
  scene.instances = {{0, {}}, {1, {}}};
  scene.camera = Camera{{0, 6.5f, 11}, {0, 0.3f, 0.8f}, {0, 1, 0}, 45};
  loaded.is_animated = true;
  loaded.at_time = [scene](double seconds) {
    Scene moved = scene;
    moved.meshes[0] = cone_mesh(seconds);
    return moved;
  };
  return loaded;
}

LoadedScene make_teapots() {
  constexpr int kSide = 32;
  const Vec3f step{7.5f, 4.5f, 5.5f};
  LoadedScene loaded = make_ground(2000);
  Scene& scene = loaded.scene;
  scene.surfaces = make_teapot().scene.surfaces;
  for (int i = 0; i < kSide * kSide * kSide; ++i) {
    Instance teapot{0, {}, ObjectKind::kPatchSurface};
    const int at[3] = {i % kSide, i / kSide % kSide, i / (kSide * kSide)};
    teapot.object_to_world.m[0][3] = step.x * (static_cast<float>(at[0]) - 0.5f * (kSide - 1));
    teapot.object_to_world.m[1][3] = step.y * static_cast<float>(at[1]) + 1;
    teapot.object_to_world.m[2][3] = step.z * (static_cast<float>(at[2]) - 0.5f * (kSide - 1));
    scene.instances.push_back(teapot);
  }
  scene.instances.push_back({0, {}});
  scene.camera = Camera{{230, 190, 260}, {0, 66, 0}, {0, 1, 0}, 42};
  return loaded;
}

LoadedScene make_teapots_apart() {
  LoadedScene loaded = make_teapots();
  Scene& scene = loaded.scene;
  const PatchSurface teapot = *scene.surfaces[0];
  auto all = std::make_shared<PatchSurface>();
  all->materials = {0};
  for (const Instance& instance : scene.instances) {
    if (instance.kind != ObjectKind::kPatchSurface) continue;
    all->patches.insert(all->patches.end(), teapot.patches.begin(), teapot.patches.end());
    // Points without weights: three numbers each.
    for (std::size_t i = 0; i < teapot.numbers.size(); ++i)
      all->numbers.push_back(teapot.numbers[i] + instance.object_to_world.m[i % 3][3]);
  }
  scene.surfaces = {all};
  scene.instances = {{0, {}, ObjectKind::kPatchSurface}, {0, {}}};
  return loaded;
}

LoadedScene make_teapots_mesh() {
  LoadedScene loaded = make_teapots();
  Scene& scene = loaded.scene;
  scene.meshes.push_back(teapot_mesh(8));
  scene.surfaces.clear();
  for (Instance& instance : scene.instances) {
    if (instance.kind == ObjectKind::kPatchSurface) instance = {1, instance.object_to_world};
  }
  return loaded;
}

}  // namespace tessera::master
