#include "master/schedule/scheduler.h"

#include <algorithm>
#include <utility>

#include "common/base/check.h"
#include "common/base/limits.h"

namespace tessera::master {
namespace {

// A tile is overdue after twice the usual time from lease to result, but never before this: short
// of it, the message to a second slave costs more than waiting.
constexpr std::chrono::milliseconds kOverdueMin{500};
// A slave that hands back a tile gets none for this long: more than leaving takes (2 s for the
// tiles in work, 2 s to say goodbye), so that slaves that leave together do not pass tiles around.
constexpr std::chrono::seconds kRest{5};
// Ended frames whose late results are still known as such; more than an application can cancel
// while a result waits in a slave's send queue.
constexpr std::size_t kFramesRemembered = 1024;
constexpr double kTurnaroundWeight = 0.1;  // of the newest result in the moving average

}  // namespace

Scheduler::Frame* Scheduler::find(FrameId id) {
  const auto found =
      std::find_if(frames_.begin(), frames_.end(), [&](const Frame& f) { return f.id == id; });
  return found == frames_.end() ? nullptr : &*found;
}

const FrameLedger* Scheduler::ledger(FrameId frame) const {
  const Frame* found = const_cast<Scheduler*>(this)->find(frame);
  return found == nullptr ? nullptr : &found->ledger;
}

std::size_t Scheduler::active_count() const {
  return std::min(frames_.size(), static_cast<std::size_t>(options_.frames_in_flight));
}

Actions Scheduler::start(TimePoint now) {
  is_started_ = true;
  Actions actions;
  fill_all(now, actions);
  return actions;
}

void Scheduler::slave_joined(SessionId session, std::uint32_t threads) {
  TESSERA_CHECK(!slaves_.contains(session));
  slaves_[session].threads = std::max(threads, 1u);
}

Actions Scheduler::slave_lost(SessionId session, TimePoint now) {
  Actions actions;
  const auto slave = slaves_.find(session);
  if (slave == slaves_.end()) return actions;
  const std::uint32_t threads = slave->second.threads;
  slaves_.erase(slave);
  for (Frame& frame : frames_) {
    if (frame.state != FrameState::kOpen || frame.held.erase(session) == 0) continue;
    if (frame.ledger.lose_session(session, threads) >= kTileAttemptsMax) {
      end_frame(frame, FrameState::kFailed,
                "a tile was lost with " + std::to_string(kTileAttemptsMax) +
                    " slaves, one after the other",
                actions);
    }
  }
  fail_hopeless(actions);
  deliver(actions);
  fill_all(now, actions);
  return actions;
}

Actions Scheduler::scene_built(SessionId session, SceneVersion version, TimePoint now) {
  Actions actions;
  const auto slave = slaves_.find(session);
  if (slave == slaves_.end()) return actions;
  slave->second.built.insert(version);
  fill_all(now, actions);
  return actions;
}

Actions Scheduler::scene_failed(SessionId session, SceneVersion version, const std::string& reason,
                                TimePoint now) {
  Actions actions;
  const auto slave = slaves_.find(session);
  if (slave == slaves_.end()) return actions;
  slave->second.failed[version] = reason;
  fail_hopeless(actions);
  deliver(actions);
  fill_all(now, actions);
  return actions;
}

// A frame whose scene no connected slave can hold.
void Scheduler::fail_hopeless(Actions& actions) {
  if (slaves_.empty()) return;
  for (Frame& frame : frames_) {
    if (frame.state != FrameState::kOpen) continue;
    const SceneVersion version = frame.ledger.version();
    const bool is_hopeless = std::all_of(slaves_.begin(), slaves_.end(), [&](const auto& entry) {
      return entry.second.failed.contains(version);
    });
    if (is_hopeless) {
      end_frame(frame, FrameState::kFailed,
                "no slave can hold the scene: " + slaves_.begin()->second.failed[version], actions);
    }
  }
}

Actions Scheduler::submit_frame(FrameId frame, SceneVersion version, TileIndex tile_count,
                                TimePoint now) {
  TESSERA_CHECK_GE(frame, next_frame_);
  next_frame_ = frame + 1;
  frames_.push_back({frame, FrameState::kOpen, "", FrameLedger(version, tile_count), {}});
  Actions actions;
  fail_hopeless(actions);
  deliver(actions);
  fill_all(now, actions);
  return actions;
}

Actions Scheduler::cancel_frame(FrameId id, TimePoint now) {
  Actions actions;
  Frame* frame = find(id);
  if (frame == nullptr || frame->state != FrameState::kOpen) return actions;
  end_frame(*frame, FrameState::kCancelled, "cancelled", actions);
  deliver(actions);
  fill_all(now, actions);
  return actions;
}

Actions Scheduler::refuse_frame(FrameId frame, std::string reason) {
  TESSERA_CHECK_GE(frame, next_frame_);
  next_frame_ = frame + 1;
  frames_.push_back({frame, FrameState::kFailed, std::move(reason), FrameLedger(0, 1), {}});
  Actions actions;
  deliver(actions);
  return actions;
}

void Scheduler::retire_scenes(SceneVersion first_kept) {
  for (auto& [session, slave] : slaves_) {
    slave.built.erase(slave.built.begin(), slave.built.lower_bound(first_kept));
    slave.failed.erase(slave.failed.begin(), slave.failed.lower_bound(first_kept));
  }
}

void Scheduler::release(Frame& frame, SessionId session) {
  if (const auto held = frame.held.find(session); held != frame.held.end() && --held->second == 0)
    frame.held.erase(held);
  if (const auto slave = slaves_.find(session); slave != slaves_.end()) --slave->second.in_flight;
}

ResultVerdict Scheduler::result(SessionId session, FrameId id, SceneVersion version, TileIndex tile,
                                Attempt attempt, TimePoint now, Actions& actions) {
  const auto slave = slaves_.find(session);
  if (slave == slaves_.end()) return ResultVerdict::kNotLeased;
  Frame* frame = find(id);
  if (frame == nullptr || frame->state != FrameState::kOpen) {
    return slave->second.begun.contains(id) ? ResultVerdict::kFrameEnded
                                            : ResultVerdict::kUnknownFrame;
  }
  const ResultVerdict verdict = frame->ledger.accept(session, version, tile, attempt);
  if (verdict != ResultVerdict::kAccepted && verdict != ResultVerdict::kDuplicate) return verdict;
  release(*frame, session);
  if (const auto since = leased_at_.find({id, tile}); since != leased_at_.end()) {
    const double turnaround = seconds(now - since->second);
    turnaround_seconds_ +=
        (turnaround_seconds_ == 0 ? 1 : kTurnaroundWeight) * (turnaround - turnaround_seconds_);
    leased_at_.erase(since);
  }
  if (frame->ledger.is_complete()) {
    end_frame(*frame, FrameState::kComplete, "", actions);
    deliver(actions);
    fill_all(now, actions);
  } else {
    while (lease_one(session, slave->second, now, actions)) {
    }
  }
  return verdict;
}

Actions Scheduler::tile_returned(SessionId session, FrameId id, TileIndex tile, Attempt attempt,
                                 TimePoint now) {
  Actions actions;
  Frame* frame = find(id);
  if (frame == nullptr || frame->state != FrameState::kOpen ||
      !frame->ledger.hand_back(session, tile, attempt)) {
    return actions;
  }
  release(*frame, session);
  if (const auto slave = slaves_.find(session); slave != slaves_.end()) {
    slave->second.rests_until = now + kRest;
  }
  if (frame->ledger.attempts(tile) >= kTileLeasesMax + 2 * slaves_.size()) {
    end_frame(*frame, FrameState::kFailed,
              "tile " + std::to_string(tile) + " came back unrendered " +
                  std::to_string(frame->ledger.attempts(tile)) + " times",
              actions);
    deliver(actions);
    fill_all(now, actions);
    return actions;
  }
  for (auto& [other, slave] : slaves_) {
    while (lease_one(other, slave, now, actions)) {
    }
  }
  return actions;
}

void Scheduler::end_frame(Frame& frame, FrameState state, std::string reason, Actions& actions) {
  frame.state = state;
  frame.reason = std::move(reason);
  frame.ledger.abandon_all();
  for (const auto& [session, count] : frame.held) {
    if (const auto slave = slaves_.find(session); slave != slaves_.end())
      slave->second.in_flight -= count;
  }
  frame.held.clear();
  leased_at_.erase(leased_at_.lower_bound({frame.id, 0}),
                   leased_at_.lower_bound({frame.id + 1, 0}));
  for (auto& [session, slave] : slaves_) {
    if (slave.begun.contains(frame.id))
      actions.push_back({ActionKind::kEndFrame, session, frame.id, {}, false, ""});
    while (slave.begun.size() > kFramesRemembered) slave.begun.erase(slave.begun.begin());
  }
}

void Scheduler::deliver(Actions& actions) {
  while (!frames_.empty() && frames_.front().state != FrameState::kOpen) {
    Frame& frame = frames_.front();
    const ActionKind kind = frame.state == FrameState::kComplete ? ActionKind::kFrameComplete
                                                                 : ActionKind::kFrameFailed;
    actions.push_back({kind, 0, frame.id, {}, frame.state == FrameState::kCancelled, frame.reason});
    const LedgerCounts& counts = frame.ledger.counts();
    ended_counts_.issued += counts.issued;
    ended_counts_.accepted += counts.accepted;
    ended_counts_.rejected += counts.rejected;
    ended_counts_.abandoned += counts.abandoned;
    frames_.pop_front();
  }
}

void Scheduler::issue(SessionId session, Slave& slave, Frame& frame, TileAssignment tile,
                      Actions& actions) {
  if (slave.begun.insert(frame.id).second) {
    actions.push_back({ActionKind::kBeginFrame, session, frame.id, {}, false, ""});
  }
  ++slave.in_flight;
  ++frame.held[session];
  actions.push_back({ActionKind::kLease, session, frame.id, tile, false, ""});
}

// Returns: whether a tile was leased. Oldest frame first.
bool Scheduler::lease_one(SessionId session, Slave& slave, TimePoint now, Actions& actions) {
  const auto capacity =
      slave.threads * static_cast<std::uint32_t>(options_.prefetch_per_thread + 1);
  if (!is_started_ || slave.in_flight >= capacity || now < slave.rests_until) return false;
  for (std::size_t i = 0; i < active_count(); ++i) {
    Frame& frame = frames_[i];
    if (frame.state != FrameState::kOpen || !slave.built.contains(frame.ledger.version())) continue;
    if (const auto tile = frame.ledger.lease_next(session, now)) {
      leased_at_[{frame.id, tile->tile}] = now;
      issue(session, slave, frame, *tile, actions);
      return true;
    }
  }
  return false;
}

// In rounds, one tile for each slave, so that the first slave does not take all.
void Scheduler::fill_all(TimePoint now, Actions& actions) {
  for (bool has_leased = true; has_leased;) {
    has_leased = false;
    for (auto& [session, slave] : slaves_)
      has_leased = lease_one(session, slave, now, actions) || has_leased;
  }
}

Actions Scheduler::tick(TimePoint now) {
  Actions actions;
  if (!is_started_) return actions;
  fill_all(now, actions);  // what was handed back while nobody else was there
  const Duration overdue = std::max<Duration>(kOverdueMin, from_seconds(2 * turnaround_seconds_));
  for (auto& [session, slave] : slaves_) {
    if (slave.in_flight > 0 || now < slave.rests_until) continue;
    for (std::size_t i = 0; i < active_count() && slave.in_flight < slave.threads; ++i) {
      Frame& frame = frames_[i];
      if (frame.state != FrameState::kOpen || !slave.built.contains(frame.ledger.version()))
        continue;
      while (slave.in_flight < slave.threads) {
        const auto tile = frame.ledger.lease_again(session, now, overdue);
        if (!tile) break;
        issue(session, slave, frame, *tile, actions);
      }
    }
  }
  return actions;
}

std::uint32_t Scheduler::tiles_in_flight(SessionId session) const {
  const auto slave = slaves_.find(session);
  return slave == slaves_.end() ? 0 : slave->second.in_flight;
}

LedgerCounts Scheduler::counts() const {
  LedgerCounts total = ended_counts_;
  for (const Frame& frame : frames_) {
    const LedgerCounts& counts = frame.ledger.counts();
    total.issued += counts.issued;
    total.accepted += counts.accepted;
    total.rejected += counts.rejected;
    total.abandoned += counts.abandoned;
    total.in_flight += counts.in_flight;
  }
  return total;
}

SceneVersion Scheduler::oldest_version_needed(SceneVersion none) const {
  SceneVersion oldest = none;
  for (const Frame& frame : frames_) {
    if (frame.state == FrameState::kOpen) oldest = std::min(oldest, frame.ledger.version());
  }
  return oldest;
}

}  // namespace tessera::master
