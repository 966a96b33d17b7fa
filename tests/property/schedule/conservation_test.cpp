// SPDX-License-Identifier: Apache-2.0
// Slaves that come, answer late, hand back and die at random: no tile is lost, none counts twice,
// frames come out in order, and every lease ends once.
//
// A failing seed is printed; run it alone with TESSERA_SEED=N.
#include <gtest/gtest.h>
#include <stdlib.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <random>
#include <set>

#include "common/base/limits.h"
#include "master/schedule/lease_accounts.h"
#include "master/schedule/scheduler.h"

namespace tessera::master {
namespace {

using namespace std::chrono_literals;

struct Lease {
  FrameId frame = 0;
  SceneVersion version = 0;
  TileAssignment tile;
};

// A simulated cluster as the scheduler sees it, with checks of what must never happen.
class Cluster {
 public:
  explicit Cluster(std::uint64_t seed)
      : random_(seed),
        options_{pick(-1, 4), pick(1, 2), pick(0, 9) == 0, {pick(0, 3) == 0 ? 0.3 : 0}},
        scheduler_(options_),
        kill_share_(pick(0, 3)) {}

  void run() {
    for (int i = pick(1, 4); i > 0; --i) join();
    if (pick(0, 1) == 0) perform(scheduler_.start(now_));
    for (int step = 0; step < 400 && !::testing::Test::HasFatalFailure(); ++step) {
      random_event();
      check();
    }
    finish();
  }

 private:
  int pick(int least, int greatest) {
    return std::uniform_int_distribution<int>(least, greatest)(random_);
  }

  void random_event() {
    now_ += std::chrono::milliseconds(pick(0, 40));
    const int event = pick(0, 99);
    if (event < 55) return answer_one();
    if (event < 65) return build_one();
    if (event < 75) return submit();
    if (event < 80)
      return perform(scheduler_.tick(now_ += std::chrono::milliseconds(pick(0, 900))));
    if (event < 85) return hand_back_one();
    if (event < 90) return join();
    if (event < 93) return cancel_one();
    if (event < 94 && !scheduler_.is_started()) return perform(scheduler_.start(now_));
    if (event < 94 + kill_share_) lose_one();
  }

  void join() {
    if (slaves_.size() >= 6) return;
    const SessionId session = ++last_session_;
    const auto threads = static_cast<std::uint32_t>(pick(1, 3));
    slaves_[session].threads = threads;
    slaves_[session].is_liar = options_.audit.share > 0 && pick(0, 7) == 0;
    liar_count_ += slaves_[session].is_liar;
    scheduler_.slave_joined(session, {std::to_string(session), "", 0}, threads, now_);
  }

  SessionId any_slave() {
    if (slaves_.empty()) return 0;
    auto it = slaves_.begin();
    std::advance(it, pick(0, static_cast<int>(slaves_.size()) - 1));
    return it->first;
  }

  void build_one() {
    const SessionId session = any_slave();
    if (session == 0) return;
    Slave& slave = slaves_[session];
    if (slave.built >= newest_version_) return;
    perform(scheduler_.scene_built(session, ++slave.built, now_));
  }

  void submit() {
    if (submitted_ - delivered_ >= 4) return;
    if (pick(0, 2) == 0 || newest_version_ == 0) ++newest_version_;
    const FrameId frame = submitted_++;
    const auto tiles = static_cast<TileIndex>(pick(1, 30));
    versions_[frame] = newest_version_;
    tiles_[frame] = tiles;
    std::vector<TileIndex> order(tiles);
    std::iota(order.begin(), order.end(), TileIndex{0});
    std::shuffle(order.begin(), order.end(), random_);
    perform(scheduler_.submit_frame(frame, newest_version_, order, now_));
  }

  void answer_one() {
    const SessionId session = any_slave();
    if (session == 0 || slaves_[session].leases.empty()) return;
    auto& leases = slaves_[session].leases;
    const auto which = pick(0, 4) == 0 ? pick(0, static_cast<int>(leases.size()) - 1) : 0;
    const Lease lease = leases[static_cast<std::size_t>(which)];
    leases.erase(leases.begin() + which);
    Actions actions;
    const double render = 0.001 * pick(0, 30);
    const std::uint64_t pixels = slaves_[session].is_liar ? session : 0;
    const ResultVerdict verdict =
        scheduler_.result(session,
                          {lease.frame, lease.version, lease.tile.tile, lease.tile.attempt, render,
                           render + 0.001 * pick(0, 9), 0.001 * pick(0, 1), pixels},
                          now_, actions);
    if (verdict == ResultVerdict::kAccepted) {
      const bool is_first = accepted_[lease.frame].insert(lease.tile.tile).second;
      EXPECT_TRUE(is_first || options_.audit.share > 0) << "a tile accepted twice";
    } else {
      EXPECT_TRUE(answers_lease(verdict) || verdict == ResultVerdict::kFrameEnded)
          << verdict_text(verdict) << ": an honest slave is no violator";
    }
    if (verdict != ResultVerdict::kFrameEnded)
      accounts_.answered(session, lease.frame, lease.tile, verdict == ResultVerdict::kAccepted);
    for (const Action& action : actions) {
      if (verdict == ResultVerdict::kAccepted && action.kind == ActionKind::kExpel)
        accounts_.overruled(action.session);
    }
    perform(actions);
  }

  void hand_back_one() {
    const SessionId session = any_slave();
    if (session == 0 || slaves_[session].leases.empty()) return;
    const Lease lease = slaves_[session].leases.back();
    slaves_[session].leases.pop_back();
    accounts_.handed_back(session, lease.frame, lease.tile);
    perform(
        scheduler_.tile_returned(session, lease.frame, lease.tile.tile, lease.tile.attempt, now_));
  }

  void lose_one() {
    const SessionId session = any_slave();
    if (session == 0) return;
    slaves_.erase(session);
    accounts_.slave_lost(session);
    perform(scheduler_.slave_lost(session, now_));
  }

  void cancel_one() {
    if (submitted_ == delivered_) return;
    const FrameId frame =
        delivered_ + static_cast<FrameId>(pick(0, static_cast<int>(submitted_ - delivered_) - 1));
    perform(scheduler_.cancel_frame(frame, now_));
  }

  void perform(const Actions& actions) {
    for (const Action& action : actions) {
      switch (action.kind) {
        case ActionKind::kBeginFrame:
          EXPECT_TRUE(slaves_.at(action.session).begun.insert(action.frame).second);
          break;
        case ActionKind::kLease:
          on_lease(action);
          break;
        case ActionKind::kEndFrame:
          slaves_.at(action.session).begun.erase(action.frame);
          accounts_.frame_ended(action.session, action.frame);
          break;
        case ActionKind::kSuspect:
          break;
        case ActionKind::kStalled:
          EXPECT_TRUE(slaves_.contains(action.session));
          break;
        case ActionKind::kExpel:
          EXPECT_TRUE(!slaves_.contains(action.session) || slaves_[action.session].is_liar ||
                      liar_count_ > 1)
              << "an honest slave was outvoted by one liar";
          break;
        case ActionKind::kFrameComplete:
          EXPECT_EQ(accepted_[action.frame].size(), tiles_[action.frame]) << "a hole in the frame";
          [[fallthrough]];
        case ActionKind::kFrameFailed:
          EXPECT_EQ(action.frame, delivered_) << "out of order, or twice";
          delivered_ = action.frame + 1;
          break;
      }
    }
  }

  void on_lease(const Action& action) {
    ASSERT_TRUE(slaves_.contains(action.session)) << "a lease for a slave that is gone";
    Slave& slave = slaves_[action.session];
    EXPECT_TRUE(slave.begun.contains(action.frame)) << "a tile before its frame";
    EXPECT_GE(slave.built, versions_[action.frame]) << "a tile of a scene not built there";
    EXPECT_LT(action.tile.tile, tiles_[action.frame]);
    EXPECT_LT(action.frame, delivered_ + static_cast<FrameId>(options_.frames_in_flight) + 4);
    slave.leases.push_back({action.frame, versions_[action.frame], action.tile});
    accounts_.leased(action.session, action.frame, action.tile);
  }

  void check() {
    const LedgerCounts counts = scheduler_.counts();
    ASSERT_EQ(counts.issued,
              counts.accepted + counts.rejected + counts.abandoned + counts.in_flight);
    // A second account, kept only from what was done and heard, says the same.
    ASSERT_EQ(accounts_.total(), (TileAccounts{counts.issued, counts.accepted, counts.rejected,
                                               counts.abandoned, counts.in_flight}));
    for (const auto& [session, slave] : slaves_) {
      ASSERT_LE(scheduler_.tiles_in_flight(session), slave.threads * kTilesPerWorkerMax);
      ASSERT_EQ(accounts_.of(session).in_flight, scheduler_.tiles_in_flight(session));
    }
  }

  // Slaves are honest and there are no more accidents, so that every frame comes out.
  void finish() {
    if (!scheduler_.is_started()) perform(scheduler_.start(now_));
    for (int round = 0; round < 4000 && delivered_ < submitted_; ++round) {
      now_ += 100ms;
      if (slaves_.empty()) join();
      for (auto& [session, slave] : slaves_) {
        while (slave.built < newest_version_) {
          perform(scheduler_.scene_built(session, ++slave.built, now_));
        }
      }
      for (int i = 0; i < 20; ++i) answer_one();
      perform(scheduler_.tick(now_));
      check();
    }
    EXPECT_EQ(delivered_, submitted_) << "a frame never came out";
    EXPECT_EQ(scheduler_.counts().in_flight, 0u);
  }

  struct Slave {
    std::uint32_t threads = 1;
    bool is_liar = false;  // its pixels are wrong, as no other slave has them
    SceneVersion built = 0;
    std::set<FrameId> begun;
    std::vector<Lease> leases;
  };

  std::mt19937_64 random_;
  const SchedulerOptions options_;
  Scheduler scheduler_;
  LeaseAccounts accounts_;
  const int kill_share_;
  TimePoint now_{};
  std::map<SessionId, Slave> slaves_;
  SessionId last_session_ = 0;
  int liar_count_ = 0;  // in the whole run
  FrameId submitted_ = 0, delivered_ = 0;
  SceneVersion newest_version_ = 0;
  std::map<FrameId, SceneVersion> versions_;
  std::map<FrameId, TileIndex> tiles_;
  std::map<FrameId, std::set<TileIndex>> accepted_;
};

TEST(ScheduleConservation, TilesAreConservedUnderRandomFailures) {
  const char* one = getenv("TESSERA_SEED");
  const std::uint64_t first = one != nullptr ? strtoull(one, nullptr, 10) : 1;
  const std::uint64_t count = one != nullptr ? 1 : 1000;
  for (std::uint64_t seed = first; seed < first + count; ++seed) {
    Cluster(seed).run();
    if (HasFailure()) FAIL() << "TESSERA_SEED=" << seed;
  }
}

}  // namespace
}  // namespace tessera::master
