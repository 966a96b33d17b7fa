// SPDX-License-Identifier: Apache-2.0
// Property: the kernels compute the points of the sample sequence and samples of emitters of a
// packet to the bit as plain arithmetic does for each alone, on every instruction set.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <memory>
#include <random>
#include <vector>

#include "common/math/rounding.h"
#include "slave/core/kernels/kernel_table.h"
#include "slave/core/light/light_sampling.h"
#include "slave/core/sampling/sample_sequence.h"
#include "tests/support/packets.h"
#include "tests/support/seed.h"

namespace tessera::core {
namespace {

bool same_bits(Vec3f a, Vec3f b) { return std::memcmp(&a, &b, sizeof(a)) == 0; }
Vec3f at(const float (&v)[3][kLitPoints], int i) { return {v[0][i], v[1][i], v[2][i]}; }

// Sobol's second dimension from one direction number after the other, as his paper has it.
std::uint32_t sobol2_by_directions(std::uint32_t i) {
  std::uint32_t sum = 0;
  for (std::uint32_t v = 1u << 31; i != 0; i >>= 1, v ^= v >> 1) {
    if ((i & 1u) != 0) sum ^= v;
  }
  return sum;
}

TEST(LightPackets, TheSecondDimensionIsSobols) {
  std::mt19937 random(test::seed(1));
  for (std::uint32_t i = 0; i < 100000; ++i) {
    ASSERT_EQ(sobol2_bits(i), sobol2_by_directions(i));
    const auto any = static_cast<std::uint32_t>(random());
    ASSERT_EQ(sobol2_bits(any), sobol2_by_directions(any)) << any;
  }
}

TEST(LightPackets, PointsOfTheSequenceAreThoseOfEachKeyAlone) {
  for (const Isa isa : test::isas_here()) {
    std::mt19937 random(test::seed(2));
    SamplePoints points{};
    for (int round = 0; round < 10000; ++round) {
      const auto dimension = static_cast<std::uint32_t>(random());
      const auto index = static_cast<std::uint32_t>(round % 3 == 0 ? random() : random() % 4096);
      points.count = 1 + static_cast<int>(random() % kSamplePoints);
      for (auto& key : points.key) key = static_cast<std::uint32_t>(random());
      kernels_for(isa).sample_points(dimension, index, points);
      for (int i = 0; i < points.count; ++i) {
        const Vec2f alone = shuffled_2d(hash_combine(points.key[i], dimension), index);
        ASSERT_TRUE(alone.x == points.square[0][i] && alone.y == points.square[1][i])
            << isa_name(isa);
      }
    }
  }
}

// A surface and an emitter, in front of each other, behind, next to each other, or far away.
struct Pair {
  LitSurfaces& lit;
  EmitterSamples& e;
  Emitter emitter;
  Vec3f point, normal, shading;
  float offset;

  void set(std::mt19937& random, int i) {
    std::uniform_real_distribution<float> unit(-1, 1);
    const auto any = [&](float size) {
      return Vec3f{unit(random) * size, unit(random) * size, unit(random) * size};
    };
    const float size = std::exp2(static_cast<float>(random() % 20) - 10);
    const Vec3f middle = random() % 4 == 0 ? any(1000) : Vec3f{};
    emitter.a = middle + any(size);
    emitter.edge_b = any(size);
    emitter.edge_c = any(size);
    const Vec3f across = cross(emitter.edge_b, emitter.edge_c);
    emitter.normal = normalize(across);
    emitter.area = length(across) / 2;
    emitter.share = std::fabs(unit(random));
    point = random() % 16 == 0 ? emitter.a : middle + any(3 * size);
    normal = normalize(any(1));
    shading = normalize(normal + any(0.5f));
    offset = 1e-6f * size;
    const float square[2] = {(unit(random) + 1) / 2, (unit(random) + 1) / 2};
    put(i, square);
  }

  void put(int i, const float (&square)[2]) {
    for (int a = 0; a < 3; ++a) {
      e.a[a][i] = emitter.a[a];
      e.edge_b[a][i] = emitter.edge_b[a];
      e.edge_c[a][i] = emitter.edge_c[a];
      e.emitter_normal[a][i] = emitter.normal[a];
      lit.point[a][i] = point[a];
      lit.normal[a][i] = normal[a];
      lit.shading_normal[a][i] = shading[a];
    }
    for (int a = 0; a < 2; ++a) e.square[a][i] = square[a];
    lit.offset[i] = offset;
    e.area[i] = emitter.area;
    e.chance[i] = emitter.share;
  }

  // Expects the rendering equation's strength in plain arithmetic. Returns: whether there is light.
  bool expect_plain(int i) const {
    const EmitterPoint on = point_on(LightSet{}, emitter, {e.square[0][i], e.square[1][i]});
    const Vec3f away = on.at.point - point;
    const float distance2 = dot(away, away), distance = std::sqrt(distance2);
    const Vec3f to_light = away * (1 / distance);
    const float cosine_light = -dot(emitter.normal, to_light), cosine = dot(shading, to_light);
    if (!(cosine_light > 0 && cosine > 0 && dot(normal, to_light) > 0)) {
      EXPECT_EQ(e.strength[i], 0);
      return false;
    }
    const float whole = cosine * cosine_light * emitter.area / distance2;
    EXPECT_EQ(e.strength[i], 0.318309886f * whole * (1 / (e.samples * emitter.share)));
    EXPECT_EQ(e.pdf[i], emitter.share / emitter.area * distance2 / cosine_light);
    EXPECT_TRUE(same_bits(to_light, at(e.to_light, i)));
    const Vec3f start = point + normal * offset;
    const Vec3f end = on.at.point + emitter.normal * (on.at.offset + gamma(2) * distance);
    EXPECT_TRUE(same_bits(start, at(e.start, i)));
    EXPECT_TRUE(same_bits(end - start, at(e.direction, i)));
    return true;
  }
};

TEST(LightPackets, SamplesOfEmittersAreThoseOfEachSurfaceAlone) {
  for (const Isa isa : test::isas_here()) {
    std::mt19937 random(test::seed(3));
    auto lit = std::make_unique<LitSurfaces>();
    auto samples = std::make_unique<EmitterSamples>();
    int lights = 0;
    for (int round = 0; round < 5000; ++round) {
      std::vector<Pair> pairs(static_cast<std::size_t>(kLitPoints),
                              Pair{*lit, *samples, {}, {}, {}, {}, 0});
      samples->count = 1 + static_cast<int>(random() % kLitPoints);
      samples->samples = static_cast<float>(1 + random() % 4);
      for (int i = 0; i < samples->count; ++i) pairs[static_cast<std::size_t>(i)].set(random, i);
      kernels_for(isa).emitter_samples(*lit, *samples);
      for (int i = 0; i < samples->count; ++i)
        lights += pairs[static_cast<std::size_t>(i)].expect_plain(i) ? 1 : 0;
      if (HasFailure()) FAIL() << isa_name(isa);
    }
    EXPECT_GT(lights, 10000) << isa_name(isa);
  }
}

}  // namespace
}  // namespace tessera::core
