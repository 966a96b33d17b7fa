// SPDX-License-Identifier: Apache-2.0
// Property: whether a ray hits a triangle is what rational arithmetic says, and of several the
// closest is the one of the least t as plane-inl.h defines it, the lowest number at one t: by fans,
// bundles, rays by themselves and rays in flight, on every instruction set, at slivers whose
// corners are a few roundings apart (tests/support/slivers.h).
//
// TESSERA_LONG=1 asks for 10^7 rays, each of which goes all ways.
#include <gtest/gtest.h>

#include <bit>
#include <cstdlib>
#include <sstream>

#include "tests/support/packets.h"
#include "tests/support/rational_hit.h"
#include "tests/support/slivers.h"
#include "tests/support/test_meshes.h"

namespace tessera::core {
namespace {

bool is_long() { return std::getenv("TESSERA_LONG") != nullptr; }

struct Expected {
  SingleHit hit{0, kNoPrimitive};
  bool is_right = true;  // t of all triangles that were met is as near as is promised
};

// Looks at every triangle.
Expected expected_of(const Mesh& mesh, const SingleRay& ray) {
  Expected best;
  const float* const d = ray.direction;
  if (d[0] == 0 && d[1] == 0 && d[2] == 0) return best;
  for (std::uint32_t k = 0; k < mesh.triangles.size(); ++k) {
    float triangle[9] = {};
    for (std::size_t c = 0; c < 3; ++c) {
      for (int a = 0; a < 3; ++a)
        triangle[3 * c + static_cast<std::size_t>(a)] = mesh.positions[mesh.triangles[k][c]][a];
    }
    const test::RationalHit rational = test::rational_hit(ray.origin, d, triangle);
    if (!rational.is_hit) continue;
    const test::DefinedT defined = test::defined_t(ray.origin, d, triangle);
    best.is_right = best.is_right && test::is_near(defined, rational.t);
    if (!(defined.t >= ray.t_min && defined.t <= ray.t_max)) continue;
    if (best.hit.primitive == kNoPrimitive || defined.t < best.hit.t) best.hit = {defined.t, k};
  }
  return best;
}

struct Packet {
  test::NeighbourRays made;
  std::array<Expected, kPacketRays> expected;
};

// How many rays were asked, and how many answers differ, with the first few of them.
struct Count {
  std::uint64_t rays = 0, hits = 0, different = 0;
  std::string examples;

  void differs(const char* way, Isa isa, const SingleRay& ray, const Mesh& mesh) {
    if (++different > 4) return;
    std::ostringstream text;
    text << std::hexfloat << way << " on " << isa_name(isa) << ": ray ";
    for (const float x : ray.origin) text << x << " ";
    for (const float x : ray.direction) text << x << " ";
    text << ray.t_min << " " << ray.t_max << " triangles";
    for (const Vec3f p : mesh.positions) text << " | " << p.x << " " << p.y << " " << p.z;
    examples += text.str() + "\n";
  }
};

// The answers of one instruction set to a packet, all ways.
class Ways {
 public:
  Ways(const Mesh& mesh, const SceneTracer& tracer, Isa isa, Count& count)
      : mesh_(mesh), tracer_(tracer), isa_(isa), count_(count) {}

  void compare(const Packet& packet) {
    PacketHits hits;
    if (packet.made.is_fan) {
      const FanPacket fan = fan_packet(packet);
      tracer_.closest(fan, hits);
      compare_hits("fan", packet, hits);
      compare_bits("fan, any hit", packet, tracer_.occluded(fan));
    }
    RayPacket bundle = ray_packet(packet);
    tracer_.closest(bundle, hits);
    compare_hits("bundle", packet, hits);
    bundle.habit = {};
    compare_bits("bundle, any hit", packet, tracer_.occluded(bundle));
    bundle.habit.alone = 1;  // as after packets that have not paid: its rays fly, or go one by one
    tracer_.closest(bundle, hits);
    compare_hits("many", packet, hits);
    bundle.habit.alone = 1;
    compare_bits("many, any hit", packet, tracer_.occluded(bundle));
    for (std::size_t i = 0; i < kPacketRays; ++i) {
      const SingleRay& ray = packet.made.rays[i];
      compare_hit("single", packet, i, tracer_.closest(ray));
      if (tracer_.occluded(ray) != is_hit(packet, i))
        count_.differs("single, any hit", isa_, ray, mesh_);
    }
  }

 private:
  static bool is_hit(const Packet& packet, std::size_t i) {
    return packet.expected[i].hit.primitive != kNoPrimitive;
  }
  static FanPacket fan_packet(const Packet& packet) {
    FanPacket fan{};
    fan.active = ~std::uint64_t{0};
    fan.t_min = packet.made.rays[0].t_min;
    for (std::size_t a = 0; a < 3; ++a) fan.origin[a] = packet.made.rays[0].origin[a];
    for (std::size_t i = 0; i < kPacketRays; ++i) {
      fan.t_max[i] = packet.made.rays[i].t_max;
      for (std::size_t a = 0; a < 3; ++a) fan.direction[a][i] = packet.made.rays[i].direction[a];
    }
    return fan;
  }
  static RayPacket ray_packet(const Packet& packet) {
    RayPacket bundle{};
    bundle.active = ~std::uint64_t{0};
    for (std::size_t i = 0; i < kPacketRays; ++i) {
      const SingleRay& ray = packet.made.rays[i];
      bundle.t_min[i] = ray.t_min;
      bundle.t_max[i] = ray.t_max;
      for (std::size_t a = 0; a < 3; ++a) {
        bundle.origin[a][i] = ray.origin[a];
        bundle.direction[a][i] = ray.direction[a];
      }
    }
    return bundle;
  }
  void compare_hit(const char* way, const Packet& packet, std::size_t i, const SingleHit& hit) {
    const SingleHit& wanted = packet.expected[i].hit;
    const auto bits = [](float t) { return std::bit_cast<std::uint32_t>(t); };
    if (hit.primitive != wanted.primitive || bits(hit.t) != bits(wanted.t))
      count_.differs(way, isa_, packet.made.rays[i], mesh_);
  }
  void compare_hits(const char* way, const Packet& packet, const PacketHits& hits) {
    for (std::size_t i = 0; i < kPacketRays; ++i)
      compare_hit(way, packet, i, {hits.t[i], hits.primitive[i]});
  }
  void compare_bits(const char* way, const Packet& packet, std::uint64_t blocked) {
    for (std::size_t i = 0; i < kPacketRays; ++i) {
      if (((blocked >> i & 1u) != 0) != is_hit(packet, i))
        count_.differs(way, isa_, packet.made.rays[i], mesh_);
    }
  }

  const Mesh& mesh_;
  const SceneTracer& tracer_;
  Isa isa_;
  Count& count_;
};

// Traces packets at meshes of up to so many triangles, until so many rays have been traced.
Count trace(unsigned seed, unsigned triangle_count, std::uint64_t ray_count) {
  constexpr int kPacketsPerMesh = 8;
  test::Choices any(seed);
  Count count;
  for (unsigned round = 0; count.rays < ray_count; ++round) {
    const test::Slivers slivers = test::make_slivers(any, triangle_count);
    const Structure structure = round % 4 == 3 ? Structure::kKd : Structure::kBvh;
    const auto scene =
        PreparedScene::build(test::make_scene(slivers.mesh), {1, nullptr, structure});
    if (!scene.is_ok()) {
      ADD_FAILURE() << scene.status().message();
      return count;
    }
    for (int k = 0; k < kPacketsPerMesh; ++k) {
      Packet packet{test::make_rays(any, slivers), {}};
      for (std::size_t i = 0; i < kPacketRays; ++i) {
        const SingleRay& ray = packet.made.rays[i];
        packet.expected[i] = expected_of(slivers.mesh, ray);
        count.hits += packet.expected[i].hit.primitive != kNoPrimitive ? 1u : 0u;
        if (!packet.expected[i].is_right)
          count.differs("t of the oracle", Isa::kScalar, ray, slivers.mesh);
      }
      count.rays += kPacketRays;
      for (const Isa isa : test::isas_here()) {
        const SceneTracer tracer((*scene)->impl().index, kernels_for(isa));
        Ways(slivers.mesh, tracer, isa, count).compare(packet);
      }
    }
  }
  return count;
}

TEST(SliverAnswers, EachTriangleIsHitWhereRationalArithmeticSaysSo) {
  const Count count = trace(184, 1, is_long() ? 7'000'000 : 100'000);
  EXPECT_EQ(count.different, 0u) << count.examples;
  EXPECT_GT(count.hits, count.rays / 8);
  RecordProperty("rays", std::to_string(count.rays));
}

TEST(SliverAnswers, OfAStripTheClosestIsTheOneOfTheLeastT) {
  const Count count = trace(185, 6, is_long() ? 3'000'000 : 30'000);
  EXPECT_EQ(count.different, 0u) << count.examples;
  EXPECT_GT(count.hits, count.rays / 8);
  RecordProperty("rays", std::to_string(count.rays));
}

}  // namespace
}  // namespace tessera::core
