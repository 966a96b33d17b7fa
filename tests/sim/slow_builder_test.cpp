// SPDX-License-Identifier: Apache-2.0
// Slaves that take ten times as long as the others to build a scene, where each frame shows a scene
// of its own.
#include <gtest/gtest.h>

#include <chrono>
#include <string>

#include "common/base/log.h"
#include "tests/sim/storm.h"

namespace tessera::sim {
namespace {

constexpr std::size_t kOthers = 3;
constexpr int kFrames = 40;

struct BuildCase {
  std::string name;
  double build_seconds;  // of the others
  int frames_in_flight;
};

// Three slaves of two threads, whose frames take about 80 ms.
StormPlan plan_of(const BuildCase& build, SceneWeight weight) {
  StormPlan plan;
  plan.seed = 1;
  plan.master_link.delay = std::chrono::microseconds(50);
  plan.frames_in_flight = plan.script.in_flight = build.frames_in_flight;
  plan.slaves_min = static_cast<int>(kOthers);
  for (std::size_t i = 0; i < kOthers; ++i) {
    SlavePlan slave;
    slave.link.delay = std::chrono::microseconds(100);
    slave.threads = 2;
    slave.tile_seconds = 0.01;
    slave.tile_spread = 0.3;
    slave.build_seconds = build.build_seconds;
    plan.slaves.push_back(slave);
  }
  plan.script.frames = kFrames;
  plan.script.scene_change = 1;
  plan.script.weight = weight;
  return plan;
}

class SlowBuilder : public testing::TestWithParam<BuildCase> {
 protected:
  static void SetUpTestSuite() { init_log(LogLevel::kOff, LogFormat::kText); }
};

TEST_P(SlowBuilder, GetsFewerTilesOrNoneAndHoldsNobodyUp) {
  for (const SceneWeight weight : {SceneWeight::kMoving, SceneWeight::kEdited}) {
    StormPlan plan = plan_of(GetParam(), weight);
    const StormReport without = run_storm(plan);
    plan.slaves.push_back(plan.slaves.back());
    plan.slaves.back().build_seconds *= 10;
    const StormReport with = run_storm(plan);
    EXPECT_EQ(without.violation, "");
    EXPECT_EQ(with.violation, "");
    EXPECT_EQ(with.frames_delivered, kFrames);
    EXPECT_EQ(with.frames_failed, 0);
    EXPECT_LE(with.frames_seconds, 1.05 * without.frames_seconds);
    for (std::size_t i = 0; i < kOthers; ++i)
      EXPECT_LT(with.rendering[kOthers], 0.5 * with.rendering[i]) << "s" << i;
  }
}

INSTANTIATE_TEST_SUITE_P(Builds, SlowBuilder,
                         testing::Values(BuildCase{"short", 0.008, 2}, BuildCase{"usual", 0.03, 2},
                                         BuildCase{"one_in_flight", 0.03, 1},
                                         BuildCase{"long", 0.2, 2}, BuildCase{"very_long", 1, 2}),
                         [](const auto& info) { return info.param.name; });

}  // namespace
}  // namespace tessera::sim
