// SPDX-License-Identifier: Apache-2.0
// Property: a ray from inside a closed mesh, aimed at a shared vertex or edge, never gets out; on
// every instruction set, in bundles, far from the origin of the world, at small and large scale.
#include <gtest/gtest.h>

#include <random>

#include "slave/core/scene/prepared_scene_impl.h"
#include "tests/support/packets.h"
#include "tests/support/seed.h"
#include "tests/support/test_meshes.h"

namespace tessera::core {
namespace {

struct Case {
  const char* name;
  Mesh mesh;
  Vec3f inside;       // a point well inside, before placing
  float free_radius;  // origins are drawn from a cube of this half edge around it
};

std::vector<Case> closed_meshes() {
  return {{"cube", test::make_cube(), {0, 0, 0}, 0.8f},
          {"icosphere", test::make_icosphere(4), {0, 0, 0}, 0.5f},
          {"torus", test::make_torus(90, 40), {1, 0, 0}, 0.2f}};
}

// A point on an edge, rounded to float32: often exactly a vertex or the middle, else anywhere.
Vec3f point_on_edge(const Mesh& mesh, std::mt19937& random) {
  const auto& t = mesh.triangles[random() % mesh.triangles.size()];
  const std::size_t k = random() % 3;
  const Vec3f a = mesh.positions[t[k]], b = mesh.positions[t[(k + 1) % 3]];
  switch (random() % 4) {
    case 0:
      return a;
    case 1:
      return (a + b) * 0.5f;
    default:
      return a + (b - a) * std::uniform_real_distribution<float>(0, 1)(random);
  }
}

// Rays of one bundle share their origin every other time, as camera rays do.
std::vector<test::Ray> aimed_rays(const Mesh& mesh, Vec3f centre, float radius, std::size_t count,
                                  std::mt19937& random) {
  std::uniform_real_distribution<float> offset(-radius, radius);
  std::vector<test::Ray> rays;
  Vec3f origin = centre;
  for (std::size_t i = 0; i < count; ++i) {
    const bool is_shared = (i / kPacketRays) % 2 == 0;
    if (!is_shared || i % kPacketRays == 0) {
      origin = centre + Vec3f{offset(random), offset(random), offset(random)};
      // Now and then the origin lies in planes of symmetry, where splits and edges are.
      if (random() % 8 == 0) origin = centre;
    }
    rays.push_back({origin, point_on_edge(mesh, random) - origin, 0, Bounds3f::kInf});
  }
  return rays;
}

std::size_t leaks(const Mesh& mesh, const PreparedScene::Impl& scene, const KernelTable& kernels,
                  Vec3f centre, float radius, std::size_t count, std::uint32_t seed) {
  std::mt19937 random(test::seed(seed));
  std::size_t leak_count = 0;
  for (std::size_t done = 0; done < count; done += 4096) {
    const std::vector<test::Ray> rays = aimed_rays(mesh, centre, radius, 4096, random);
    const std::vector<test::Hit> hits = test::trace_packets(kernels, scene, rays);
    for (std::size_t i = 0; i < rays.size(); ++i) {
      if (hits[i].is_hit()) continue;
      if (++leak_count > 3) continue;
      const Vec3f o = rays[i].origin, d = rays[i].direction;
      ADD_FAILURE() << std::hexfloat << "leak, seed " << seed << ": " << o.x << " " << o.y << " "
                    << o.z << " to " << d.x << " " << d.y << " " << d.z;
    }
  }
  return leak_count;
}

struct Place {
  float scale;
  Vec3f offset;
};

TEST(Watertight, NoRayFromInsideLeaksThroughASharedEdgeOrVertex) {
  const Place places[] = {{1, {0, 0, 0}},
                          {1, {1e4f, -3e4f, 2e4f}},
                          {1e-6f, {0, 0, 0}},
                          {1e6f, {0, 0, 0}},
                          {3e3f, {1e6f, 1e6f, -1e6f}}};
  std::size_t total = 0;
  for (const Case& c : closed_meshes()) {
    for (const Place& place : places) {
      Mesh mesh = c.mesh;
      test::place(mesh, place.scale, place.offset);
      const Vec3f centre = c.inside * place.scale + place.offset;
      const auto scene = PreparedScene::build(test::make_scene(mesh), {});
      ASSERT_TRUE(scene.is_ok());
      for (const Isa isa : test::isas_here()) {
        SCOPED_TRACE(std::string(c.name) + " scale " + std::to_string(place.scale) + " " +
                     std::string(isa_name(isa)));
        // 10^6 rays in all for each instruction set.
        const std::size_t count = 17 * 4096;
        EXPECT_EQ(0u, leaks(mesh, (*scene)->impl(), kernels_for(isa), centre,
                            c.free_radius * place.scale, count, 77));
        total += count;
      }
    }
  }
  RecordProperty("rays", static_cast<int>(total));
}

TEST(Watertight, AxisParallelRaysInEdgesAndSplitPlanesDoNotLeak) {
  // A cube of grid cells: every vertex, edge and split plane lies on multiples of 1/8, and so do
  // the rays.
  Mesh mesh = test::make_cube();
  const auto scene = PreparedScene::build(test::make_scene(mesh), {});
  ASSERT_TRUE(scene.is_ok());
  const float zeros[] = {0.0f, -0.0f, 1e-45f, -1e-45f, 1e-40f, -1e-38f};
  for (const Isa isa : test::isas_here()) {
    for (int axis = 0; axis < 3; ++axis) {
      for (const float sign : {1.0f, -1.0f, 1e-30f, -1e30f, 1e-42f}) {
        for (int i = -7; i <= 7; ++i) {
          for (int j = -8; j <= 8; ++j) {  // 8: within the face itself
            float o[3] = {}, d[3] = {};
            o[(axis + 1) % 3] = static_cast<float>(i) / 8;
            o[(axis + 2) % 3] = static_cast<float>(j) / 8;
            d[axis] = sign;
            // Components that are zero or too small to matter next to the main one.
            d[(axis + 1) % 3] = std::fabs(sign) < 1e-20f ? 0.0f : zeros[(i + 7) % 6];
            d[(axis + 2) % 3] = std::fabs(sign) < 1e-20f ? -0.0f : zeros[(j + 8) % 6];
            const test::Ray ray{{o[0], o[1], o[2]}, {d[0], d[1], d[2]}, 0, Bounds3f::kInf};
            EXPECT_TRUE(test::trace_single(kernels_for(isa), (*scene)->impl(), ray).is_hit())
                << isa_name(isa) << " axis " << axis << " sign " << sign << " at " << i << " " << j;
          }
        }
      }
    }
  }
}

}  // namespace
}  // namespace tessera::core
