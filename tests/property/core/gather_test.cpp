// SPDX-License-Identifier: Apache-2.0
// Shadow rays of a VPL are told which triangles they cannot meet: the one that they leave and the
// one that they end on. That may save tests and must change no answer, in fans and alone, on every
// instruction set.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <memory>
#include <random>

#include "slave/core/surface/surface_offset.h"
#include "slave/core/trace/ray_groups.h"
#include "tests/support/packets.h"
#include "tests/support/seed.h"
#include "tests/support/test_meshes.h"

namespace tessera::core {
namespace {

// Tori of very different sizes, one of them far from the origin, and a plane that they stand on.
std::shared_ptr<const PreparedScene> make_scene() {
  Scene scene = test::make_scene(test::make_torus(60, 25));
  Instance moved;
  moved.object_to_world.m = {{{0.02f, 0, 0, 2}, {0, 0.02f, 0, 0.1f}, {0, 0, 0.02f, 1}}};
  scene.instances.push_back(moved);
  moved.object_to_world.m = {{{9, 0, 0, 9000}, {0, 9, 3, -40}, {0, 0, 9, 30}}};
  scene.instances.push_back(moved);
  Mesh plane;
  test::add_quad(plane, {-30, -1, -30}, {0, 0, 60}, {60, 0, 0}, 0);
  plane.materials = {0};
  scene.meshes.push_back(std::make_shared<const Mesh>(plane));
  scene.instances.push_back({1, {}});
  return *PreparedScene::build(scene, {});
}

// Finds points that rays from around `centre` hit.
void find_points(const PreparedScene::Impl& scene, const SceneTracer& tracer, std::mt19937& random,
                 Vec3f centre, float size, GatherPoints& to) {
  std::uniform_real_distribution<float> unit(-1, 1);
  RayPacket rays;
  for (int i = 0; i < kPacketRays; ++i) {
    for (int a = 0; a < 3; ++a) {
      rays.origin[a][i] = centre[a] + size * unit(random);
      rays.direction[a][i] = unit(random);
    }
    rays.t_min[i] = 0;
    rays.t_max[i] = 1e30f;
  }
  rays.active = ~std::uint64_t{0};
  PacketHits hits;
  PacketPoints met;
  tracer.closest(rays, hits);
  tracer.kernels().packet_points(scene.triangles.vertices.data(), rays, hits, met);
  for (std::uint64_t left = met.met; left != 0 && to.count < kGatherMax; left &= left - 1) {
    const int i = std::countr_zero(left), n = to.count++;
    for (int a = 0; a < 3; ++a) {
      to.point[a][n] = met.point[a][i];
      to.normal[a][n] = to.shading[a][n] = met.normal[a][i];
    }
    to.offset[n] = met.offset[i];
    to.horizon[n] = kPlaneHorizon;
    to.primitive[n] = (met.sliver >> i & 1u) != 0 ? kNoPrimitive : hits.primitive[i];
  }
}

LightPoint vpl_at(const GatherPoints& points, int i) {
  LightPoint light{};
  light.kind = LightPointKind::kSurface;
  for (int a = 0; a < 3; ++a) {
    light.normal[a] = points.normal[a][i];
    light.position[a] = points.point[a][i] + points.normal[a][i] * points.offset[i];
  }
  light.primitive = points.primitive[i];
  return light;
}

struct Compared {
  std::int64_t rays = 0, known = 0, wrong = 0;
};

// Compares a VPL's shadow rays with and without their excluded triangles, in fans and alone.
void compare(const SceneTracer& tracer, const LightPoint& light, const GatherRays& rays,
             Compared& sum) {
  ShadowFans fans{&rays.targets, {}, light.t_min, 1 - 4 * kUnitRoundoff};
  std::copy_n(light.position, 3, fans.origin);
  const int groups = rays.targets.group_count, count = rays.targets.count;
  const auto blocked = [&](int alone) {
    fans.habit = {};
    fans.habit.alone = alone;
    std::vector<std::uint64_t> bits(static_cast<std::size_t>(groups));
    tracer.occluded(fans, bits.data());
    return bits;
  };
  const auto count_wrong = [&](const std::vector<std::uint64_t>& a,
                               const std::vector<std::uint64_t>& b) {
    for (std::size_t g = 0; g < a.size(); ++g) sum.wrong += std::popcount(a[g] ^ b[g]);
  };
  const auto plain = blocked(groups);
  count_wrong(plain, blocked(0));
  fans.excluded_at_origin = rays.is_origin_excluded ? light.primitive : kNoPrimitive;
  fans.excluded_at_end = rays.excluded;
  count_wrong(plain, blocked(0));
  count_wrong(plain, blocked(groups));
  sum.rays += count;
  sum.known += std::count_if(rays.excluded, rays.excluded + count,
                             [](std::uint32_t triangle) { return triangle != kNoPrimitive; });
}

// Every seventh of the points becomes a VPL for all of them.
void compare_all(const SceneTracer& tracer, GatherPoints& points, GatherRays& rays, Compared& sum) {
  if (points.count == 0) return;
  tracer.kernels().bound_points(points);
  for (int i = 0; i < points.count; i += 7) {
    const LightPoint light = vpl_at(points, i);
    if (!tracer.kernels().begin_gather(points, light, 1e30f, rays)) continue;
    tracer.kernels().group_fans(rays.targets);
    compare(tracer, light, rays, sum);
  }
}

TEST(Gather, WhatShadowRaysAreKnownNotToMeetChangesNoAnswer) {
  const auto prepared = make_scene();
  const PreparedScene::Impl& scene = prepared->impl();
  for (const Isa isa : test::isas_here()) {
    const SceneTracer tracer(scene.index, kernels_for(isa));
    std::mt19937 random(test::seed(5));
    auto points = std::make_unique<GatherPoints>();
    auto rays = std::make_unique<GatherRays>();
    Compared sum;
    for (int round = 0; round < 200; ++round) {
      points->count = 0;
      const Vec3f centre = round % 4 == 0   ? Vec3f{9000, -40, 30}
                           : round % 4 == 1 ? Vec3f{2, 0.1f, 1}
                                            : Vec3f{0, 0, 0};
      const float size = round % 4 == 0 ? 9.0f : round % 4 == 1 ? 0.05f : 3.0f;
      for (int i = 0; i < 6; ++i) find_points(scene, tracer, random, centre, size, *points);
      compare_all(tracer, *points, *rays, sum);
    }
    EXPECT_GT(sum.rays, 150000) << isa_name(isa);
    EXPECT_GT(sum.known, sum.rays * 8 / 10) << isa_name(isa);
    EXPECT_EQ(sum.wrong, 0) << isa_name(isa);
  }
}

// The inner corner of a closed box, where points and VPLs are next to each other and to each
// other's planes. The further it is from the origin, the more their positions are rounded.
TEST(Gather, NorDoesItInCornersFarFromTheOrigin) {
  for (const float at : {0.0f, 1e3f, 1e5f}) {
    Scene scene = test::make_scene(test::make_cube());
    scene.instances[0].object_to_world.m = {
        {{1, 0, 0, at}, {0, 0.9f, 0.3f, at * 0.37f}, {0, -0.3f, 0.9f, -at * 0.71f}}};
    for (const Structure structure : {Structure::kBvh, Structure::kKd}) {
      BuildOptions options;
      options.structure = structure;
      const auto built = *PreparedScene::build(scene, options);
      const SceneTracer tracer(built->impl().index, kernels_for(test::isas_here().back()));
      std::mt19937 random(test::seed(6));
      auto points = std::make_unique<GatherPoints>();
      auto rays = std::make_unique<GatherRays>();
      Compared sum;
      for (int round = 0; round < 120; ++round) {
        points->count = 0;
        const float size = round % 2 == 0 ? 0.05f : 0.01f, e = 1 - size;
        const Vec3f corner = scene.instances[0].object_to_world.point({e, e, e});
        for (int i = 0; i < 6; ++i)
          find_points(built->impl(), tracer, random, corner, size, *points);
        compare_all(tracer, *points, *rays, sum);
      }
      EXPECT_GT(sum.rays, 400000) << at;
      EXPECT_EQ(sum.wrong, 0) << at;
    }
  }
}

// An excluded triangle does not block, whatever else of its leaf block the ray comes near.
TEST(Gather, ExcludedTrianglesDoNotBlock) {
  Mesh mesh;
  for (const float z : {0.0f, 3.0f}) {  // the ray ends before the second plane
    for (int i = 0; i < 4; ++i)
      test::add_quad(mesh, {static_cast<float>(i), 0, z}, {1, 0, 0}, {0, 1, 0}, 0);
  }
  mesh.materials = {0};
  const auto prepared = *PreparedScene::build(test::make_scene(mesh), {});
  for (const Isa isa : test::isas_here()) {
    const SceneTracer tracer(prepared->impl().index, kernels_for(isa));
    std::mt19937 random(test::seed(9));
    std::uniform_real_distribution<float> unit(0, 1);
    for (int i = 0; i < 20000; ++i) {
      const float x = 4 * unit(random);
      // Half of the rays pass next to the edge that the halves of a quad share.
      const float along = x - std::floor(x);
      const float y = i % 2 == 0 ? unit(random) : along + 1e-7f * (unit(random) - 0.5f);
      SingleRay ray{{x, y, -1}, {0, 0, 2}, 0, 1};
      const SingleHit hit = tracer.closest(ray);
      if (hit.primitive == kNoPrimitive) continue;
      ASSERT_TRUE(tracer.occluded(ray));
      ray.excluded[i % 2] = hit.primitive;
      ray.t_max = 0.75f;
      const bool is_on_edge = y == along || x == std::floor(x) || y == 0 || y == 1;
      ASSERT_TRUE(is_on_edge || !tracer.occluded(ray)) << isa_name(isa) << " " << x << " " << y;
    }
  }
}

// The computed normals of thin triangles are off, so a VPL that seems to be above one need not be.
TEST(Gather, NorDoesItForSlivers) {
  std::mt19937 random(test::seed(7));
  std::uniform_real_distribution<float> unit(-1, 1);
  const auto any = [&](float size) {
    return Vec3f{unit(random) * size, unit(random) * size, unit(random) * size};
  };
  auto points = std::make_unique<GatherPoints>();
  auto rays = std::make_unique<GatherRays>();
  int compared = 0, slivers = 0;
  for (int round = 0; round < 150; ++round) {
    const float thin = std::ldexp(1.0f, -5 - round % 11);
    Mesh mesh;
    mesh.materials = {0};
    for (std::uint32_t i = 0; i < 60; ++i) {
      const Vec3f a = any(100), along = normalize(any(1)), aside = normalize(any(1));
      mesh.positions.insert(mesh.positions.end(), {a, a + along, a + along * 0.5f + aside * thin});
      mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    const auto prepared = *PreparedScene::build(test::make_scene(mesh), {});
    const PreparedScene::Impl& scene = prepared->impl();
    const SceneTracer tracer(scene.index, kernels_for(test::isas_here().back()));
    for (std::uint32_t number = 0; number < 60 * 8; ++number) {
      const std::uint32_t t = number / 8;
      const Vec3f a = scene.triangles.vertex(t, 0), b = scene.triangles.vertex(t, 1) - a,
                  c = scene.triangles.vertex(t, 2) - a;
      const Vec3f n = normalize(cross(b, c)) * (number % 2 == 0 ? 1.0f : -1.0f);
      const SurfacePoint at = surface_point(a, b, c, n, 0.2f + 0.1f * unit(random), 0.5f);
      // The VPL is low over the computed plane, along the long side.
      const float away = 0.3f + 0.2f * unit(random);
      const float rise = 0x1p-12f * (1.6f + 0.5f * unit(random)) * away + 2 * at.offset;
      const Vec3f along = normalize(b) * (number % 4 < 2 ? 1.0f : -1.0f);
      const Vec3f from = at.point + (along - n * dot(n, along)) * away + n * rise;
      LightPoint light{};
      light.kind = LightPointKind::kSurface;
      points->count = 1;
      const Vec3f facing = normalize(at.point - from);
      for (int axis = 0; axis < 3; ++axis) {
        points->point[axis][0] = at.point[axis];
        points->normal[axis][0] = points->shading[axis][0] = n[axis];
        light.position[axis] = from[axis];
        light.normal[axis] = facing[axis];
      }
      points->offset[0] = at.offset;
      points->primitive[0] = is_sliver(b, c) ? kNoPrimitive : t;
      points->horizon[0] = kPlaneHorizon;
      slivers += is_sliver(b, c) ? 1 : 0;
      tracer.kernels().bound_points(*points);
      if (!tracer.kernels().begin_gather(*points, light, 1e30f, *rays)) continue;
      const auto& direction = rays->targets.direction;
      SingleRay ray{{from.x, from.y, from.z},
                    {direction[0][0], direction[1][0], direction[2][0]},
                    0,
                    1 - 4 * kUnitRoundoff};
      const bool plain = tracer.occluded(ray);
      ray.excluded[0] = rays->excluded[0];
      EXPECT_EQ(plain, tracer.occluded(ray)) << thin;
      ++compared;
    }
  }
  EXPECT_GT(compared, 50000);
  EXPECT_GT(slivers, 10000);
}

}  // namespace
}  // namespace tessera::core
