// SPDX-License-Identifier: Apache-2.0
#include "master/session/cluster_speed.h"

#include <gtest/gtest.h>

#include <vector>

namespace tessera {
namespace {

constexpr double kRate = 1e8, kOverheadSeconds = 0.02;

// Seconds of a frame on a cluster where each frame has an overhead.
double frame_seconds(double rays) { return kOverheadSeconds + rays / kRate; }

double expected_seconds(const ClusterSpeed& speed, double rays) {
  return rays / speed.rays_per_second(rays);
}

TEST(ClusterSpeed, IsUnknownBeforeAFrameAndOfOneRateAfterIt) {
  ClusterSpeed speed;
  EXPECT_EQ(speed.rays_per_second(1e6), 0);
  speed.measured(1e6, 0.1);
  for (const double rays : {1.0, 1e3, 1e6, 1e9, 1e20})
    EXPECT_NEAR(speed.rays_per_second(rays), 1e7, 1e-3);
}

TEST(ClusterSpeed, FramesOfTwoSizesDoNotUnlearnEachOther) {
  ClusterSpeed speed;
  const std::vector<double> sizes{5e5, 4e7};
  for (const double rays : sizes) speed.measured(rays, frame_seconds(rays));
  for (int i = 0; i < 100; ++i) speed.measured(sizes[1], frame_seconds(sizes[1]));
  for (const double rays : sizes) {
    const double right = frame_seconds(rays);
    EXPECT_NEAR(expected_seconds(speed, rays), right, 1e-6 * right) << rays;
  }
}

// Knots are a factor of 4 apart; expectations between two that were learnt are close.
TEST(ClusterSpeed, SizesBetweenThoseMeasuredAreExpectedToLieBetweenThem) {
  ClusterSpeed speed;
  for (int round = 0; round < 20; ++round) {
    for (double rays = 1e5; rays < 1e9; rays *= 1.9) speed.measured(rays, frame_seconds(rays));
  }
  for (double rays = 2e5; rays < 5e8; rays *= 1.07) {
    const double right = frame_seconds(rays);
    EXPECT_NEAR(expected_seconds(speed, rays), right, 0.1 * right) << rays;
  }
}

TEST(ClusterSpeed, AnotherClusterIsFoundOutForEverySize) {
  ClusterSpeed speed;
  for (const double rays : {5e5, 4e7}) speed.measured(rays, frame_seconds(rays));
  for (int i = 0; i < 20; ++i) speed.measured(4e7, 10 * frame_seconds(4e7));
  EXPECT_NEAR(expected_seconds(speed, 4e7), 10 * frame_seconds(4e7), 0.2 * frame_seconds(4e7));
  EXPECT_GE(expected_seconds(speed, 5e5), 6 * frame_seconds(5e5)) << "within 1.5";
}

TEST(ClusterSpeed, ABoundOnlySlowsDown) {
  ClusterSpeed speed;
  speed.at_most(1e6, 0.1);
  EXPECT_NEAR(speed.rays_per_second(1e6), 1e7, 1e-3);
  speed.at_most(1e6, 0.01);
  EXPECT_NEAR(speed.rays_per_second(1e6), 1e7, 1e-3);
  speed.at_most(1e6, 1);
  EXPECT_NEAR(speed.rays_per_second(1e6), 1e6, 1e-3);
  EXPECT_NEAR(speed.rays_per_second(1e9), 1e6, 1e-3);
}

}  // namespace
}  // namespace tessera
