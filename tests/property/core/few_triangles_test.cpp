// SPDX-License-Identifier: Apache-2.0
// Property: in structures of so few triangles that every ray is tested against all of them, and in
// those of some more, packets answer as rays do by themselves, to the bit, on every instruction
// set, at all scales: rays at corners and edges, from the surfaces themselves, with limits at their
// hits, at triangles that lie in one plane or in one place.
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

using Random = std::mt19937;

float between(Random& random, float low, float high) {
  return std::uniform_real_distribution<float>(low, high)(random);
}
Vec3f point_in_cube(Random& random, float edge) {
  return {between(random, -edge, edge), between(random, -edge, edge), between(random, -edge, edge)};
}

void add_triangle(Mesh& mesh, Vec3f a, Vec3f b, Vec3f c) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  mesh.positions.insert(mesh.positions.end(), {a, b, c});
  mesh.triangles.push_back({first, first + 1, first + 2});
  mesh.materials.push_back(0);
}

// Triangles of all shapes: large ones, small ones, slivers, neighbours in one plane, and copies.
Mesh few_triangles(Random& random, std::size_t count, float scale) {
  Mesh mesh;
  const Vec3f middle = point_in_cube(random, 3 * scale);
  while (mesh.triangles.size() < count) {
    const Vec3f a = middle + point_in_cube(random, scale);
    const float size = random() % 3 == 0 ? 0.01f * scale : scale;
    const Vec3f b = a + point_in_cube(random, size), c = a + point_in_cube(random, size);
    switch (random() % 4) {
      case 0:  // two halves of a parallelogram
        add_triangle(mesh, a, b, c);
        if (mesh.triangles.size() < count) add_triangle(mesh, c, b, b + c - a);
        break;
      case 1:  // in one place
        add_triangle(mesh, a, b, c);
        if (mesh.triangles.size() < count) add_triangle(mesh, b, c, a);
        break;
      case 2:
        add_triangle(mesh, a, b, b + (c - b) * 1e-5f);
        break;
      default:
        add_triangle(mesh, a, b, c);
    }
  }
  return mesh;
}

Vec3f point_on(Random& random, const Mesh& mesh) {
  const auto& corner = mesh.triangles[random() % mesh.triangles.size()];
  const auto at = [&](std::size_t c) { return mesh.positions[corner[c]]; };
  const float u = random() % 4 == 0 ? 0 : between(random, 0, 1);
  const float v = random() % 4 == 0 ? 0 : between(random, 0, 1 - u);
  return at(0) + (at(1) - at(0)) * u + (at(2) - at(0)) * v;
}

std::vector<test::Ray> rays_at(Random& random, const Mesh& mesh, std::size_t count, float scale) {
  std::vector<test::Ray> rays;
  for (std::size_t i = 0; i < count; ++i) {
    test::Ray ray{{}, {}, 0, Bounds3f::kInf};
    ray.origin = random() % 2 == 0 ? point_on(random, mesh) : point_in_cube(random, 5 * scale);
    ray.direction = point_on(random, mesh) - ray.origin;
    if (random() % 2 == 0)
      ray.direction = mesh.positions[random() % mesh.positions.size()] - ray.origin;
    switch (random() % 16) {
      case 0:
        ray.t_min = between(random, 0, 1);
        break;
      case 1:
        ray.t_max = 1;  // some hits lie there
        break;
      case 2:
        ray.t_min = -2;
        break;
      case 3:
        ray.direction.y = 0;
        break;
      case 4:
        ray.direction = ray.direction * 0x1p-60f;
        break;
      case 5:
        ray.origin = ray.origin * 0x1p40f;
        break;
      case 6:
        ray.direction.x = std::numeric_limits<float>::quiet_NaN();
        break;
      case 7:
        ray.t_max = -1;
        break;
      default:
        break;
    }
    rays.push_back(ray);
  }
  return rays;
}

// Sets the limits of every other ray to its hit, or to the number beside it.
void put_limits_at_hits(Random& random, const PreparedScene::Impl& scene,
                        std::vector<test::Ray>& rays) {
  for (std::size_t i = 0; i < rays.size(); i += 2) {
    const test::Hit hit = test::trace_single(kernels_for(Isa::kScalar), scene, rays[i]);
    if (!hit.is_hit()) continue;
    const float beside = std::nextafter(hit.t, random() % 2 == 0 ? 0 : Bounds3f::kInf);
    (random() % 2 == 0 ? rays[i].t_min : rays[i].t_max) = random() % 2 == 0 ? hit.t : beside;
  }
}

std::string text_of(const test::Ray& ray) {
  std::ostringstream text;
  text << std::hexfloat;
  for (const float x : {ray.origin.x, ray.origin.y, ray.origin.z, ray.direction.x, ray.direction.y,
                        ray.direction.z, ray.t_min, ray.t_max})
    text << x << " ";
  return text.str();
}

bool is_same(const test::Hit& a, const test::Hit& b) {
  return a.primitive == b.primitive &&
         std::bit_cast<std::uint32_t>(a.t) == std::bit_cast<std::uint32_t>(b.t);
}

struct Counts {
  std::size_t hits = 0, misses = 0;
};

void compare(const PreparedScene::Impl& scene, const std::vector<test::Ray>& rays, Counts& counts) {
  for (const Isa isa : test::isas_here()) {
    const std::vector<test::Hit> together = test::trace_packets(kernels_for(isa), scene, rays);
    const SceneTracer tracer(scene.index, kernels_for(isa));
    std::uint64_t blocked = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const test::Hit alone = test::trace_single(kernels_for(Isa::kScalar), scene, rays[i]);
      ASSERT_TRUE(is_same(alone, together[i]))
          << isa_name(isa) << ": " << together[i].primitive << " at " << together[i].t << ", not "
          << alone.primitive << " at " << alone.t << ": " << text_of(rays[i]);
      if (i % kPacketRays == 0) blocked = tracer.occluded(test::make_packet(rays, i));
      ASSERT_EQ(alone.is_hit(), (blocked >> i % kPacketRays & 1u) != 0)
          << isa_name(isa) << ": " << text_of(rays[i]);
      ++(alone.is_hit() ? counts.hits : counts.misses);
    }
  }
}

TEST(FewTriangles, AnswerAsRaysAloneDo) {
  Random random(test::seed(31));
  Counts counts;
  for (const std::size_t count : {1u, 2u, 7u, 16u, 33u, 63u, 64u, 65u, 90u}) {
    for (const float scale : {1e-12f, 1e-6f, 0.01f, 1.0f, 300.0f, 1e6f, 1e12f}) {
      const Mesh mesh = few_triangles(random, count, scale);
      const auto scene = PreparedScene::build(test::make_scene(mesh), {});
      ASSERT_TRUE(scene.is_ok());
      std::vector<test::Ray> rays = rays_at(random, mesh, 10 * kPacketRays + 17, scale);
      put_limits_at_hits(random, (*scene)->impl(), rays);
      compare((*scene)->impl(), rays, counts);
      if (HasFatalFailure()) return;
    }
  }
  EXPECT_GT(counts.hits, counts.misses / 8);
  EXPECT_GT(counts.misses, counts.hits / 8);
}

}  // namespace
}  // namespace tessera::core
