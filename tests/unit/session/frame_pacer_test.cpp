// SPDX-License-Identifier: Apache-2.0
#include "master/session/frame_pacer.h"

#include <gtest/gtest.h>

#include <cmath>

namespace tessera {
namespace {

constexpr double kBudgetSeconds = 0.050;

FrameSettings full() {
  FrameSettings s;
  s.width_px = 1600;
  s.height_px = 1200;
  s.samples_per_pixel = 16;
  s.light_samples = 4;
  return s;
}

double rays(const FrameSettings& s) {
  return 1.0 * s.width_px * s.height_px * s.samples_per_pixel * (1 + s.light_samples);
}

TEST(FramePacer, WithoutABudgetNothingIsEverReduced) {
  FramePacer pacer(0);
  pacer.frame_done(full(), 100);
  EXPECT_EQ(pacer.moving(full()), full());
  EXPECT_EQ(pacer.scaled(full(), 0.25), full());
}

// The size that a moving picture settles at is at most 5 % too large on each side and 20 % too
// small. Samples are halved, for which the size makes up by shrinking but not by growing.
TEST(FramePacer, MovingFramesComeToTakeTheBudget) {
  for (const double rays_per_second : {2e6, 1e7, 1e8, 1e9}) {
    FramePacer pacer(kBudgetSeconds);
    FrameSettings s;
    for (int i = 0; i < 20; ++i) {
      s = pacer.moving(full());
      pacer.frame_done(s, rays(s) / rays_per_second);
    }
    const double taken = rays(s) / rays_per_second / kBudgetSeconds;
    EXPECT_LE(taken, 1.05 * 1.05 + 0.02) << rays_per_second;
    EXPECT_GE(taken, 1 / (1.2 * 1.2) / 2) << rays_per_second;
    EXPECT_NEAR(1.0 * s.width_px / s.height_px, 4.0 / 3, 0.02) << "the aspect stays";
  }
}

TEST(FramePacer, VplsGoBeforePixelsButNotAll) {
  FrameSettings wanted = full();
  wanted.renderer = Renderer::kIgi;
  wanted.samples_per_pixel = 1;
  for (const double times : {1.3, 1000.0}) {
    FramePacer pacer(kBudgetSeconds);
    pacer.frame_done(wanted, kBudgetSeconds * times);
    const FrameSettings s = pacer.moving(wanted);
    EXPECT_EQ(s.vpls, times < 2 ? 32 : 16);
    EXPECT_EQ(s.width_px == wanted.width_px, times < 2);
    EXPECT_EQ(s.light_samples, wanted.light_samples) << "igi has none";
  }
}

TEST(FramePacer, SamplesGoBeforePixels) {
  FramePacer pacer(kBudgetSeconds);
  pacer.frame_done(full(), 3.3 * kBudgetSeconds);  // 0.85 of a budget is aimed at
  const FrameSettings s = pacer.moving(full());
  EXPECT_EQ(s.width_px, full().width_px);
  EXPECT_EQ(s.samples_per_pixel, 4);
}

TEST(FramePacer, AStepHasItsShareOfEachSideAndTheSamplesThatTheBudgetLeaves) {
  FramePacer pacer(kBudgetSeconds);
  pacer.frame_done(full(), 6.7 * kBudgetSeconds);
  const FrameSettings quarter = pacer.scaled(full(), 0.25), half = pacer.scaled(full(), 0.5);
  EXPECT_EQ(quarter.width_px, 400);
  EXPECT_EQ(quarter.height_px, 300);
  EXPECT_EQ(quarter.samples_per_pixel, 16) << "half of the time would be left over";
  EXPECT_EQ(half.width_px, 800);
  EXPECT_EQ(half.samples_per_pixel, 8)
      << "a quarter of the time, by half the samples: 0.84 budgets";
}

// A full frame tells little about a small one, of which each ray costs more.
TEST(FramePacer, SmallFramesAreExpectedToTakeWhatSmallFramesTook) {
  constexpr double kFullRate = 1e9;
  const auto frame_seconds = [](const FrameSettings& s) { return 0.010 + rays(s) / kFullRate; };
  FramePacer pacer(kBudgetSeconds);
  for (int i = 0; i < 3; ++i) pacer.frame_done(full(), 8 * frame_seconds(full()));
  FrameSettings s = pacer.moving(full());
  pacer.frame_done(s, 8 * frame_seconds(s));
  for (int i = 0; i < 30; ++i) pacer.frame_done(full(), 8 * frame_seconds(full()));  // at rest
  s = pacer.moving(full());
  EXPECT_LE(8 * frame_seconds(s), 1.1 * kBudgetSeconds + 8 * 0.010);
  pacer.frame_done(s, 8 * frame_seconds(s));
  EXPECT_NEAR(pacer.expected_seconds(full()), 8 * frame_seconds(full()), 0.01);
}

TEST(FramePacer, TheSizeDoesNotFlicker) {
  FramePacer pacer(kBudgetSeconds);
  pacer.frame_done(full(), 20);
  const int width = pacer.moving(full()).width_px;
  for (int i = 0; i < 50; ++i) {
    const FrameSettings s = pacer.moving(full());
    pacer.frame_done(s, rays(s) / (rays(full()) / 20) * (i % 2 == 0 ? 0.95 : 1.05));
    EXPECT_EQ(pacer.moving(full()).width_px, width);
  }
}

TEST(FramePacer, AnOverdueFrameMakesTheNextOneSmallerAtOnce) {
  FramePacer pacer(kBudgetSeconds);
  pacer.frame_done(full(), 20);
  const FrameSettings s = pacer.moving(full());
  const double expected = pacer.expected_seconds(s);
  pacer.frame_overdue(s, 10 * expected);
  EXPECT_NEAR(pacer.expected_seconds(s), 10 * expected, 1e-9 * expected);
  EXPECT_TRUE(FramePacer::is_better(s, pacer.moving(full())));
  pacer.frame_overdue(s, expected);
  EXPECT_NEAR(pacer.expected_seconds(s), 10 * expected, 1e-9 * expected) << "a bound, no measure";
}

TEST(FramePacer, MorePixelsShowMoreThanMoreSamples) {
  FrameSettings more_pixels = full(), more_samples = full();
  more_pixels.samples_per_pixel = 1;
  more_samples.width_px /= 2;
  more_samples.samples_per_pixel = 256;
  EXPECT_TRUE(FramePacer::is_better(more_pixels, more_samples));
  EXPECT_FALSE(FramePacer::is_better(more_samples, more_pixels));
  EXPECT_TRUE(FramePacer::is_better(full(), more_pixels));
  EXPECT_FALSE(FramePacer::is_better(full(), full()));
}

}  // namespace
}  // namespace tessera
