// SPDX-License-Identifier: Apache-2.0
// Property: rays that are traced by one call, as many as there are, answer as they do alone, to the
// bit, on every instruction set, through every structure: among packets that form bundles, packets
// that do not, empty ones, and rays that are not valid; closest hits and any hit; through surfaces
// that rays pass, and among patches.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <limits>
#include <memory>
#include <random>

#include "slave/core/ray/ray_list.h"
#include "slave/core/scene/prepared_scene_impl.h"
#include "tests/support/packets.h"
#include "tests/support/patch_scene_of.h"
#include "tests/support/seed.h"
#include "tests/support/test_meshes.h"

namespace tessera::core {
namespace {

using Random = std::mt19937;

constexpr int kPacketsMost = 40;
constexpr int kPlaces = kPacketsMost * kPacketRays;

float unit(Random& random) { return std::uniform_real_distribution<float>(-1, 1)(random); }
Vec3f point(Random& random) { return {unit(random), unit(random), unit(random)}; }

struct Rays {
  alignas(64) float origin[3][kPlaces], direction[3][kPlaces];
  alignas(64) float t_min[kPlaces], t_max[kPlaces];
  std::uint64_t active[kPacketsMost] = {};
  PacketHabit habit;

  ManyRays many(int packet_count) {
    return {{origin[0], origin[1], origin[2]},
            {direction[0], direction[1], direction[2]},
            t_min,
            t_max,
            active,
            packet_count,
            &habit};
  }
  SingleRay ray(int i) const {
    return {{origin[0][i], origin[1][i], origin[2][i]},
            {direction[0][i], direction[1][i], direction[2][i]},
            t_min[i],
            t_max[i]};
  }
  void put(int i, Vec3f from, Vec3f along) {
    put_vector(from, origin, i);
    put_vector(along, direction, i);
  }
};

void fill(Rays& rays, Random& random) {
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = Bounds3f::kInf;
  for (int p = 0; p < kPacketsMost; ++p) {
    const bool is_bundle = random() % 4 == 0;
    const Vec3f from = point(random) * 2, along = point(random);
    rays.active[p] = std::uint64_t{random()} << 32 | random();
    if (random() % 3 == 0) rays.active[p] = ~std::uint64_t{0};
    if (random() % 8 == 0) rays.active[p] = 0;
    for (int i = p * kPacketRays; i < (p + 1) * kPacketRays; ++i) {
      rays.put(i, is_bundle ? from + point(random) * 0.05f : point(random) * 2,
               is_bundle ? along + point(random) * 0.05f : point(random));
      rays.t_min[i] = random() % 4 == 0 ? 0.3f * unit(random) : 0;
      rays.t_max[i] = random() % 4 == 0 ? 1 + unit(random) : inf;
      if (random() % 40 == 0) rays.direction[random() % 3][i] = random() % 2 == 0 ? nan : inf;
      if (random() % 40 == 0) rays.origin[random() % 3][i] = nan;
      if (random() % 40 == 0) (random() % 2 == 0 ? rays.t_min : rays.t_max)[i] = nan;
    }
  }
}

// Returns: how many rays hit something.
int compare(const PreparedScene::Impl& scene, Rays& rays) {
  int hit_count = 0;
  const SceneTracer reference(scene.index, kernels_for(Isa::kScalar), scene.alpha.get());
  for (const Isa isa : test::isas_here()) {
    const SceneTracer tracer(scene.index, kernels_for(isa), scene.alpha.get());
    for (const int packet_count : {1, 2, 7, 16, kPacketsMost}) {
      alignas(64) float t[kPlaces];
      alignas(64) std::uint32_t primitive[kPlaces];
      std::uint64_t blocked[kPacketsMost];
      rays.habit = {};
      tracer.closest(rays.many(packet_count), {t, primitive});
      rays.habit = {};
      std::fill_n(blocked, packet_count, ~std::uint64_t{0});  // what is left of other rays
      tracer.occluded(rays.many(packet_count), blocked);
      for (int i = 0; i < packet_count * kPacketRays; ++i) {
        const bool is_active = (rays.active[i / kPacketRays] >> i % kPacketRays & 1u) != 0;
        const SingleHit wanted =
            is_active ? reference.closest(rays.ray(i)) : SingleHit{0, kNoPrimitive};
        const bool is_same =
            wanted.primitive == primitive[i] &&
            std::bit_cast<std::uint32_t>(wanted.t) == std::bit_cast<std::uint32_t>(t[i]);
        const bool is_blocked = (blocked[i / kPacketRays] >> i % kPacketRays & 1u) != 0;
        EXPECT_TRUE(is_same) << isa_name(isa) << ", " << packet_count << " packets, ray " << i
                             << ": " << primitive[i] << " at " << t[i] << ", not "
                             << wanted.primitive << " at " << wanted.t;
        EXPECT_EQ(is_blocked, wanted.primitive != kNoPrimitive)
            << isa_name(isa) << ", " << packet_count << " packets, ray " << i;
        if (testing::Test::HasFailure()) return 0;
        hit_count += wanted.primitive != kNoPrimitive;
      }
    }
  }
  return hit_count;
}

void check(const Scene& scene, const BuildOptions& options) {
  const unsigned seed = test::seed(41);
  TESSERA_TRACE_SEED(seed);
  Random random(seed);
  const auto prepared = PreparedScene::build(scene, options);
  ASSERT_TRUE(prepared.is_ok());
  const auto rays = std::make_unique<Rays>();
  fill(*rays, random);
  EXPECT_GT(compare((*prepared)->impl(), *rays), kPlaces / 4);
}

TEST(ManyRays, AnswerAsTheyDoAloneInAHierarchy) {
  check(test::make_scene(test::make_random_triangles(3000, 0.2f, 3)), {});
}

TEST(ManyRays, AnswerAsTheyDoAloneInAHierarchyOfOneNode) {
  check(test::make_scene(test::make_cube()), {});
}

TEST(ManyRays, AnswerAsTheyDoAloneInAKdTree) {
  BuildOptions options;
  options.structure = Structure::kKd;
  check(test::make_scene(test::make_random_triangles(3000, 0.2f, 3)), options);
}

TEST(ManyRays, AnswerAsTheyDoAloneAmongInstances) {
  Scene scene = test::make_scene(test::make_random_triangles(300, 0.3f, 5));
  for (int i = 1; i < 9; ++i) {
    Instance next = scene.instances[0];
    next.object_to_world.m[0][3] = 0.3f * static_cast<float>(i - 4);
    next.object_to_world.m[1][2] = 0.1f * static_cast<float>(i);
    scene.instances.push_back(next);
  }
  BuildOptions options;
  options.instancing = Instancing::kAlways;
  check(scene, options);
}

TEST(ManyRays, AnswerAsTheyDoAloneThroughWhatTheyPass) {
  Scene scene = test::make_scene(test::make_random_triangles(3000, 0.3f, 3));
  scene.materials[0].alpha.mode = AlphaMode::kBlend;
  scene.materials[0].alpha.value = 0.5f;
  check(scene, {});
}

TEST(ManyRays, AnswerAsTheyDoAloneAmongPatches) {
  for (const char* shape : {"teapot", "torus"}) check(test::patch_scene_of(shape), {});
}

TEST(ManyRays, OfAListLieWhereTheyWerePut) {
  const auto list = std::make_unique<RayList>();
  for (int round = 0; round < 2; ++round) {
    list->clear();
    EXPECT_EQ(list->many().packet_count, 0);
    list->put(130, {1, 2, 3}, {4, 5, 6});
    list->put(3, {7, 8, 9}, {10, 11, 12}, 0.5f);
    ASSERT_EQ(list->packet_count(), 3);
    EXPECT_EQ(list->active(0), std::uint64_t{1} << 3);
    EXPECT_EQ(list->active(1), 0u);
    EXPECT_EQ(list->active(2), std::uint64_t{1} << 2);
    const auto packet = std::make_unique<RayPacket>();
    list->copy_packet(2, *packet);
    EXPECT_EQ(packet->active, std::uint64_t{1} << 2);
    EXPECT_EQ(packet->origin[1][2], 2);
    EXPECT_EQ(packet->direction[2][2], 6);
    EXPECT_EQ(packet->t_max[2], RayList::kNoEnd);
    EXPECT_EQ(list->many().t_max[3], 0.5f);
    EXPECT_EQ(list->many().t_min[3], 0);
  }
}

}  // namespace
}  // namespace tessera::core
