// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/scenes.h"

#include "tests/bench/shape_builder.h"

namespace tessera::bench {
namespace {

// Upper bits of a linear congruential generator (D. Knuth, MMIX).
class Random {
 public:
  float in(float low, float high) { return low + (high - low) * next(); }

 private:
  float next() {
    state_ = state_ * 6364136223846793005ull + 1442695040888963407ull;
    return static_cast<float>(state_ >> 40) / 16777216.0f;
  }
  std::uint64_t state_ = 0x9E3779B97F4A7C15ull;
};

struct View {
  Vec3f eye, target;
  float vfov_degrees;
  Vec3f light;
};

// Furniture in metres; detail: factor of the number of cells in each direction.
void add_chair(ShapeBuilder& b, Vec3f at, float yaw, int detail) {
  b.set_frame(at, yaw);
  b.add_superellipsoid({0, 0, 0.46f}, {0.25f, 0.25f, 0.05f}, 0.4f, 0.5f, 10 * detail, 5 * detail);
  b.add_superellipsoid({-0.24f, 0, 0.80f}, {0.04f, 0.23f, 0.22f}, 0.5f, 0.4f, 10 * detail,
                       5 * detail);
  for (unsigned k = 0; k < 4; ++k) {
    const float x = (k & 1u) != 0 ? 0.2f : -0.22f, y = (k & 2u) != 0 ? 0.2f : -0.2f;
    b.add_rod({x, y, 0}, {x, y, 0.45f}, 0.012f, 2 * detail, 3 * detail);
  }
  for (const float side : {-1.0f, 1.0f}) {
    const auto arm = [&](float s) {
      const float a = kPi * s;
      return Vec3f{0.02f - 0.22f * std::cos(a), 0.26f * side,
                   0.44f + 0.22f * std::pow(std::sin(a), 0.5f)};
    };
    b.add_tube(arm, 0.012f, 8 * detail, 3 * detail);
  }
  for (int k = 0; k < 6; ++k) {
    const float x = -0.22f + 0.08f * static_cast<float>(k);
    b.add_rod({x, -0.2f, 0.12f}, {x, 0.2f, 0.12f}, 0.004f, detail, 2 * detail);
  }
}

void add_table(ShapeBuilder& b, Vec3f at, float yaw, float length, float width, int detail) {
  b.set_frame(at, yaw);
  b.add_superellipsoid({0, 0, 0.73f}, {length, width, 0.03f}, 0.15f, 0.3f, 16 * detail, 6 * detail);
  for (unsigned k = 0; k < 4; ++k) {
    const Vec3f foot{((k & 1u) != 0 ? 0.7f : -0.7f) * length,
                     ((k & 2u) != 0 ? 0.6f : -0.6f) * width, 0};
    b.add_rod(foot, foot + Vec3f{0, 0, 0.7f}, 0.05f, 2 * detail, 6 * detail);
    b.add_superellipsoid(foot + Vec3f{0, 0, 0.02f}, {0.12f, 0.12f, 0.02f}, 0.5f, 1, 6 * detail,
                         3 * detail);
  }
}

// Adds a lamp with louvres, which are many thin boxes.
void add_lamp(ShapeBuilder& b, Vec3f at, int detail) {
  b.set_frame(at);
  const int louvres = 3 * detail;
  for (int k = 0; k < louvres; ++k) {
    const float x = -0.55f + 1.1f * static_cast<float>(k) / static_cast<float>(louvres - 1);
    b.add_box({x, -0.28f, -0.08f}, {x + 0.003f, 0.28f, 0});
  }
  for (const float side : {-1.0f, 1.0f}) {
    b.add_box({-0.56f, 0.28f * side - 0.005f, -0.1f}, {0.56f, 0.28f * side + 0.005f, 0});
  }
  b.add_rod({-0.5f, 0, -0.02f}, {0.5f, 0, -0.02f}, 0.015f, detail, 2 * detail);
}

void add_shell(ShapeBuilder& b, float x, float y, float z) {
  b.set_frame({0, 0, 0});
  b.add_quad({0, 0, 0}, {x, 0, 0}, {0, y, 0});
  b.add_quad({0, 0, z}, {0, y, 0}, {x, 0, 0});
  b.add_quad({0, 0, 0}, {0, 0, z}, {x, 0, 0});
  b.add_quad({0, y, 0}, {x, 0, 0}, {0, 0, z});
  b.add_quad({0, 0, 0}, {0, y, 0}, {0, 0, z});
  b.add_quad({x, 0, 0}, {0, 0, z}, {0, y, 0});
}

void add_blinds(ShapeBuilder& b) {
  b.set_frame({0, 0, 0});
  for (int window = 0; window < 4; ++window) {
    for (int k = 0; k < 90; ++k) {
      const float z = 0.9f + 0.024f * static_cast<float>(k);
      const float x = 1 + 3.8f * static_cast<float>(window);
      b.add_box({x, 0.06f, z}, {x + 2.6f, 0.085f, z + 0.002f});
      b.add_rod({x + 1.3f, 0.07f, z}, {x + 1.3f, 0.07f, z + 0.024f}, 0.0015f, 1, 6);
    }
  }
}

void add_cables(ShapeBuilder& b, float x, float z) {
  for (int i = 0; i < 24; ++i) {
    const auto k = static_cast<float>(i);
    const float y = 0.4f + 0.39f * k;
    const auto cable = [&](float s) {
      return Vec3f{0.1f + (x - 0.2f) * s, y + 0.06f * std::sin(25 * s + k),
                   z - 0.22f + 0.03f * std::sin(40 * s + 2 * k)};
    };
    b.add_tube(cable, 0.008f, 120, 6);
  }
}

void add_cups_and_papers(ShapeBuilder& b) {
  for (int i = 0; i < 20; ++i) {
    const auto k = static_cast<float>(i);
    b.set_frame({4.4f + 0.37f * k, 4.2f + 1.5f * static_cast<float>(i & 1), 0.76f}, 0.3f * k);
    b.add_tube([](float s) { return Vec3f{0, 0, 0.1f * s}; }, 0.04f, 4, 32);
    const auto handle = [](float s) {
      const float a = kPi * s;
      return Vec3f{0.04f + 0.03f * std::sin(a), 0, 0.05f - 0.035f * std::cos(a)};
    };
    b.add_tube(handle, 0.006f, 16, 10);
    b.add_box({-0.3f, 0.1f, 0}, {-0.09f, 0.4f, 0.001f});
  }
}

View make_interior(ShapeBuilder& b) {
  constexpr float kX = 16, kY = 10, kZ = 3.4f;
  add_shell(b, kX, kY, kZ);
  add_table(b, {8, 5, 0}, 0, 4.2f, 1.4f, 8);
  for (int i = 0; i < 10; ++i) {
    for (const float side : {-1.0f, 1.0f}) {
      const auto k = static_cast<float>(i);
      add_chair(b, {4.4f + 0.8f * k, 5 + side * 1.85f, 0},
                side * -kPi / 2 + 0.15f * std::sin(7.0f * k + side), 4);
    }
  }
  for (int k = 0; k < 18; ++k) {
    add_chair(b, {1.0f + 0.82f * static_cast<float>(k), 9.2f, 0}, -kPi / 2, 3);
  }
  for (int i = 0; i < 7; ++i) {
    for (int j = 0; j < 4; ++j) {
      add_lamp(
          b, {1.6f + 2.1f * static_cast<float>(i), 1.4f + 2.4f * static_cast<float>(j), kZ - 0.02f},
          12);
    }
  }
  add_blinds(b);
  add_cables(b, kX, kZ);
  add_cups_and_papers(b);
  return {{0.9f, 8.5f, 2.3f}, {8.6f, 3.4f, 1.1f}, 65, {8, 5, 2.9f}};
}

View make_knot(ShapeBuilder& b) {
  b.set_frame({0, 0, 0});
  const auto unit = [](Vec3f a) { return a * (1.0f / std::sqrt(dot(a, a))); };
  const auto knot = [](float t) {  // the (2, 3) torus knot
    const float r = 2 + std::cos(3 * t);
    return Vec3f{r * std::cos(2 * t), r * std::sin(2 * t), 1.1f * std::sin(3 * t)};
  };
  b.add_surface(160, 1500, [&](float u, float v) {
    const float t = 2 * kPi * v, a = 2 * kPi * u;
    const Vec3f d = unit(knot(t + 1e-3f) - knot(t)), n = unit(cross(d, {0, 0, 1}));
    const Vec3f m = cross(n, d);
    const float r = 0.42f + 0.03f * std::sin(24 * t + 3 * a) * std::sin(5 * a) +
                    0.006f * std::sin(160 * t) * std::cos(14 * a);
    return knot(t) + n * (r * std::cos(a)) + m * (r * std::sin(a));
  });
  for (int i = 0; i < 9; ++i) {
    const auto k = static_cast<float>(i);
    const float a = 2 * kPi * k / 9;
    b.add_superellipsoid({5.2f * std::cos(a), 5.2f * std::sin(a), -0.7f}, {0.8f, 0.8f, 0.9f},
                         0.3f + 0.2f * k, 2.0f - 0.2f * k, 150, 74);
  }
  b.add_surface(64, 64, [](float u, float v) { return Vec3f{24 * u - 12, 24 * v - 12, -1.75f}; });
  return {{6.5f, -7.0f, 4.6f}, {0, 0, -0.1f}, 48, {4, -2, 9}};
}

constexpr float kRoomWidth = 5, kRoomHeight = 3;

// A wall with a door, along one axis of the room.
void add_wall(ShapeBuilder& b, bool along_x, float door) {
  constexpr float kThick = 0.12f;
  const auto part = [&](float from, float to, float low, float high) {
    if (along_x) {
      b.add_box({from, 0, low}, {to, kThick, high});
    } else {
      b.add_box({0, from, low}, {kThick, to, high});
    }
  };
  const float end = door + 1.1f;
  part(0, door, 0, kRoomHeight - 0.15f);
  part(end, kRoomWidth, 0, kRoomHeight - 0.15f);
  part(door, end, 2.1f, kRoomHeight - 0.15f);
}

void add_shelf(ShapeBuilder& b, Random& random) {
  for (int i = 0; i < 5; ++i) {
    const auto k = static_cast<float>(i);
    b.add_box({0.2f, 4.6f, 0.4f * k + 0.1f}, {1.8f, 4.9f, 0.4f * k + 0.12f});
    for (float x = 0.22f; x < 1.7f;) {
      const float width = random.in(0.015f, 0.05f);
      const float depth = random.in(0.15f, 0.25f), height = random.in(0.18f, 0.26f);
      b.add_box({x, 4.62f, 0.4f * k + 0.12f},
                {x + width, 4.62f + depth, 0.4f * k + 0.12f + height});
      x += width + 0.004f;
    }
  }
}

void add_room(ShapeBuilder& b, Vec3f at, Random& random) {
  b.set_frame(at);
  b.add_box({0, 0, -0.15f}, {kRoomWidth, kRoomWidth, 0});
  for (const bool along_x : {false, true}) add_wall(b, along_x, random.in(0.6f, 3.2f));
  add_table(b, at + Vec3f{2.6f, 2.6f, 0}, random.in(0, kPi), 1.0f, 0.6f, 1);
  for (int k = 0; k < 4; ++k) {
    const float a = static_cast<float>(k) * kPi / 2 + random.in(-0.3f, 0.3f);
    add_chair(b, at + Vec3f{2.6f + 1.2f * std::cos(a), 2.6f + 1.0f * std::sin(a), 0}, a + kPi, 2);
  }
  add_lamp(b, at + Vec3f{1.5f, 2.5f, kRoomHeight - 0.16f}, 6);
  add_lamp(b, at + Vec3f{3.6f, 2.5f, kRoomHeight - 0.16f}, 6);
  b.set_frame(at);
  add_shelf(b, random);
}

View make_building(ShapeBuilder& b) {
  constexpr int kAcross = 10, kDeep = 6, kFloors = 4;
  constexpr float kX = kAcross * kRoomWidth, kY = kDeep * kRoomWidth, kZ = kFloors * kRoomHeight;
  Random random;
  for (int f = 0; f < kFloors; ++f) {
    for (int j = 0; j < kDeep; ++j) {
      for (int i = 0; i < kAcross; ++i) {
        add_room(b,
                 {static_cast<float>(i) * kRoomWidth, static_cast<float>(j) * kRoomWidth,
                  static_cast<float>(f) * kRoomHeight},
                 random);
      }
    }
  }
  b.set_frame({0, 0, 0});
  b.add_box({0, 0, kZ - 0.15f}, {kX, kY, kZ});
  b.add_box({kX, 0, 0}, {kX + 0.12f, kY, kZ});
  b.add_box({0, kY, 0}, {kX, kY + 0.12f, kZ});
  return {{21.2f, 10.9f, 7.7f}, {24.5f, 14.2f, 7.0f}, 70, {22.5f, 13.0f, 8.6f}};
}

float ground(float x, float y) {
  return 3.0f * std::sin(0.07f * x) * std::cos(0.05f * y) + 0.8f * std::sin(0.31f * x + 0.2f * y) +
         0.15f * std::sin(1.7f * x) * std::sin(1.3f * y) + 0.02f * std::sin(9 * x + 7 * y);
}

View make_field(ShapeBuilder& b) {
  b.set_frame({0, 0, 0});
  b.add_surface(1600, 1600, [](float u, float v) {
    const float x = 200 * u - 100, y = 200 * v - 100;
    return Vec3f{x, y, ground(x, y)};
  });
  Random random;
  for (int k = 0; k < 2700; ++k) {
    const float x = random.in(-98, 98), y = random.in(-98, 98), scale = random.in(0.4f, 1.3f);
    b.set_frame({x, y, ground(x, y)}, random.in(0, 6.28f), scale);
    const float e2 = random.in(0.4f, 1.6f), e1 = random.in(0.4f, 1.6f);
    b.add_superellipsoid({0, 0, 0.4f}, {0.9f, 0.7f, 0.6f}, e1, e2, 44, 20);
    b.add_rod({1.2f, 0, -0.2f}, {1.2f, 0, 2.2f}, 0.05f, 5, 12);
  }
  return {{-62, -70, 11}, {-30, -33, -2}, 50, {-20, -40, 60}};
}

// Turned, tilted and scaled figures on a field, each a body, a head and limbs.
BenchScene make_crowd() {
  BenchScene scene;
  scene.name = "crowd";
  ShapeBuilder b;
  b.add_surface(40, 40, [](float u, float v) {
    return Vec3f{60 * u - 30, 60 * v - 30, 0.2f * std::sin(7 * u) * std::cos(5 * v)};
  });
  scene.meshes.push_back(b.take());
  b = {};
  b.add_superellipsoid({0, 0, 1.1f}, {0.3f, 0.2f, 0.45f}, 0.8f, 0.9f, 40, 24);
  b.add_superellipsoid({0, 0, 1.75f}, {0.14f, 0.16f, 0.18f}, 1, 1, 32, 16);
  for (const float side : {-1.0f, 1.0f}) {
    b.add_rod({0.16f * side, 0, 0}, {0.12f * side, 0, 0.8f}, 0.09f, 12, 14);
    b.add_rod({0.3f * side, 0, 1.4f}, {0.42f * side, 0.2f, 0.8f}, 0.07f, 12, 14);
  }
  scene.meshes.push_back(b.take());
  scene.instances.push_back({0, {}});
  Random random;
  for (int i = 0; i < 400; ++i) {
    const float yaw = random.in(0, 6.28f), tilt = random.in(-0.3f, 0.3f),
                size = random.in(0.8f, 1.3f);
    const float c = std::cos(yaw) * size, s = std::sin(yaw) * size;
    Instance figure;
    figure.mesh = 1;
    figure.object_to_world.m = {{{c, -s, tilt, 2.6f * static_cast<float>(i % 20) - 25},
                                 {s, c, tilt / 2, 2.6f * static_cast<float>(i / 20) - 25},
                                 {0, 0, size, 0.1f}}};
    scene.instances.push_back(figure);
  }
  scene.camera = {{-18, -33, 7}, {0, -8, 0.5f}, {0, 0, 1}, 45};
  scene.light = {-10, -20, 30};
  return scene;
}

struct Maker {
  const char* name;
  View (*make)(ShapeBuilder&);
};
constexpr Maker kMakers[] = {{"interior", make_interior},
                             {"knot", make_knot},
                             {"building", make_building},
                             {"field", make_field}};

}  // namespace

std::vector<std::string> scene_names() {
  std::vector<std::string> names;
  for (const Maker& maker : kMakers) names.emplace_back(maker.name);
  return names;
}

Result<BenchScene> make_scene(const std::string& name) {
  if (name == "crowd") return make_crowd();
  for (const Maker& maker : kMakers) {
    if (name != maker.name) continue;
    ShapeBuilder builder;
    const View view = maker.make(builder);
    BenchScene scene;
    scene.name = name;
    scene.mesh = builder.take();
    scene.camera = {view.eye, view.target, {0, 0, 1}, view.vfov_degrees};
    scene.light = view.light;
    return scene;
  }
  return Status::invalid_argument("scene " + name +
                                  ": give interior, knot, building, field or crowd");
}

}  // namespace tessera::bench
