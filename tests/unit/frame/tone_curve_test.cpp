// SPDX-License-Identifier: Apache-2.0
#include "common/frame/tone_curve.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "common/frame/frame_image.h"
#include "tests/support/seed.h"

namespace tessera {
namespace {

constexpr ToneCurve kCurves[] = {ToneCurve::kLinear, ToneCurve::kFilmic, ToneCurve::kAces,
                                 ToneCurve::kAgx};

Vec3f grey(float x) { return {x, x, x}; }

TEST(ToneCurve, MiddleGreyStaysMiddleGreyUnderEveryCurve) {
  for (const ToneCurve tone : kCurves) {
    const Vec3f shown = displayed(grey(0.18f), {0, tone});
    for (int a = 0; a < 3; ++a) EXPECT_NEAR(shown[a], 0.18f, 2e-4f) << tone_curve_name(tone);
  }
}

TEST(ToneCurve, ExposureIsCountedInStops) {
  for (const ToneCurve tone : kCurves) {
    for (const float ev : {-3.0f, -0.5f, 1.0f, 4.0f}) {
      const Vec3f radiance{0.02f, 0.3f, 0.1f};
      const Vec3f by_ev = displayed(radiance, {ev, tone});
      const Vec3f by_hand = displayed(radiance * std::exp2(ev), {0, tone});
      for (int a = 0; a < 3; ++a) EXPECT_NEAR(by_ev[a], by_hand[a], 1e-6f);
    }
  }
}

TEST(ToneCurve, MoreLightIsNeverShownDarkerAndStaysInRange) {
  for (const ToneCurve tone : kCurves) {
    float last = -1;
    for (int step = -200; step <= 200; ++step) {
      const float x = displayed(grey(std::exp2(static_cast<float>(step) / 8)), {0, tone}).y;
      EXPECT_GE(x, last) << tone_curve_name(tone) << " at step " << step;
      EXPECT_LE(x, 1);
      last = x;
    }
    EXPECT_GT(last, 0.99f) << tone_curve_name(tone);
  }
}

// By Sobotka's sigmoid 6.5 stops above middle grey are white, ten below are black, and the middle
// is 0.5 of the encoded range at slope 2. The curve is scaled afterwards to keep middle grey.
TEST(ToneCurve, AgxSpansItsStops) {
  const float black = displayed(grey(0.18f * std::exp2(-11.0f)), {0, ToneCurve::kAgx}).y;
  const float white = displayed(grey(0.18f * std::exp2(7.0f)), {0, ToneCurve::kAgx}).y;
  EXPECT_LT(black, 1e-4f);
  EXPECT_GT(white, 0.995f);
}

TEST(ToneCurve, AcesIsHillsFit) {
  // The fit's own figures at 1: (1 + 0.0245786 - 0.000090537) / (0.983729 + 0.4329510 + 0.238081).
  // Without a scale grey 1 is shown as 0.6191 of the rows' sums, which are 1 to three digits.
  double scale = 1;
  for (int i = 0; i < 60; ++i) {  // fixed point: where the fit reaches 0.18
    const double x = 0.18 * scale;
    const double y =
        (x * (x + 0.0245786) - 0.000090537) / (x * (0.983729 * x + 0.432951) + 0.238081);
    scale *= std::sqrt(0.18 / y);
  }
  const float at = static_cast<float>(1 / scale);
  EXPECT_NEAR(displayed(grey(at), {0, ToneCurve::kAces}).y, 0.6191f, 2e-3f);
}

TEST(ToneCurve, WhatIsNoLightIsBlackAndWhatIsEndlessIsWhite) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  constexpr float kInf = std::numeric_limits<float>::infinity();
  for (const ToneCurve tone : kCurves) {
    EXPECT_EQ(displayed(grey(kNan), {0, tone}).x, displayed(grey(0), {0, tone}).x);
    EXPECT_EQ(displayed(grey(-1), {0, tone}).y, displayed(grey(0), {0, tone}).y);
    EXPECT_LT(displayed(grey(0), {0, tone}).z, 1e-6f);
    EXPECT_GT(displayed(grey(kInf), {0, tone}).z, 0.99f);
  }
}

TEST(ToneCurve, ColoursOfTheDisplayAreFoundAgain) {
  const unsigned seed = 20061;
  std::mt19937 random(test::seed(seed));
  std::uniform_real_distribution<float> unit(0.02f, 0.98f);
  for (int i = 0; i < 2000; ++i) {
    // Colours near grey, which every curve can show.
    const float middle = unit(random);
    const Vec3f light{middle, middle * (0.9f + 0.1f * unit(random)), middle * 0.95f};
    for (const ToneCurve tone : kCurves) {
      const DisplayTransform transform{unit(random) * 8 - 4, tone};
      const Vec3f again = displayed(radiance_of(light, transform), transform);
      for (int a = 0; a < 3; ++a)
        ASSERT_NEAR(again[a], light[a], 5e-4f) << tone_curve_name(tone) << ", seed " << seed;
    }
  }
}

TEST(ToneCurve, TablesAreTheCurves) {
  for (const ToneCurve tone : {ToneCurve::kFilmic, ToneCurve::kAces, ToneCurve::kAgx}) {
    const ToneTable table = tone_table(tone);
    for (int step = 0; step < 2000; ++step) {
      const float x = std::exp2(-16 + 0.0101f * static_cast<float>(step));
      float bent[3], light[3];
      for (int a = 0; a < 3; ++a) {
        const float in = (table.in[a][0] + table.in[a][1] + table.in[a][2]) * x;
        const float at = (std::log2(in) - ToneTable::kLowEv) /
                         (ToneTable::kHighEv - ToneTable::kLowEv) * (ToneTable::kSamples - 1);
        const int below = static_cast<int>(at);
        const float share = at - static_cast<float>(below);
        bent[a] = table.of[below] * (1 - share) + table.of[below + 1] * share;
      }
      for (int a = 0; a < 3; ++a)
        light[a] =
            table.out[a][0] * bent[0] + table.out[a][1] * bent[1] + table.out[a][2] * bent[2];
      const Vec3f exact = displayed(grey(x), {0, tone});
      ASSERT_NEAR(std::clamp(light[1], 0.0f, 1.0f), exact.y, 1e-4f) << tone_curve_name(tone);
    }
  }
}

TEST(ToneCurve, Display8PixelsAreExposedAndLinearOnesAreNot) {
  const std::vector<float> rgb{0.1f, 0.2f, 0.4f};
  const DisplayTransform transform{1, ToneCurve::kFilmic};
  std::vector<std::byte> plain(3), shown(3), linear(12), linear_too(12);
  encode_pixels(rgb, PixelFormat::kDisplay8, plain);
  encode_pixels(rgb, PixelFormat::kDisplay8, shown, transform);
  encode_pixels(rgb, PixelFormat::kFloat, linear);
  encode_pixels(rgb, PixelFormat::kFloat, linear_too, transform);
  EXPECT_NE(plain, shown);
  EXPECT_EQ(linear, linear_too);
  const Vec3f light = displayed({0.1f, 0.2f, 0.4f}, transform);
  EXPECT_EQ(static_cast<int>(shown[1]), std::lround(255 * srgb_encode(light.y)));
}

}  // namespace
}  // namespace tessera
