// SPDX-License-Identifier: Apache-2.0
// What happens to frames and tiles, for whoever watches: accounts of every slave's leases, metrics,
// a trace. The frame loop tells the observer what it does and hears; the observer decides nothing.
//
// Threads. Io thread only; the trace is handed over there, too.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>

#include "common/wire/messages.h"
#include "master/cluster/cluster.h"
#include "master/frame_loop/trace.h"
#include "master/schedule/frame_ledger.h"
#include "master/schedule/lease_accounts.h"
#include "master/schedule/scheduler.h"

namespace tessera::master {

enum class FrameEndKind { kDone, kFailed, kCancelled };

class Observer {
 public:
  explicit Observer(const Cluster& cluster) : cluster_(cluster) {}

  void slave_joined(SessionId session, std::uint32_t threads);
  void slave_lost(SessionId session);
  void leased(SessionId session, FrameId frame, const TileAssignment& tile, TimePoint now);
  // How long ago the lease was given, zero for one that is not outstanding.
  Duration since_lease(SessionId session, FrameId frame, const TileAssignment& tile,
                       TimePoint now) const {
    const auto since = accounts_.leased_at(session, frame, tile);
    return since ? now - *since : Duration::zero();
  }
  void scene_offered(SceneVersion version, TimePoint now);  // to all slaves, those to come, too
  void scene_built(SessionId session, const wire::SceneBuilt& built, TimePoint now);
  void handed_back(SessionId session, const wire::TileReturned& tile);
  void frame_ended(SessionId session, FrameId frame);  // FrameEnd was sent to that slave
  // `actions`: what the scheduler made of the result.
  void answered(SessionId session, const wire::TileResult& result, ResultVerdict verdict,
                const Actions& actions, TimePoint now);
  // `begin`: when the frame's first tile was leased; nothing for a frame that never began.
  void frame_over(FrameId frame, SceneVersion version, FrameEndKind kind,
                  std::optional<TimePoint> begin, TimePoint now);

  // Records from the first lease or built scene on, for `interval` (zero: until finish_trace());
  // then hands the trace over, once.
  void start_trace(Duration interval, std::function<void(Trace)> on_done);
  // Ends an interval that is over; call often.
  void tick(TimePoint now);
  // Hands over what was recorded, if that was not done before.
  void finish_trace();

  // The status as far as frames, tiles and slaves go: without the application, quarantined slaves,
  // open frames, and the pace, which sorts the times of tiles.
  ClusterStatus counts(const Scheduler& scheduler) const;

 private:
  // More versions are never in work at one time.
  static constexpr std::size_t kOfferedMax = 64;

  void begin_trace(TimePoint now);  // where one is wanted
  // Since when the scene is on its way to the slave, if that is known.
  std::optional<TimePoint> offered_at(SessionId session, SceneVersion version) const;

  const Cluster& cluster_;
  LeaseAccounts accounts_;
  std::uint64_t frames_done_ = 0, frames_failed_ = 0, frames_cancelled_ = 0, tiles_reissued_ = 0,
                slaves_lost_ = 0;
  std::map<SceneVersion, TimePoint> offered_;  // the newest
  std::map<SessionId, TimePoint> joined_;      // of slaves that are here
  std::optional<TraceRecorder> trace_;         // since it began
  std::function<void(Trace)> on_trace_;        // null: no trace is wanted, or it was handed over
  Duration trace_interval_{};
  TimePoint trace_end_{};
};

}  // namespace tessera::master
