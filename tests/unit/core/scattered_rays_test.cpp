// SPDX-License-Identifier: Apache-2.0
// Each ray that a surface scatters has a pdf by which its light can be weighed.
#include "slave/core/integrate/scattered_rays.h"

#include <gtest/gtest.h>

#include <memory>
#include <random>
#include <vector>

#include "slave/core/integrate/frame_light.h"
#include "slave/core/sampling/hemisphere.h"
#include "slave/core/sampling/sample_sequence.h"
#include "tests/support/packets.h"
#include "tests/support/seed.h"
#include "tests/support/test_meshes.h"

namespace tessera::core {
namespace {

constexpr std::uint32_t kDimension = 7, kSample = 3;

// Keys whose sample lies on the edge of the unit square, where directions run along the surface.
// One key of 2^24 is such.
std::vector<std::uint32_t> keys_on_the_edge(const KernelTable& kernels) {
  std::vector<std::uint32_t> keys;
  SamplePoints points{};
  points.count = kSamplePoints;
  for (std::uint32_t first = 0; keys.size() < 3 && first < 1u << 29; first += kSamplePoints) {
    for (std::uint32_t i = 0; i < kSamplePoints; ++i) points.key[i] = first + i;
    kernels.sample_points(kDimension, kSample, points);
    for (std::uint32_t i = 0; i < kSamplePoints; ++i) {
      if (points.square[0][i] == 0) keys.push_back(first + i);
    }
  }
  return keys;
}

TEST(ScatteredRays, HaveADensityOrAreNotTraced) {
  const auto prepared = *PreparedScene::build(test::make_scene(test::make_cube()), {});
  const KernelTable& kernels = kernels_for(test::isas_here().back());
  const SceneTracer tracer(prepared->impl().index, kernels);
  auto batch = std::make_unique<SurfaceBatch>();
  const FrameSettings settings;
  const CameraRays camera(settings.camera, settings.width_px, settings.height_px);
  FrameLight light;
  const RenderContext context{prepared->impl(), tracer, settings, camera, light};
  const auto memory = std::make_unique<ScatteredRays::Memory>();
  ScatteredRays rays(context, *memory);
  Surface& s = batch->surface[0];
  batch->count = 1;
  s.albedo = {1, 1, 1};
  std::mt19937 random(test::seed(4));
  std::uniform_real_distribution<float> unit(-1, 1);
  const auto any = [&](float size) {
    return Vec3f{unit(random) * size, unit(random) * size, unit(random) * size};
  };
  const std::vector<std::uint32_t> keys = keys_on_the_edge(kernels);
  ASSERT_EQ(keys.size(), 3u);
  int left_out = 0, traced = 0;
  for (int round = 0; round < 3000; ++round) {
    const std::uint32_t key = round % 2 == 0 ? keys[static_cast<std::size_t>(round / 2 % 3)]
                                             : static_cast<std::uint32_t>(random());
    s.shading_normal = normalize(any(1));
    s.normal = normalize(s.shading_normal + any(0.2f));
    const Vec3f way =
        cosine_direction(s.shading_normal, shuffled_2d(hash_combine(key, kDimension), kSample));
    const bool is_above = dot(way, s.normal) > 0, has_pdf = dot(way, s.shading_normal) > 0;
    rays.clear();
    rays.ask(0, key);
    rays.scatter(*batch, kDimension, kSample);
    ASSERT_EQ(rays.count(), is_above && has_pdf ? 1 : 0);
    if (rays.count() == 1) {
      ASSERT_GT(rays.pdf(0), 0);
    }
    left_out += is_above && !has_pdf ? 1 : 0;
    traced += rays.count();
  }
  EXPECT_GT(left_out, 100);
  EXPECT_GT(traced, 1000);
}

}  // namespace
}  // namespace tessera::core
