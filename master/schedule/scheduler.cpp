// SPDX-License-Identifier: Apache-2.0
#include "master/schedule/scheduler.h"

#include <algorithm>
#include <utility>

#include "common/base/check.h"
#include "common/base/limits.h"

namespace tessera::master {
namespace {

// A slave that hands back a tile gets none for this long: more than leaving takes (2 s for the
// tiles in work, 2 s to say goodbye), so that slaves that leave together do not pass tiles around.
constexpr std::chrono::seconds kRest{5};
// Ended frames whose late results are still known as such; more than an application can cancel
// while a result waits in a slave's send queue.
constexpr std::size_t kFramesRemembered = 1024;
constexpr double kTileWeight = 1.0 / 32;  // of the newest tile in the cluster's moving average

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

void Scheduler::slave_joined(SessionId session, SlaveIdentity slave, std::uint32_t threads,
                             TimePoint now) {
  departed_.joined(slave.name);
  audits_.joined(slave);
  const SlaveHistory::Past past = history_.joined(slave, now);
  for (Frame& frame : frames_) frame.ledger.slave_joined(session, slave);
  SlavePace pace(std::max(threads, 1u), options_.prefetch_per_thread);
  count_pace(pace, 1);
  Slave joined{std::move(slave), std::move(pace)};
  joined.was_lost = past.was_lost;
  joined.debt_tiles = past.debt_tiles;
  joined.has_brought = past.has_brought;
  const bool is_new = slaves_.try_emplace(session, std::move(joined)).second;
  TESSERA_CHECK(is_new);
}

void Scheduler::round_trip_measured(SessionId session, double seconds) {
  const auto slave = slaves_.find(session);
  if (slave == slaves_.end()) return;
  if (!slave->second.is_stalled) count_pace(slave->second.pace, -1);
  slave->second.pace.round_trip_measured(seconds);
  if (!slave->second.is_stalled) count_pace(slave->second.pace, 1);
}

Actions Scheduler::slave_lost(SessionId session, TimePoint now, SlaveEnd how) {
  Actions actions;
  const auto slave = slaves_.find(session);
  if (slave == slaves_.end()) return actions;
  const SlaveIdentity gone = slave->second.is;
  audits_.left(gone);
  if (!slave->second.is_stalled) count_pace(slave->second.pace, -1);
  const bool is_lost = how == SlaveEnd::kLost;
  const bool ends_with_anything =
      is_lost && slave->second.in_flight > 0 && slave->second.brought < slave->second.debt_tiles;
  if (how != SlaveEnd::kLeft && slave->second.in_flight > 0)
    history_.lost(gone, slave->second.in_flight, slave->second.has_brought, now);
  std::set<SceneVersion> refused;
  for (const auto& [version, reason] : slave->second.failed) refused.insert(version);
  departed_.left({gone.name, std::move(refused), now});
  slaves_.erase(slave);
  for (Frame& frame : frames_) {
    if (frame.state != FrameState::kOpen) continue;
    frame.held.erase(session);
    const auto tile = frame.ledger.lose_session(session, gone, is_lost, now);
    if (ends_with_anything) frame.ledger.losses().discredit(gone, now);
    if (tile && is_useless_to_all(frame, *tile, gone)) {
      end_frame(frame, FrameState::kFailed,
                "tile " + std::to_string(*tile) + " was leased " +
                    std::to_string(frame.ledger.attempts(*tile)) + " times, at last to slave '" +
                    gone.name + "', and never came back",
                actions);
    }
  }
  for (Frame& frame : frames_) {
    waive_refusals(frame);
    waive_audits(frame, actions);
  }
  fail_lost_tiles(now, actions);
  fail_hopeless(now, actions);
  deliver(actions);
  fill_all(now, actions);
  return actions;
}

Actions Scheduler::scene_built(SessionId session, SceneVersion version, TimePoint now) {
  Actions actions;
  const auto slave = slaves_.find(session);
  if (slave == slaves_.end()) return actions;
  slave->second.built.insert(version);
  for (Frame& frame : frames_) {
    waive_refusals(frame);
    waive_audits(frame, actions);  // the slave may be all that is here again
  }
  deliver(actions);
  fill_all(now, actions);
  return actions;
}

Actions Scheduler::scene_failed(SessionId session, SceneVersion version, const std::string& reason,
                                TimePoint now) {
  Actions actions;
  const auto slave = slaves_.find(session);
  if (slave == slaves_.end()) return actions;
  slave->second.failed[version] = reason;
  slave->second.built.erase(version);  // one that is built as rays meet it may fail late
  fail_hopeless(now, actions);
  for (Frame& frame : frames_) {
    waive_refusals(frame);
    waive_audits(frame, actions);
  }
  deliver(actions);
  fill_all(now, actions);
  return actions;
}

// Fails the frames whose scene no connected slave can hold, unless one that could has just left and
// may come back: a link that was silent for a moment is no reason to give a picture up.
void Scheduler::fail_hopeless(TimePoint now, Actions& actions) {
  if (slaves_.empty()) return;
  for (Frame& frame : frames_) {
    if (frame.state != FrameState::kOpen) continue;
    const SceneVersion version = frame.ledger.version();
    const bool is_refused = std::all_of(slaves_.begin(), slaves_.end(), [&](const auto& entry) {
      return entry.second.failed.contains(version);
    });
    const DepartedSlaves::Slave* able = departed_.last_able(version, now);
    if (!is_refused || (able != nullptr && able->may_return(now))) continue;
    std::string reason = "no slave can hold the scene: " + slaves_.begin()->second.failed[version];
    if (able != nullptr)
      reason += "; slave '" + able->name + "', which had not refused it, is gone";
    frame.is_final = true;
    end_frame(frame, FrameState::kFailed, std::move(reason), actions);
  }
}

Actions Scheduler::submit_frame(FrameId frame, SceneVersion version, std::vector<TileIndex> order,
                                TimePoint now) {
  TESSERA_CHECK_GE(frame, next_frame_);
  next_frame_ = frame + 1;
  frames_.push_back({frame, FrameState::kOpen, "", FrameLedger(version, std::move(order)), {}, {}});
  Actions actions;
  fail_hopeless(now, actions);
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

Actions Scheduler::fail_frame(FrameId id, std::string reason, TimePoint now) {
  Actions actions;
  Frame* frame = find(id);
  if (frame == nullptr || frame->state != FrameState::kOpen) return actions;
  end_frame(*frame, FrameState::kFailed, std::move(reason), actions);
  deliver(actions);
  fill_all(now, actions);
  return actions;
}

Actions Scheduler::refuse_frame(FrameId frame, std::string reason, bool is_cancelled) {
  TESSERA_CHECK_GE(frame, next_frame_);
  next_frame_ = frame + 1;
  const FrameState state = is_cancelled ? FrameState::kCancelled : FrameState::kFailed;
  frames_.push_back(
      {frame, state, std::move(reason), FrameLedger(0, {0}), {}, {}, /*is_final=*/!is_cancelled});
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

// Adds a slave's pace to the cluster's, or takes it out before it changes. That of a stalled one is
// out.
void Scheduler::count_pace(const SlavePace& pace, int sign) {
  rate_total_ = std::max(rate_total_ + sign * pace.tiles_per_second(), 0.0);
  round_trip_total_ = std::max(round_trip_total_ + sign * pace.round_trip_seconds(), 0.0);
}

void Scheduler::release(Frame& frame, SessionId session) {
  if (const auto held = frame.held.find(session); held != frame.held.end() && --held->second == 0)
    frame.held.erase(held);
  if (const auto slave = slaves_.find(session); slave != slaves_.end()) --slave->second.in_flight;
}

ResultVerdict Scheduler::result(SessionId session, const TileReport& report, TimePoint now,
                                Actions& actions) {
  const auto slave = slaves_.find(session);
  if (slave == slaves_.end()) return ResultVerdict::kNotLeased;
  Frame* frame = find(report.frame);
  if (frame == nullptr || frame->state != FrameState::kOpen) {
    heard(slave->second, now);
    return slave->second.begun.contains(report.frame) ? ResultVerdict::kFrameEnded
                                                      : ResultVerdict::kUnknownFrame;
  }
  const bool is_suspect = report.is_faulty && !options_.is_static && able_count(*frame) >= 2;
  const LedgerAnswer answer = frame->ledger.accept(session, report.version, report.tile,
                                                   report.attempt, report.pixels, is_suspect);
  if (!answers_lease(answer.verdict)) return answer.verdict;
  release(*frame, session);
  learn(slave->second, report, answer.leased_at, now);
  const ResultAuthor& refused_of = answer.refused_of;
  if (refused_of.session != 0 && refused_of.newest != session && !report.is_faulty) {
    actions.push_back(
        {ActionKind::kSuspect,
         refused_of.session,
         frame->id,
         {report.tile, 0},
         false,
         "NaN, infinite or negative pixels that slave " + name_of(session) + " rendered without",
         false,
         id_of(refused_of)});
  }
  settle_audit(*frame, session, report.tile, answer, actions);
  if (frame->state == FrameState::kOpen && frame->ledger.is_complete())
    end_frame(*frame, FrameState::kComplete, "", actions);
  if (frame->state == FrameState::kOpen && answer.verdict != ResultVerdict::kFaulty) {
    fill(*slave, now, actions);
  } else {
    deliver(actions);
    fill_all(now, actions);
  }
  return answer.verdict;
}

void Scheduler::learn(Slave& slave, const TileReport& report, TimePoint leased_at, TimePoint now) {
  heard(slave, now);
  count_pace(slave.pace, -1);
  if (report.starved_seconds > 0 && !slave.was_dry) slave.pace.starved();
  slave.was_dry = false;
  if (slave.brought < std::numeric_limits<std::uint32_t>::max()) ++slave.brought;
  slave.has_brought = true;
  slave.pace.tile_done(now, seconds(now - leased_at), report.held_seconds, report.render_seconds);
  count_pace(slave.pace, 1);
  tile_seconds_ += kTileWeight * (slave.pace.tile_seconds() - tile_seconds_);
  has_measured_ = true;
  budget_.tile_done();
}

std::string Scheduler::name_of(SessionId session) const {
  const auto slave = slaves_.find(session);
  return slave == slaves_.end() ? std::string("(gone)") : "'" + slave->second.is.name + "'";
}

// Requires: the result is one of a frame that is open.
std::string Scheduler::id_of(const ResultAuthor& author) const {
  return author.id.empty() ? slaves_.at(author.newest).is.id() : author.id;
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
  const auto slave = slaves_.find(session);
  if (slave == slaves_.end()) return actions;
  slave->second.rests_until = now + kRest;
  heard(slave->second, now);
  if (is_useless_to_all(*frame, tile, slave->second.is)) {
    end_frame(*frame, FrameState::kFailed,
              "tile " + std::to_string(tile) + " came back unrendered " +
                  std::to_string(frame->ledger.attempts(tile)) + " times",
              actions);
    deliver(actions);
    fill_all(now, actions);
    return actions;
  }
  fill_all(now, actions);
  return actions;
}

void Scheduler::end_frame(Frame& frame, FrameState state, std::string reason, Actions& actions) {
  frame.state = state;
  frame.reason = std::move(reason);
  frame.ledger.abandon_all();
  for (const auto& [session, count] : frame.held) {
    const auto slave = slaves_.find(session);
    if (slave == slaves_.end()) continue;
    slave->second.in_flight -= count;
    // Tiles of a cancelled frame are dropped, so nothing is owed for the time that they were held.
    if (state == FrameState::kCancelled && !slave->second.is_stalled) slave->second.silence = {};
  }
  frame.held.clear();
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
    actions.push_back({kind,
                       0,
                       frame.id,
                       {},
                       frame.state == FrameState::kCancelled,
                       std::move(frame.reason),
                       frame.is_final});
    ended_counts_ += frame.ledger.counts();
    frames_.pop_front();
  }
}

std::uint32_t Scheduler::tiles_in_flight(SessionId session) const {
  const auto slave = slaves_.find(session);
  return slave == slaves_.end() ? 0 : slave->second.in_flight;
}

bool Scheduler::is_stalled(SessionId session) const {
  const auto slave = slaves_.find(session);
  return slave != slaves_.end() && slave->second.is_stalled;
}

const SlavePace* Scheduler::pace(SessionId session) const {
  const auto slave = slaves_.find(session);
  return slave == slaves_.end() ? nullptr : &slave->second.pace;
}

LedgerCounts Scheduler::counts() const {
  LedgerCounts total = ended_counts_;
  for (const Frame& frame : frames_) {
    total += frame.ledger.counts();
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
