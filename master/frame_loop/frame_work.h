// SPDX-License-Identifier: Apache-2.0
// One frame from submit to outcome: its pixels, and the account of what it cost.
//
// Threads. Io thread only.
#pragma once

#include <optional>
#include <set>
#include <utility>

#include "common/base/clock.h"
#include "master/cluster/cluster.h"
#include "master/frame_loop/frame_assembly.h"
#include "master/schedule/scheduler.h"

namespace tessera::master {

class FrameWork {
 public:
  FrameWork(FrameId frame, SceneVersion version, const FrameSettings& settings, FrameDigest digest)
      : assembly(frame, version, settings, std::move(digest)) {}

  // A slave is about to get its first tile of this frame, with this instruction set.
  void slave_begins(Isa isa, Cluster& cluster);
  // Adds an accepted result. `is_settled`: no other one of the tile will be.
  void add(SessionId session, const wire::TileResult& result, std::uint16_t slave_ordinal,
           bool is_settled);
  // Completes the account once the last result has come.
  void settle(const Cluster& cluster, const Scheduler& scheduler);
  // Those whose tiles were taken.
  const std::set<SessionId>& slaves() const { return slaves_; }
  // When the frame's first tile was leased; nothing before that.
  std::optional<TimePoint> begin() const {
    return has_begun_ ? std::optional(begin_) : std::nullopt;
  }

  FrameAssembly assembly;

 private:
  bool has_begun_ = false;  // first tile leased
  TimePoint begin_;
  std::uint64_t bytes_sent_at_begin_ = 0, bytes_received_at_begin_ = 0;
  double starved_seconds_ = 0;
  double available_threads_ = 0;
  std::set<SessionId> slaves_;
};

}  // namespace tessera::master
