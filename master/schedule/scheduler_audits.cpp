// SPDX-License-Identifier: Apache-2.0
// What the scheduler makes of tiles that two slaves render: who may compare, who was wrong, and
// when nobody is waited for any more; and of tiles whose pixels were refused.
#include <utility>

#include "master/schedule/scheduler.h"

namespace tessera::master {

bool Scheduler::is_under_audit(FrameId frame, TileIndex tile) const {
  const FrameLedger* const found = ledger(frame);
  return found != nullptr && found->is_audited(tile);
}

// Slaves that hold the frame's scene or may yet hold it, and have not stalled. Slaves that are
// still building it count: otherwise the one that is done first would never be audited.
bool Scheduler::may_audit(const Slave& slave, const Frame& frame) const {
  return !slave.failed.contains(frame.ledger.version()) && !slave.is_stalled;
}

std::vector<SessionId> Scheduler::auditors(const Frame& frame) const {
  std::vector<SessionId> sessions;
  for (const auto& [session, slave] : slaves_) {
    if (may_audit(slave, frame)) sessions.push_back(session);
  }
  return sessions;
}

bool Scheduler::has_auditors(const Frame& frame, std::size_t least) const {
  std::size_t count = 0;
  for (auto slave = slaves_.begin(); slave != slaves_.end() && count < least; ++slave)
    count += may_audit(slave->second, frame) ? 1u : 0u;
  return count >= least;
}

// Expels the slave that was outvoted; a dispute that nobody is left to decide fails the frame.
void Scheduler::settle_audit(Frame& frame, SessionId session, TileIndex tile,
                             const LedgerAnswer& answer, Actions& actions) {
  const auto where = [&] {
    return "tile " + std::to_string(tile) + " of frame " + std::to_string(frame.id);
  };
  if (answer.outvoted.session != 0) {
    // What is leased before the slave is expelled is for others.
    if (const auto liar = slaves_.find(answer.outvoted.newest); liar != slaves_.end())
      liar->second.rests_until = TimePoint::max();
    actions.push_back({ActionKind::kExpel,
                       answer.outvoted.session,
                       frame.id,
                       {tile, 0},
                       false,
                       "audit: two others agree on another picture of " + where(),
                       false,
                       id_of(answer.outvoted)});
  }
  if (answer.verdict == ResultVerdict::kUndecided) {
    end_frame(frame, FrameState::kFailed,
              "audit: " + where() + ": slaves " + "'" + id_of(answer.first_vote) + "'" + ", " +
                  name_of(session) + " and another one render it differently",
              actions);
  }
  if (frame.ledger.has_audits() && !has_auditors(frame, FrameLedger::kVotesMax + 1))
    waive_audits(frame, actions);
}

// Ends audits that no slave is left for: one result is taken as it is, two that differ fail the
// frame.
void Scheduler::waive_audits(Frame& frame, Actions& actions) {
  if (frame.state != FrameState::kOpen || !frame.ledger.has_audits()) return;
  const std::vector<SessionId> able = auditors(frame);
  if (able.empty()) return;
  if (const auto dispute = frame.ledger.waive_audits(able)) {
    end_frame(frame, FrameState::kFailed,
              "audit: tile " + std::to_string(dispute->tile) + ": slaves " + "'" +
                  id_of(dispute->first) + "'" + " and " + "'" + id_of(dispute->second) + "'" +
                  " render it differently, and there is no third one to decide",
              actions);
  } else if (frame.ledger.is_complete()) {
    end_frame(frame, FrameState::kComplete, "", actions);
  }
}

// Tiles refused of the only slave that holds the frame's scene are for it again.
void Scheduler::waive_refusals(Frame& frame) {
  SessionId only = 0;
  for (const auto& [session, slave] : slaves_) {
    if (!slave.built.contains(frame.ledger.version())) continue;
    if (std::exchange(only, session) != 0) return;
  }
  frame.ledger.waive_refusals(only);
}

void Scheduler::audit_without(const std::set<SessionId>& silent, Actions& actions) {
  for (Frame& frame : frames_) {
    if (frame.state != FrameState::kOpen) continue;
    frame.ledger.audit_without(silent);
    waive_audits(frame, actions);
  }
}

}  // namespace tessera::master
