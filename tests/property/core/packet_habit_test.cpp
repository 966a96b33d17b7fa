// SPDX-License-Identifier: Apache-2.0
// Property: packets that are given up, or not tried, give the answers of their rays.
#include <gtest/gtest.h>

#include <random>

#include "slave/core/primitive/primitive_index.h"
#include "slave/core/primitive/triangle/triangle_store.h"
#include "slave/core/ray/fan_of.h"
#include "slave/core/trace/scene_tracer.h"
#include "tests/support/packets.h"
#include "tests/support/seed.h"
#include "tests/support/test_meshes.h"

namespace tessera::core {
namespace {

SingleRay ray_of(const FanPacket& fan, int i) {
  return {{fan.origin[0], fan.origin[1], fan.origin[2]},
          {fan.direction[0][i], fan.direction[1][i], fan.direction[2][i]},
          fan.t_min,
          fan.t_max[i]};
}

// Rays far apart over tiny triangles: packets are given up on the way, and for a while not tried.
// One packet is filled again and again, as callers do.
TEST(PacketHabit, PacketsThatDoNotPayAnswerAsTheirRaysDo) {
  const std::uint32_t seed = 7;
  const Mesh mesh = test::make_terrain(300, 2);
  std::vector<Bounds3f> boxes;
  const TriangleStore store = make_triangle_store(test::make_scene(mesh), boxes);
  const IndexedBvh<8> bvh = std::move(*index_by_bvh<8>(boxes, store.vertices, {1, nullptr}));
  std::mt19937 random(test::seed(seed));
  std::uniform_real_distribution<float> unit(-1, 1);
  for (const Isa isa : test::isas_here()) {
    const auto& kernels = kernels_of(kernels_for(isa), view_of(bvh));
    FanPacket fan{};
    PacketHabit any_habit;  // of those that ask for any hit
    int given_up = 0, left_out = 0;
    for (int number = 0; number < 60; ++number) {
      // Every third packet is narrow, and pays.
      const float width = number % 3 == 0 ? 0.01f : 0.5f;
      const Vec3f middle = mesh.positions[random() % mesh.positions.size()];
      fan.active = ~std::uint64_t{0};
      const Vec3f origin = middle + Vec3f{0, 3, 0};
      for (int a = 0; a < 3; ++a) fan.origin[a] = origin[a];
      for (int i = 0; i < kPacketRays; ++i) {
        const Vec3f target = middle + Vec3f{width * unit(random), 0, width * unit(random)};
        for (int a = 0; a < 3; ++a) fan.direction[a][i] = target[a] - origin[a];
        fan.t_max[i] = Bounds3f::kInf;
      }
      const int before = fan.habit.alone;
      PacketHits hits;
      kernels.closest_fan(view_of(bvh), fan_of(fan), arrays_of(hits));
      given_up += before == 0 && fan.habit.alone > 0 ? 1 : 0;
      left_out += before > 0 ? 1 : 0;
      FanPacket shadows = fan;
      shadows.habit = any_habit;
      const std::uint64_t blocked = kernels.occluded_fan(view_of(bvh), fan_of(shadows));
      any_habit = shadows.habit;
      for (int i = 0; i < kPacketRays; ++i) {
        SingleHit expected;
        kernels_for(Isa::kScalar).bvh8.closest_ray(view_of(bvh), ray_of(fan, i), expected);
        ASSERT_EQ(hits.primitive[i], expected.primitive) << isa_name(isa) << " " << number;
        ASSERT_EQ(hits.t[i], expected.t) << isa_name(isa) << " " << number;
        ASSERT_EQ(blocked >> i & 1u, expected.primitive != kNoPrimitive ? 1u : 0u);
      }
    }
    EXPECT_GT(given_up, 0) << isa_name(isa);
    EXPECT_GT(left_out, 0) << isa_name(isa);
    EXPECT_LT(given_up + left_out, 60) << isa_name(isa);
  }
}

}  // namespace
}  // namespace tessera::core
