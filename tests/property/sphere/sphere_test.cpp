// SPDX-License-Identifier: Apache-2.0
// Property: a kind of primitive that slave/core knows nothing of is traced by its structures,
// builders and packets: every ball is found by every ray that meets it, alone, in fans and in
// bundles, through the hierarchy and the kd-tree, on every instruction set, with the same bits.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <random>

#include "common/math/bounds3.h"
#include "slave/core/accel/bvh_builder.h"
#include "slave/core/accel/kd_index.h"
#include "slave/core/primitive/primitive_index.h"
#include "slave/core/ray/fan_of.h"
#include "tests/property/sphere/sphere_kernels.h"
#include "tests/support/packets.h"
#include "tests/support/seed.h"

namespace tessera::core {
namespace {

using Random = std::mt19937;
constexpr int W = 16;
constexpr float kInf = Bounds3f::kInf;

float unit(Random& random) { return std::uniform_real_distribution<float>(-1, 1)(random); }
Vec3f point(Random& random) { return {unit(random), unit(random), unit(random)}; }

// Bounding boxes, moved out by the rounding of a sum.
std::vector<Bounds3f> boxes_of(const std::vector<Ball>& balls) {
  std::vector<Bounds3f> boxes;
  for (const Ball& ball : balls) {
    float low[3], high[3];
    for (int a = 0; a < 3; ++a) {
      low[a] = std::nextafter(ball.center[a] - ball.radius, -kInf);
      high[a] = std::nextafter(ball.center[a] + ball.radius, kInf);
    }
    boxes.push_back({{low[0], low[1], low[2]}, {high[0], high[1], high[2]}});
  }
  return boxes;
}

// The closest hit, found by a look at every ball.
SingleHit reference(const std::vector<Ball>& balls, const SingleRay& ray) {
  SingleHit best{0, kNoPrimitive};
  float nearest = kInf;
  for (std::uint32_t i = 0; i < balls.size(); ++i) {
    const float center[3] = {balls[i].center.x, balls[i].center.y, balls[i].center.z};
    const float t =
        sphere_t(ray.origin, ray.direction, center, balls[i].radius, ray.t_min, ray.t_max);
    if (t >= nearest) continue;
    nearest = t;
    best = {t, i};
  }
  return best;
}

// 64 rays from one point, or from about one place.
std::vector<SingleRay> rays_of(Random& random, const std::vector<Ball>& balls, bool is_fan) {
  const Vec3f eye = point(random) * 3.0f;
  const Ball& aim = balls[random() % balls.size()];
  const bool is_narrow = random() % 2 == 0;
  std::vector<SingleRay> rays;
  for (int i = 0; i < kPacketRays; ++i) {
    const Vec3f from = is_fan ? eye : eye + point(random) * 0.02f;
    // Some rays end at the rim of a ball, give or take a rounding.
    Vec3f to = aim.center + point(random) * (is_narrow ? 1.5f * aim.radius : 1.0f);
    if (i % 5 == 0) to = aim.center + normalize(point(random)) * aim.radius;
    const Vec3f d = to - from;
    rays.push_back({{from.x, from.y, from.z}, {d.x, d.y, d.z}, 0, i % 7 == 0 ? 0.9f : kInf});
  }
  return rays;
}

template <class Packet>
Packet packet_of(const std::vector<SingleRay>& rays) {
  Packet packet{};
  for (std::size_t i = 0; i < rays.size(); ++i) {
    for (int a = 0; a < 3; ++a) {
      packet.direction[a][i] = rays[i].direction[a];
      if constexpr (std::is_same_v<Packet, RayPacket>) {
        packet.origin[a][i] = rays[i].origin[a];
      } else {
        packet.origin[a] = rays[0].origin[a];
      }
    }
    packet.t_max[i] = rays[i].t_max;
  }
  packet.active = ~std::uint64_t{0};
  return packet;
}

bool is_same(const SingleHit& a, const SingleHit& b) {
  return a.primitive == b.primitive &&
         std::bit_cast<std::uint32_t>(a.t) == std::bit_cast<std::uint32_t>(b.t);
}

// Returns: how many rays hit something.
template <class View>
int check(const ViewKernels<View>& kernels, const View& view, const std::vector<Ball>& balls,
          unsigned seed) {
  Random random(seed);
  int hit_count = 0;
  for (int n = 0; n < 60; ++n) {
    const bool is_fan = n % 2 == 0;
    const std::vector<SingleRay> rays = rays_of(random, balls, is_fan);
    PacketHits hits;
    std::uint64_t blocked = 0;
    if (is_fan) {
      const auto packet = packet_of<FanPacket>(rays);
      kernels.closest_fan(view, fan_of(packet), arrays_of(hits));
      blocked = kernels.occluded_fan(view, fan_of(packet));
    } else {
      const auto packet = packet_of<RayPacket>(rays);
      kernels.closest_many(view, many_of(packet), arrays_of(hits));
      kernels.occluded_many(view, many_of(packet), &blocked);
    }
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const SingleHit wanted = reference(balls, rays[i]);
      SingleHit alone;
      kernels.closest_ray(view, rays[i], alone);
      EXPECT_TRUE(is_same(wanted, alone)) << wanted.primitive << " " << alone.primitive;
      EXPECT_TRUE(is_same(wanted, {hits.t[i], hits.primitive[i]}));
      EXPECT_EQ(wanted.primitive != kNoPrimitive, (blocked >> i & 1u) != 0);
      EXPECT_EQ(wanted.primitive != kNoPrimitive, kernels.occluded_ray(view, rays[i]));
      hit_count += wanted.primitive != kNoPrimitive;
    }
    if (testing::Test::HasFailure()) return 0;
  }
  return hit_count;
}

class ThirdKind : public testing::TestWithParam<float> {};

TEST_P(ThirdKind, IsTracedOnEveryWay) {
  const unsigned seed = test::seed();
  TESSERA_TRACE_SEED(seed);
  Random random(seed);
  std::vector<Ball> balls;
  for (int i = 0; i < 1500; ++i)
    balls.push_back({point(random), GetParam() * (0.1f + std::fabs(unit(random)))});
  balls.push_back(balls[0]);  // the lower number wins
  const std::vector<Bounds3f> boxes = boxes_of(balls);
  SphereWriter<W> bvh_leaves(balls), kd_leaves(balls);
  const auto bvh = build_bvh<W>({boxes, bvh_leaves}, {2, nullptr});
  ASSERT_TRUE(bvh.is_ok());
  EXPECT_TRUE(bvh->validate({boxes, bvh_leaves}).is_ok());
  const auto kd = build_kd_index<W>({boxes, kd_leaves}, {1, nullptr});
  ASSERT_TRUE(kd.is_ok());
  for (const Isa isa : test::isas_here()) {
    SCOPED_TRACE(isa_name(isa));
    const SphereBvh<W> through_bvh{
        bvh->nodes.data(), {bvh_leaves.blocks()}, scene_box(bvh->bounds)};
    EXPECT_GT(check(sphere_bvh_kernels(isa).by16, through_bvh, balls, seed), 200);
    const SphereKd<W> through_kd{
        kd->nodes.data(), kd->leaves.data(), {kd_leaves.blocks()}, scene_box(kd->bounds)};
    EXPECT_GT(check(sphere_kd_kernels(isa).by16, through_kd, balls, seed), 200);
  }
}

INSTANTIATE_TEST_SUITE_P(Radii, ThirdKind, testing::Values(0.3f, 0.03f, 0.002f));

// A ray that starts inside meets the surface, wherever it goes.
TEST(ThirdKind, IsClosed) {
  const unsigned seed = test::seed();
  TESSERA_TRACE_SEED(seed);
  Random random(seed);
  const std::vector<Ball> balls{{{0.3f, -0.2f, 5.0f}, 1.25f}};
  const std::vector<Bounds3f> boxes = boxes_of(balls);
  SphereWriter<W> leaves(balls);
  const auto bvh = build_bvh<W>({boxes, leaves}, {1, nullptr});
  ASSERT_TRUE(bvh.is_ok());
  const SphereBvh<W> view{bvh->nodes.data(), {leaves.blocks()}, scene_box(bvh->bounds)};
  for (const Isa isa : test::isas_here()) {
    const ViewTables<SphereBvh> kernels = sphere_bvh_kernels(isa);
    for (int n = 0; n < 100'000; ++n) {
      const Vec3f from = balls[0].center + normalize(point(random)) * 1.2499f;
      const Vec3f d = point(random);
      SingleHit hit;
      kernels.by16.closest_ray(view, {{from.x, from.y, from.z}, {d.x, d.y, d.z}, 0, kInf}, hit);
      ASSERT_EQ(hit.primitive, 0u) << isa_name(isa);
    }
  }
}

}  // namespace
}  // namespace tessera::core
