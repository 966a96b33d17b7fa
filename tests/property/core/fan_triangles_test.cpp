// SPDX-License-Identifier: Apache-2.0
// Property: a full fan of neighbours answers what its rays answer alone, to the bit, and hits a
// triangle exactly when exact arithmetic says so, where a filter in float32 has least to go by:
//   slivers  two corners a few roundings apart, at scales 1e-6 to 1e6, far from the world's origin,
//            seen edge-on, with t_min 0 and above, by rays that start in the plane of the triangle
//            or next to it
//   stacks   triangles in one plane, or a few roundings from it: whose t is the least is decided by
//            bits
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdlib>

#include "slave/core/primitive/triangle/exact_hit_abi.h"
#include "tests/support/choices.h"
#include "tests/support/packets.h"
#include "tests/support/test_meshes.h"

namespace tessera::core {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

// TESSERA_LONG=1 asks for the long form.
int rounds(int few) { return std::getenv("TESSERA_LONG") == nullptr ? few : 20 * few; }

using test::Choices;

struct Fan {
  Vec3f origin;
  float t_min = 0;
  Vec3f direction[kPacketRays];
  float t_max[kPacketRays];

  FanPacket packet() const {
    FanPacket p{};
    p.t_min = t_min;
    p.active = ~std::uint64_t{0};
    for (int a = 0; a < 3; ++a) p.origin[a] = origin[a];
    for (int i = 0; i < kPacketRays; ++i) {
      p.t_max[i] = t_max[i];
      for (int a = 0; a < 3; ++a) p.direction[a][i] = direction[i][a];
    }
    return p;
  }
  SingleRay ray(int i) const {
    const Vec3f d = direction[i];
    return {{origin.x, origin.y, origin.z}, {d.x, d.y, d.z}, t_min, t_max[i]};
  }
};

// How often fans, closest and any hit, differ from single rays. hits: of single rays.
struct Count {
  std::uint64_t rays = 0, hits = 0, different = 0;
};

void compare(const SceneTracer& tracer, const Fan& fan, Count& count) {
  PacketHits hits;
  tracer.closest(fan.packet(), hits);
  const std::uint64_t blocked = tracer.occluded(fan.packet());
  for (int i = 0; i < kPacketRays; ++i) {
    const SingleHit alone = tracer.closest(fan.ray(i));
    const bool is_hit = alone.primitive != kNoPrimitive;
    const bool is_same =
        hits.primitive[i] == alone.primitive &&
        std::bit_cast<std::uint32_t>(hits.t[i]) == std::bit_cast<std::uint32_t>(alone.t);
    count.different += is_same && (blocked >> i & 1u) == (is_hit ? 1u : 0u) ? 0u : 1u;
    count.hits += is_hit ? 1u : 0u;
    ++count.rays;
  }
}

std::shared_ptr<const PreparedScene> prepared(Mesh mesh) {
  auto built = PreparedScene::build(test::make_scene(std::move(mesh)), {});
  EXPECT_TRUE(built.is_ok());
  return *built;
}

struct Sliver {
  Vec3f a, b, c;
  float size;
  Vec3f middle;

  explicit Sliver(Choices& any) : size(any.power(-6, 6)) {
    if (any.below(2) == 0) middle = any.point(size * any.power(0, 4));
    a = middle + any.point(size);
    b = any.below(2) == 0 ? middle + any.point(size) : a + any.point(size * any.power(-3, 0));
    c = any.beside(b);
  }
  Mesh mesh(Choices& any) const {
    Mesh mesh;
    mesh.positions = {a, b, c};
    const unsigned first = any.below(3);
    mesh.triangles = {{first, (first + 1) % 3, (first + 2) % 3}};
    if (any.below(2) == 0) std::swap(mesh.triangles[0][0], mesh.triangles[0][1]);
    mesh.materials = {0};
    return mesh;
  }
  Vec3f any_origin(Choices& any) const {
    const Vec3f along = a + (b - a) * (4 * any.share() - 2);
    switch (any.below(4)) {
      case 0:
        return middle + any.point(2 * size);
      case 1:  // in the plane, as rounded
        return along + (c - a) * (any.sign() * any.power(0, 6));
      case 2:  // seen edge-on
        return any.beside(along + any.point(size));
      default:
        return any.beside(a);
    }
  }
  Vec3f target(Choices& any) const {
    const float x = any.share();
    switch (any.below(4)) {
      case 0:
        return a + (b - a) * x;
      case 1:
        return a + (c - a) * x;
      case 2:
        return a + (b - a) * x + (c - b) * (x * any.share());
      default:
        return any.below(2) == 0 ? b : (a + b) * 0.5f;
    }
  }
  Fan fan(Choices& any) const {
    Fan fan;
    fan.origin = any_origin(any);
    fan.t_min = any.below(2) == 0 ? 0 : 1e-4f;
    for (int i = 0; i < kPacketRays; ++i) {
      fan.direction[i] = (target(any) - fan.origin) * (any.below(4) == 0 ? 0.5f + any.share() : 1);
      fan.t_max[i] = any.below(8) == 0 ? 1 : kInfinity;
    }
    return fan;
  }
};

TEST(FanTriangles, SliversAreHitByFansAsByTheirRaysAlone) {
  for (const Isa isa : test::isas_here()) {
    Choices any(180);
    Count count;
    for (int round = 0; round < rounds(700); ++round) {
      const Sliver sliver(any);
      const auto scene = prepared(sliver.mesh(any));
      const SceneTracer tracer(scene->impl().index, kernels_for(isa));
      for (int k = 0; k < 4; ++k) compare(tracer, sliver.fan(any), count);
    }
    EXPECT_EQ(count.different, 0u) << isa_name(isa);
    EXPECT_GT(count.hits, count.rays / 8);
  }
}

TEST(FanTriangles, SliversAreHitWhereExactArithmeticSaysSo) {
  const Isa isa = widest_isa(supported_isas());
  Choices any(181);
  std::uint64_t different = 0;
  for (int round = 0; round < rounds(700); ++round) {
    const Sliver sliver(any);
    const Mesh mesh = sliver.mesh(any);
    float corners[9];
    for (int c = 0; c < 3; ++c) {
      for (int a = 0; a < 3; ++a)
        corners[3 * c + a] = mesh.positions[mesh.triangles[0][static_cast<std::size_t>(c)]][a];
    }
    const auto scene = prepared(mesh);
    const SceneTracer tracer(scene->impl().index, kernels_for(isa));
    Fan fan = sliver.fan(any);
    std::fill_n(fan.t_max, kPacketRays, kInfinity);
    PacketHits hits;
    tracer.closest(fan.packet(), hits);
    for (int i = 0; i < kPacketRays; ++i) {
      const SingleRay ray = fan.ray(i);
      const bool has_length =
          ray.direction[0] != 0 || ray.direction[1] != 0 || ray.direction[2] != 0;
      const ExactHit exact =
          has_length ? exact_hit(ray.origin, ray.direction, corners) : ExactHit{false, 0};
      // At t_min itself the rounded t decides.
      if (exact.is_hit && std::fabs(exact.t - fan.t_min) <= 1e-6f * fan.t_min) continue;
      const bool is_hit = exact.is_hit && exact.t >= fan.t_min;
      different += is_hit == (hits.primitive[i] != kNoPrimitive) ? 0u : 1u;
    }
  }
  EXPECT_EQ(different, 0u);
}

// A sliver a million times the size of a hall, whose B and C are a few roundings apart, seen nearly
// edge-on. A fan of long rays missed it once.
TEST(FanTriangles, LongRaysHitTheSliverOfTheHall) {
  Mesh mesh;
  mesh.positions = {{0x1.37a3cap+22f, 0x1.621e24p+21f, 0x1.f16232p+19f},
                    {0x1.3cc588p+22f, 0x1.634042p+21f, 0x1.f20cp+19f},
                    {0x1.3cc592p+22f, 0x1.63403ep+21f, 0x1.f20cp+19f}};
  mesh.triangles = {{0, 1, 2}};
  mesh.materials = {0};
  const auto scene = prepared(mesh);
  Fan fan;
  fan.origin = {0x1.73867ep+22f, 0x1.0dcba4p+23f, 0x1.9b40acp+20f};
  for (const float spread : {0.0f, 1e-7f, 1e-5f, 1e-3f, 0.1f}) {
    Choices any(182);
    for (int i = 0; i < kPacketRays; ++i) {
      const Vec3f d{-0x1.bd902p+19f, -0x1.6a11c8p+22f, -0x1.449482p+19f};
      for (int a = 0; a < 3; ++a)
        (&fan.direction[i].x)[a] = d[a] * (1 + (i == 10 ? 0 : spread * any.sign()));
      fan.t_max[i] = kInfinity;
    }
    for (const Isa isa : test::isas_here()) {
      const SceneTracer tracer(scene->impl().index, kernels_for(isa));
      PacketHits hits;
      tracer.closest(fan.packet(), hits);
      EXPECT_EQ(hits.primitive[10], 0u) << isa_name(isa) << " " << spread;
      Count count;
      compare(tracer, fan, count);
      EXPECT_EQ(count.different, 0u) << isa_name(isa) << " " << spread;
    }
  }
}

// Triangles of one plane, some of them twice and some a few roundings off.
Mesh stack(Choices& any, float size, Vec3f middle) {
  Mesh mesh;
  const Vec3f u = any.point(size), v = any.point(size);
  for (unsigned k = 0; k < 40; ++k) {
    const auto corner = [&] { return middle + u * any.sign() + v * any.sign(); };
    Vec3f c[3] = {corner(), corner(), corner()};
    if (any.below(3) == 0 && k > 0)
      std::copy_n(&mesh.positions[3 * static_cast<std::size_t>(any.below(k))], 3, c);
    for (Vec3f& p : c) mesh.positions.push_back(any.below(3) == 0 ? any.beside(p) : p);
    mesh.triangles.push_back({3 * k, 3 * k + 1, 3 * k + 2});
  }
  mesh.materials = {0};
  return mesh;
}

TEST(FanTriangles, OfAStackTheNearestIsTheOneOfItsRayAlone) {
  for (const Isa isa : test::isas_here()) {
    Choices any(183);
    Count count;
    for (int round = 0; round < rounds(150); ++round) {
      const float size = any.power(-5, 5);
      const Vec3f middle = any.below(2) == 0 ? Vec3f{} : any.point(size * any.power(0, 3));
      const auto scene = prepared(stack(any, size, middle));
      const SceneTracer tracer(scene->impl().index, kernels_for(isa));
      for (int k = 0; k < 4; ++k) {
        Fan fan;
        fan.origin = middle + any.point(size * any.power(-2, 1.5f));
        fan.t_min = any.below(3) == 0 ? 0.5f * any.share() : 0;
        const Vec3f target = middle + any.point(size * 0.3f);
        const float spread = any.power(-4, 0);
        for (int i = 0; i < kPacketRays; ++i) {
          fan.direction[i] = target + any.point(size * spread) - fan.origin;
          fan.t_max[i] = any.below(4) == 0 ? 1 : kInfinity;
        }
        compare(tracer, fan, count);
      }
    }
    EXPECT_EQ(count.different, 0u) << isa_name(isa);
    EXPECT_GT(count.hits, count.rays / 8);
  }
}

}  // namespace
}  // namespace tessera::core
