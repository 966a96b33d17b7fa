// SPDX-License-Identifier: Apache-2.0
#include "master/frame_loop/observer.h"

#include <algorithm>
#include <utility>

#include "master/cluster/master_metrics.h"

namespace tessera::master {

void Observer::slave_joined(SessionId session, std::uint32_t threads) {
  joined_[session] = Clock::now();
  if (trace_) trace_->slave_joined(session, cluster_.name_of(session), threads);
}

void Observer::slave_lost(SessionId session) {
  accounts_.slave_lost(session);
  joined_.erase(session);
  ++slaves_lost_;
  if (trace_) trace_->slave_lost(session);
}

void Observer::leased(SessionId session, FrameId frame, const TileAssignment& tile, TimePoint now) {
  accounts_.leased(session, frame, tile, now);
  // An earlier action of the same list may have expelled the slave.
  if (cluster_.threads_of(session) == 0) return accounts_.slave_lost(session);
  if (tile.attempt > 1 && !tile.is_comparison) ++tiles_reissued_;
  begin_trace(now);
  if (trace_) trace_->leased(session, frame, tile.tile, tile.attempt, now);
}

void Observer::begin_trace(TimePoint now) {
  if (!on_trace_ || trace_) return;
  trace_.emplace(now);
  trace_end_ = now + trace_interval_;
  for (const SessionId other : cluster_.joined_sessions())
    trace_->slave_joined(other, cluster_.name_of(other), cluster_.threads_of(other));
}

void Observer::scene_offered(SceneVersion version, TimePoint now) {
  offered_[version] = now;
  if (offered_.size() > kOfferedMax) offered_.erase(offered_.begin());
}

std::optional<TimePoint> Observer::offered_at(SessionId session, SceneVersion version) const {
  const auto offered = offered_.find(version);
  const auto joined = joined_.find(session);
  if (offered == offered_.end() || joined == joined_.end()) return std::nullopt;
  return std::max(offered->second, joined->second);
}

void Observer::scene_built(SessionId session, const wire::SceneBuilt& built, TimePoint now) {
  begin_trace(now);
  if (trace_)
    trace_->built({session, built.version, now, built.build_seconds, built.built_primitives,
                   offered_at(session, built.version)});
}

void Observer::handed_back(SessionId session, const wire::TileReturned& tile) {
  accounts_.handed_back(session, tile.frame, {tile.tile, tile.attempt});
}

void Observer::frame_ended(SessionId session, FrameId frame) {
  accounts_.frame_ended(session, frame);
  if (trace_) trace_->frame_ended(session, frame);
}

void Observer::answered(SessionId session, const wire::TileResult& result, ResultVerdict verdict,
                        const Actions& actions, TimePoint now) {
  MasterMetrics& cells = master_metrics();
  cells.results[static_cast<std::size_t>(verdict)].add();
  if (!answers_lease(verdict)) return;
  cells.tile_seconds.observe(result.seconds);
  const bool is_accepted = verdict == ResultVerdict::kAccepted;
  accounts_.answered(session, result.frame, {result.tile, result.attempt}, is_accepted);
  for (const Action& action : actions) {  // an audit took another slave's pixels instead
    if (is_accepted && action.kind == ActionKind::kExpel) accounts_.overruled(action.session);
  }
  if (!trace_ || result.began_ns == 0) return;
  TracedTile tile;
  tile.session = session;
  tile.frame = result.frame;
  tile.tile = result.tile;
  tile.attempt = result.attempt;
  tile.worker = result.worker;
  tile.received = now;
  tile.began_ns = result.began_ns;
  tile.render_seconds = result.seconds;
  tile.is_accepted = is_accepted;
  trace_->answered(tile, cluster_.clock_of(session, now));
}

void Observer::frame_over(FrameId frame, SceneVersion version, FrameEndKind kind,
                          std::optional<TimePoint> begin, TimePoint now) {
  static constexpr const char* kOutcomes[] = {"done", "failed", "cancelled"};
  if (kind == FrameEndKind::kDone) ++frames_done_;
  if (kind == FrameEndKind::kFailed) ++frames_failed_;
  if (kind == FrameEndKind::kCancelled) ++frames_cancelled_;
  if (!begin) return;
  if (kind == FrameEndKind::kDone) master_metrics().frame_seconds.observe(seconds(now - *begin));
  if (trace_)
    trace_->frame_over({frame, version, *begin, now, kOutcomes[static_cast<std::size_t>(kind)]});
}

void Observer::start_trace(Duration interval, std::function<void(Trace)> on_done) {
  trace_interval_ = interval;
  on_trace_ = std::move(on_done);
}

void Observer::tick(TimePoint now) {
  if (trace_ && trace_interval_ > Duration::zero() && now >= trace_end_) finish_trace();
}

void Observer::finish_trace() {
  if (!on_trace_) return;
  const auto on_done = std::exchange(on_trace_, nullptr);
  on_done(trace_ ? trace_->take() : Trace());
  trace_.reset();
}

ClusterStatus Observer::counts(const Scheduler& scheduler) const {
  ClusterStatus status;
  status.slaves = cluster_.status([&](SessionId session, SlaveStatus& slave) {
    slave.tiles_in_flight = scheduler.tiles_in_flight(session);
    if (scheduler.is_stalled(session)) slave.state = SlaveState::kStalled;
    slave.tiles = accounts_.of(session);
    const SlavePace* pace = scheduler.pace(session);
    if (pace == nullptr) return;
    slave.prefetch_depth = pace->depth() - std::min(pace->depth(), slave.threads);
    if (pace->is_known()) slave.tile_seconds = pace->tile_seconds();
  });
  const LedgerCounts counts = scheduler.counts();
  status.tiles = {counts.issued, counts.accepted, counts.rejected, counts.abandoned,
                  counts.in_flight};
  status.frames_done = frames_done_;
  status.frames_failed = frames_failed_;
  status.frames_cancelled = frames_cancelled_;
  status.tiles_reissued = tiles_reissued_;
  status.slaves_lost = slaves_lost_;
  return status;
}

}  // namespace tessera::master
