// SPDX-License-Identifier: Apache-2.0
// Property: the kernels look up and sample the environment map for whole packets to the bit as
// SkyMap does for each direction and each sample alone, on every instruction set.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <random>

#include "slave/core/kernels/kernel_table.h"
#include "slave/core/light/sky_map.h"
#include "tests/support/packets.h"
#include "tests/support/plain_sky.h"
#include "tests/support/seed.h"

namespace tessera::core {
namespace {

bool same_bits(Vec3f a, Vec3f b) { return std::memcmp(&a, &b, sizeof(a)) == 0; }
Vec3f at(const float (&v)[3][kSkyPoints], int i) { return {v[0][i], v[1][i], v[2][i]}; }

// An environment map over 12 orders of magnitude, half of it black, with a sun.
std::shared_ptr<const EnvironmentMap> make_map(int width_px, int height_px) {
  std::mt19937 random(static_cast<unsigned>(width_px));
  std::uniform_real_distribution<float> exponent(-6, 6);
  auto map = std::make_shared<EnvironmentMap>();
  map->width_px = width_px;
  map->height_px = height_px;
  for (int i = 0; i < 3 * width_px * height_px; ++i)
    map->rgb.push_back(random() % 2 == 0 ? 0 : std::pow(10.0f, exponent(random)));
  map->rgb[map->rgb.size() / 3] = 1e9f;
  return map;
}

// A direction, at times along the axes or on the seam, or the zero vector.
Vec3f any_direction(std::mt19937& random) {
  std::uniform_real_distribution<float> unit(-1, 1);
  const float odd[] = {0, -0.0f, 1, -1, 1e-30f, 1e-10f};
  const auto part = [&] { return random() % 4 == 0 ? odd[random() % 6] : unit(random); };
  const float x = part(), y = part(), z = part();
  return random() % 2 == 0 ? normalize({x, y, z}) : Vec3f{x, y, z} * 7;
}

// A number in [0, 1), at times one of its ends or where parts of the map meet.
float any_share(std::mt19937& random) {
  const float below_one = 1 - std::numeric_limits<float>::epsilon() / 2;
  switch (random() % 4) {
    case 0:
      return random() % 2 == 0 ? 0 : below_one;
    case 1:
      return static_cast<float>(random() % 64) / 64;
    default:
      return std::uniform_real_distribution<float>(0, below_one)(random);
  }
}

class SkyPackets : public testing::TestWithParam<std::pair<int, int>> {};

TEST_P(SkyPackets, SeeWhatEachDirectionSees) {
  const auto [width, height] = GetParam();
  const SkyMap sky(make_map(width, height));
  const SkyView view = sky.view();
  for (const Isa isa : test::isas_here()) {
    std::mt19937 random(test::seed(3));
    SkyPoints points{};
    for (int round = 0; round < 4000; ++round) {
      Vec3f direction[kSkyPoints];
      points.wanted = std::uint64_t{random()} << 32 | random();
      for (int i = 0; i < kSkyPoints; ++i) {
        direction[i] = any_direction(random);
        const bool is_wanted = (points.wanted >> i & 1u) != 0;
        for (int a = 0; a < 3; ++a)
          points.direction[a][i] = is_wanted ? direction[i][a] : std::nanf("");
      }
      kernels_for(isa).sky_light(view, points);
      for (int i = 0; i < kSkyPoints; ++i) {
        if ((points.wanted >> i & 1u) == 0) continue;
        const Vec3f d = direction[i];
        ASSERT_TRUE(same_bits(test::plain_radiance(sky, d), at(points.radiance, i)))
            << d.x << " " << d.y << " " << d.z << " " << isa_name(isa);
        ASSERT_EQ(test::plain_pdf(sky, d), points.pdf[i]) << d.x << " " << d.y << " " << d.z;
      }
    }
  }
}

TEST_P(SkyPackets, SampleWhatEachSquareSamples) {
  const auto [width, height] = GetParam();
  const SkyMap sky(make_map(width, height));
  const SkyView view = sky.view();
  for (const Isa isa : test::isas_here()) {
    std::mt19937 random(test::seed(4));
    SkyPoints points{};
    for (int round = 0; round < 4000; ++round) {
      points.wanted = std::uint64_t{random()} << 32 | random();
      for (int i = 0; i < kSkyPoints; ++i) {
        for (auto& axis : points.square) axis[i] = any_share(random);
      }
      kernels_for(isa).sky_samples(view, points);
      for (int i = 0; i < kSkyPoints; ++i) {
        if ((points.wanted >> i & 1u) == 0) continue;
        const SkyMap::Sample alone = sky.sample({points.square[0][i], points.square[1][i]});
        ASSERT_TRUE(same_bits(alone.direction, at(points.direction, i))) << isa_name(isa);
        ASSERT_TRUE(same_bits(alone.radiance, at(points.radiance, i)));
        ASSERT_EQ(alone.angle, points.angle[i]);
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Maps, SkyPackets,
                         testing::Values(std::pair{64, 32}, std::pair{1, 1}, std::pair{37, 5},
                                         std::pair{1024, 512}));

}  // namespace
}  // namespace tessera::core
