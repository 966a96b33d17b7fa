// SPDX-License-Identifier: Apache-2.0
// Property: single rays and packets, on every instruction set and in all structures, give
// one answer, the same to the bit; it is the one that exact arithmetic on every triangle gives.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <random>
#include <sstream>
#include <string>

#include "slave/core/primitive/primitive_index.h"
#include "slave/core/primitive/triangle/exact_hit_abi.h"
#include "slave/core/primitive/triangle/triangle_clipper.h"
#include "slave/core/primitive/triangle/triangle_store.h"
#include "slave/core/ray/fan_of.h"
#include "slave/core/trace/scene_tracer.h"
#include "tests/support/packets.h"
#include "tests/support/seed.h"
#include "tests/support/test_meshes.h"

namespace tessera::core {
namespace {

struct Prepared {
  std::vector<Bounds3f> boxes;
  TriangleStore store;
  IndexedBvh<8> bvh8;
  IndexedBvh<16> bvh16, cut_bvh16;
  IndexedKd<8> kd8;
  IndexedKd<16> kd16;

  explicit Prepared(const Mesh& mesh) {
    store = make_triangle_store(test::make_scene(mesh), boxes);
    bvh8 = std::move(*index_by_bvh<8>(boxes, store.vertices, {1, nullptr}));
    bvh16 = std::move(*index_by_bvh<16>(boxes, store.vertices, {1, nullptr}));
    // A fine tree, which has more planes for rays to go wrong at than the default.
    KdBuildConfig fine;
    fine.cost_intersect = 4;
    kd8 = std::move(*index_by_kd<8>(boxes, store.vertices, {1, nullptr}, fine));
    // A tree whose triangles are clipped, finer than the default, too.
    const TriangleClipper clipper(store.vertices);
    // And a hierarchy whose triangles are cut wherever there is room for it.
    BvhBuildConfig spatial = spatial_build(clipper);
    spatial.cuts_max = 0.5f;
    spatial.overlap_min = 0;
    spatial.overlap_share = 0;
    spatial.cut_weight = 0.5f;
    spatial.cuts_have_to_pay = false;
    cut_bvh16 = std::move(*index_by_bvh<16>(boxes, store.vertices, {1, nullptr}, spatial));
    KdBuildConfig cut = quality_build(clipper);
    cut.cost_intersect = 1;
    kd16 = std::move(*index_by_kd<16>(boxes, store.vertices, {1, nullptr}, cut));
  }

  template <class Test>
  void for_all(const Test& test) const {
    test(bvh8);
    test(bvh16);
    test(cut_bvh16);
    test(kd8);
    test(kd16);
  }
};

// A thin spike, a needle and a well-shaped triangle in turn, at random places.
Mesh make_slivers(std::uint32_t count, std::uint32_t seed) {
  Mesh mesh = test::make_random_triangles(count, 0.3f, seed);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    auto& [a, b, c] = mesh.triangles[t];
    const float share = t % 3 == 0 ? 1e-6f : t % 3 == 1 ? 1e-3f : 1;
    mesh.positions[c] = mesh.positions[b] + (mesh.positions[c] - mesh.positions[b]) * share;
  }
  return mesh;
}

Vec3f vector(const float* v, int stride) { return {v[0], v[stride], v[2 * stride]}; }

std::string text_of(const FanPacket& fan, int i) {
  const Vec3f d = vector(&fan.direction[0][i], kPacketRays);
  std::ostringstream out;
  out << std::hexfloat << fan.origin[0] << " " << fan.origin[1] << " " << fan.origin[2] << " to "
      << d.x << " " << d.y << " " << d.z << " t_max " << fan.t_max[i];
  return out.str();
}

// A fan from `origin` at random points, corners and edges, along axes, and now and then invalid.
FanPacket make_fan(const Mesh& mesh, Vec3f origin, std::mt19937& random) {
  FanPacket fan{};
  if (random() % 4 == 0) fan.t_min = 0.4f;
  for (int a = 0; a < 3; ++a) fan.origin[a] = origin[a];
  const auto corner = [&] { return mesh.positions[random() % mesh.positions.size()]; };
  const bool is_wide = random() % 4 == 0;  // no frustum: traced one by one
  const Vec3f middle = corner();
  // A fan no wider than a ray shows how far the planes of a frustum and the depths between them are
  // off.
  const bool is_line = random() % 4 == 0;
  std::uniform_real_distribution<float> unit(-1, 1);
  for (int i = 0; i < kPacketRays; ++i) {
    const auto& triangle = mesh.triangles[random() % mesh.triangles.size()];
    const Vec3f p = mesh.positions[triangle[0]], q = mesh.positions[triangle[1]];
    Vec3f target = is_wide ? p : middle + (p - middle) * 0.2f;
    if (random() % 3 == 0) target = is_wide ? (p + q) * 0.5f : middle;
    Vec3f direction = target - origin;
    if (random() % 16 == 0) direction.x = random() % 2 != 0 ? 0.0f : -0.0f;
    if (random() % 16 == 0) direction.y = 1e-41f;
    if (random() % 256 == 0) direction = direction * (random() % 2 != 0 ? 1e-30f : 1e22f);
    if (!is_line && random() % 64 == 0) direction.z = std::numeric_limits<float>::quiet_NaN();
    if (is_line && i > 0) direction = vector(&fan.direction[0][0], kPacketRays);
    for (int a = 0; a < 3; ++a) fan.direction[a][i] = direction[a];
    fan.t_max[i] = random() % 8 == 0 ? unit(random) + 1 : Bounds3f::kInf;
    fan.active |= std::uint64_t{random() % 32 != 0} << i;
  }
  return fan;
}

SingleRay ray_of(const FanPacket& fan, int i) {
  return {{fan.origin[0], fan.origin[1], fan.origin[2]},
          {fan.direction[0][i], fan.direction[1][i], fan.direction[2][i]},
          fan.t_min,
          fan.t_max[i]};
}

SingleRay ray_of(const RayPacket& packet, int i) {
  return {{packet.origin[0][i], packet.origin[1][i], packet.origin[2][i]},
          {packet.direction[0][i], packet.direction[1][i], packet.direction[2][i]},
          packet.t_min[i],
          packet.t_max[i]};
}

bool is_valid(const SingleRay& ray) {
  const Vec3f d = vector(ray.direction, 1);
  return is_finite(d) && is_finite(vector(ray.origin, 1)) && (d.x != 0 || d.y != 0 || d.z != 0) &&
         ray.t_min <= ray.t_max;
}

// Returns: what is wrong with an answer, or nullptr. t is off by 3 roundings (plane-inl.h), exact.t
// by 2.
const char* judge(const TriangleStore& store, const std::vector<Bounds3f>& boxes,
                  const SingleRay& ray, const SingleHit& hit) {
  const bool is_hit = hit.primitive != kNoPrimitive;
  if (!is_valid(ray)) return is_hit ? "an invalid ray hits" : nullptr;
  const auto error = [](float t) { return std::fabs(t) * 0x1p-21f; };
  for (std::uint32_t p = 0; p < boxes.size(); ++p) {
    if (boxes[p].is_empty()) continue;
    const ExactHit exact =
        exact_hit(ray.origin, ray.direction, &store.vertices[std::size_t{9} * p]);
    if (p == hit.primitive) {
      if (!exact.is_hit) return "reports a triangle that the ray misses";
      if (std::fabs(exact.t - hit.t) > error(exact.t)) return "t is wrong";
    }
    const float slack = error(exact.t);
    if (!exact.is_hit || !(exact.t - slack >= ray.t_min)) continue;
    if (!(exact.t + slack <= ray.t_max)) continue;
    if (!is_hit) return "misses a triangle that the ray hits";
    if (exact.t + slack < hit.t) return "reports a triangle behind another";
  }
  return nullptr;
}

template <class Index>
void expect_agreement(const Index& bvh, const FanPacket& fan, const PacketHits& expected) {
  for (const Isa isa : test::isas_here()) {
    const auto& kernels = kernels_of(kernels_for(isa), view_of(bvh));
    PacketHits hits;
    kernels.closest_fan(view_of(bvh), fan_of(fan), arrays_of(hits));
    const std::uint64_t blocked = kernels.occluded_fan(view_of(bvh), fan_of(fan));
    for (int i = 0; i < kPacketRays; ++i) {
      const auto same = [&](float t, std::uint32_t primitive) {
        return primitive == expected.primitive[i] &&
               std::bit_cast<std::uint32_t>(t) == std::bit_cast<std::uint32_t>(expected.t[i]);
      };
      const bool is_hit = expected.primitive[i] != kNoPrimitive;
      EXPECT_TRUE(same(hits.t[i], hits.primitive[i]))
          << isa_name(isa) << " fan " << text_of(fan, i);
      EXPECT_EQ(blocked >> i & 1u, is_hit ? 1u : 0u) << isa_name(isa) << " any " << text_of(fan, i);
      if ((fan.active >> i & 1u) == 0) continue;
      SingleHit single;
      kernels.closest_ray(view_of(bvh), ray_of(fan, i), single);
      EXPECT_TRUE(same(single.t, single.primitive)) << isa_name(isa) << " ray " << text_of(fan, i);
      EXPECT_EQ(kernels.occluded_ray(view_of(bvh), ray_of(fan, i)), is_hit) << text_of(fan, i);
    }
  }
}

// The rays of a fan with their origins moved apart, by much or as little as the points of one
// surface are.
RayPacket make_packet(const FanPacket& fan, float scale, std::mt19937& random) {
  RayPacket packet{};
  packet.active = fan.active;
  const float share = random() % 4 == 0 ? 1.0f : random() % 2 != 0 ? 0.1f : 0.01f;
  std::uniform_real_distribution<float> apart(-share * scale, share * scale);
  for (int i = 0; i < kPacketRays; ++i) {
    for (int a = 0; a < 3; ++a) {
      packet.origin[a][i] = fan.origin[a] + apart(random);
      // Most are aimed at where the ray of the fan went: corners and edges.
      const float target = fan.origin[a] + fan.direction[a][i];
      packet.direction[a][i] = i % 4 != 0 ? target - packet.origin[a][i] : fan.direction[a][i];
    }
    if (random() % 128 == 0) packet.origin[1][i] = Bounds3f::kInf;
    packet.t_min[i] = random() % 4 == 0 ? 0.3f : 0.0f;
    packet.t_max[i] = fan.t_max[i];
  }
  return packet;
}

template <class Index>
void expect_agreement(const Index& bvh, const RayPacket& packet, const SingleHit* expected) {
  for (const Isa isa : test::isas_here()) {
    const auto& kernels = kernels_of(kernels_for(isa), view_of(bvh));
    PacketHits hits;
    kernels.closest_many(view_of(bvh), many_of(packet), arrays_of(hits));
    std::uint64_t blocked = 0;
    kernels.occluded_many(view_of(bvh), many_of(packet), &blocked);
    for (int i = 0; i < kPacketRays; ++i) {
      EXPECT_EQ(hits.primitive[i], expected[i].primitive) << isa_name(isa) << " " << i;
      EXPECT_EQ(std::bit_cast<std::uint32_t>(hits.t[i]),
                std::bit_cast<std::uint32_t>(expected[i].t))
          << isa_name(isa) << " " << i;
      const bool is_hit = expected[i].primitive != kNoPrimitive;
      EXPECT_EQ(blocked >> i & 1u, is_hit ? 1u : 0u) << isa_name(isa) << " any " << i;
    }
  }
}

struct Place {
  float scale;
  Vec3f offset;
};
constexpr Place kPlaces[] = {{1, {0, 0, 0}},      {1e-6f, {0, 0, 0}}, {1e6f, {0, 0, 0}},
                             {1e-20f, {0, 0, 0}}, {1e15f, {0, 0, 0}}, {1, {1e4f, -2e4f, 3e4f}}};

// Calls test(scene, fan, random) `count` times on several meshes in several places.
template <class Test>
void with_fans(std::uint32_t seed, int count, const Test& test_fan) {
  const Mesh meshes[] = {test::make_icosphere(3), test::make_terrain(24, 1),
                         test::make_random_triangles(1500, 0.2f, 2), make_slivers(1500, 3)};
  for (const Place& place : kPlaces) {
    for (Mesh mesh : meshes) {
      test::place(mesh, place.scale, place.offset);
      const Prepared scene(mesh);
      std::mt19937 random(test::seed(seed));
      std::uniform_real_distribution<float> unit(-1.5f, 1.5f);
      for (int number = 0; number < count && !testing::Test::HasFailure(); ++number) {
        Vec3f origin = Vec3f{unit(random), unit(random), unit(random)} * place.scale + place.offset;
        if (number % 8 == 0) origin = mesh.positions[random() % mesh.positions.size()];
        SCOPED_TRACE("seed " + std::to_string(seed) + ", scale " + std::to_string(place.scale) +
                     ", fan " + std::to_string(number));
        test_fan(scene, make_fan(mesh, origin, random), place.scale, random);
      }
    }
  }
}

TEST(Kernels, EveryPathGivesTheAnswerOfExactArithmetic) {
  with_fans(4711, 40, [](const Prepared& scene, const FanPacket& fan, float, std::mt19937&) {
    PacketHits hits;
    kernels_for(Isa::kScalar).bvh8.closest_fan(view_of(scene.bvh8), fan_of(fan), arrays_of(hits));
    for (int i = 0; i < kPacketRays; ++i) {
      if ((fan.active >> i & 1u) == 0) continue;
      const char* const wrong =
          judge(scene.store, scene.boxes, ray_of(fan, i), {hits.t[i], hits.primitive[i]});
      EXPECT_EQ(wrong, nullptr) << (wrong != nullptr ? wrong : "") << ": " << text_of(fan, i);
    }
    scene.for_all([&](const auto& index) { expect_agreement(index, fan, hits); });
  });
}

// Closest-hit and any-hit rays agree in all ways also where t_max is exactly the t of the hit, or
// one float less.
TEST(Kernels, LimitsCountToTheBit) {
  with_fans(77, 25, [](const Prepared& scene, const FanPacket& plain, float, std::mt19937& random) {
    FanPacket fan = plain;
    PacketHits hits;
    const auto& scalar = kernels_for(Isa::kScalar).bvh8;
    for (int i = 0; i < kPacketRays; ++i) {
      hits.t[i] = 0;
      hits.primitive[i] = kNoPrimitive;
      if ((fan.active >> i & 1u) == 0) continue;
      SingleHit hit;
      scalar.closest_ray(view_of(scene.bvh8), ray_of(fan, i), hit);
      if (hit.primitive != kNoPrimitive)
        fan.t_max[i] = random() % 2 == 0 ? hit.t : std::nextafter(hit.t, 0.0f);
      scalar.closest_ray(view_of(scene.bvh8), ray_of(fan, i), hit);
      hits.t[i] = hit.t;
      hits.primitive[i] = hit.primitive;
    }
    scene.for_all([&](const auto& index) { expect_agreement(index, fan, hits); });
  });
}

TEST(Kernels, RaysWithOriginsOfTheirOwnAnswerAsIfAlone) {
  with_fans(
      815, 60, [](const Prepared& scene, const FanPacket& fan, float scale, std::mt19937& random) {
        const RayPacket packet = make_packet(fan, scale, random);
        SingleHit expected[kPacketRays];
        for (int i = 0; i < kPacketRays; ++i) {
          expected[i] = {0, kNoPrimitive};
          if ((packet.active >> i & 1u) == 0) continue;
          const SingleRay ray = ray_of(packet, i);
          kernels_for(Isa::kScalar).bvh8.closest_ray(view_of(scene.bvh8), ray, expected[i]);
          EXPECT_EQ(judge(scene.store, scene.boxes, ray, expected[i]), nullptr) << "ray " << i;
        }
        scene.for_all([&](const auto& index) { expect_agreement(index, packet, expected); });
      });
}

TEST(Kernels, SingleRaysKeepToTheirRangeOnBothSidesOfTheOrigin) {
  const std::uint32_t seed = 12;
  const Mesh mesh = test::make_random_triangles(1500, 0.3f, 5);
  const Prepared scene(mesh);
  std::mt19937 random(test::seed(seed));
  std::uniform_real_distribution<float> unit(-1, 1);
  for (int i = 0; i < 4000; ++i) {
    const float a = 2 * unit(random), b = 2 * unit(random);
    const SingleRay ray{{unit(random), unit(random), unit(random)},
                        {unit(random), unit(random), unit(random)},
                        std::min(a, b),
                        std::max(a, b)};
    SingleHit expected;
    kernels_for(Isa::kScalar).bvh8.closest_ray(view_of(scene.bvh8), ray, expected);
    ASSERT_EQ(judge(scene.store, scene.boxes, ray, expected), nullptr)
        << "seed " << seed << ", " << i;
    for (const Isa isa : test::isas_here()) {
      SingleHit hit;
      kernels_for(isa).bvh16.closest_ray(view_of(scene.bvh16), ray, hit);
      ASSERT_EQ(hit.primitive, expected.primitive) << "seed " << seed << ", " << i;
      ASSERT_EQ(hit.t, expected.t) << "seed " << seed << ", " << i;
      kernels_for(isa).kd8.closest_ray(view_of(scene.kd8), ray, hit);
      ASSERT_EQ(hit.primitive, expected.primitive) << "seed " << seed << ", " << i;
      ASSERT_EQ(hit.t, expected.t) << "seed " << seed << ", " << i;
    }
  }
}

// No ray gets out of a closed mesh, aimed at its edges and corners or not.
TEST(Kernels, NoRayLeavesAClosedMesh) {
  const std::uint32_t seed = 99;
  std::size_t rays = 0, leaks = 0;
  for (const Place& place : kPlaces) {
    Mesh mesh = test::make_icosphere(4);
    test::place(mesh, place.scale, place.offset);
    const Prepared scene(mesh);
    std::mt19937 random(test::seed(seed));
    std::uniform_real_distribution<float> unit(-0.4f, 0.4f);
    const KernelTable& table = kernels_for(test::isas_here().back());
    for (int packet = 0; packet < 4000; ++packet) {
      const Vec3f origin =
          Vec3f{unit(random), unit(random), unit(random)} * place.scale + place.offset;
      FanPacket fan = make_fan(mesh, origin, random);
      fan.t_min = 0;
      for (float& t : fan.t_max) t = Bounds3f::kInf;
      PacketHits hits;
      if (packet % 2 == 0) {
        table.bvh8.closest_fan(view_of(scene.bvh8), fan_of(fan), arrays_of(hits));
      } else {
        table.kd8.closest_fan(view_of(scene.kd8), fan_of(fan), arrays_of(hits));
      }
      for (int i = 0; i < kPacketRays; ++i) {
        if ((fan.active >> i & 1u) == 0 || !is_valid(ray_of(fan, i))) continue;
        ++rays;
        if (hits.primitive[i] != kNoPrimitive) continue;
        if (++leaks <= 3) ADD_FAILURE() << "leak, seed " << seed << ": " << text_of(fan, i);
      }
    }
  }
  EXPECT_EQ(leaks, 0u);
  EXPECT_GT(rays, 1'000'000u);
}

}  // namespace
}  // namespace tessera::core
