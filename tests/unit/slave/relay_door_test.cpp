// SPDX-License-Identifier: Apache-2.0
// Who may be fed by a slave when many come to its door.
#include <gtest/gtest.h>

#include "tests/unit/slave/relay_fixture.h"
#include "tests/unit/slave/relay_stranger.h"

namespace tessera::slave {
namespace {

using namespace std::chrono_literals;

TEST_F(RelayTest, BeyondTheMostChildrenTheOldestGoes) {
  const auto upper = slave("upper");
  std::vector<std::unique_ptr<RelaySlave>> children;
  for (std::size_t i = 0; i <= RelayFeeder::kChildrenMax; ++i) {
    children.push_back(slave("child " + std::to_string(i)));
    children.back()->follow(kVersion, *upper);
    settle();
    EXPECT_LE(upper->feeder().child_count(), RelayFeeder::kChildrenMax);
  }
  give_all(*upper);
  settle();
  EXPECT_EQ(faults(*children[0]), kOnceGone);
  EXPECT_FALSE(children[0]->complete_at);
  for (std::size_t i = 1; i < children.size(); ++i) {
    EXPECT_TRUE(children[i]->complete_at) << i;
    EXPECT_EQ(faults(*children[i]), kNone) << i;
  }
}

TEST_F(RelayTest, StrangersWhoKnockPushNoChildOut) {
  const auto upper = slave("upper"), lower = slave("lower");
  lower->follow(kVersion, *upper);
  settle();
  std::vector<std::unique_ptr<RelayStranger>> strangers;
  for (std::size_t i = 0; i < 2 * RelayFeeder::kChildrenMax; ++i) {
    strangers.push_back(std::make_unique<RelayStranger>(queue_, network_));
    strangers.back()->call(upper->node());
  }
  run_for(10ms);
  give_all(*upper);
  settle();
  EXPECT_TRUE(lower->complete_at);
  EXPECT_EQ(faults(*lower), kNone);
}

}  // namespace
}  // namespace tessera::slave
