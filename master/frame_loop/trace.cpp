// SPDX-License-Identifier: Apache-2.0
#include "master/frame_loop/trace.h"

#include <algorithm>

namespace tessera::master {
namespace {

constexpr double kBuildSecondsMax = 24 * 3600;  // a slave may say anything

}  // namespace

void TraceRecorder::slave_joined(SessionId session, const std::string& name,
                                 std::uint32_t threads) {
  if (trace_.slaves.size() >= kSlavesMax) forget_slaves();
  trace_.slaves[session] = {name, threads, std::nullopt};
  present_.insert(session);
}

// Forgets slaves that are gone and have neither tile nor build here.
void TraceRecorder::forget_slaves() {
  std::set<SessionId> kept = present_;
  for (const TracedTile& tile : trace_.tiles) kept.insert(tile.session);
  for (const TracedBuild& build : trace_.builds) kept.insert(build.session);
  std::erase_if(trace_.slaves, [&](const auto& entry) { return !kept.contains(entry.first); });
}

void TraceRecorder::leased(SessionId session, FrameId frame, std::uint32_t tile,
                           std::uint32_t attempt, TimePoint now) {
  leases_[{session, frame, tile, attempt}] = now;
}

void TraceRecorder::frame_ended(SessionId session, FrameId frame) {
  leases_.erase(leases_.lower_bound({session, frame, 0, 0}),
                leases_.lower_bound({session, frame + 1, 0, 0}));
}

void TraceRecorder::slave_lost(SessionId session) {
  present_.erase(session);
  leases_.erase(leases_.lower_bound({session, 0, 0, 0}),
                leases_.lower_bound({session + 1, 0, 0, 0}));
}

void TraceRecorder::answered(TracedTile tile, const std::optional<ClockEstimate>& clock) {
  const auto slave = trace_.slaves.find(tile.session);
  const auto lease = leases_.find({tile.session, tile.frame, tile.tile, tile.attempt});
  if (slave == trace_.slaves.end() || lease == leases_.end()) return;
  tile.leased = lease->second;
  leases_.erase(lease);
  slave->second.clock = better(slave->second.clock, clock);
  trace_.tiles.push_back(tile);
  if (trace_.tiles.size() > kTilesMax) {
    trace_.tiles.pop_front();
    ++trace_.tiles_dropped;
  }
}

void TraceRecorder::frame_over(const TracedFrame& frame) {
  trace_.start = std::min(trace_.start, frame.begin);  // a moment before the frame's first lease
  trace_.frames.push_back(frame);
  if (trace_.frames.size() > kFramesMax) {
    trace_.frames.pop_front();
    ++trace_.frames_dropped;
  }
}

void TraceRecorder::built(const TracedBuild& build) {
  if (!trace_.slaves.contains(build.session)) return;
  trace_.builds.push_back(build);
  double& said = trace_.builds.back().seconds;
  said = std::clamp(said, 0.0, kBuildSecondsMax);
  const auto taken = std::chrono::duration_cast<Duration>(std::chrono::duration<double>(said));
  trace_.start = std::min(trace_.start, build.told - taken);
  if (build.offered) trace_.start = std::min(trace_.start, *build.offered);
  if (trace_.builds.size() > kFramesMax) {
    trace_.builds.pop_front();
    ++trace_.builds_dropped;
  }
}

}  // namespace tessera::master
