// SPDX-License-Identifier: Apache-2.0
// Slaves that die with their tiles again and again, hold them, or send wrong ones: no frame fails
// while a good slave is there, and a tile that ends slaves ends few of them.
#include "tests/unit/schedule/bad_slaves.h"

#include <map>
#include <numeric>
#include <set>

#include "common/base/limits.h"

namespace tessera::master {
namespace {

TEST_F(BadSlaves, ALargeSlaveThatDiesWithItsFirstTilesFailsNoFrame) {
  const SessionId good = join("good", 1), other = join("other", 2);
  SessionId bad = join("bad", 100, 64);
  submit(0, 300);
  ASSERT_GT(out_[bad].size(), 200u) << "as a newcomer it is given what its threads need";
  for (std::uint64_t life = 101; life < 120; ++life) {
    lose(bad);
    tick(100ms);
    for (int i = 0; i < 3; ++i) {
      answer(good);
      answer(other);
    }
    bad = join("bad", life, 64);
    EXPECT_LE(out_[bad].size(), 1u) << "it has earned no more";
  }
  while (answer(good) || answer(other)) tick(10ms);
  lose(bad);
  while (answer(good) || answer(other)) tick(10ms);
  EXPECT_EQ(complete_, 1);
  EXPECT_TRUE(failed_.empty()) << failed_[0];
}

TEST_F(BadSlaves, ThreeOfThemThatComeTogetherWithTheGoodOnesFailNoFrameEither) {
  std::map<std::string, SessionId> bad{{"a", 0}, {"b", 0}, {"c", 0}};
  std::uint64_t life = 10;
  for (auto& [name, session] : bad) session = join(name, ++life, 4);
  const SessionId good = join("good", 1);
  submit(0, 60);
  for (int round = 0; round < 10; ++round) {
    for (auto& [name, session] : bad) {
      lose(session);
      session = join(name, ++life, 4);
    }
    tick(200ms);
  }
  for (auto& [name, session] : bad) lose(session);
  while (answer(good)) tick(10ms);
  EXPECT_EQ(complete_, 1);
  EXPECT_TRUE(failed_.empty()) << failed_[0];
}

TEST_F(BadSlaves, AComerBackEarnsOneTileMoreWithEach) {
  SessionId slave = join("s", 1, 4);
  submit(0, 400);
  lose(slave);
  slave = join("s", 2, 4);
  for (std::size_t earned = 1; earned < 10; ++earned) {
    ASSERT_EQ(out_[slave].size(), earned);
    answer(slave);
  }
}

// Tile 7 ends whoever renders it.
TEST_F(BadSlaves, APoisonTileEndsAsManySlavesAsMayBeEachOnce) {
  std::map<std::string, SessionId> slaves;
  std::uint64_t life = 0;
  for (const char* name : {"a", "b", "c", "d", "e"}) slaves[name] = join(name, ++life, 2);
  submit(0, 60);
  std::map<std::string, int> deaths;
  for (int step = 0; step < 3000 && failed_.empty(); ++step) {
    tick(10ms);
    for (auto& [name, session] : slaves) {
      if (holds(session, 7) && out_[session].front().tile.tile == 7) {
        ++deaths[name];
        lose(session);
        session = join(name, ++life, 2);
      } else {
        answer(session);
      }
    }
  }
  ASSERT_EQ(failed_.size(), 1u);
  EXPECT_EQ(deaths.size(), std::size_t{kTileAttemptsMax});
  for (const auto& [name, count] : deaths) {
    EXPECT_EQ(count, 1) << name;
    EXPECT_NE(failed_[0].find("'" + name + "'"), std::string::npos) << failed_[0];
  }
  EXPECT_NE(failed_[0].find("tile 7 "), std::string::npos) << failed_[0];
}

TEST_F(BadSlaves, WhoLostATileDoesNotGetItAgainWhileAnotherCanTakeIt) {
  const SessionId first = join("a", 1);
  submit(0, 1);
  ASSERT_TRUE(holds(first, 0));
  lose(first);
  const SessionId again = join("a", 2);
  EXPECT_TRUE(holds(again, 0)) << "nobody else is there";
  lose(again);
  const SessionId other = join("b", 3);
  EXPECT_TRUE(holds(other, 0));
  lose(other, SlaveEnd::kExpelled);
  const SessionId third = join("a", 4);
  EXPECT_TRUE(holds(third, 0)) << "once more: an expelled slave is no slave that was lost with it";
}

TEST_F(BadSlaves, TheOnlySlaveMayDieThreeTimesWithATile) {
  for (std::uint64_t life = 1; life <= 3; ++life) {
    const SessionId slave = join("a", life);
    if (life == 1) submit(0, 1);
    EXPECT_TRUE(holds(slave, 0));
    lose(slave);
  }
  tick(10ms);
  EXPECT_TRUE(failed_.empty()) << "its link may have been broken";
  join("a", 4);
  tick(10ms);
  ASSERT_EQ(failed_.size(), 1u);
  EXPECT_NE(failed_[0].find("'a' (3 times)"), std::string::npos) << failed_[0];
}

TEST_F(BadSlaves, LossesFromWhichNobodyComesBackAreCertainAfterAWhile) {
  std::vector<SessionId> slaves;
  for (std::uint64_t life = 1; life <= 4; ++life)
    slaves.push_back(join("s" + std::to_string(life), life));
  submit(0, 8);
  for (bool has_answered = true; has_answered;) {
    has_answered = false;
    for (const SessionId slave : slaves) has_answered = answer(slave) || has_answered;
  }
  submit(1, 1);
  std::size_t lost = 0;
  for (const SessionId slave : slaves) {
    if (!holds(slave, 0)) continue;
    lose(slave);
    ++lost;
  }
  EXPECT_EQ(lost, 3u) << "the fourth does not get it";
  tick(DepartedSlaves::kReturn - 1ms);
  EXPECT_TRUE(failed_.empty());
  tick(1ms);
  EXPECT_EQ(failed_.size(), 1u);
}

TEST_F(BadSlaves, AProcessThatComesBackHadABrokenLinkAndDidNotCrash) {
  std::map<std::string, SessionId> slaves;
  for (const char* name : {"a", "b", "c"}) slaves[name] = join(name, slaves.size() + 1);
  submit(0, 3);
  for (int reset = 0; reset < 4; ++reset) {
    tick(1s);
    std::uint64_t instance = 0;
    for (auto& [name, session] : slaves) lose(session);
    tick(100ms);
    for (auto& [name, session] : slaves) session = join(name, ++instance);
  }
  for (auto& [name, session] : slaves) answer(session);
  EXPECT_EQ(complete_, 1);
  EXPECT_TRUE(failed_.empty()) << failed_[0];
}

TEST_F(BadSlaves, FaultyPixelsThatAnotherSlaveDoesNotHaveAreToldOf) {
  const SessionId bad = join("bad", 1), good = join("good", 2);
  submit(0, 8);
  answer(good);
  const TileIndex tile = out_[bad].front().tile.tile;
  answer(bad, true);
  while (holds(good, tile)) answer(good);
  EXPECT_EQ(suspects_, std::vector<std::string>{"bad"});
}

TEST_F(BadSlaves, FaultyPixelsThatAnotherSlaveHasTooAreTheScenes) {
  const SessionId one = join("one", 1), two = join("two", 2);
  submit(0, 8);
  const TileIndex tile = out_[one].front().tile.tile;
  answer(one, true);
  while (holds(two, tile)) answer(two, out_[two].front().tile.tile == tile);
  EXPECT_TRUE(suspects_.empty());
}

TEST_F(BadSlaves, WhoIsThereFirstAndReturnsNothingHoldsUpNobodyForLong) {
  const SessionId hoarder = join("hoarder", 1, 4);
  submit(0, 6);
  ASSERT_EQ(out_[hoarder].size(), 6u);
  const SessionId good = join("good", 2);
  for (int step = 0; step < 800 && complete_ == 0; ++step) {
    tick(10ms);
    answer(good);
  }
  EXPECT_EQ(complete_, 1);
}

// Two slaves hoard, and each tile is audited: the two good ones confirm each other.
TEST_F(BadSlaves, AuditsGoOnWithoutSlavesThatReturnNothing) {
  scheduler_audits_.start(now_);
  for (SessionId slave = 1; slave <= 4; ++slave) {
    scheduler_audits_.slave_joined(slave, {"s" + std::to_string(slave), "", slave}, 1, now_);
    scheduler_audits_.scene_built(slave, 1, now_);
  }
  std::vector<TileIndex> order(12);
  std::iota(order.begin(), order.end(), TileIndex{0});
  Actions next = scheduler_audits_.submit_frame(0, 1, order, now_);
  for (int step = 0; step < 1000 && complete_ == 0; ++step) {
    perform(next);
    next = scheduler_audits_.tick(now_ += 10ms);
    for (const SessionId good : {SessionId{1}, SessionId{2}}) {
      std::vector<Action>& leases = out_[good];
      if (leases.empty()) continue;
      const Action lease = leases.front();
      leases.erase(leases.begin());
      scheduler_audits_.result(
          good,
          {0, 1, lease.tile.tile, lease.tile.attempt, kTileSeconds, kTileSeconds, 0, 5, false},
          now_, next);
    }
  }
  EXPECT_EQ(complete_, 1);
  EXPECT_TRUE(failed_.empty()) << failed_[0];
}

// The hoarder that joins second has the shortest way to the master and the most threads.
TEST_F(BadSlaves, WhileNobodyHasReturnedATileManyAreTriedAndNotTheNearest) {
  const SessionId first = join("first", 1, 16);
  submit(0, 16);
  ASSERT_EQ(out_[first].size(), 16u);
  const SessionId second = join("second", 2, 64), good = join("good", 3, 2);
  scheduler_.round_trip_measured(second, 1e-4);
  scheduler_.round_trip_measured(good, 0.02);
  Duration waited{};
  for (; waited < 20s && complete_ == 0; waited += 10ms) {
    tick(10ms);
    answer(good);
  }
  EXPECT_EQ(complete_, 1);
  EXPECT_LT(waited, 8s) << "only the first one is waited for";
}

TEST_F(BadSlaves, ASlaveThatReturnsNothingStallsOnceAndHoldsOneTileAtMost) {
  const SessionId hoarder = join("hoarder", 1), good = join("good", 2);
  FrameId frame = 0;
  submit(frame, 40);
  for (int step = 0; step < 2000; ++step) {
    tick(10ms);
    answer(good);
    if (complete_ > static_cast<int>(frame)) submit(++frame, 40);
    if (step > 400) {
      EXPECT_LE(out_[hoarder].size(), 1u);
    }
  }
  EXPECT_GT(complete_, 40) << "at 10 ms a tile, with a second for each look at the hoarder";
  EXPECT_EQ(stalled_, std::vector<SessionId>{hoarder});
  EXPECT_TRUE(scheduler_.is_stalled(hoarder));
  for (int step = 0; step < 4000 && out_[hoarder].empty(); ++step) {
    tick(10ms);
    answer(good);
    if (complete_ > static_cast<int>(frame)) submit(++frame, 40);
  }
  ASSERT_TRUE(answer(hoarder)) << "it is asked again now and then";
  EXPECT_FALSE(scheduler_.is_stalled(hoarder));
  EXPECT_GT(out_[hoarder].size(), 1u);
}

}  // namespace
}  // namespace tessera::master
