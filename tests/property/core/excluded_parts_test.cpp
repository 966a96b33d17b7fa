// SPDX-License-Identifier: Apache-2.0
// Property: rays that leave patches and name the sub-patch that they leave (patch_horizon.h) are
// answered as if they had not, flattened and among places, by every call and instruction set; and
// what a ray names is left out.
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "slave/core/kernels/kernel_table.h"
#include "slave/core/primitive/freeform/patch_point.h"
#include "slave/core/primitive/patch/patch_horizon.h"
#include "slave/core/ray/ray_list.h"
#include "slave/core/scene/prepared_scene_impl.h"
#include "slave/core/trace/ray_groups.h"
#include "slave/core/trace/scene_tracer.h"
#include "tests/support/packets.h"
#include "tests/support/patch_scene_of.h"
#include "tests/support/seed.h"

namespace tessera::core {
namespace {

using Random = std::mt19937;

float unit(Random& random) { return std::uniform_real_distribution<float>(-1, 1)(random); }
Vec3f point(Random& random) { return {unit(random), unit(random), unit(random)}; }

// A ray that leaves a sub-patch.
struct Leaving {
  Vec3f origin, direction, normal;
  std::uint32_t part;
  float horizon;

  // The sub-patch, where it is known that the ray does not meet it again; or no primitive.
  std::uint32_t own() const { return own_towards(direction); }
  std::uint32_t own_towards(Vec3f along) const {
    return dot(along, normal) > horizon * length(along) ? part : kNoPrimitive;
  }
};

std::vector<Leaving> leaving_rays(const PreparedScene::Impl& scene, Random& random, int count) {
  const SceneTracer tracer(scene.index, kernels_for(Isa::kScalar));
  std::vector<Leaving> rays;
  for (int tries = 0; tries < 50 * count && static_cast<int>(rays.size()) < count; ++tries) {
    const Vec3f from = point(random) * 6, along = point(random) * 2 - from;
    const SingleHit hit =
        tracer.closest({{from.x, from.y, from.z}, {along.x, along.y, along.z}, 0, Bounds3f::kInf});
    if (hit.primitive == kNoPrimitive) continue;
    const PartInWorld there = scene.part(scene.triangles.instance_of(hit.primitive), hit.primitive);
    const PatchSurfacePoint at = patch_point(*there.patch, *there.part, &from.x, &along.x, hit.t);
    const Vec3f normal = dot(at.normal, along) < 0 ? at.normal : -at.normal;
    Vec3f direction = normalize(point(random));
    if (dot(direction, normal) < 0) direction = -direction;
    const float horizon =
        horizon_at(*there.patch, *there.part, at.u, at.v, at.point, normal).value_or(kNoHorizon);
    rays.push_back({at.point + normal * at.offset, direction, normal, hit.primitive, horizon});
  }
  return rays;
}

SingleRay single(const Leaving& ray, std::uint32_t excluded = kNoPrimitive) {
  return {{ray.origin.x, ray.origin.y, ray.origin.z},
          {ray.direction.x, ray.direction.y, ray.direction.z},
          0,
          Bounds3f::kInf,
          {excluded, kNoPrimitive}};
}

// Rays of which each excludes one primitive, in one list.
void put(const std::vector<Leaving>& rays, const std::vector<std::uint32_t>& excluded,
         RayList& list) {
  list.clear();
  for (int i = 0; i < static_cast<int>(rays.size()); ++i) {
    list.put(i, rays[static_cast<std::size_t>(i)].origin,
             rays[static_cast<std::size_t>(i)].direction);
    list.exclude(i, excluded[static_cast<std::size_t>(i)]);
  }
}

// Whether all calls answer as single rays do by the scalar kernels. Returns: how many hit.
int compare(const PreparedScene::Impl& scene, const std::vector<Leaving>& rays,
            const std::vector<std::uint32_t>& excluded, const std::vector<SingleHit>& wanted) {
  const auto list = std::make_unique<RayList>();
  const auto found = std::make_unique<ListHits>();
  int hits = 0;
  for (const Isa isa : test::isas_here()) {
    const SceneTracer tracer(scene.index, kernels_for(isa));
    put(rays, excluded, *list);
    tracer.closest(list->many(), found->arrays());
    std::uint64_t blocked[RayList::kPacketsMax];
    tracer.occluded(list->many(), blocked);
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const SingleHit alone = tracer.closest(single(rays[i], excluded[i]));
      EXPECT_EQ(alone.primitive, wanted[i].primitive) << isa_name(isa) << ", ray " << i;
      EXPECT_EQ(alone.t, wanted[i].t) << isa_name(isa) << ", ray " << i;
      EXPECT_EQ(found->primitive[i], wanted[i].primitive) << isa_name(isa) << ", ray " << i;
      EXPECT_EQ(found->t[i], wanted[i].t) << isa_name(isa) << ", ray " << i;
      const bool is_blocked = (blocked[i / kPacketRays] >> i % kPacketRays & 1u) != 0;
      EXPECT_EQ(is_blocked, wanted[i].primitive != kNoPrimitive) << isa_name(isa) << ", ray " << i;
      hits += is_blocked;
      if (testing::Test::HasFailure()) return 0;
    }
  }
  return hits;
}

constexpr float kEnd = 1 - 0x1p-20f;

SingleRay from_lamp(Vec3f lamp, Vec3f end, std::uint32_t excluded) {
  const Vec3f d = end - lamp;
  return {{lamp.x, lamp.y, lamp.z}, {d.x, d.y, d.z}, 0, kEnd, {excluded, kNoPrimitive}};
}

// Whether fans from a lamp, whose rays exclude a primitive each, answer as single rays do.
void compare_fans(const PreparedScene::Impl& scene, const std::vector<Leaving>& rays, Vec3f lamp,
                  const std::vector<std::uint32_t>& excluded, const std::vector<bool>& wanted) {
  for (const Isa isa : test::isas_here()) {
    const KernelTable& kernels = kernels_for(isa);
    const SceneTracer tracer(scene.index, kernels);
    const auto blocked = std::make_unique<std::uint64_t[]>(RayGroups::kRaysMax);
    RayGroups groups;
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const int number = groups.add(rays[i].origin - lamp);
      groups.exclude(number, excluded[i]);
    }
    groups.form(kernels);
    tracer.occluded(groups.fans_from(lamp, 0, kEnd), blocked.get());
    for (int g = 0; g < groups.group_count(); ++g) {
      std::uint64_t bits = blocked[static_cast<std::size_t>(g)];
      for (const int ray : groups.group(g)) {
        EXPECT_EQ((bits & 1u) != 0, wanted[static_cast<std::size_t>(ray)])
            << isa_name(isa) << ", ray " << ray;
        bits >>= 1;
      }
    }
    if (testing::Test::HasFailure()) return;
  }
}

// Rays that end on patches: what they end on, and what blocks them.
void check_fans(const PreparedScene::Impl& scene, const std::vector<Leaving>& rays, Vec3f lamp) {
  const SceneTracer tracer(scene.index, kernels_for(Isa::kScalar));
  std::vector<std::uint32_t> own, met;
  std::vector<bool> plain, without;
  for (const Leaving& ray : rays) {
    const SingleHit hit = tracer.closest(from_lamp(lamp, ray.origin, kNoPrimitive));
    plain.push_back(hit.primitive != kNoPrimitive);
    own.push_back(ray.own_towards(lamp - ray.origin));
    met.push_back(hit.primitive);
    without.push_back(tracer.occluded(from_lamp(lamp, ray.origin, hit.primitive)));
  }
  compare_fans(scene, rays, lamp, own, plain);
  compare_fans(scene, rays, lamp, met, without);
}

void check(const Scene& scene, const BuildOptions& options) {
  const unsigned seed = test::seed(43);
  TESSERA_TRACE_SEED(seed);
  Random random(seed);
  const auto prepared = PreparedScene::build(scene, options);
  ASSERT_TRUE(prepared.is_ok());
  const PreparedScene::Impl& impl = (*prepared)->impl();
  std::vector<Leaving> rays = leaving_rays(impl, random, RayList::kRaysMax);
  ASSERT_GT(rays.size(), 200u);
  const SceneTracer tracer(impl.index, kernels_for(Isa::kScalar));
  std::vector<SingleHit> plain, without;
  std::vector<std::uint32_t> own, met;
  int named = 0;
  for (const Leaving& ray : rays) {
    plain.push_back(tracer.closest(single(ray)));
    own.push_back(ray.own());
    named += own.back() != kNoPrimitive;
    met.push_back(plain.back().primitive);
    without.push_back(tracer.closest(single(ray, met.back())));
    if (met.back() != kNoPrimitive) {
      EXPECT_NE(without.back().primitive, met.back());
      EXPECT_TRUE(without.back().primitive == kNoPrimitive || without.back().t >= plain.back().t);
    }
  }
  EXPECT_GT(named, static_cast<int>(rays.size()) / 2);
  compare(impl, rays, own, plain);
  // What is named is left out, even where a ray does meet it.
  compare(impl, rays, met, without);
  for (std::size_t i = 0; i < 8; ++i)
    check_fans(impl, rays, rays[i].origin + rays[i].direction * 3.0f);
}

Scene scene_of(const char* shape, int places) {
  Scene scene = test::patch_scene_of(shape);
  for (int i = 1; i < places; ++i)
    scene.instances.push_back({0,
                               test::turned_and_moved(0.7f, {1.5f * static_cast<float>(i), 0.4f, 0},
                                                      /*is_mirrored=*/i % 2 == 1),
                               ObjectKind::kPatchSurface});
  return scene;
}

TEST(ExcludedParts, ChangeNoAnswerInAHierarchy) {
  for (const char* shape : {"teapot", "torus", "sphere"}) check(scene_of(shape, 2), {});
}

TEST(ExcludedParts, ChangeNoAnswerAmongPlaces) {
  BuildOptions options;
  options.instancing = Instancing::kAlways;
  check(scene_of("teapot", 4), options);
}

}  // namespace
}  // namespace tessera::core
