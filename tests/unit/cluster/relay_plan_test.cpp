// SPDX-License-Identifier: Apache-2.0
// Who feeds whom: chains grow at their end, heal where they break, and never close to a circle.
#include "master/cluster/relay_plan.h"
#include "tests/support/seed.h"

#include <gtest/gtest.h>

#include <map>
#include <random>
#include <set>

namespace tessera::master {
namespace {

constexpr std::uint64_t kScene = 100 << 20;
constexpr SceneVersion kVersion = 7;

struct Plan {
  RelayPlan plan;
  TimePoint now{};

  SessionId join_and_want(SessionId session, bool can_feed = true, bool is_near = false) {
    plan.joined(session, can_feed, is_near);
    return want(session);
  }
  SessionId want(SessionId session, std::uint64_t bytes = kScene) {
    return plan.want(session, kVersion, bytes, kScene, true, now);
  }
  std::vector<Feed> fail(SessionId child, SessionId feeder, wire::RelayFault fault) {
    return plan.failed(child, kVersion, feeder, fault, now);
  }
  // Lets `time` pass; at its end each slave reports its count of `bytes`.
  std::vector<Feed> pass(Duration time, const std::map<SessionId, std::uint64_t>& bytes) {
    now += time;
    for (const auto& [session, count] : bytes) plan.progress(session, kVersion, count, now);
    return plan.tick(now);
  }
};

TEST(RelayPlan, AChainGrowsAtItsEnd) {
  Plan p;
  EXPECT_EQ(p.join_and_want(1), kFedByMaster);
  for (SessionId s = 2; s <= 8; ++s) EXPECT_EQ(p.join_and_want(s), s - 1);
}

TEST(RelayPlan, LittleIsSentAtOnceAndWhoDoesNotListenFeedsNobody) {
  Plan p;
  p.join_and_want(1);
  p.plan.joined(2, true, false);
  EXPECT_EQ(p.want(2, RelayPlan::kBytesMin - 1), kFedByMaster);
  Plan q;
  q.join_and_want(1, false);
  EXPECT_EQ(q.join_and_want(2), kFedByMaster);
  EXPECT_EQ(q.join_and_want(3), 2u);
}

TEST(RelayPlan, OneThatCameOverLoopbackFeedsOnlyItsLike) {
  Plan p;
  p.join_and_want(1, true, true);
  EXPECT_EQ(p.join_and_want(2, true, false), kFedByMaster);
  EXPECT_NE(p.join_and_want(3, true, true), kFedByMaster) << "it reaches both";
}

TEST(RelayPlan, OneThatHadItAllFromTheBeginningIsBypassedWhenItIsSilent) {
  Plan p;
  p.plan.joined(1, true, false);
  p.plan.complete(1, kVersion, kScene);  // slave 1 lacked nothing
  ASSERT_EQ(p.join_and_want(2), 1u);
  const auto feeds = p.pass(RelayPlan::kWindow, {});
  ASSERT_EQ(feeds.size(), 1u);
  EXPECT_EQ(feeds[0].child, 2u);
  EXPECT_EQ(feeds[0].feeder, kFedByMaster);
}

TEST(RelayPlan, ALostOneIsBypassedInOneStep) {
  Plan p;
  for (SessionId s = 1; s <= 5; ++s) p.join_and_want(s);
  const std::vector<Feed> feeds = p.plan.lost(3, p.now);
  ASSERT_EQ(feeds.size(), 1u);
  EXPECT_EQ(feeds[0].child, 4u);
  EXPECT_EQ(feeds[0].feeder, 2u) << "who fed the lost one; never 5, which it feeds itself";
  EXPECT_TRUE(p.fail(4, 3, wire::RelayFault::kGone).empty()) << "its own word comes late";
}

TEST(RelayPlan, TheHeadOfTheChainLostMakesTheNextOneTheHead) {
  Plan p;
  for (SessionId s = 1; s <= 3; ++s) p.join_and_want(s);
  const std::vector<Feed> feeds = p.plan.lost(1, p.now);
  ASSERT_EQ(feeds.size(), 1u);
  EXPECT_EQ(feeds[0].child, 2u);
  EXPECT_EQ(feeds[0].feeder, kFedByMaster);
}

TEST(RelayPlan, OneThatAltersIsNeverAskedAgain) {
  Plan p;
  for (SessionId s = 1; s <= 4; ++s) p.join_and_want(s);
  const std::vector<Feed> feeds = p.fail(3, 2, wire::RelayFault::kAltered);
  ASSERT_EQ(feeds.size(), 1u);
  EXPECT_EQ(feeds[0].feeder, kFedByMaster) << "1 feeds 2 still, 4 is below";
  p.plan.complete(2, kVersion, kScene);
  for (SessionId s = 10; s < 20; ++s) EXPECT_NE(p.join_and_want(s), 2u);
}

TEST(RelayPlan, AfterSomeFeedersTheMasterFeedsForGood) {
  Plan p;
  p.join_and_want(1);
  for (SessionId s = 100; s < 120; ++s) {
    p.plan.joined(s, true, false);
    p.plan.complete(s, kVersion, kScene);
  }
  SessionId feeder = p.join_and_want(2);
  std::set<SessionId> seen;
  while (feeder != kFedByMaster) {
    EXPECT_TRUE(seen.insert(feeder).second) << "twice the same";
    const std::vector<Feed> feeds = p.fail(2, feeder, wire::RelayFault::kUnreachable);
    ASSERT_EQ(feeds.size(), 1u);
    feeder = feeds[0].feeder;
  }
  EXPECT_LE(seen.size(), RelayPlan::kFeedersMax);
}

TEST(RelayPlan, OneThatHoldsBackIsBypassedAndSlowLinksAboveItAreNot) {
  Plan p;
  for (SessionId s = 1; s <= 4; ++s) p.join_and_want(s);
  const std::uint64_t mib = 1 << 20;
  // The master sends 10 MiB a second. Slave 2 passes on a tenth of what it has, and slave 4 has all
  // that slave 3 has.
  EXPECT_TRUE(p.pass(RelayPlan::kWindow, {{1, 20 * mib}, {2, 20 * mib}, {3, 2 * mib}, {4, 2 * mib}})
                  .empty())
      << "a window shows it, not its beginning";
  const std::vector<Feed> feeds =
      p.pass(RelayPlan::kWindow, {{1, 40 * mib}, {2, 40 * mib}, {3, 4 * mib}, {4, 4 * mib}});
  ASSERT_EQ(feeds.size(), 1u);
  EXPECT_EQ(feeds[0].child, 3u);
  EXPECT_EQ(feeds[0].feeder, kFedByMaster) << "1 feeds 2, 4 is below";
}

TEST(RelayPlan, OneThatStallsIsBypassedEvenAtTheEnd) {
  Plan p;
  for (SessionId s = 1; s <= 2; ++s) p.join_and_want(s);
  p.plan.complete(1, kVersion, kScene);
  EXPECT_TRUE(p.pass(RelayPlan::kWindow, {{2, kScene - 1000}}).empty());
  const std::vector<Feed> feeds = p.pass(RelayPlan::kWindow, {});
  ASSERT_EQ(feeds.size(), 1u);
  EXPECT_EQ(feeds[0].feeder, kFedByMaster);
}

TEST(RelayPlan, ALateJoinerIsFedByOneThatHasItAll) {
  Plan p;
  for (SessionId s = 1; s <= 3; ++s) p.join_and_want(s);
  for (SessionId s = 1; s <= 3; ++s) p.plan.complete(s, kVersion, kScene);
  const SessionId first = p.join_and_want(4), second = p.join_and_want(5);
  EXPECT_NE(first, kFedByMaster);
  EXPECT_NE(second, kFedByMaster);
  EXPECT_NE(first, second) << "one child each";
}

TEST(RelayPlan, TheNextVersionKeepsTheChainInWhateverOrderItIsAskedFor) {
  Plan p;
  for (SessionId s = 1; s <= 4; ++s) p.join_and_want(s);
  for (SessionId s = 1; s <= 4; ++s) p.plan.complete(s, kVersion, kScene);
  const auto next = [&](SessionId s) {
    return p.plan.want(s, kVersion + 1, kScene, kScene, true, p.now);
  };
  EXPECT_EQ(next(3), 2u) << "which has not asked yet itself";
  EXPECT_EQ(next(4), 3u);
  EXPECT_EQ(next(1), kFedByMaster);
  EXPECT_EQ(next(2), 1u);
}

TEST(RelayPlan, AUsualFeederThatFeedsAnotherInTheVersionBeforeIsLeftAlone) {
  Plan p;
  p.join_and_want(1);
  p.join_and_want(2);
  p.plan.complete(1, kVersion, kScene);
  p.plan.complete(2, kVersion, kScene);
  EXPECT_EQ(p.join_and_want(3), 1u) << "of those that have it all the first; still on its way";
  const SessionId feeder = p.plan.want(2, kVersion + 1, kScene, kScene, true, p.now);
  EXPECT_NE(feeder, 1u) << "two children at a time";
}

TEST(RelayPlan, AUsualFeederThatIsGoneOrFailedIsReplaced) {
  Plan p;
  for (SessionId s = 1; s <= 3; ++s) p.join_and_want(s);
  for (SessionId s = 1; s <= 3; ++s) p.plan.complete(s, kVersion, kScene);
  p.plan.lost(2, p.now);
  EXPECT_EQ(p.plan.want(1, kVersion + 1, kScene, kScene, true, p.now), kFedByMaster);
  EXPECT_EQ(p.plan.want(3, kVersion + 1, kScene, kScene, true, p.now), 1u);
  // A feeder that never gets the version itself cannot feed it to anybody and is bypassed.
  EXPECT_EQ(p.plan.want(3, kVersion + 2, kScene, kScene, true, p.now), 1u);
  p.now += RelayPlan::kWindow;
  bool is_bypassed = false;
  for (const Feed& feed : p.plan.tick(p.now))
    is_bypassed |= feed.child == 3 && feed.version == kVersion + 2 && feed.feeder == kFedByMaster;
  EXPECT_TRUE(is_bypassed);
}

// Whatever happens in random histories of a plan, no slave waits for itself, and each child has a
// feeder that is still there.
TEST(RelayPlan, NoCircleWhateverHappens) {
  for (std::uint32_t seed = 1; seed <= 300; ++seed) {
    std::mt19937_64 random(test::seed(seed));
    Plan p;
    std::set<SessionId> here, done;
    SessionId next = 1;
    for (int step = 0; step < 200; ++step) {
      p.now += std::chrono::milliseconds(random() % 700);
      const auto any = [&] {
        auto it = here.begin();
        std::advance(it, static_cast<std::ptrdiff_t>(random() % here.size()));
        return *it;
      };
      if (here.empty() || random() % 4 == 0) {
        p.join_and_want(next, random() % 8 != 0, random() % 8 == 0);
        here.insert(next++);
      } else if (random() % 6 == 0) {
        const SessionId gone = any();
        here.erase(gone);
        p.plan.lost(gone, p.now);
      } else if (random() % 3 == 0) {
        const SessionId child = any();
        const auto feeder = p.plan.feeder_of(child, kVersion);
        if (feeder) p.fail(child, *feeder, static_cast<wire::RelayFault>(random() % 3));
      } else if (random() % 8 == 0) {
        const SessionId whole = any();
        p.plan.complete(whole, kVersion, kScene);
        done.insert(whole);
      } else {
        p.pass(Duration::zero(), {{any(), random() % kScene}});
      }
      for (const SessionId session : here) {
        SessionId up = session;
        for (std::size_t links = 0; up != kFedByMaster; ++links) {
          ASSERT_LE(links, here.size()) << "a circle; seed " << seed;
          if (done.contains(up)) break;
          ASSERT_TRUE(here.contains(up)) << "fed by a lost one; seed " << seed;
          up = p.plan.feeder_of(up, kVersion).value_or(kFedByMaster);
        }
      }
    }
  }
}

}  // namespace
}  // namespace tessera::master
