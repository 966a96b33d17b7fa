// Shadow rays of a VPL are told which triangles they cannot meet: the one that they leave and the one
// that they end on. That may save tests and must change no answer, in fans and alone, on every
// instruction set.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <memory>
#include <random>

#include "slave/core/trace/ray_groups.h"
#include "tests/support/packets.h"
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

// Points that rays from around `centre` meet.
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
    to.triangle[n] = hits.primitive[i];
  }
}

LightPoint vpl_at(const GatherPoints& points, int i) {
  LightPoint light{};
  light.kind = LightPointKind::kSurface;
  for (int a = 0; a < 3; ++a) {
    light.normal[a] = points.normal[a][i];
    light.position[a] = points.point[a][i] + points.normal[a][i] * points.offset[i];
  }
  light.triangle = points.triangle[i];
  return light;
}

// The rays of a VPL with and without what is known of them. Returns: rays of which something is.
int compare(const SceneTracer& tracer, const LightPoint& light, const GatherRays& rays) {
  int known = 0;
  FanPacket fan;
  for (int a = 0; a < 3; ++a) fan.origin[a] = light.position[a];
  fan.t_min = light.t_min;
  std::fill_n(fan.t_max, kPacketRays, 1 - 0x1p-22f);
  for (int g = 0; g < rays.targets.group_count; ++g) {
    fill_fan(rays.targets, g, fan);
    const int* const order = rays.targets.order + rays.targets.group[g];
    fan.unmet = {};
    const std::uint64_t plain = tracer.occluded(fan);
    fan.unmet = {rays.unmet, order, light.triangle, rays.are_all_unmet};
    EXPECT_EQ(plain, tracer.occluded(fan));
    for (std::uint64_t left = fan.active; left != 0; left &= left - 1) {
      const int i = std::countr_zero(left);
      const std::uint32_t own = rays.unmet[order[i]];
      if (own == kNoPrimitive) continue;
      ++known;
      SingleRay ray{{fan.origin[0], fan.origin[1], fan.origin[2]},
                    {fan.direction[0][i], fan.direction[1][i], fan.direction[2][i]},
                    fan.t_min,
                    fan.t_max[i],
                    {own, light.triangle}};
      EXPECT_EQ((plain >> i & 1u) != 0, tracer.occluded(ray)) << own << " " << light.triangle;
    }
  }
  return known;
}

TEST(Gather, WhatShadowRaysAreKnownNotToMeetChangesNoAnswer) {
  const auto prepared = make_scene();
  const PreparedScene::Impl& scene = prepared->impl();
  for (const Isa isa : test::isas_here()) {
    const SceneTracer tracer(scene.index, kernels_for(isa));
    std::mt19937 random(5);
    auto points = std::make_unique<GatherPoints>();
    auto rays = std::make_unique<GatherRays>();
    std::int64_t known = 0, all = 0;
    for (int round = 0; round < 400; ++round) {
      points->count = 0;
      const Vec3f centre = round % 4 == 0   ? Vec3f{9000, -40, 30}
                           : round % 4 == 1 ? Vec3f{2, 0.1f, 1}
                                            : Vec3f{0, 0, 0};
      const float size = round % 4 == 0 ? 9.0f : round % 4 == 1 ? 0.05f : 3.0f;
      for (int i = 0; i < 6; ++i) find_points(scene, tracer, random, centre, size, *points);
      if (points->count == 0) continue;
      tracer.kernels().bound_points(*points);
      for (int i = 0; i < points->count; i += 7) {
        const LightPoint light = vpl_at(*points, i);
        if (!tracer.kernels().begin_gather(*points, light, 1e30f, *rays)) continue;
        tracer.kernels().group_fans(rays->targets);
        all += rays->targets.count;
        known += compare(tracer, light, *rays);
      }
    }
    EXPECT_GT(all, 300000) << isa_name(isa);
    EXPECT_GT(known, all * 8 / 10) << isa_name(isa);
  }
}

}  // namespace
}  // namespace tessera::core
