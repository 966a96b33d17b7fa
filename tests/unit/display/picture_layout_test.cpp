// SPDX-License-Identifier: Apache-2.0
#include "master/display/picture_layout.h"

#include <gtest/gtest.h>

#include <cmath>

namespace tessera::master {
namespace {

TEST(Letterbox, FillsAWindowOfTheSameSize) {
  EXPECT_EQ(letterbox({640, 480}, {640, 480}), (PixelRect{0, 0, 640, 480}));
  EXPECT_EQ(letterbox({320, 240}, {640, 480}), (PixelRect{0, 0, 640, 480}));
}

TEST(Letterbox, KeepsTheAspectAndCentres) {
  EXPECT_EQ(letterbox({100, 100}, {300, 200}), (PixelRect{50, 0, 200, 200}));
  EXPECT_EQ(letterbox({200, 100}, {300, 300}), (PixelRect{0, 75, 300, 150}));
}

TEST(Letterbox, NeverVanishesAndNeverLeavesTheWindow) {
  const int sides[] = {1, 2, 3, 16, 17, 640, 16384};
  for (const int pw : sides) {
    for (const int ph : sides) {
      for (const int ww : sides) {
        for (const int wh : sides) {
          const PixelRect r = letterbox({pw, ph}, {ww, wh});
          ASSERT_GE(r.width_px, 1);
          ASSERT_GE(r.height_px, 1);
          ASSERT_GE(r.x_px, 0);
          ASSERT_GE(r.y_px, 0);
          ASSERT_LE(r.x_px + r.width_px, ww);
          ASSERT_LE(r.y_px + r.height_px, wh);
          ASSERT_TRUE(r.width_px == ww || r.height_px == wh);
        }
      }
    }
  }
}

TEST(ResizeDebounce, OneStepCountsAtOnceAndManyAfterRest) {
  ResizeDebounce resize({640, 480}, 4096);
  EXPECT_FALSE(resize.poll(0).has_value());
  for (int i = 0; i < 100; ++i) {  // a border is dragged for a second
    resize.on_resize({640 + i, 480 + 2}, 0.01 * i);
    EXPECT_EQ(resize.poll(0.01 * i).has_value(), i == 0);
  }
  EXPECT_EQ(resize.size(), (PixelSize{640, 482}));
  EXPECT_FALSE(resize.poll(0.99 + ResizeDebounce::kQuietSeconds / 2).has_value());
  EXPECT_EQ(resize.poll(2), (PixelSize{739, 482}));
  EXPECT_FALSE(resize.poll(3).has_value());
}

TEST(ResizeDebounce, ClampsAndIgnoresAMinimisedWindow) {
  ResizeDebounce resize({640, 480}, 1000);
  resize.on_resize({0, 0}, 1);
  EXPECT_FALSE(resize.poll(9).has_value());
  resize.on_resize({3, 5000}, 10);
  EXPECT_EQ(resize.poll(19), (PixelSize{ResizeDebounce::kSideMinPx, 1000}));
}

TEST(ResizeDebounce, GoingThereAndBackIsNoChange) {
  ResizeDebounce resize({640, 480}, 1000);
  resize.on_resize({700, 480}, 1);
  resize.on_resize({640, 480}, 1.01);
  EXPECT_FALSE(resize.poll(9).has_value());
  resize.on_resize({700, 480}, 10);
  EXPECT_EQ(resize.poll(10), (PixelSize{700, 480}));
}

TEST(SlaveColour, FirstTwelveAreToldApart) {
  for (std::uint16_t a = 0; a < 12; ++a) {
    const auto ca = slave_colour(a);
    for (std::uint16_t b = 0; b < a; ++b) {
      const auto cb = slave_colour(b);
      double difference = 0;
      for (std::size_t i = 0; i < 3; ++i) difference += std::abs(double{ca[i]} - double{cb[i]});
      EXPECT_GT(difference, 0.15) << a << " and " << b;
    }
  }
  for (int i = 0; i < 65536; ++i) {
    for (const float c : slave_colour(static_cast<std::uint16_t>(i))) {
      ASSERT_TRUE(c >= 0 && c <= 1);
    }
  }
}

}  // namespace
}  // namespace tessera::master
