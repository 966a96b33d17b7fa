// SPDX-License-Identifier: Apache-2.0
// Property: a ray's answer is the same to the bit alone, in a packet, among any companions (even
// invalid ones), and on every instruction set.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <limits>
#include <random>
#include <sstream>

#include "slave/core/scene/prepared_scene_impl.h"
#include "tests/support/packets.h"
#include "tests/support/seed.h"
#include "tests/support/test_meshes.h"

namespace tessera::core {
namespace {

std::string text_of(const test::Ray& ray) {
  std::ostringstream out;
  out << std::hexfloat << ray.origin.x << " " << ray.origin.y << " " << ray.origin.z << " to "
      << ray.direction.x << " " << ray.direction.y << " " << ray.direction.z;
  return out.str();
}

// Rays of all kinds: coherent, incoherent, aimed at vertices, along axes, short, invalid.
std::vector<test::Ray> mixed_rays(const Mesh& mesh, std::size_t count, std::uint32_t seed) {
  std::mt19937 random(test::seed(seed));
  std::uniform_real_distribution<float> unit(-1, 1);
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = Bounds3f::kInf;
  std::vector<test::Ray> rays;
  const Vec3f eye{0.1f, 0.2f, 3};
  for (std::size_t i = 0; i < count; ++i) {
    const bool is_coherent = (i / 32) % 2 == 0;
    test::Ray ray{eye, {0.1f * unit(random), 0.1f * unit(random), -1}, 0, inf};
    if (!is_coherent) {
      ray.origin = {unit(random), unit(random), unit(random)};
      ray.direction = {unit(random), unit(random), unit(random)};
    }
    switch (random() % 12) {
      case 0:
        ray.direction = mesh.positions[random() % mesh.positions.size()] - ray.origin;
        break;
      case 1:
        ray.direction.x = random() % 2 ? 0.0f : -0.0f;
        break;
      case 2:
        ray.direction.y = ray.direction.x = 0;
        break;
      case 3:
        ray.t_min = 0.1f;
        ray.t_max = 0.4f;
        break;
      case 4:
        if (random() % 2) ray.origin.x = nan;
        if (random() % 2) ray.direction.z = inf;
        if (random() % 2) ray.t_max = nan;
        break;
      default:
        break;
    }
    rays.push_back(ray);
  }
  return rays;
}

bool is_same(const test::Hit& a, const test::Hit& b) {
  const auto bits = [](float x) { return std::bit_cast<std::uint32_t>(x); };
  return a.primitive == b.primitive && bits(a.t) == bits(b.t) && bits(a.u) == bits(b.u) &&
         bits(a.v) == bits(b.v);
}

TEST(Companions, AnswerIsTheSameAloneAndInBundlesOnEveryInstructionSet) {
  const Mesh meshes[] = {test::make_icosphere(4), test::make_random_triangles(4000, 0.15f, 2),
                         test::make_terrain(60, 1)};
  for (const Mesh& mesh : meshes) {
    const auto scene = PreparedScene::build(test::make_scene(mesh), {});
    ASSERT_TRUE(scene.is_ok());
    const PreparedScene::Impl& view = (*scene)->impl();
    const std::vector<test::Ray> rays = mixed_rays(mesh, 16 * 800, 11);
    const std::vector<test::Hit> first = test::trace_packets(kernels_for(Isa::kScalar), view, rays);
    std::size_t hit_count = 0;
    for (const Isa isa : test::isas_here()) {
      const std::vector<test::Hit> bundled = test::trace_packets(kernels_for(isa), view, rays);
      for (std::size_t i = 0; i < rays.size(); ++i) {
        const test::Hit alone = test::trace_single(kernels_for(isa), view, rays[i]);
        ASSERT_TRUE(is_same(alone, bundled[i]))
            << isa_name(isa) << " ray " << i << ": " << text_of(rays[i]);
        ASSERT_TRUE(is_same(first[i], bundled[i]))
            << isa_name(isa) << " ray " << i << ": " << text_of(rays[i]);
        hit_count += alone.is_hit() ? 1u : 0u;
      }
    }
    EXPECT_GT(hit_count, rays.size() / 4);
  }
}

TEST(Companions, OccludedIsTrueExactlyWhereClosestHits) {
  const Mesh mesh = test::make_random_triangles(4000, 0.15f, 2);
  const auto scene = PreparedScene::build(test::make_scene(mesh), {});
  ASSERT_TRUE(scene.is_ok());
  const PreparedScene::Impl& view = (*scene)->impl();
  const std::vector<test::Ray> rays = mixed_rays(mesh, 16 * 1500, 12);
  for (const Isa isa : test::isas_here()) {
    const std::vector<test::Hit> hits = test::trace_packets(kernels_for(isa), view, rays);
    const SceneTracer tracer(view.index, kernels_for(isa));
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const std::uint64_t blocked =
          tracer.occluded(test::make_packet(rays, i / kPacketRays * kPacketRays));
      ASSERT_EQ(hits[i].is_hit(), (blocked >> i % kPacketRays & 1u) != 0)
          << isa_name(isa) << " ray " << i;
    }
  }
}

// Rays in flight remember few boxes; one that meets more is traced by itself. Here every ray passes
// the boxes of all primitives, and half of the rays no primitive.
TEST(Companions, RaysThatMeetMoreBoxesThanAFlightRemembersAreTracedAlone) {
  std::mt19937 random(test::seed(7));
  std::uniform_real_distribution<float> unit(0, 1);
  Mesh mesh;
  for (std::uint32_t i = 0; i < 30000; ++i) {
    const float z = unit(random), size = 1 + unit(random);
    mesh.positions.insert(mesh.positions.end(),
                          {{size, 0, z - 3}, {0, size, z + 3}, {size, size, z}});
    mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    mesh.materials.push_back(0);
  }
  const auto scene = PreparedScene::build(test::make_scene(mesh), {});
  ASSERT_TRUE(scene.is_ok());
  std::vector<test::Ray> rays;
  for (int i = 0; i < 2 * kPacketRays; ++i) {
    const float at = i % 2 == 0 ? 0.4f : 0.8f, side = i % 4 < 2 ? 1.0f : -1.0f;
    rays.push_back({{at * unit(random), at * unit(random), -9 * side}, {0, 0, side}, 0, 99});
  }
  for (const Isa isa : test::isas_here()) {
    const PreparedScene::Impl& view = (*scene)->impl();
    const std::vector<test::Hit> together = test::trace_packets(kernels_for(isa), view, rays);
    const SceneTracer tracer(view.index, kernels_for(isa));
    std::uint64_t blocked = 0;
    int misses = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const test::Hit alone = test::trace_single(kernels_for(isa), view, rays[i]);
      ASSERT_TRUE(is_same(alone, together[i])) << isa_name(isa) << " ray " << i;
      if (i % kPacketRays == 0) blocked = tracer.occluded(test::make_packet(rays, i));
      ASSERT_EQ(alone.is_hit(), (blocked >> i % kPacketRays & 1u) != 0)
          << isa_name(isa) << " " << i;
      misses += alone.is_hit() ? 0 : 1;
    }
    EXPECT_GT(misses, kPacketRays / 2);
    EXPECT_LT(misses, 2 * kPacketRays - 8);
  }
}

TEST(Companions, InvalidRaysAreMisses) {
  const auto scene = PreparedScene::build(test::make_scene(test::make_cube()), {});
  ASSERT_TRUE(scene.is_ok());
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = Bounds3f::kInf;
  const test::Ray invalid[] = {{{nan, 0, 0}, {0, 0, 1}, 0, inf}, {{0, -inf, 0}, {0, 0, 1}, 0, inf},
                               {{0, 0, 0}, {0, nan, 1}, 0, inf}, {{0, 0, 0}, {0, 0, inf}, 0, inf},
                               {{0, 0, 0}, {0, 0, 0}, 0, inf},   {{0, 0, 0}, {-0.0f, 0, 0}, 0, inf},
                               {{0, 0, 0}, {0, 0, 1}, nan, inf}, {{0, 0, 0}, {0, 0, 1}, 0, nan},
                               {{0, 0, 0}, {0, 0, 1}, 3, 2}};
  for (const Isa isa : test::isas_here()) {
    for (const test::Ray& ray : invalid) {
      const test::Hit hit = test::trace_single(kernels_for(isa), (*scene)->impl(), ray);
      EXPECT_FALSE(hit.is_hit()) << isa_name(isa) << " " << text_of(ray);
      EXPECT_EQ(0.0f, hit.t);
    }
    const test::Ray sound{{0, 0, 0}, {0, 0, 2}, 0, 0.5f};  // the limit is part of the range
    const test::Hit hit = test::trace_single(kernels_for(isa), (*scene)->impl(), sound);
    EXPECT_TRUE(hit.is_hit());
    EXPECT_EQ(0.5f, hit.t);
  }
}

TEST(Companions, LowestPrimitiveWinsAtEqualDistance) {
  Mesh mesh = test::make_terrain(30, 5);
  const auto once = mesh.triangles;
  mesh.triangles.insert(mesh.triangles.end(), once.begin(), once.end());  // every triangle twice
  const auto scene = PreparedScene::build(test::make_scene(mesh), {});
  ASSERT_TRUE(scene.is_ok());
  std::mt19937 random(test::seed(3));
  std::uniform_real_distribution<float> unit(-0.9f, 0.9f);
  for (const Isa isa : test::isas_here()) {
    for (int i = 0; i < 2000; ++i) {
      const test::Ray ray{{unit(random), 2, unit(random)}, {0, -1, 0}, 0, Bounds3f::kInf};
      const test::Hit hit = test::trace_single(kernels_for(isa), (*scene)->impl(), ray);
      ASSERT_TRUE(hit.is_hit());
      ASSERT_LT(hit.primitive, once.size());
    }
  }
}

}  // namespace
}  // namespace tessera::core
