// SPDX-License-Identifier: Apache-2.0
// Property: rays in a closed mesh that is flatter than what a filter in float32 tells cost no more
// exact decisions than a few times those in its round like, although they pass next to the edges of
// all triangles above and below their way; and none of them leaks.
//
// Decisions are counted, since times judge nothing here: the linker leads the kernels' calls of
// exact_hit() and is_exact_hit() through this file (--wrap, see CMakeLists.txt).
#include <gtest/gtest.h>

#include <atomic>

#include "slave/core/primitive/triangle/exact_hit_abi.h"
#include "tests/support/choices.h"
#include "tests/support/packets.h"
#include "tests/support/test_meshes.h"

namespace tessera::core {

namespace {
std::atomic<std::uint64_t> decisions{0};
}  // namespace

using Decide = ExactHit(const float*, const float*, const float*);
using DecideOnly = bool(const float*, const float*, const float*);
Decide kept_hit asm("__real__ZN7tessera4core9exact_hitEPKfS2_S2_");
Decide counted_hit asm("__wrap__ZN7tessera4core9exact_hitEPKfS2_S2_");
DecideOnly kept_is_hit asm("__real__ZN7tessera4core12is_exact_hitEPKfS2_S2_");
DecideOnly counted_is_hit asm("__wrap__ZN7tessera4core12is_exact_hitEPKfS2_S2_");

ExactHit counted_hit(const float* origin, const float* direction, const float* triangle) {
  ++decisions;
  return kept_hit(origin, direction, triangle);
}
bool counted_is_hit(const float* origin, const float* direction, const float* triangle) {
  ++decisions;
  return kept_is_hit(origin, direction, triangle);
}

namespace {

// An ellipsoid of radii 1, 1 and `thickness`, along the axes or turned.
struct Ellipsoid {
  float thickness;
  bool is_turned;

  Vec3f placed(Vec3f p) const {
    p.z *= thickness;
    if (!is_turned) return p;
    const Vec3f q{0.8f * p.x - 0.6f * p.z, p.y, 0.6f * p.x + 0.8f * p.z};
    return {0.8f * q.x - 0.6f * q.y, 0.6f * q.x + 0.8f * q.y, q.z};
  }
  Mesh mesh() const {
    Mesh mesh = test::make_icosphere(3);
    for (Vec3f& p : mesh.positions) p = placed(p);
    return mesh;
  }
};

// Decisions a ray, by the way that it went.
struct Costs {
  double single = 0, bundle = 0, many = 0, any_hit = 0, fan = 0;
  double most() const { return std::max({single, bundle, many, any_hit, fan}); }
};

// Packets from a point inside and from points next to it, to points of edges.
Costs costs_of(const Ellipsoid& ellipsoid, Isa isa, std::uint64_t& leaks) {
  constexpr int kPackets = 40;
  test::Choices any(186);
  const Mesh mesh = ellipsoid.mesh();
  const auto scene = PreparedScene::build(test::make_scene(mesh), {});
  const SceneTracer tracer((*scene)->impl().index, kernels_for(isa));
  const auto target = [&] {
    const auto& t = mesh.triangles[any.below(static_cast<unsigned>(mesh.triangles.size()))];
    const unsigned k = any.below(3);
    const Vec3f a = mesh.positions[t[k]], b = mesh.positions[t[(k + 1) % 3]];
    return any.one_in(4) ? a : a + (b - a) * any.share();
  };
  Costs costs;
  const auto counted = [](double& cost, const auto& trace) {
    const std::uint64_t before = decisions;
    trace();
    cost += static_cast<double>(decisions - before) / (kPackets * kPacketRays);
  };
  for (int k = 0; k < kPackets; ++k) {
    FanPacket fan{};
    RayPacket packet{};
    fan.active = packet.active = ~std::uint64_t{0};
    const Vec3f inside = any.point(0.5f), middle = target();
    for (int i = 0; i < kPacketRays; ++i) {
      Vec3f to = target();
      while (length(to - middle) > 0.25f) to = target();
      const Vec3f from = ellipsoid.placed(inside + any.point(0.01f));
      for (int a = 0; a < 3; ++a) {
        fan.origin[a] = ellipsoid.placed(inside)[a];
        fan.direction[a][i] = to[a] - fan.origin[a];
        packet.origin[a][i] = from[a];
        packet.direction[a][i] = to[a] - from[a];
      }
      fan.t_max[i] = packet.t_max[i] = Bounds3f::kInf;
    }
    PacketHits hits;
    counted(costs.fan, [&] { tracer.closest(fan, hits); });
    for (const std::uint32_t hit : hits.primitive) leaks += hit == kNoPrimitive ? 1u : 0u;
    counted(costs.bundle, [&] { tracer.closest(packet, hits); });
    for (const std::uint32_t hit : hits.primitive) leaks += hit == kNoPrimitive ? 1u : 0u;
    packet.habit = {};
    counted(costs.any_hit, [&] { leaks += tracer.occluded(packet) != packet.active ? 1u : 0u; });
    packet.habit.alone = 1;  // its rays fly, or go one by one
    counted(costs.many, [&] { tracer.closest(packet, hits); });
    counted(costs.single, [&] {
      for (std::size_t i = 0; i < kPacketRays; ++i) {
        const auto at = [&](const auto& v, std::size_t a) { return v[a][i]; };
        const SingleRay ray{
            {at(packet.origin, 0), at(packet.origin, 1), at(packet.origin, 2)},
            {at(packet.direction, 0), at(packet.direction, 1), at(packet.direction, 2)},
            0,
            Bounds3f::kInf};
        leaks += tracer.closest(ray).primitive == kNoPrimitive ? 1u : 0u;
      }
    });
  }
  return costs;
}

// In the round mesh a ray aimed at an edge or a corner needs two decisions. kMost is what the
// flattest mesh may need; before planes were looked at in lanes it needed 118.
TEST(FlatMesh, TakesFewExactDecisionsARay) {
  constexpr double kMost = 12;
  for (const Isa isa : test::isas_here()) {
    for (const bool is_turned : {false, true}) {
      for (const float thickness : {1.0f, 1e-2f, 1e-4f, 1e-5f, 1e-6f, 1e-7f, 1e-8f, 1e-10f}) {
        // A turned mesh that is thinner than the roundings of its corners is no ellipsoid.
        if (is_turned && thickness < 1e-6f) continue;
        std::uint64_t leaks = 0;
        const Costs costs = costs_of({thickness, is_turned}, isa, leaks);
        EXPECT_LE(costs.most(), kMost)
            << isa_name(isa) << (is_turned ? " turned " : " ") << thickness << ": single "
            << costs.single << ", bundle " << costs.bundle << ", many " << costs.many
            << ", any hit " << costs.any_hit << ", fan " << costs.fan;
        EXPECT_EQ(leaks, 0u) << isa_name(isa) << " " << thickness;
      }
    }
  }
  EXPECT_GT(decisions, 0u);  // they are counted
}

}  // namespace
}  // namespace tessera::core
