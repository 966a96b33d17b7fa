// SPDX-License-Identifier: Apache-2.0
#include "master/display/exposure_control.h"

#include <gtest/gtest.h>

namespace tessera::master {
namespace {

TEST(ExposureControl, FirstPictureIsShownAsItWasSettled) {
  ExposureControl control({2.5f, ToneCurve::kAgx}, true);
  control.measured(-7);
  EXPECT_FALSE(control.advance(0.1));
  EXPECT_EQ(control.display().exposure_ev, 2.5f);
}

TEST(ExposureControl, ABrighterViewIsDarkenedSmoothlyByAsMuch) {
  ExposureControl control({0, ToneCurve::kAgx}, true);
  control.measured(-2);
  control.measured(1);
  float last = 0;
  for (int i = 0; i < 200; ++i) {
    control.advance(0.02);
    EXPECT_LE(control.display().exposure_ev, last);
    EXPECT_LT(last - control.display().exposure_ev, 0.2f) << "no jump can be seen";
    last = control.display().exposure_ev;
  }
  EXPECT_NEAR(last, -3, 1.0 / 64);
  EXPECT_TRUE(control.is_settled());
}

TEST(ExposureControl, AGivenExposureStaysWhateverIsShown) {
  ExposureControl control({1, ToneCurve::kLinear}, false);
  control.measured(-2);
  control.measured(5);
  control.advance(10);
  EXPECT_EQ(control.display().exposure_ev, 1);
}

TEST(ExposureControl, KeysAddStopsAndResetTakesThemAway) {
  ExposureControl control({1, ToneCurve::kLinear}, false);
  for (int i = 0; i < 3; ++i) control.nudge(ExposureControl::kKeyEv);
  control.advance(0);
  EXPECT_NEAR(control.display().exposure_ev, 2, 1e-6);
  control.reset();
  control.advance(0);
  EXPECT_EQ(control.display().exposure_ev, 1);
}

TEST(ExposureControl, CurvesGoRound) {
  ExposureControl control({0, ToneCurve::kAgx}, false);
  control.next_curve();
  EXPECT_EQ(control.display().tone, ToneCurve::kLinear);
  for (int i = 0; i < 3; ++i) control.next_curve();
  EXPECT_EQ(control.display().tone, ToneCurve::kAgx);
}

}  // namespace
}  // namespace tessera::master
