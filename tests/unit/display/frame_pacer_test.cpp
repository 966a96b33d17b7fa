#include "master/display/frame_pacer.h"

#include <gtest/gtest.h>

namespace tessera::master {
namespace {

using namespace std::chrono_literals;
const TimePoint kStart{};

FrameSettings full() {
  FrameSettings s;
  s.width_px = 1600;
  s.height_px = 1200;
  s.samples_per_pixel = 16;
  s.light_samples = 4;
  return s;
}

double work(const FrameSettings& s) {
  return 1.0 * s.width_px * s.height_px * s.samples_per_pixel * (1 + s.light_samples);
}

// A cluster that does so much work in a second.
double seconds_on(const FrameSettings& s, double work_per_second) {
  return work(s) / work_per_second;
}

TEST(FramePacer, WithoutATargetNothingIsEverReduced) {
  FramePacer pacer(0);
  pacer.moved(kStart);
  EXPECT_EQ(pacer.settings(full(), kStart), full());
}

TEST(FramePacer, MovingFramesComeToTakeTheTimeAskedFor) {
  constexpr double kTarget = 0.050;
  for (const double speed : {1e6, 1e7, 1e8}) {
    FramePacer pacer(kTarget);
    TimePoint now = kStart;
    FrameSettings s;
    for (int i = 0; i < 20; ++i) {
      pacer.moved(now);
      s = pacer.settings(full(), now);
      pacer.frame_done(s, seconds_on(s, speed));
      now += 50ms;
    }
    EXPECT_LE(seconds_on(s, speed), 1.4 * kTarget) << speed;
    EXPECT_GE(seconds_on(s, speed), 0.4 * kTarget) << speed;
    EXPECT_NEAR(1.0 * s.width_px / s.height_px, 4.0 / 3, 0.02) << "the aspect stays";
  }
}

TEST(FramePacer, VplsGoBeforePixelsButNotAll) {
  FrameSettings wanted = full();
  wanted.renderer = Renderer::kIgi;
  wanted.samples_per_pixel = 1;
  for (const double times : {1.8, 1000.0}) {
    FramePacer pacer(0.050);
    pacer.frame_done(wanted, 0.050 * times);
    pacer.moved(kStart);
    const FrameSettings s = pacer.settings(wanted, kStart);
    EXPECT_EQ(s.vpls, times < 2 ? 32 : 16);
    EXPECT_EQ(s.width_px == wanted.width_px, times < 2);
    EXPECT_EQ(s.light_samples, wanted.light_samples) << "igi has none";
  }
}

TEST(FramePacer, SamplesGoBeforePixels) {
  FramePacer pacer(0.050);
  pacer.frame_done(full(), 0.200);
  pacer.moved(kStart);
  const FrameSettings s = pacer.settings(full(), kStart);
  EXPECT_EQ(s.width_px, full().width_px);
  EXPECT_EQ(s.samples_per_pixel, 4);
}

TEST(FramePacer, AtRestEverythingComesBack) {
  FramePacer pacer(0.050);
  pacer.frame_done(full(), 10);
  pacer.moved(kStart);
  EXPECT_LT(pacer.settings(full(), kStart + 100ms).width_px, full().width_px);
  EXPECT_EQ(pacer.settings(full(), kStart + 300ms), full());
}

TEST(FramePacer, TheSizeDoesNotFlicker) {
  FramePacer pacer(0.050);
  pacer.frame_done(full(), 20);
  pacer.moved(kStart);
  const int width = pacer.settings(full(), kStart).width_px;
  for (int i = 0; i < 50; ++i) {
    const FrameSettings s = pacer.settings(full(), kStart);
    pacer.frame_done(s, 0.050 * (i % 2 == 0 ? 0.9 : 1.1));
    EXPECT_EQ(pacer.settings(full(), kStart).width_px, width);
  }
}

TEST(FramePacer, OnlyASlowFullFrameIsLeftBehindByAMovingView) {
  FramePacer pacer(0.050);
  pacer.frame_done(full(), 1);
  EXPECT_FALSE(pacer.is_left_behind(full(), full(), kStart)) << "nothing moves";
  pacer.moved(kStart);
  EXPECT_TRUE(pacer.is_left_behind(full(), full(), kStart));
  EXPECT_FALSE(pacer.is_left_behind(pacer.settings(full(), kStart), full(), kStart));
}

}  // namespace
}  // namespace tessera::master
