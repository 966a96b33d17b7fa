// SPDX-License-Identifier: Apache-2.0
// Property: hit or miss, primitive and distance agree with all triangles tested in double
// precision, wherever the ray passes an edge by more than the tolerance of 16 u s.
#include <gtest/gtest.h>

#include <random>

#include "slave/core/scene/prepared_scene_impl.h"
#include "tests/support/packets.h"
#include "tests/support/seed.h"
#include "tests/support/test_meshes.h"

namespace tessera::core {
namespace {

void expect_agreement(const char* name, const Mesh& mesh, float radius, Vec3f centre,
                      std::size_t count, std::uint32_t seed) {
  const auto scene = PreparedScene::build(test::make_scene(mesh), {});
  ASSERT_TRUE(scene.is_ok());
  const TriangleStore& store = (*scene)->impl().triangles;
  std::vector<test::ReferenceTriangle> triangles;
  for (std::uint64_t i = 0; i < store.primitive_count(); ++i) {
    triangles.push_back({store.vertex(i, 0), store.vertex(i, 1), store.vertex(i, 2)});
  }
  std::mt19937 random(test::seed(seed));
  std::uniform_real_distribution<float> unit(-1, 1);
  std::vector<test::Ray> rays;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3f from{unit(random), unit(random), unit(random)},
        to{unit(random), unit(random), unit(random)};
    const Vec3f origin = centre + from * (1.5f * radius);
    rays.push_back({origin, centre + to * radius - origin, 0, i % 5 == 0 ? 0.7f : Bounds3f::kInf});
  }
  const std::vector<test::Hit> hits =
      test::trace_packets(kernels_for(widest_isa(supported_isas())), (*scene)->impl(), rays);
  std::size_t hit_count = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const char* wrong =
        test::judge(rays[i], triangles, hits[i].is_hit(), hits[i].primitive, hits[i].t);
    ASSERT_EQ(nullptr, wrong) << name << ", seed " << seed << ", ray " << i << ": " << wrong;
    hit_count += hits[i].is_hit() ? 1u : 0u;
  }
  EXPECT_GT(hit_count, count / 10) << name;
}

TEST(ReferenceAgreement, HitMissPrimitiveAndDistanceAreRight) {
  for (std::uint32_t seed = 1; seed <= 4; ++seed) {
    expect_agreement("soup", test::make_random_triangles(1500, 0.2f, seed), 1, {}, 4000, seed);
    expect_agreement("large", test::make_random_triangles(200, 2.0f, seed), 1, {}, 8000, seed);
    expect_agreement("sphere", test::make_icosphere(3), 1, {}, 4000, seed);
    expect_agreement("torus", test::make_torus(40, 20), 1, {}, 4000, seed);
  }
}

TEST(ReferenceAgreement, HoldsFarFromTheWorldOriginAndAtEveryScale) {
  struct Place {
    float scale;
    Vec3f offset;
  };
  const Place places[] = {
      {1, {1e6f, 1e6f, -1e6f}}, {1e-6f, {}}, {1e6f, {}}, {1e-9f, {}}, {1e9f, {}}};
  for (const Place& place : places) {
    Mesh mesh = test::make_random_triangles(1000, 0.3f, 8);
    test::place(mesh, place.scale, place.offset);
    expect_agreement("placed", mesh, place.scale, place.offset, 4000, 21);
  }
}

TEST(ReferenceAgreement, SmallAndVeryLargeTrianglesTogether) {
  Mesh mesh = test::make_random_triangles(1000, 0.1f, 8);
  const auto n = static_cast<std::uint32_t>(mesh.positions.size());
  mesh.positions.insert(mesh.positions.end(),
                        {{-1e4f, -1.1f, -1e4f}, {1e4f, -1.1f, -1e4f}, {0, -1.1f, 2e4f}});
  mesh.triangles.push_back({n, n + 1, n + 2});
  expect_agreement("floor", mesh, 1, {}, 8000, 5);
}

}  // namespace
}  // namespace tessera::core
