// SPDX-License-Identifier: Apache-2.0
// Property: fans that begin where their tile's window allows hit what they would from the root,
// also where they pass the window's very edges and corners.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "slave/core/primitive/primitive_index.h"
#include "slave/core/primitive/triangle/triangle_clipper.h"
#include "slave/core/primitive/triangle/triangle_store.h"
#include "slave/core/ray/fan_of.h"
#include "slave/core/trace/fan_window.h"
#include "slave/core/trace/scene_tracer.h"
#include "tests/support/packets.h"
#include "tests/support/seed.h"
#include "tests/support/test_meshes.h"

namespace tessera::core {
namespace {

struct Tile {
  Vec3f origin;
  std::vector<Vec3f> corners;
};

// A tile whose corner rays go to corners of the mesh, so that the window ends exactly there. A
// third of the tiles are a line, a third have an edge along an axis.
Tile make_tile(const Mesh& mesh, std::mt19937& random) {
  std::uniform_real_distribution<float> unit(-1, 1);
  const auto vertex = [&] { return mesh.positions[random() % mesh.positions.size()]; };
  const Vec3f middle = vertex();
  Tile tile{Vec3f{unit(random), unit(random), unit(random)} * 3, {}};
  const float width = random() % 2 == 0 ? 0.05f : 0.5f;
  const auto kind = random() % 3;
  for (int i = 0; i < 4; ++i) {
    Vec3f target = random() % 2 == 0 ? vertex() : middle;
    target = middle + (target - middle) * width;
    if (random() % 2 == 0) target = middle;
    Vec3f direction = target - tile.origin;
    if (kind == 0) direction = middle - tile.origin;
    if (kind == 1) direction.x = 0;
    tile.corners.push_back(direction);
  }
  return tile;
}

FanPacket make_fan(const Tile& tile, std::mt19937& random) {
  FanPacket fan{};
  for (int a = 0; a < 3; ++a) fan.origin[a] = tile.origin[a];
  std::uniform_real_distribution<float> unit(0, 1);
  for (int i = 0; i < kPacketRays; ++i) {
    const Vec3f p = tile.corners[random() % 4], q = tile.corners[random() % 4],
                r = tile.corners[random() % 4];
    Vec3f direction = p;
    if (random() % 4 != 0) direction = direction + (q - p) * unit(random);
    if (random() % 4 != 0) direction = direction + (r - direction) * unit(random);
    for (int a = 0; a < 3; ++a) fan.direction[a][i] = direction[a];
    fan.t_max[i] = random() % 8 == 0 ? 2 * unit(random) : Bounds3f::kInf;
    fan.active |= std::uint64_t{random() % 32 != 0} << i;
  }
  return fan;
}

struct Tally {
  int fans = 0, hits = 0, deep = 0;
};

template <class Index>
void expect_same(const Index& index, const Tile& tile, std::mt19937& random, Tally& tally) {
  const auto window = fan_window(tile.origin, tile.corners);
  if (!window) return;
  const auto view = view_of(index);
  for (const Isa isa : test::isas_here()) {
    const auto& kernels = kernels_of(kernels_for(isa), view);
    FanEntry entry;
    kernels.enter_fans(view, *window, entry);
    tally.deep += entry.top.child[0] != 0 ? 1 : 0;
    for (int number = 0; number < 3; ++number) {
      FanPacket fan = make_fan(tile, random);
      PacketHits expected, hits;
      kernels.closest_fan(view, fan_of(fan), arrays_of(expected));
      const std::uint64_t blocked = kernels.occluded_fan(view, fan_of(fan));
      fan.entry = &entry;
      kernels.closest_fan(view, fan_of(fan), arrays_of(hits));
      ASSERT_EQ(blocked, kernels.occluded_fan(view, fan_of(fan))) << isa_name(isa);
      for (int i = 0; i < kPacketRays; ++i) {
        ASSERT_EQ(hits.primitive[i], expected.primitive[i]) << isa_name(isa) << " ray " << i;
        ASSERT_EQ(hits.t[i], expected.t[i]) << isa_name(isa) << " ray " << i;
        tally.hits += hits.primitive[i] != kNoPrimitive ? 1 : 0;
      }
      ++tally.fans;
    }
  }
}

TEST(FanEntry, FansHitWhatTheyWouldFromTheRoot) {
  const std::uint32_t seed = 20261121;
  std::mt19937 random(test::seed(seed));
  Tally tally;
  const Mesh meshes[] = {test::make_icosphere(4), test::make_torus(60, 40), test::make_cube(),
                         test::make_random_triangles(4000, 0.2f, 3), test::make_terrain(60, 5)};
  for (const Mesh& mesh : meshes) {
    std::vector<Bounds3f> boxes;
    const TriangleStore store = make_triangle_store(test::make_scene(mesh), boxes);
    const BuildControl alone{1, nullptr};
    const auto bvh8 = index_by_bvh<8>(boxes, store.vertices, alone);
    const auto bvh16 = index_by_bvh<16>(boxes, store.vertices, alone);
    const TriangleClipper clipper(store.vertices);
    BvhBuildConfig cut = spatial_build(clipper);
    cut.cuts_have_to_pay = false;
    const auto cut8 = index_by_bvh<8>(boxes, store.vertices, alone, cut);
    const auto kd8 = index_by_kd<8>(boxes, store.vertices, alone);
    const auto kd16 = index_by_kd<16>(boxes, store.vertices, alone);
    for (int number = 0; number < 150 && !testing::Test::HasFatalFailure(); ++number) {
      SCOPED_TRACE("seed " + std::to_string(seed) + ", tile " + std::to_string(number));
      const Tile tile = make_tile(mesh, random);
      expect_same(*bvh8, tile, random, tally);
      expect_same(*bvh16, tile, random, tally);
      expect_same(*cut8, tile, random, tally);
      expect_same(*kd8, tile, random, tally);
      expect_same(*kd16, tile, random, tally);
    }
  }
  // With fewer of them nothing would be tested.
  EXPECT_GT(tally.fans, 2000);
  EXPECT_GT(tally.hits, 64 * tally.fans / 10);
  EXPECT_GT(tally.deep, tally.fans / 10);
}

TEST(FanEntry, AWindowBehindTheSceneLeavesNothingToGoTo) {
  const Mesh mesh = test::make_icosphere(3);
  std::vector<Bounds3f> boxes;
  const TriangleStore store = make_triangle_store(test::make_scene(mesh), boxes);
  const auto kd = index_by_kd<8>(boxes, store.vertices, {1, nullptr});
  const auto bvh = index_by_bvh<8>(boxes, store.vertices, {1, nullptr});
  const Vec3f away[] = {{1, 0.1f, 0}, {1, -0.1f, 0}, {1, 0, 0.1f}};
  const auto window = fan_window({5, 0, 0}, away);
  ASSERT_TRUE(window.has_value());
  const KernelTable& kernels = kernels_for(Isa::kScalar);
  FanEntry entry;
  kernels.bvh8.enter_fans(view_of(*bvh), *window, entry);
  EXPECT_EQ(entry.top.child[0], kBvhNoChild);
  kernels.kd8.enter_fans(view_of(*kd), *window, entry);
  EXPECT_EQ(entry.top.child[0], kBvhNoChild);
}

TEST(FanWindow, RaysTooFarApartHaveNone) {
  const Vec3f around[] = {{1, 0, 0}, {-1, 0.1f, 0}, {0, 0, 1}};
  EXPECT_FALSE(fan_window({}, around).has_value());
  const Vec3f nothing[] = {{0, 0, 0}};
  EXPECT_FALSE(fan_window({}, nothing).has_value());
  const Vec3f no_number[] = {{1, NAN, 0}};
  EXPECT_FALSE(fan_window({}, no_number).has_value());
}

}  // namespace
}  // namespace tessera::core
