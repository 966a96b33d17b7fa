// SPDX-License-Identifier: Apache-2.0
// A scheduler and slaves that join, are lost, answer or do not, for tests of what bad ones may do.
//
// Threads. One.
#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <map>
#include <numeric>
#include <string>
#include <vector>

#include "master/schedule/scheduler.h"

namespace tessera::master {

using namespace std::chrono_literals;
inline constexpr double kTileSeconds = 0.010;

// A scheduler, its slaves, and what is out.
class BadSlaves : public ::testing::Test {
 protected:
  explicit BadSlaves(const AuditOptions& audit = {}) : scheduler_({3, 2, false, audit}) {
    EXPECT_TRUE(scheduler_.start(now_).empty());
  }

  // A slave joins and builds the scene. Returns: its session.
  SessionId join(const std::string& name, std::uint64_t instance, std::uint32_t threads = 1,
                 const std::string& key = "") {
    const SessionId session = ++last_session_;
    scheduler_.slave_joined(session, {name, key, instance}, threads, now_);
    perform(scheduler_.scene_built(session, 1, now_));
    return session;
  }
  void lose(SessionId session, SlaveEnd how = SlaveEnd::kLost) {
    const Actions actions = scheduler_.slave_lost(session, now_, how);
    out_.erase(session);
    perform(actions);
  }
  void submit(FrameId frame, TileIndex tiles) {
    std::vector<TileIndex> order(tiles);
    std::iota(order.begin(), order.end(), TileIndex{0});
    perform(scheduler_.submit_frame(frame, 1, order, now_));
  }
  // The slave answers its oldest lease. Returns: false when it has none.
  bool answer(SessionId session, bool is_faulty = false, std::uint64_t pixels = 0) {
    std::vector<Action>& leases = out_[session];
    if (leases.empty()) return false;
    const Action lease = leases.front();
    leases.erase(leases.begin());
    Actions actions;
    scheduler_.result(session,
                      {lease.frame, 1, lease.tile.tile, lease.tile.attempt, kTileSeconds,
                       kTileSeconds, 0, pixels, is_faulty},
                      now_, actions);
    perform(actions);
    return true;
  }
  void tick(Duration later) { perform(scheduler_.tick(now_ += later)); }
  bool holds(SessionId session, TileIndex tile) {
    for (const Action& lease : out_[session]) {
      if (lease.tile.tile == tile) return true;
    }
    return false;
  }

  void perform(const Actions& actions) {
    for (const Action& action : actions) {
      if (action.kind == ActionKind::kLease) out_[action.session].push_back(action);
      if (action.kind == ActionKind::kEndFrame) {
        std::erase_if(out_[action.session],
                      [&](const Action& lease) { return lease.frame == action.frame; });
      }
      if (action.kind == ActionKind::kFrameComplete) ++complete_;
      if (action.kind == ActionKind::kFrameFailed) failed_.push_back(action.reason);
      if (action.kind == ActionKind::kSuspect) suspects_.push_back(action.slave);
      if (action.kind == ActionKind::kExpel) expelled_.push_back(action.slave);
      if (action.kind == ActionKind::kStalled) stalled_.push_back(action.session);
    }
  }

  Scheduler scheduler_, scheduler_audits_{{3, 2, false, {1.0}}};
  TimePoint now_{};
  SessionId last_session_ = 0;
  std::map<SessionId, std::vector<Action>> out_;
  int complete_ = 0;
  std::vector<std::string> failed_;
  std::vector<std::string> suspects_, expelled_;  // SlaveIdentity::id()
  std::vector<SessionId> stalled_;
};

}  // namespace tessera::master
