// SPDX-License-Identifier: Apache-2.0
// What the scheduler does about slaves that die with tiles, or hold them and return none.
#include <algorithm>
#include <set>
#include <utility>

#include "common/base/limits.h"
#include "master/schedule/departed_slaves.h"
#include "master/schedule/scheduler.h"

namespace tessera::master {
namespace {

// A slave has stalled when it was silent, while another one works, for so many times the silence
// after which its tiles are leased again, and for this at least: what a busy machine may do to a
// healthy slave is shorter.
constexpr int kStallSilences = 2;
constexpr std::chrono::milliseconds kStallMin{500};

}  // namespace

// A slave that was lost before starts with one tile and earns one more with each that it brings.
std::uint32_t Scheduler::allowance(const Slave& slave) {
  constexpr auto kMost = std::numeric_limits<std::uint32_t>::max();
  return slave.was_lost && slave.brought < kMost ? slave.brought + 1 : kMost;
}

// A slave is proven when it has brought tiles and no process of its ended with any.
Scheduler::Trust Scheduler::trust_in(const Slave& slave) {
  if (slave.is_stalled || slave.brought < slave.debt_tiles) return Trust::kDoubtful;
  if (!slave.has_brought) return Trust::kNew;
  return slave.debt_tiles == 0 ? Trust::kProven : Trust::kEarned;
}

void Scheduler::count_able(Frame& frame) {
  if (frame.ledger.losses().is_empty()) return;
  frame.able = {};
  for (const auto& [session, slave] : slaves_) {
    if (slave.built.contains(frame.ledger.version()))
      ++frame.able[static_cast<std::size_t>(trust_in(slave))];
  }
}

// Whether the slave may have a tile that slaves were lost with. Those that were not lost with it
// come first, and of them those that are trusted most. The last try that a tile may have waits for
// a proven slave: with a bad one it would be wasted, and a good one may be busy or just back.
bool Scheduler::may_have_lost_tile(const Frame& frame, const SlaveEntry& entry, TileIndex tile,
                                   TimePoint now) const {
  const TileLosses& losses = frame.ledger.losses();
  const TileLosses::Case what = losses.of(tile);
  if (what == TileLosses::Case::kNone) return true;
  if (what != TileLosses::Case::kOpen && what != TileLosses::Case::kOthers) return false;
  // Whoever holds it may be lost with it, too. A slave that has stalled does not end, it waits.
  const std::vector<SessionId> holders = frame.ledger.holders(tile);
  const auto at_risk = static_cast<std::size_t>(
      std::count_if(holders.begin(), holders.end(), [&](SessionId session) {
        const auto slave = slaves_.find(session);
        return slave != slaves_.end() && !slave->second.is_stalled;
      }));
  constexpr std::size_t kMost{kTileAttemptsMax};
  if (losses.witness_count(tile) + at_risk >= kMost) return false;
  const std::size_t tries = losses.slave_count(tile) + at_risk;
  auto others = frame.able;
  const std::vector<SessionId> lost = losses.sessions(tile);
  std::set<SessionId> not_others(lost.begin(), lost.end());
  for (const SessionId session : frame.ledger.seen_by(tile)) not_others.insert(session);
  for (const SessionId session : not_others) {
    const auto slave = slaves_.find(session);
    if (slave == slaves_.end() || !slave->second.built.contains(frame.ledger.version())) continue;
    std::uint32_t& count = others[static_cast<std::size_t>(trust_in(slave->second))];
    if (count > 0) --count;
  }
  const auto best = static_cast<std::size_t>(
      std::find_if(others.begin(), others.end(), [](std::uint32_t count) { return count > 0; }) -
      others.begin());
  if (std::find(lost.begin(), lost.end(), entry.first) != lost.end())
    return what == TileLosses::Case::kOpen && best == kTrusts;
  const Trust trust = trust_in(entry.second);
  const bool has_waited = tries < kMost && now - losses.last_at(tile) >= DepartedSlaves::kReturn;
  if (tries + 1 >= kMost && trust != Trust::kProven && !has_waited) return false;
  return static_cast<std::size_t>(trust) <= best;
}

FrameLedger::LostTileFilter Scheduler::lost_tiles_for(const Frame& frame, const SlaveEntry& entry,
                                                      TimePoint now) const {
  if (frame.ledger.losses().is_empty()) return {};
  return [this, &frame, &entry, now](TileIndex tile) {
    return may_have_lost_tile(frame, entry, tile, now);
  };
}

// Whether a slave of that trust is there that holds the tile, or may get it: it was not lost with
// it, has not answered it, and has the scene or may yet have it.
bool Scheduler::is_anybody_left(const Frame& frame, TileIndex tile, Trust least) const {
  const std::vector<SessionId> lost = frame.ledger.losses().sessions(tile);
  const std::vector<SessionId> seen = frame.ledger.seen_by(tile);
  const std::vector<SessionId> holders = frame.ledger.holders(tile);
  const auto is_in = [](const std::vector<SessionId>& sessions, SessionId session) {
    return std::find(sessions.begin(), sessions.end(), session) != sessions.end();
  };
  return std::any_of(slaves_.begin(), slaves_.end(), [&](const auto& entry) {
    const SessionId session = entry.first;
    return !entry.second.failed.contains(frame.ledger.version()) &&
           trust_in(entry.second) <= least && !is_in(lost, session) &&
           (!is_in(seen, session) || is_in(holders, session));
  });
}

// Whether nobody is left who may try a tile that slaves were lost with, for certain.
bool Scheduler::is_given_up(const Frame& frame, TileIndex tile, TimePoint now) const {
  const TileLosses& losses = frame.ledger.losses();
  if (losses.of(tile) != TileLosses::Case::kOthers || !losses.is_certain(tile)) return false;
  if (losses.slave_count(tile) < std::size_t{kTileAttemptsMax})
    return !is_anybody_left(frame, tile, Trust::kDoubtful);
  return now - losses.last_at(tile) >= DepartedSlaves::kReturn &&
         !is_anybody_left(frame, tile, Trust::kProven);
}

// The slave has given the tile back unrendered, or left with it. Returns: whether every slave that
// is here and may hold the scene has done so since the tile had more leases than it may need. One
// that comes again and again is no reason to fail a frame that another one can render. Where names
// cost nothing, kTileLeasesMax of them stand for everybody.
bool Scheduler::is_useless_to_all(Frame& frame, TileIndex tile, const SlaveIdentity& slave) const {
  if (frame.ledger.attempts(tile) < kTileLeasesMax + 2 * slaves_.size()) return false;
  std::set<std::string>& slaves = frame.useless_to[tile];
  slaves.insert(slave.id());
  return slaves.size() >= std::size_t{kTileLeasesMax} ||
         std::none_of(slaves_.begin(), slaves_.end(), [&](const auto& entry) {
           return !entry.second.failed.contains(frame.ledger.version()) &&
                  !slaves.contains(entry.second.is.id());
         });
}

// Fails the frames of tiles that have ended as many slaves as may be, or that nobody is left for. A
// tile that was only being compared is taken as it is.
void Scheduler::fail_lost_tiles(TimePoint now, Actions& actions) {
  for (Frame& frame : frames_) {
    if (frame.state != FrameState::kOpen || frame.ledger.losses().is_empty()) continue;
    TileLosses& losses = frame.ledger.losses();
    losses.settle(now);
    for (const TileIndex tile : losses.tiles()) {
      const bool is_hopeless = losses.of(tile) == TileLosses::Case::kHopeless;
      if (!is_hopeless && !is_given_up(frame, tile, now)) continue;
      if (frame.ledger.waive_audit(tile)) continue;
      frame.is_final = true;
      end_frame(frame, FrameState::kFailed,
                "tile " + std::to_string(tile) + " was in work on " + losses.names(tile) +
                    " as each of them ended, one after the other" +
                    (is_hopeless ? "" : ", and no other slave is there"),
                actions);
      break;
    }
    if (frame.state == FrameState::kOpen && frame.ledger.is_complete())
      end_frame(frame, FrameState::kComplete, "", actions);
  }
}

void Scheduler::heard(Slave& slave, TimePoint now) {
  slave.last_heard = slave.watched = now;
  slave.silence = {};
  if (std::exchange(slave.is_stalled, false)) count_pace(slave.pace, 1);
}

// Finds slaves that hold tiles and return none, whatever their links say. Audits go on without them
// as soon as they are silent.
void Scheduler::watch_for_stalls(TimePoint now, Actions& actions) {
  std::set<SessionId> silent;
  auto working = std::count_if(slaves_.begin(), slaves_.end(),
                               [](const auto& entry) { return !entry.second.is_stalled; });
  for (auto& [session, slave] : slaves_) {
    const TimePoint since = std::exchange(slave.watched, now);
    if (slave.in_flight == 0) continue;
    if (slave.is_stalled || is_silent(slave, now)) silent.insert(session);
    slave.silence += std::max(now - since, Duration::zero());
    const Duration allowed = std::max<Duration>(kStallSilences * silence_allowed(slave), kStallMin);
    if (slave.is_stalled || slave.silence <= allowed) continue;
    if (working < 2) continue;  // nobody else could take its tiles
    --working;
    slave.is_stalled = true;
    count_pace(slave.pace, -1);
    slave.probe_at = now + slave.silence / 2;
    actions.push_back(
        {ActionKind::kStalled,
         session,
         0,
         {},
         false,
         "it holds " + std::to_string(slave.in_flight) + " tiles and has returned none for " +
             std::to_string(static_cast<int>(seconds(slave.silence) * 1000)) + " ms"});
  }
  if (!silent.empty() && audits_.is_possible()) audit_without(silent, actions);
}

}  // namespace tessera::master
