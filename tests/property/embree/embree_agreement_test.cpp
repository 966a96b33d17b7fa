// SPDX-License-Identifier: Apache-2.0
// Property: on meshes too large for brute force, the kernels and Embree (robust mode) give the same
// hits. Where they differ, the ray passes an edge within the tolerance of the double reference, or
// two triangles lie equally far.
#include <embree3/rtcore.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <random>

#include "slave/core/scene/prepared_scene_impl.h"
#include "tests/support/packets.h"
#include "tests/support/seed.h"
#include "tests/support/test_meshes.h"

namespace tessera::core {
namespace {

// An Embree scene of one mesh, in the order of the product's triangles.
class EmbreeScene {
 public:
  explicit EmbreeScene(const TriangleStore& store) {
    RTCGeometry geometry = rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_TRIANGLE);
    const auto count = static_cast<std::size_t>(store.primitive_count());
    auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(
        geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), 3 * count));
    auto* indices = static_cast<unsigned*>(rtcSetNewGeometryBuffer(
        geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(unsigned), count));
    for (std::size_t i = 0; i < 3 * count; ++i) {
      const Vec3f corner = store.vertex(i / 3, static_cast<int>(i % 3));
      for (int axis = 0; axis < 3; ++axis) *vertices++ = corner[axis];
      *indices++ = static_cast<unsigned>(i);
    }
    rtcSetSceneFlags(scene_.get(), RTC_SCENE_FLAG_ROBUST);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene_.get(), geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene_.get());
  }

  test::Hit trace(const test::Ray& ray) const {
    RTCRayHit query{};
    query.ray.org_x = ray.origin[0], query.ray.org_y = ray.origin[1],
    query.ray.org_z = ray.origin[2];
    query.ray.dir_x = ray.direction[0], query.ray.dir_y = ray.direction[1];
    query.ray.dir_z = ray.direction[2];
    query.ray.tnear = ray.t_min, query.ray.tfar = ray.t_max;
    query.ray.mask = ~0u;
    query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcIntersect1(scene_.get(), &context, &query);
    if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return {};
    return {query.hit.primID, query.ray.tfar, query.hit.u, query.hit.v};
  }

 private:
  struct Release {
    void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
    void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
  };
  std::unique_ptr<RTCDeviceTy, Release> device_{rtcNewDevice("threads=1")};
  std::unique_ptr<RTCSceneTy, Release> scene_{rtcNewScene(device_.get())};
};

test::ReferenceAnswer reference_of(const TriangleStore& store, const test::Ray& ray,
                                   const test::Hit& hit) {
  const std::uint64_t i = hit.primitive;
  return test::reference_hit(ray, {store.vertex(i, 0), store.vertex(i, 1), store.vertex(i, 2)});
}

// Whether two different answers are both right.
bool is_excused(const TriangleStore& store, const test::Ray& ray, const test::Hit& ours,
                const test::Hit& theirs) {
  double slack = 0;
  for (const test::Hit& hit : {ours, theirs}) {
    if (!hit.is_hit()) continue;
    const test::ReferenceAnswer answer = reference_of(store, ray, hit);
    if (answer.verdict == test::Verdict::kEdge) return true;
    slack += 2 * answer.t_error;
  }
  if (!ours.is_hit() || !theirs.is_hit()) return false;
  return std::abs(static_cast<double>(ours.t) - static_cast<double>(theirs.t)) <= slack;
}

void expect_agreement(const char* name, Mesh mesh, std::size_t count, std::uint32_t seed) {
  const auto scene = PreparedScene::build(test::make_scene(std::move(mesh)), {});
  ASSERT_TRUE(scene.is_ok());
  const TriangleStore& store = (*scene)->impl().triangles;
  const EmbreeScene embree(store);
  std::mt19937 random(test::seed(seed + 1000));  // not the stream of the corners
  std::uniform_real_distribution<float> unit(-1, 1);
  std::vector<test::Ray> rays;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3f from{unit(random), unit(random), unit(random)};
    const Vec3f to{unit(random), unit(random), unit(random)};
    rays.push_back({from * 2, to - from * 2, 0, Bounds3f::kInf});
  }
  const auto hits =
      test::trace_packets(kernels_for(widest_isa(supported_isas())), (*scene)->impl(), rays);
  std::size_t hit_count = 0, differing = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const test::Hit theirs = embree.trace(rays[i]);
    hit_count += theirs.is_hit() ? 1u : 0u;
    if (hits[i].primitive == theirs.primitive) continue;
    ++differing;
    ASSERT_TRUE(is_excused(store, rays[i], hits[i], theirs))
        << name << ", seed " << seed << ", ray " << i << ": primitive " << hits[i].primitive
        << " at " << hits[i].t << ", Embree " << theirs.primitive << " at " << theirs.t;
  }
  EXPECT_GT(hit_count, count / 10) << name;
  EXPECT_LT(differing, count / 1000) << name;
}

TEST(EmbreeAgreement, TheSameHitsOnLargeMeshes) {
  for (std::uint32_t seed = 1; seed <= 2; ++seed) {
    expect_agreement("terrain", test::make_terrain(200, seed), 50'000, seed);
    expect_agreement("soup", test::make_random_triangles(100'000, 0.05f, seed), 50'000, seed);
    expect_agreement("sphere", test::make_icosphere(6), 50'000, seed);
  }
}

}  // namespace
}  // namespace tessera::core
