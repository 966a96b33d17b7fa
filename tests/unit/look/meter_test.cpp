// SPDX-License-Identifier: Apache-2.0
#include "master/look/meter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

namespace tessera::master {
namespace {

// A grey picture with one value for each pixel.
std::vector<float> grey(const std::vector<float>& values) {
  std::vector<float> rgb;
  for (const float x : values) rgb.insert(rgb.end(), {x, x, x});
  return rgb;
}

std::vector<float> of(std::size_t count, float value) { return std::vector<float>(count, value); }

std::vector<float> joined(std::vector<float> a, const std::vector<float>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

TEST(Meter, AnEvenPictureBecomesMiddleGrey) {
  for (const float radiance : {1e-4f, 0.18f, 3.0f, 700.0f}) {
    const Metering m = meter(grey(of(100, radiance)), grey(of(100, 1)));
    EXPECT_NEAR(radiance * std::exp2(m.exposure_ev), 0.18, 0.18 * 0.006)  // half of 1/64 stop
        << radiance;
    EXPECT_EQ(m.seen_share, 1);
  }
}

TEST(Meter, BackgroundIsNeitherMeteredNorCountedAsLit) {
  const auto rgb = grey(joined(of(50, 0.18f), of(50, 40)));
  const auto distance = grey(joined(of(50, 2), of(50, 0)));
  const Metering m = meter(rgb, distance);
  EXPECT_NEAR(m.exposure_ev, 0, 1.0 / 64);
  EXPECT_EQ(m.seen_share, 1);
}

TEST(Meter, ASmallLampDoesNotDarkenThePicture) {
  const Metering m = meter(grey(joined(of(97, 0.18f), of(3, 1e4f))), grey(of(100, 1)));
  EXPECT_NEAR(m.exposure_ev, 0, 1.0 / 64);
}

TEST(Meter, ALampThatLightsNothingElseLeavesASceneUnlit) {
  const Metering m = meter(grey(joined(of(95, 0), of(5, 10))), grey(of(100, 1)));
  EXPECT_NEAR(m.seen_share, 0.05, 1e-9);
  EXPECT_LT(m.seen_share, kSeenShareMin);
}

TEST(Meter, WhatIsMoreThanSixStopsBelowTheMiddleIsNotSeen) {
  const float dim = 0.18f / 1024;  // ten stops; the metered middle is one below 0.18
  const Metering m = meter(grey(joined(of(40, dim), of(160, 0.18f))), grey(of(200, 1)));
  EXPECT_NEAR(m.seen_share, 0.8, 1e-9);
}

TEST(Meter, TheDarkHasNoExposureAndNaNIsDark) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (const float x : {0.0f, -1.0f, nan}) {
    const Metering m = meter(grey(of(10, x)), grey(of(10, 1)));
    EXPECT_EQ(m.seen_share, 0);
    EXPECT_EQ(m.exposure_ev, 0);
    EXPECT_TRUE(m.has_surface);
  }
}

TEST(Meter, ExposureIsBoundedAndInSteps) {
  const Metering dim = meter(grey(of(10, 1e-30f)), grey(of(10, 1)));
  EXPECT_EQ(dim.exposure_ev, kAutoExposureEvMax);
  const Metering any = meter(grey(of(10, 0.3f)), grey(of(10, 1)));
  EXPECT_EQ(any.exposure_ev * 64, std::round(any.exposure_ev * 64));
}

TEST(Meter, StudioLeavesWhiteWhiteAndBlackBlackButOpensDarkRooms) {
  EXPECT_EQ(studio_exposure_ev(-2.2f), 0);  // white
  EXPECT_EQ(studio_exposure_ev(1.4f), 0);   // dark leather
  EXPECT_EQ(studio_exposure_ev(4), 4);      // a room
  float last = 0;
  for (float ev = -3; ev < 8; ev += 0.01f) {
    EXPECT_GE(studio_exposure_ev(ev), last);
    EXPECT_LT(studio_exposure_ev(ev), last + 0.03f) << "no jump";
    last = studio_exposure_ev(ev);
  }
}

TEST(Meter, APictureWithoutSurfacesIsMeteredWhole) {
  const Metering m = meter(grey(of(10, 0.72f)), grey(of(10, 0)));
  EXPECT_FALSE(m.has_surface);
  EXPECT_NEAR(m.exposure_ev, -2, 1.0 / 64);
}

}  // namespace
}  // namespace tessera::master
