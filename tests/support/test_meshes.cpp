// SPDX-License-Identifier: Apache-2.0
#include "tests/support/test_meshes.h"

#include <cmath>
#include <map>
#include <random>
#include <utility>

#include "common/scene/surface_program.h"

namespace tessera::test {
namespace {

using Index = std::uint32_t;

Index midpoint(Mesh& mesh, std::map<std::pair<Index, Index>, Index>& known, Index a, Index b) {
  const auto key = std::minmax(a, b);
  const auto found = known.find(key);
  if (found != known.end()) return found->second;
  mesh.positions.push_back(normalize(mesh.positions[a] + mesh.positions[b]));
  const Index m = static_cast<Index>(mesh.positions.size() - 1);
  known[key] = m;
  return m;
}

// Adds two triangles for each cell of a grid of rows * columns vertices that closes on itself.
void close_grid(Mesh& mesh, Index rows, Index columns) {
  for (Index i = 0; i < rows; ++i) {
    for (Index j = 0; j < columns; ++j) {
      const Index i1 = (i + 1) % rows, j1 = (j + 1) % columns;
      const Index a = i * columns + j, b = i1 * columns + j, c = i1 * columns + j1,
                  d = i * columns + j1;
      mesh.triangles.push_back({a, b, c});
      mesh.triangles.push_back({a, c, d});
    }
  }
}

}  // namespace

Mesh make_cube() {
  Mesh mesh;
  for (int i = 0; i < 8; ++i) {
    mesh.positions.push_back({i & 1 ? 1.0f : -1.0f, i & 2 ? 1.0f : -1.0f, i & 4 ? 1.0f : -1.0f});
  }
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  mesh.materials = {0};
  return mesh;
}

Mesh make_icosphere(int levels) {
  Mesh mesh;
  const float g = (1 + std::sqrt(5.0f)) / 2;
  mesh.positions = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                    {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
  for (Vec3f& p : mesh.positions) p = normalize(p);
  mesh.triangles = {{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                    {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                    {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                    {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}};
  for (int level = 0; level < levels; ++level) {
    std::map<std::pair<Index, Index>, Index> known;
    std::vector<std::array<Index, 3>> finer;
    for (const auto& t : mesh.triangles) {
      const Index a = midpoint(mesh, known, t[0], t[1]), b = midpoint(mesh, known, t[1], t[2]),
                  c = midpoint(mesh, known, t[2], t[0]);
      finer.insert(finer.end(), {{t[0], a, c}, {t[1], b, a}, {t[2], c, b}, {a, b, c}});
    }
    mesh.triangles = std::move(finer);
  }
  mesh.materials = {0};
  return mesh;
}

Mesh make_torus(int around, int across) {
  Mesh mesh;
  const float turn = 6.2831853f;
  for (int i = 0; i < around; ++i) {
    const float a = turn * static_cast<float>(i) / static_cast<float>(around);
    for (int j = 0; j < across; ++j) {
      const float b = turn * static_cast<float>(j) / static_cast<float>(across);
      const float r = 1 + 0.4f * std::cos(b);
      mesh.positions.push_back({r * std::cos(a), r * std::sin(a), 0.4f * std::sin(b)});
    }
  }
  close_grid(mesh, static_cast<Index>(around), static_cast<Index>(across));
  mesh.materials = {0};
  return mesh;
}

Mesh make_random_triangles(std::uint32_t count, float size, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> unit(-1, 1);
  Mesh mesh;
  for (std::uint32_t i = 0; i < count; ++i) {
    const Vec3f a{unit(random), unit(random), unit(random)};
    mesh.positions.push_back(a);
    mesh.positions.push_back(a + Vec3f{unit(random), unit(random), unit(random)} * size);
    mesh.positions.push_back(a + Vec3f{unit(random), unit(random), unit(random)} * size);
    mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  mesh.materials = {0};
  return mesh;
}

Mesh make_terrain(int n, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> bump(-0.3f, 0.3f);
  Mesh mesh;
  const float cell = 2 / static_cast<float>(n);
  for (int i = 0; i <= n; ++i) {
    for (int j = 0; j <= n; ++j) {
      const float x = -1 + cell * static_cast<float>(j), z = -1 + cell * static_cast<float>(i);
      const float y = 0.15f * std::sin(9 * x) * std::cos(7 * z) + bump(random) * cell;
      mesh.positions.push_back({x, y, z});
    }
  }
  const Index row = static_cast<Index>(n) + 1;
  for (Index i = 0; i + 1 < row; ++i) {
    for (Index j = 0; j + 1 < row; ++j) {
      const Index a = i * row + j;
      mesh.triangles.push_back({a, a + row, a + row + 1});
      mesh.triangles.push_back({a, a + row + 1, a + 1});
    }
  }
  mesh.materials = {0};
  return mesh;
}

void place(Mesh& mesh, float scale, Vec3f offset) {
  for (Vec3f& p : mesh.positions) p = p * scale + offset;
}

void add_quad(Mesh& mesh, Vec3f a, Vec3f b, Vec3f c, std::uint32_t material) {
  const auto n = static_cast<std::uint32_t>(mesh.positions.size());
  mesh.positions.insert(mesh.positions.end(), {a, a + b, a + b + c, a + c});
  mesh.triangles.push_back({n, n + 1, n + 2});
  mesh.triangles.push_back({n, n + 2, n + 3});
  mesh.materials.insert(mesh.materials.end(), 2, material);
}

Scene make_scene(Mesh mesh) {
  Scene scene;
  scene.meshes.push_back(std::make_shared<const Mesh>(std::move(mesh)));
  scene.materials.emplace_back();
  scene.instances.emplace_back();
  return scene;
}

Scene make_full_scene() {
  Scene scene = make_scene(make_terrain(40, 2));
  Mesh ball = make_icosphere(3);
  ball.normals = ball.positions;
  for (const Vec3f& p : ball.positions) ball.uvs.push_back({p.x * 2, p.y * 3});
  ball.materials = {1};
  scene.meshes.push_back(std::make_shared<const Mesh>(ball));
  Texture texture;
  texture.width_px = texture.height_px = 2;
  texture.rgba = {255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 255, 200, 200, 90, 255};
  scene.textures.push_back(std::make_shared<const Texture>(texture));
  scene.materials.resize(3);
  scene.materials[1].name = "ball";
  scene.materials[1].albedo = {0.9f, 0.8f, 0.7f};
  scene.materials[1].albedo_texture = 0;
  scene.materials[2].name = "lamp";
  scene.materials[2].albedo = {0, 0, 0};
  scene.materials[2].emission = {5, 4, 3};
  Mesh lamp;
  lamp.positions = {{-0.3f, 2, -0.3f}, {0.3f, 2, -0.3f}, {0.3f, 2, 0.3f}, {-0.3f, 2, 0.3f}};
  lamp.triangles = {{0, 1, 2}, {0, 2, 3}};
  lamp.materials = {2};
  scene.meshes.push_back(std::make_shared<const Mesh>(lamp));
  Instance instance;
  instance.mesh = 1;
  instance.object_to_world.m = {{{0.3f, 0, 0, 0.2f}, {0, 0.4f, 0, 0.4f}, {0, 0, 0.3f, 0.1f}}};
  scene.instances.push_back(instance);
  scene.instances.push_back({2, {}});
  scene.lights = {{LightKind::kPoint, {1, 2, 1}, {}, {2, 2, 2}, 1, 0},
                  {LightKind::kSpot, {-1, 2, 1}, {0.5f, -1, -0.5f}, {3, 2, 2}, 0.95f, 0.8f},
                  {LightKind::kDirectional, {}, {0.3f, -1, 0.2f}, {0.2f, 0.2f, 0.4f}, 1, 0}};
  scene.environment = {0.1f, 0.1f, 0.2f};
  return scene;
}

// The room of make_full_scene() with every kind of surface program and BSDF.
Scene make_scene_of_all_materials() {
  Scene scene = make_full_scene();
  scene.materials[0].surface = {SurfaceKind::kBrick,
                                find_surface_program(SurfaceKind::kBrick)->defaults};
  scene.materials[1].bsdf = BsdfKind::kGlossy;
  scene.materials[1].roughness = 0.3f;
  scene.materials[1].roughness_metalness_texture = 0;
  for (int i = 0; i < 3; ++i) {
    Mesh ball = make_icosphere(2);
    ball.normals = ball.positions;
    ball.materials = {static_cast<std::uint32_t>(scene.materials.size())};
    Material material;
    material.bsdf = i == 0 ? BsdfKind::kMirror : i == 1 ? BsdfKind::kGlass : BsdfKind::kGlossy;
    material.specular = {0.9f, 0.8f, 0.7f};
    material.metalness = 0.5f;
    material.roughness = 0.1f;
    if (i == 2)
      material.surface = {SurfaceKind::kMarble,
                          find_surface_program(SurfaceKind::kMarble)->defaults};
    scene.materials.push_back(material);
    Instance instance;
    instance.mesh = static_cast<std::uint32_t>(scene.meshes.size());
    const float at = 0.6f * static_cast<float>(i) - 0.6f;
    instance.object_to_world.m = {
        {{0.25f, 0, 0, at}, {0, 0.25f, 0, 0.6f}, {0, 0, 0.25f, 0.8f - 0.2f * at}}};
    scene.instances.push_back(instance);
    scene.meshes.push_back(std::make_shared<const Mesh>(ball));
  }
  return scene;
}

}  // namespace tessera::test
