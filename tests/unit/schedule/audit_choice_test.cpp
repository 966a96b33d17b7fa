// SPDX-License-Identifier: Apache-2.0
// Which tiles are rendered twice and compared: a share that nobody can guess, and none while a
// third certificate is missing.
#include <gtest/gtest.h>

#include <numeric>
#include <set>

#include "master/schedule/scheduler.h"

namespace tessera::master {
namespace {

std::set<std::pair<FrameId, TileIndex>> chosen(const AuditChoice& choice) {
  std::set<std::pair<FrameId, TileIndex>> tiles;
  for (FrameId frame = 0; frame < 100; ++frame) {
    for (TileIndex tile = 0; tile < 200; ++tile) {
      if (choice.has_chosen(frame, tile)) tiles.emplace(frame, tile);
    }
  }
  return tiles;
}

TEST(AuditChoice, TakesItsShareOfTheTiles) {
  EXPECT_TRUE(chosen(AuditChoice({0, 0, 1})).empty());
  EXPECT_EQ(chosen(AuditChoice({1, 0, 1})).size(), 20'000u);
  const auto some = chosen(AuditChoice({0.01, 0, 1}));
  EXPECT_GT(some.size(), 140u);
  EXPECT_LT(some.size(), 260u);
}

TEST(AuditChoice, IsTheSameAgainAndAnotherForEachSecret) {
  const auto one = chosen(AuditChoice({0.1, 0, 1}));
  EXPECT_EQ(one, chosen(AuditChoice({0.1, 0, 1})));
  const auto other = chosen(AuditChoice({0.1, 0, 2}));
  std::size_t common = 0;
  for (const auto& tile : one) common += other.contains(tile) ? 1u : 0u;
  EXPECT_LT(common, one.size() / 5) << "a tenth of them by chance";
}

TEST(AuditChoice, WaitsForAsManyCertificatesAsItNeeds) {
  AuditChoice choice({1, 3, 1});
  choice.joined({"a", "a", 1});
  choice.joined({"b", "b", 2});
  choice.joined({"local", "", 3});
  choice.joined({"b", "b", 4});
  EXPECT_FALSE(choice.has_chosen(0, 0)) << "one has no certificate, and one is here twice";
  choice.joined({"c", "c", 5});
  EXPECT_TRUE(choice.has_chosen(0, 0));
  choice.left({"b", "b", 4});
  choice.left({"local", "", 3});
  EXPECT_TRUE(choice.has_chosen(0, 0));
  choice.left({"b", "b", 2});
  EXPECT_FALSE(choice.has_chosen(0, 0));
}

// Returns: how many leases were for comparison, while slaves answer a frame.
int comparisons(Scheduler& scheduler, FrameId frame, TimePoint now) {
  std::vector<TileIndex> order(40);
  std::iota(order.begin(), order.end(), TileIndex{0});
  int count = 0;
  Actions next = scheduler.submit_frame(frame, 1, order, now);
  while (!next.empty()) {
    const Actions now_due = std::exchange(next, {});
    for (const Action& action : now_due) {
      if (action.kind != ActionKind::kLease) continue;
      count += action.tile.is_comparison ? 1 : 0;
      scheduler.result(action.session,
                       {frame, 1, action.tile.tile, action.tile.attempt, 0.01, 0.01, 0, 5, false},
                       now, next);
    }
    if (next.empty() && scheduler.has_open_frames())
      next = scheduler.tick(now += std::chrono::milliseconds(10));
  }
  EXPECT_FALSE(scheduler.has_open_frames());
  return count;
}

TEST(Scheduler, ComparesNothingBeforeTheThirdCertificateIsHereAndNothingAfterItLeft) {
  SchedulerOptions options;
  options.audit = {1, 3, 7};
  Scheduler scheduler(options);
  TimePoint now{};
  scheduler.start(now);
  const auto join = [&](SessionId session, const std::string& key) {
    scheduler.slave_joined(session, {"s" + std::to_string(session), key, session}, 1, now);
    scheduler.scene_built(session, 1, now);
  };
  join(1, "a");
  join(2, "b");
  join(3, "");
  EXPECT_EQ(comparisons(scheduler, 0, now), 0);
  join(4, "c");
  EXPECT_EQ(comparisons(scheduler, 1, now), 40);
  scheduler.slave_lost(4, now, SlaveEnd::kLeft);
  EXPECT_EQ(comparisons(scheduler, 2, now), 0);
}

}  // namespace
}  // namespace tessera::master
