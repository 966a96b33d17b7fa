// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "master/loader/builtin.h"
#include "master/loader/mesh_maker.h"

namespace tessera::master {
namespace {

// 1 below `edge`, 0 beyond twice that.
float fading(float x, float edge) { return std::clamp(2 - std::fabs(x) / edge, 0.0f, 1.0f); }

// A clear sky: pale at the horizon, blue above, a warm light a third of the way up, and the ground.
std::shared_ptr<const EnvironmentMap> clear_sky() {
  auto map = std::make_shared<EnvironmentMap>();
  map->width_px = 128;
  map->height_px = 64;
  for (int row = 0; row < map->height_px; ++row) {
    // 1 overhead, 0 at the horizon, -1 below.
    const float up = 1 - (static_cast<float>(row) + 0.5f) / 32;
    for (int column = 0; column < map->width_px; ++column) {
      const float blue = std::clamp(up * 1.6f, 0.0f, 1.0f);
      const Vec3f sky = Vec3f{0.95f, 0.97f, 1.0f} * (1 - blue) + Vec3f{0.22f, 0.42f, 0.85f} * blue;
      const float light = fading(static_cast<float>(column) - 39.5f, 2.5f) *
                          fading(static_cast<float>(row) - 17.5f, 2.5f);
      const Vec3f ground{0.46f, 0.44f, 0.41f};
      const Vec3f rgb = (up > 0 ? sky : ground) + Vec3f{60, 54, 44} * light;
      map->rgb.insert(map->rgb.end(), {rgb.x, rgb.y, rgb.z});
    }
  }
  return map;
}

Material car_paint(const char* name, Vec3f base, float metalness) {
  Material paint = matte(name, base);
  paint.bsdf = BsdfKind::kGlossy;
  paint.roughness = 0.45f;
  paint.metalness = metalness;
  paint.clearcoat.weight = 1;
  paint.clearcoat.roughness = 0.03f;
  return paint;
}

void add_ball(MeshMaker& maker, Vec3f base, float radius, std::uint32_t material) {
  std::vector<Vec2f> profile;
  for (int k = 0; k <= 64; ++k) {
    const float angle = 3.14159265f * static_cast<float>(k) / 64;
    profile.push_back({radius * std::sin(angle), radius * (1 - std::cos(angle))});
  }
  maker.lathe(base, profile, 128, material);
}

}  // namespace

LoadedScene make_paint() {
  LoadedScene loaded;
  Scene& scene = loaded.scene;
  Material glass = matte("glass", {1, 1, 1});
  glass.bsdf = BsdfKind::kGlass;
  glass.specular = {0.98f, 0.99f, 0.99f};
  scene.materials = {car_paint("red car paint", {0.62f, 0.03f, 0.04f}, 0.7f),
                     car_paint("silver car paint", {0.78f, 0.79f, 0.8f}, 1),
                     car_paint("white car paint", {0.85f, 0.85f, 0.83f}, 0), glass,
                     matte("ground", {0.42f, 0.4f, 0.37f})};
  scene.surfaces = {teapot_surface()};
  MeshMaker maker;
  maker.quad({-40, 0, 40}, {40, 0, 40}, {40, 0, -40}, {-40, 0, -40}, 4);
  add_ball(maker, {-2.6f, 0, 3.6f}, 0.9f, 1);
  add_ball(maker, {3.2f, 0, 2.6f}, 1.2f, 3);
  add_ball(maker, {0.9f, 0, 4.2f}, 0.6f, 2);
  scene.meshes = {maker.finish()};
  scene.instances = {{0, {}, ObjectKind::kPatchSurface}, {0, {}}};
  scene.environment = {1, 1, 1};
  scene.environment_map = clear_sky();
  scene.camera = Camera{{1.5f, 4.2f, 11.5f}, {0.2f, 1.2f, 0.6f}, {0, 1, 0}, 36};
  return loaded;
}

}  // namespace tessera::master
