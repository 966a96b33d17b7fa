// SPDX-License-Identifier: Apache-2.0
#include "master/loader/builtin.h"

#include <cmath>

#include "common/scene/vertex_normals.h"
#include "master/loader/mesh_maker.h"

namespace tessera::master {
namespace {

struct Builtin {
  const char* name;
  LoadedScene (*make)();
};
constexpr Builtin kBuiltins[] = {{"cones", make_cones},
                                 {"cones-mesh", make_cones_mesh},
                                 {"cornell", make_cornell},
                                 {"evening", make_evening},
                                 {"paint", make_paint},
                                 {"room", make_room},
                                 {"teapot", make_teapot},
                                 {"teapot-mesh", make_teapot_mesh},
                                 {"teapots", make_teapots},
                                 {"teapots-apart", make_teapots_apart},
                                 {"teapots-mesh", make_teapots_mesh},
                                 {"waves", make_waves}};

}  // namespace

Material matte(const char* name, Vec3f albedo) {
  Material material;
  material.name = name;
  material.albedo = albedo;
  return material;
}

Material glowing(const char* name, Vec3f emission) {
  Material material = matte(name, {0.8f, 0.8f, 0.8f});
  material.emission = emission;
  return material;
}

void add_ceiling_light(MeshMaker& maker, Vec3f c, float hx, float hz, std::uint32_t material) {
  maker.quad({c.x - hx, c.y, c.z - hz}, {c.x + hx, c.y, c.z - hz}, {c.x + hx, c.y, c.z + hz},
             {c.x - hx, c.y, c.z + hz}, material);
}

std::vector<std::string> builtin_names() {
  std::vector<std::string> names;
  for (const Builtin& builtin : kBuiltins) names.emplace_back(builtin.name);
  return names;
}

Result<LoadedScene> make_builtin(const std::string& name) {
  std::string known;
  for (const Builtin& builtin : kBuiltins) {
    if (name == builtin.name) return builtin.make();
    known += (known.empty() ? "" : ", ") + std::string(builtin.name);
  }
  return Status::invalid_argument("builtin:" + name + " does not exist; there are " + known);
}

// The Cornell box, Goral, Torrance, Greenberg, Battaile, "Modeling the Interaction of Light Between
// Diffuse Surfaces", 1984; measures and reflectances (as linear RGB) of the later Cornell
// University data.
LoadedScene make_cornell() {
  LoadedScene loaded;
  Scene& scene = loaded.scene;
  scene.materials = {matte("white", {0.73f, 0.71f, 0.68f}), matte("red", {0.61f, 0.06f, 0.06f}),
                     matte("green", {0.12f, 0.44f, 0.11f}), glowing("light", {17, 12, 6.5f})};
  MeshMaker maker;
  const Vec3f a{552.8f, 0, 0}, b{0, 0, 0}, c{0, 0, 559.2f}, d{549.6f, 0, 559.2f};
  const Vec3f e{556, 548.8f, 0}, f{0, 548.8f, 0}, g{0, 548.8f, 559.2f}, h{556, 548.8f, 559.2f};
  maker.quad(a, b, c, d, 0);  // floor
  maker.quad(e, h, g, f, 0);  // ceiling
  maker.quad(d, c, g, h, 0);  // back
  maker.quad(c, b, f, g, 2);  // right
  maker.quad(a, d, h, e, 1);  // left
  maker.quad({343, 548.7f, 227}, {343, 548.7f, 332}, {213, 548.7f, 332}, {213, 548.7f, 227}, 3);
  const auto block = [&](const Vec2f(&corner)[4], float height) {
    const auto at = [&](int i, float y) { return Vec3f{corner[i & 3].x, y, corner[i & 3].y}; };
    maker.quad(at(0, height), at(1, height), at(2, height), at(3, height), 0);
    for (int i = 0; i < 4; ++i)
      maker.quad(at(i, 0), at(i + 1, 0), at(i + 1, height), at(i, height), 0);
  };
  block({{130, 65}, {82, 225}, {240, 272}, {290, 114}}, 165);
  block({{423, 247}, {265, 296}, {314, 456}, {472, 406}}, 330);
  scene.meshes = {maker.finish()};
  scene.instances.resize(1);
  scene.camera = Camera{{278, 273, -800}, {278, 273, 0}, {0, 1, 0}, 39.3f};
  return loaded;
}

// A sea of moving sines: the mesh is sent and built anew for each frame.
LoadedScene make_waves() {
  constexpr int kCells = 256;
  const auto sea_at = [](double seconds) {
    std::vector<Vec3f> points;
    const auto t = static_cast<float>(seconds);
    for (int r = 0; r <= kCells; ++r) {
      for (int c = 0; c <= kCells; ++c) {
        const float x = 12 * (static_cast<float>(c) / kCells - 0.5f),
                    z = -12 * (static_cast<float>(r) / kCells - 0.5f);
        const float y = 0.25f * std::sin(1.3f * x + 1.7f * t) +
                        0.18f * std::sin(0.9f * z - 1.1f * x + 2.3f * t) +
                        0.06f * std::sin(4.1f * x + 3.3f * z + 4 * t) +
                        0.02f * std::sin(11 * x - 9 * z + 7 * t);
        points.push_back({x, y, z});
      }
    }
    MeshMaker maker;
    maker.grid(kCells, kCells, points, 0);
    auto sea = std::make_shared<Mesh>(*maker.finish());
    sea->normals = vertex_normals(*sea);  // which travel with the positions
    return std::shared_ptr<const Mesh>(std::move(sea));
  };
  LoadedScene loaded;
  Scene& scene = loaded.scene;
  scene.materials = {matte("sea", {0.12f, 0.36f, 0.5f}), matte("buoy", {0.85f, 0.25f, 0.1f})};
  MeshMaker buoys;
  for (std::uint32_t i = 0; i < 9; ++i) {
    std::vector<Vec2f> profile;
    for (int k = 0; k <= 24; ++k) {
      const float a = 3.14159265f * static_cast<float>(k) / 24;
      profile.push_back({0.35f * std::sin(a), -0.35f * std::cos(a)});
    }
    buoys.lathe({9 * (hash_unit(i, 1) - 0.5f), 0.15f, 9 * (hash_unit(i, 2) - 0.5f)}, profile, 48,
                1);
  }
  scene.meshes = {sea_at(0), buoys.finish()};
  scene.instances = {{0, {}}, {1, {}}};
  Light sun;
  sun.kind = LightKind::kDirectional;
  sun.direction = {-0.6f, -0.55f, -0.7f};
  sun.intensity = {3.0f, 2.8f, 2.4f};
  Light fill;
  fill.kind = LightKind::kPoint;
  fill.position = {-6, 9, 7};
  fill.intensity = {60, 75, 95};
  scene.lights = {sun, fill};
  scene.camera = Camera{{0, 3.2f, 8.5f}, {0, -0.3f, 0}, {0, 1, 0}, 42};
  loaded.is_animated = true;
  loaded.at_time = [scene, sea_at](double seconds) {
    Scene moved = scene;
    moved.meshes[0] = sea_at(seconds);
    return moved;
  };
  return loaded;
}

}  // namespace tessera::master
