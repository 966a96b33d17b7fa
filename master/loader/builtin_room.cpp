// SPDX-License-Identifier: Apache-2.0
// A furnished room, about 300,000 triangles: turned legs, bars, cloth, books, stalks and a carpet
// of thin fibres. Everything comes from a few dozen lines and an integer hash.
#include <cmath>

#include "master/loader/builtin.h"
#include "master/loader/mesh_maker.h"

namespace tessera::master {
namespace {

enum RoomMaterial : std::uint32_t {
  kWall,
  kFloor,
  kCeiling,
  kWood,
  kDark,
  kCloth,
  kMetal,
  kLeaf,
  kClay,
  kLamp,
  kPaper,
  kCarpet,
  kBookFirst
};
constexpr std::uint32_t kBookColours = 6;
constexpr float kWidth = 6, kHeight = 2.8f,
                kDepth = 5;  // metres; floor at y = 0, centred on x and z

std::shared_ptr<const Texture> plank_texture() {
  auto texture = std::make_shared<Texture>();
  texture->width_px = texture->height_px = 256;
  for (std::uint32_t y = 0; y < 256; ++y) {
    for (std::uint32_t x = 0; x < 256; ++x) {
      const std::uint32_t plank = y / 32;
      const bool is_gap = y % 32 == 0 || (x + 97 * plank) % 256 == 0;
      const float grain = std::sin(0.35f * static_cast<float>(y) +
                                   3 * std::sin(0.03f * static_cast<float>(x + 61 * plank)));
      const float shade =
          is_gap ? 0.35f : 0.8f + 0.08f * grain + 0.12f * hash_unit(plank, (x + 97 * plank) / 256);
      const auto texel = [&](float colour) {
        return static_cast<std::uint8_t>(255 * std::min(1.0f, colour * shade));
      };
      texture->rgba.insert(texture->rgba.end(), {texel(0.82f), texel(0.62f), texel(0.42f), 255});
    }
  }
  return texture;
}

void add_shell(MeshMaker& m) {
  const float x = kWidth / 2, z = kDepth / 2, h = kHeight;
  m.grid(1, 1, {{-x, 0, z}, {x, 0, z}, {-x, 0, -z}, {x, 0, -z}}, kFloor, 4);
  m.quad({-x, h, -z}, {x, h, -z}, {x, h, z}, {-x, h, z}, kCeiling);
  m.quad({-x, 0, -z}, {x, 0, -z}, {x, h, -z}, {-x, h, -z}, kWall);
  m.quad({-x, 0, z}, {-x, 0, -z}, {-x, h, -z}, {-x, h, z}, kWall);
  m.quad({x, 0, -z}, {x, 0, z}, {x, h, z}, {x, h, -z}, kWall);
  m.quad({x, 0, z}, {-x, 0, z}, {-x, h, z}, {x, h, z}, kWall);
  for (const float side : {-1.0f, 1.0f})
    m.box({-x, 0, side * (z - 0.01f) - 0.01f}, {x, 0.09f, side * (z - 0.01f) + 0.01f}, kWood);
}

// A window of bars on the left wall, and curtains beside it.
void add_window(MeshMaker& m) {
  const float x = -kWidth / 2 + 0.02f;
  m.box({x - 0.02f, 0.9f, -0.9f}, {x + 0.05f, 0.98f, 0.9f}, kWood);
  m.box({x - 0.02f, 2.2f, -0.9f}, {x + 0.05f, 2.28f, 0.9f}, kWood);
  for (int i = 0; i <= 8; ++i) {
    const float z = -0.88f + 0.22f * static_cast<float>(i);
    m.box({x, 0.98f, z - 0.008f}, {x + 0.02f, 2.2f, z + 0.008f}, kMetal);
  }
  for (int i = 1; i < 4; ++i)
    m.box({x, 0.98f + 0.3f * static_cast<float>(i), -0.9f},
          {x + 0.015f, 0.99f + 0.3f * static_cast<float>(i), 0.9f}, kMetal);
  for (const float side : {-1.0f, 1.0f}) {
    constexpr int kRows = 60, kColumns = 160;
    std::vector<Vec3f> points;
    for (int r = 0; r <= kRows; ++r) {
      for (int c = 0; c <= kColumns; ++c) {
        const float u = static_cast<float>(c) / kColumns, v = static_cast<float>(r) / kRows;
        const float fold =
            0.05f * std::sin(60 * u) * (0.4f + 0.6f * (1 - v)) + 0.02f * std::sin(23 * u + 5 * v);
        points.push_back({x + 0.12f + fold, 0.15f + 2.3f * v, side * (0.75f + 0.55f * u)});
      }
    }
    m.grid(kRows, kColumns, points, kCloth);
  }
  m.tube({{x + 0.12f, 2.47f, -1.5f}, {x + 0.12f, 2.47f, 1.5f}}, 0.015f, 12, kMetal);
}

std::vector<Vec2f> turned_leg(float height, float radius) {
  std::vector<Vec2f> profile;
  constexpr int kRings = 48;
  for (int i = 0; i <= kRings; ++i) {
    const float v = static_cast<float>(i) / kRings;
    const float bulge = 0.75f + 0.25f * std::sin(20 * v) + (v < 0.1f || v > 0.92f ? 0.35f : 0.0f);
    profile.push_back({radius * bulge, height * v});
  }
  return profile;
}

void add_table(MeshMaker& m, Vec3f at) {
  m.box(at + Vec3f{-0.8f, 0.72f, -0.45f}, at + Vec3f{0.8f, 0.76f, 0.45f}, kWood);
  m.box(at + Vec3f{-0.74f, 0.64f, -0.4f}, at + Vec3f{0.74f, 0.72f, 0.4f}, kWood);
  for (const float x : {-0.68f, 0.68f}) {
    for (const float z : {-0.34f, 0.34f})
      m.lathe(at + Vec3f{x, 0, z}, turned_leg(0.64f, 0.035f), 40, kWood);
  }
}

void add_chair(MeshMaker& m, Vec3f at, float side) {
  m.box(at + Vec3f{-0.22f, 0.44f, -0.22f}, at + Vec3f{0.22f, 0.47f, 0.22f}, kDark);
  for (const float x : {-0.18f, 0.18f}) {
    for (const float z : {-0.18f, 0.18f})
      m.lathe(at + Vec3f{x, 0, z}, turned_leg(0.44f, 0.02f), 28, kDark);
    m.lathe(at + Vec3f{x, 0.47f, side * 0.2f}, turned_leg(0.5f, 0.016f), 28, kDark);
  }
  for (int i = 0; i < 7; ++i) {
    const float x = -0.15f + 0.05f * static_cast<float>(i);
    m.tube({at + Vec3f{x, 0.47f, side * 0.2f}, at + Vec3f{x, 0.7f, side * 0.225f},
            at + Vec3f{x, 0.93f, side * 0.21f}},
           0.006f, 10, kDark);
  }
  m.box(at + Vec3f{-0.21f, 0.93f, side * 0.2f - 0.015f},
        at + Vec3f{0.21f, 0.99f, side * 0.2f + 0.015f}, kDark);
}

void add_bookshelf(MeshMaker& m, Vec3f at) {
  const float width = 1.6f, depth = 0.3f;
  for (int shelf = 0; shelf <= 5; ++shelf) {
    const float y = 0.38f * static_cast<float>(shelf) + 0.05f;
    m.box(at + Vec3f{0, y, 0}, at + Vec3f{width, y + 0.025f, depth}, kWood);
    if (shelf == 5) break;
    float x = 0.03f;
    for (std::uint32_t book = 0; x < width - 0.08f; ++book) {
      const auto id = static_cast<std::uint32_t>(shelf) * 100 + book;
      const float thick = 0.014f + 0.035f * hash_unit(id, 1),
                  tall = 0.2f + 0.12f * hash_unit(id, 2);
      const float deep = 0.16f + 0.09f * hash_unit(id, 3);
      const std::uint32_t colour =
          kBookFirst + static_cast<std::uint32_t>(hash_unit(id, 4) * kBookColours);
      m.box(at + Vec3f{x, y + 0.025f, 0.02f},
            at + Vec3f{x + thick, y + 0.025f + tall, 0.02f + deep}, colour);
      m.box(at + Vec3f{x + 0.003f, y + 0.03f, 0.025f},
            at + Vec3f{x + thick - 0.003f, y + 0.027f + tall, 0.021f + deep}, kPaper);
      x += thick + (hash_unit(id, 5) < 0.06f ? 0.05f : 0.001f);
    }
  }
  for (const float x : {-0.025f, width})
    m.box(at + Vec3f{x, 0, 0}, at + Vec3f{x + 0.025f, 2.0f, depth}, kWood);
}

void add_plant(MeshMaker& m, Vec3f at) {
  std::vector<Vec2f> pot;
  for (int i = 0; i <= 32; ++i) {
    const float v = static_cast<float>(i) / 32;
    pot.push_back({0.14f + 0.07f * v + (v > 0.85f ? 0.02f : 0.0f), 0.34f * v});
  }
  m.lathe(at, pot, 64, kClay);
  for (std::uint32_t i = 0; i < 60; ++i) {
    const float angle = 6.2831853f * hash_unit(i, 10), lean = 0.15f + 0.5f * hash_unit(i, 11),
                tall = 0.5f + 0.8f * hash_unit(i, 12);
    std::vector<Vec3f> stalk;
    for (int k = 0; k <= 16; ++k) {
      const float v = static_cast<float>(k) / 16, out = 0.05f + lean * v * v;
      stalk.push_back(at + Vec3f{out * std::cos(angle), 0.3f + tall * v - 0.3f * lean * v * v,
                                 out * std::sin(angle)});
    }
    m.tube(stalk, 0.004f, 6, kLeaf);
    for (int k = 5; k <= 16; ++k) {
      const Vec3f p = stalk[static_cast<std::size_t>(k)];
      const float turn = angle + (k % 2 == 0 ? 1.2f : -1.2f);
      const Vec3f tip = p + 0.13f * Vec3f{std::cos(turn), 0.25f, std::sin(turn)};
      const Vec3f side = 0.025f * Vec3f{-std::sin(turn), 0.2f, std::cos(turn)};
      m.quad(p, 0.5f * (p + tip) + side, tip, 0.5f * (p + tip) - side, kLeaf);
    }
  }
}

void add_carpet(MeshMaker& m, Vec3f at) {
  m.box(at + Vec3f{-1.3f, 0, -0.9f}, at + Vec3f{1.3f, 0.008f, 0.9f}, kCarpet);
  for (std::uint32_t i = 0; i < 50'000; ++i) {
    const float x = 2.6f * (hash_unit(i, 20) - 0.5f), z = 1.8f * (hash_unit(i, 21) - 0.5f);
    const float a = 6.2831853f * hash_unit(i, 22), lean = 0.02f * hash_unit(i, 23);
    const Vec3f p = at + Vec3f{x, 0.008f, z};
    const Vec3f half{0.0016f * std::cos(a), 0, 0.0016f * std::sin(a)};
    const bool is_stripe = static_cast<int>((x + 1.3f) * 5) % 3 == 0;
    m.triangle(p - half, p + half,
               p + Vec3f{lean * std::sin(a), 0.02f + 0.008f * hash_unit(i, 24), lean * std::cos(a)},
               is_stripe ? kDark : kCarpet);
  }
}

void add_lamp_and_vases(MeshMaker& m, Vec3f table) {
  add_ceiling_light(m, {0.2f, kHeight - 0.02f, 0.1f}, 0.55f, 0.3f, kLamp);
  m.box({-0.4f, kHeight - 0.018f, -0.25f}, {0.8f, kHeight, 0.45f}, kMetal);
  const auto vase = [&](Vec3f at, float scale, float waist, std::uint32_t material) {
    std::vector<Vec2f> profile;
    for (int i = 0; i <= 80; ++i) {
      const float v = static_cast<float>(i) / 80;
      profile.push_back({scale * (0.3f + waist * std::sin(1.0f + 4.4f * v)), scale * 1.6f * v});
    }
    m.lathe(at, profile, 120, material);
  };
  vase(table + Vec3f{0.35f, 0.76f, -0.1f}, 0.14f, 0.16f, kClay);
  vase(table + Vec3f{-0.45f, 0.76f, 0.1f}, 0.1f, 0.12f, kCloth);
  vase(table + Vec3f{-0.1f, 0.76f, -0.2f}, 0.08f, 0.18f, kMetal);
  m.box(table + Vec3f{-0.1f, 0.76f, 0.1f}, table + Vec3f{0.12f, 0.785f, 0.38f}, kBookFirst + 1,
        0.4f);
  m.box(table + Vec3f{-0.09f, 0.785f, 0.12f}, table + Vec3f{0.11f, 0.8f, 0.36f}, kBookFirst + 3,
        0.15f);
}

void add_pictures(MeshMaker& m) {
  const float z = -kDepth / 2 + 0.01f;
  for (int i = 0; i < 3; ++i) {
    const float x = 0.35f + 0.85f * static_cast<float>(i);
    m.box({x - 0.02f, 1.28f, z - 0.005f}, {x + 0.62f, 2.02f, z + 0.02f}, kDark);
    m.box({x + 0.02f, 1.32f, z}, {x + 0.58f, 1.98f, z + 0.025f}, kPaper);
    for (std::uint32_t k = 0; k < 40; ++k) {
      const auto id = static_cast<std::uint32_t>(i) * 64 + k;
      const float px = x + 0.06f + 0.4f * hash_unit(id, 30), py = 1.36f + 0.5f * hash_unit(id, 31);
      const float size = 0.02f + 0.07f * hash_unit(id, 32);
      m.box({px, py, z + 0.02f}, {px + size, py + size, z + 0.027f + 0.002f * hash_unit(id, 33)},
            kBookFirst + id % kBookColours);
    }
  }
}

}  // namespace

LoadedScene make_room() {
  LoadedScene loaded;
  Scene& scene = loaded.scene;
  scene.materials = {
      matte("wall", {0.72f, 0.68f, 0.58f}),     matte("floor", {1, 1, 1}),
      matte("ceiling", {0.8f, 0.8f, 0.78f}),    matte("wood", {0.45f, 0.28f, 0.15f}),
      matte("dark wood", {0.2f, 0.11f, 0.06f}), matte("cloth", {0.55f, 0.16f, 0.14f}),
      matte("metal", {0.5f, 0.5f, 0.52f}),      matte("leaf", {0.16f, 0.42f, 0.12f}),
      matte("clay", {0.62f, 0.33f, 0.2f}),      glowing("lamp", {16, 14.5f, 12}),
      matte("paper", {0.82f, 0.8f, 0.72f}),     matte("carpet", {0.4f, 0.3f, 0.24f})};
  const Vec3f books[kBookColours] = {{0.5f, 0.1f, 0.1f}, {0.12f, 0.2f, 0.45f}, {0.1f, 0.35f, 0.2f},
                                     {0.6f, 0.5f, 0.2f}, {0.3f, 0.15f, 0.35f}, {0.65f, 0.6f, 0.5f}};
  for (const Vec3f& colour : books) scene.materials.push_back(matte("book", colour));
  scene.textures = {plank_texture()};
  scene.materials[kFloor].albedo_texture = 0;
  MeshMaker maker;
  const Vec3f table{0.2f, 0, 0.1f};
  add_shell(maker);
  add_window(maker);
  add_table(maker, table);
  for (const float x : {-0.25f, 0.65f}) {
    add_chair(maker, {x, 0, -0.65f}, -1);
    add_chair(maker, {x, 0, 0.85f}, 1);
  }
  add_bookshelf(maker, {-2.6f, 0, -kDepth / 2 + 0.01f});
  add_plant(maker, {2.45f, 0, -1.9f});
  add_plant(maker, {-2.4f, 0, 1.6f});
  add_carpet(maker, table);
  add_lamp_and_vases(maker, table);
  add_pictures(maker);
  scene.meshes = {maker.finish()};
  scene.instances.resize(1);
  Light reading;
  reading.position = {-2.2f, 2.2f, -1.2f};
  reading.intensity = {1.6f, 1.3f, 0.9f};
  scene.lights = {reading};
  scene.camera = Camera{{2.1f, 1.65f, 2.2f}, {-0.35f, 0.95f, -0.6f}, {0, 1, 0}, 58};
  return loaded;
}

// The lantern goes once round the table in 12 seconds, up and down on the way.
LoadedScene make_evening() {
  LoadedScene loaded = make_room();
  loaded.is_animated = true;
  for (Material& material : loaded.scene.materials) material.emission = material.emission * 0.06f;
  loaded.at_time = [room = loaded.scene](double seconds) {
    Scene scene = room;
    const double turn = seconds / 12 * 6.283185307179586;
    Light lantern;
    lantern.position = {static_cast<float>(0.2 + 1.7 * std::cos(turn)),
                        static_cast<float>(1.3 + 0.4 * std::sin(2 * turn)),
                        static_cast<float>(0.1 + 1.4 * std::sin(turn))};
    lantern.intensity = {4.5f, 3.1f, 1.6f};
    scene.lights = {lantern};
    return scene;
  };
  loaded.scene = loaded.at_time(0);
  return loaded;
}

}  // namespace tessera::master
