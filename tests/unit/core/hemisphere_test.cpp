// SPDX-License-Identifier: Apache-2.0
// Directions about a normal: unit length, the right pdf, the same on both sides of every branch.
#include "slave/core/sampling/hemisphere.h"

#include <gtest/gtest.h>

#include <random>

#include "slave/core/sampling/sample_sequence.h"
#include "tests/support/seed.h"

namespace tessera::core {
namespace {

constexpr double kPi = 3.14159265358979323846;

TEST(Hemisphere, SineAndCosineAreRoundedOnce) {
  for (int i = -4096; i <= 4096; ++i) {
    const float x = static_cast<float>(i) / 32768;
    const SinCos t = sin_cos_turn(x);
    EXPECT_NEAR(t.sin, std::sin(2 * kPi * x), 2e-7) << x;
    EXPECT_NEAR(t.cos, std::cos(2 * kPi * x), 2e-7) << x;
  }
}

TEST(Hemisphere, AWholeTurnIsMadeOfItsEighths) {
  for (int i = 0; i <= 4096; ++i) {
    const float x = static_cast<float>(i) / 4096;
    const SinCos t = sin_cos_whole_turn(x);
    EXPECT_NEAR(t.sin, std::sin(2 * kPi * x), 2e-7) << x;
    EXPECT_NEAR(t.cos, std::cos(2 * kPi * x), 2e-7) << x;
  }
}

TEST(Hemisphere, TheDiskIsCoveredEvenly) {
  // Each of the cells of 8 rings of equal area and 8 sectors gets as many points.
  int count[8][8] = {};
  constexpr int kPoints = 1 << 18;
  for (std::uint32_t i = 0; i < kPoints; ++i) {
    const Vec2f d = concentric_disk(sample_2d(99, i));
    const double r2 = double{d.x} * d.x + double{d.y} * d.y;
    ASSERT_LT(r2, 1.000001);
    const double turn = std::atan2(d.y, d.x) / (2 * kPi) + 0.5;
    ++count[std::min(7, static_cast<int>(8 * r2))][std::min(7, static_cast<int>(8 * turn))];
  }
  for (const auto& ring : count) {
    for (const int n : ring) EXPECT_NEAR(n, kPoints / 64.0, 0.01 * kPoints / 64);
  }
}

TEST(Hemisphere, DirectionsAreOfUnitLengthAboveTheSurfaceAndCosineWeighted) {
  std::mt19937 random(test::seed(1));
  std::normal_distribution<float> normal_distribution;
  for (int k = 0; k < 200; ++k) {
    Vec3f n = normalize(
        {normal_distribution(random), normal_distribution(random), normal_distribution(random)});
    if (k < 6)
      n = {k == 0   ? 1.0f
           : k == 1 ? -1.0f
                    : 0,
           k == 2   ? 1.0f
           : k == 3 ? -1.0f
                    : 0,
           k == 4   ? 1.0f
           : k == 5 ? -1.0f
                    : 0};
    double cosine = 0, cosine2 = 0;
    constexpr std::uint32_t kCount = 1024;
    for (std::uint32_t i = 0; i < kCount; ++i) {
      const Vec3f d = cosine_direction(n, sample_2d(7, i));
      ASSERT_NEAR(length(d), 1, 1e-6);
      const double c = dot(d, n);
      ASSERT_GE(c, -1e-6);
      cosine += c / kCount;
      cosine2 += c * c / kCount;
    }
    EXPECT_NEAR(cosine, 2 / 3.0, 2e-3);  // the mean for the pdf cosine / pi
    EXPECT_NEAR(cosine2, 1 / 2.0, 2e-3);
  }
}

}  // namespace
}  // namespace tessera::core
