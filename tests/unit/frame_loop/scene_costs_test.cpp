// SPDX-License-Identifier: Apache-2.0
// What scenes cost is charged to one frame, once, however builds, frames and retirement interleave.
#include "master/frame_loop/scene_costs.h"

#include <gtest/gtest.h>

namespace tessera::master {
namespace {

using namespace std::chrono_literals;

const TimePoint kStart{1000s};

FrameStats charged(SceneCosts& costs, SceneVersion version, std::uint64_t bytes_sent = 0) {
  FrameStats stats;
  stats.scene_version = version;
  costs.charge(stats, bytes_sent);
  return stats;
}

TEST(SceneCosts, AFrameIsChargedWithTheSlaveThatBuiltMostAndTheSlowest) {
  SceneCosts costs;
  costs.built(1, 0.5, 100);
  costs.built(1, 2, 0);
  const FrameStats first = charged(costs, 1);
  EXPECT_EQ(first.scene_cost.built_primitives, 100u);
  EXPECT_EQ(first.build_seconds, 2);
  costs.built(1, 1, 100);  // a slave that came late
  EXPECT_EQ(charged(costs, 1).scene_cost.built_primitives, 0u);
}

TEST(SceneCosts, WhatNoFrameShowedIsOwedByTheNext) {
  SceneCosts costs;
  costs.built(1, 0.5, 100);
  costs.retire(2);
  costs.built(2, 0.5, 30);
  costs.built(3, 0.5, 7);
  costs.retire(3);
  EXPECT_EQ(charged(costs, 3).scene_cost.built_primitives, 137u);
  costs.retire(4);
  EXPECT_EQ(charged(costs, 4).scene_cost.built_primitives, 0u);
}

TEST(SceneCosts, WaitingIsTheTimeBetweenTheLooks) {
  SceneCosts costs;
  costs.look(true, kStart);
  costs.look(true, kStart + 1s);
  costs.look(false, kStart + 3s);
  costs.look(false, kStart + 4s);
  costs.look(true, kStart + 10s);
  costs.look(false, kStart + 11s);
  EXPECT_DOUBLE_EQ(charged(costs, 1).scene_cost.wait_seconds, 4);
  EXPECT_EQ(charged(costs, 1).scene_cost.wait_seconds, 0);
}

TEST(SceneCosts, BytesBetweenFramesAreNotLost) {
  SceneCosts costs;
  EXPECT_EQ(charged(costs, 1, 1000).scene_cost.bytes, 1000u);
  EXPECT_EQ(charged(costs, 1, 1000).scene_cost.bytes, 0u);
  EXPECT_EQ(charged(costs, 2, 1007).scene_cost.bytes, 7u);
}

}  // namespace
}  // namespace tessera::master
