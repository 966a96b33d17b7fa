// SPDX-License-Identifier: Apache-2.0
// Property: on every class of hard cases nothing is missed, wrong, false or leaking, and
// structures, sizes of bundles, threads and instruction sets agree to the bit.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>

#include "slave/core/scene/ray_caster.h"
#include "tests/support/hard_cases.h"
#include "tests/support/packets.h"
#include "tests/support/seed.h"
#include "tests/support/test_meshes.h"

namespace tessera::core {
namespace {

constexpr std::uint32_t kSeed = 20061;
constexpr std::size_t kRays = 100'000;
constexpr std::size_t kJudged =
    4'000;  // against every triangle; tessera-bench accuracy judges more

std::vector<CastRay> cast_rays_of(const test::HardCase& hard) {
  std::vector<CastRay> rays;
  for (const test::Ray& ray : hard.rays)
    rays.push_back({ray.origin, ray.direction, ray.t_min, ray.t_max});
  return rays;
}

std::vector<CastHit> hits_of(const PreparedScene& scene, std::span<const CastRay> rays,
                             const CastOptions& options) {
  std::vector<CastHit> hits(rays.size());
  cast_rays(scene, rays, options, hits);
  return hits;
}

bool is_same(const CastHit& a, const CastHit& b) {
  const auto bits = [](float x) { return std::bit_cast<std::uint32_t>(x); };
  return a.is_hit == b.is_hit && a.primitive == b.primitive && bits(a.t) == bits(b.t) &&
         bits(a.u) == bits(b.u) && bits(a.v) == bits(b.v);
}

class HardCases : public testing::TestWithParam<std::string> {};

TEST_P(HardCases, AreAnsweredRightly) {
  const test::HardCase hard = test::make_hard_case(GetParam(), kJudged, test::seed(kSeed));
  std::vector<test::Answer> answers;
  const auto scene = PreparedScene::build(test::make_scene(hard.mesh), {});
  ASSERT_TRUE(scene.is_ok());
  for (const CastHit& hit :
       hits_of(**scene, cast_rays_of(hard), {widest_isa(supported_isas()), 64, 1, false}))
    answers.push_back({hit.is_hit, hit.primitive, hit.t, hit.u, hit.v});
  test::Verdicts verdicts = test::judge_all(hard, answers);
  EXPECT_EQ(verdicts.missed, 0u) << "seed " << kSeed;
  EXPECT_EQ(verdicts.wrong, 0u) << "seed " << kSeed;
  EXPECT_EQ(verdicts.false_hits, 0u) << "seed " << kSeed;
  EXPECT_EQ(verdicts.leaks, 0u) << "seed " << kSeed;
  EXPECT_EQ(verdicts.invalid, 0u) << "seed " << kSeed;
  EXPECT_LE(verdicts.worst, 4) << "seed " << kSeed << ": " << verdicts.worst_ray;
  for (const double error : verdicts.t_relative) ASSERT_LE(error, 4 * 0x1p-24) << "seed " << kSeed;
}

TEST_P(HardCases, AreAnsweredTheSameOnEveryWay) {
  const test::HardCase hard = test::make_hard_case(GetParam(), kRays, test::seed(kSeed + 1));
  const std::vector<CastRay> rays = cast_rays_of(hard);
  const auto bvh = PreparedScene::build(test::make_scene(hard.mesh), {1, nullptr, Structure::kBvh});
  ASSERT_TRUE(bvh.is_ok());
  const std::vector<CastHit> first = hits_of(**bvh, rays, {Isa::kScalar, 1, 2, false});
  std::size_t ways = 0;
  for (const Structure structure :
       {Structure::kBvh, Structure::kBvhQuality, Structure::kKd, Structure::kKdQuality}) {
    const auto scene = PreparedScene::build(test::make_scene(hard.mesh), {1, nullptr, structure});
    ASSERT_TRUE(scene.is_ok());
    for (const Isa isa : test::isas_here()) {
      for (const int bundle : {1, 4, 16, 64}) {
        for (const bool is_any : {false, true}) {
          // Narrow packets of the scalar set are single rays with a detour; one size is enough.
          if (isa == Isa::kScalar && bundle != 64) continue;
          // A quarter of the rays each way, so that all of them go each of the larger ways.
          const std::size_t part = kRays / 4, at = ways % 4 * part;
          const std::vector<CastHit> hits = hits_of(**scene, std::span(rays).subspan(at, part),
                                                    {isa, bundle, 1 + bundle % 3, is_any});
          std::size_t differing = 0;
          for (std::size_t i = 0; i < part; ++i) {
            const CastHit& expected = first[at + i];
            const bool agrees =
                is_any ? hits[i].is_hit == expected.is_hit : is_same(hits[i], expected);
            differing += agrees ? 0u : 1u;
          }
          EXPECT_EQ(differing, 0u)
              << "seed " << kSeed + 1 << " " << isa_name(isa) << " bundle " << bundle
              << (is_any ? " any " : " ") << structure_names()[static_cast<std::size_t>(structure)];
          ++ways;
        }
      }
    }
  }
  EXPECT_GE(ways, 4u);
}

INSTANTIATE_TEST_SUITE_P(All, HardCases, testing::ValuesIn(test::hard_case_names()),
                         [](const auto& info) {
                           std::string name;
                           for (const char c : info.param)
                             if (std::isalnum(static_cast<unsigned char>(c)) != 0) name += c;
                           return name;
                         });

}  // namespace
}  // namespace tessera::core
