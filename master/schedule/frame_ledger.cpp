// SPDX-License-Identifier: Apache-2.0
#include "master/schedule/frame_ledger.h"

#include <algorithm>
#include <utility>

#include "common/base/check.h"

namespace tessera::master {

LedgerCounts& LedgerCounts::operator+=(const LedgerCounts& other) {
  issued += other.issued;
  accepted += other.accepted;
  rejected += other.rejected;
  abandoned += other.abandoned;
  in_flight += other.in_flight;
  return *this;
}

FrameLedger::FrameLedger(SceneVersion version, std::vector<TileIndex> order)
    : version_(version), tiles_(order.size()), pending_(order.begin(), order.end()) {
  TESSERA_CHECK_GE(order.size(), 1u);
}

template <typename Predicate>
bool FrameLedger::is_any_of_seen(TileIndex index, const Predicate& is_it) const {
  for (const Lease& lease : tiles_[index].out()) {
    if (is_it(lease.session)) return true;
  }
  const auto refused = refused_.find(index);
  if (refused != refused_.end() && !refused->second.is_waived &&
      is_it(refused->second.author.newest)) {
    return true;
  }
  const auto audit = audits_.find(index);
  if (audit == audits_.end()) return false;
  for (int i = 0; i < audit->second.vote_count; ++i) {
    if (is_it(audit->second.votes[static_cast<std::size_t>(i)].author.newest)) return true;
  }
  return false;
}

bool FrameLedger::has_seen(TileIndex index, SessionId session) const {
  return is_any_of_seen(index, [session](SessionId seen) { return seen == session; });
}

std::vector<SessionId> FrameLedger::seen_by(TileIndex index) const {
  std::vector<SessionId> sessions;
  is_any_of_seen(index, [&sessions](SessionId seen) {
    sessions.push_back(seen);
    return false;
  });
  return sessions;
}

std::vector<SessionId> FrameLedger::holders(TileIndex index) const {
  std::vector<SessionId> sessions;
  for (const Lease& lease : tiles_[index].out()) sessions.push_back(lease.session);
  return sessions;
}

std::optional<TileIndex> FrameLedger::next_for(SessionId session,
                                               const LostTileFilter& may_have) const {
  const bool is_any_lost = may_have && !losses_.is_empty();
  const auto is_barred = [&](TileIndex index) {
    return is_any_lost && losses_.of(index) != TileLosses::Case::kNone && !may_have(index);
  };
  // Only an audited, refused or lost tile can be pending and not fit for the session.
  const bool is_any_known = is_any_lost || !audits_.empty() || !refused_.empty();
  for (const TileIndex index : pending_) {
    if (!is_any_known || (!has_seen(index, session) && !is_barred(index))) return index;
  }
  for (const auto& [index, audit] : audits_) {
    const bool is_wanted = audit.wants_lease && !tiles_[index].is_pending;
    if (is_wanted && !has_seen(index, session) && !is_barred(index)) return index;
  }
  return std::nullopt;
}

TileAssignment FrameLedger::lease(TileIndex index, SessionId session, TimePoint now,
                                  TimePoint due) {
  Tile& tile = tiles_[index];
  tile.is_pending = false;
  ++tile.attempts;
  TESSERA_CHECK_LT(int{tile.lease_count}, kLeasesKeptMax);
  tile.leases[tile.lease_count++] = {session, tile.attempts, now, due};
  ++counts_.issued;
  ++counts_.in_flight;
  return {index, tile.attempts};
}

std::optional<TileAssignment> FrameLedger::lease_next(SessionId session, TimePoint now,
                                                      TimePoint due, bool is_audited,
                                                      const LostTileFilter& may_have) {
  const auto index = next_for(session, may_have);
  if (!index) return std::nullopt;
  if (tiles_[*index].is_pending) {
    if (is_audited && tiles_[*index].attempts == 0) audits_.emplace(*index, Audit{});
    return lease_pending(*index, session, now, due);
  }
  audits_[*index].wants_lease = false;
  TileAssignment again = lease(*index, session, now, due);
  again.is_comparison = true;
  return again;
}

TileAssignment FrameLedger::lease_pending(TileIndex index, SessionId session, TimePoint now,
                                          TimePoint due) {
  const auto place = std::find(pending_.begin(), pending_.end(), index);
  TESSERA_CHECK(place != pending_.end());
  pending_.erase(place);
  return lease(index, session, now, due);
}

std::size_t FrameLedger::live_count(const Tile& tile, const std::set<SessionId>& stalled) const {
  const std::span<const Lease> out = tile.out();
  return static_cast<std::size_t>(std::count_if(out.begin(), out.end(), [&](const Lease& lease) {
    return !stalled.contains(lease.session);
  }));
}

std::optional<TileAssignment> FrameLedger::lease_again(TileIndex index, SessionId session,
                                                       TimePoint now, TimePoint due,
                                                       const std::set<SessionId>& stalled) {
  const Tile& tile = tiles_[index];
  if (tile.lease_count == 0 || tile.lease_count >= kLeasesKeptMax ||
      live_count(tile, stalled) >= std::size_t{kLeasesPerTileMax} || tile.is_done ||
      audits_.contains(index) || has_seen(index, session)) {
    return std::nullopt;
  }
  TileAssignment again = lease(index, session, now, due);
  again.is_duplicate = true;
  return again;
}

std::vector<TileLeaseView> FrameLedger::single_leases(const std::set<SessionId>& stalled) const {
  std::vector<TileLeaseView> views;
  for (TileIndex index = 0; index < tile_count(); ++index) {
    const Tile& tile = tiles_[index];
    const std::span<const Lease> out = tile.out();
    if (out.empty() || tile.is_done || live_count(tile, stalled) > 1 || audits_.contains(index))
      continue;
    const auto live = std::find_if(out.begin(), out.end(), [&](const Lease& lease) {
      return !stalled.contains(lease.session);
    });
    const Lease& lease = live == out.end() ? out.back() : *live;
    views.push_back({index, lease.session, lease.since, lease.due});
  }
  return views;
}

void FrameLedger::end_lease(TileIndex index, std::size_t lease) {
  Tile& tile = tiles_[index];
  std::copy(tile.leases.begin() + static_cast<std::ptrdiff_t>(lease) + 1,
            tile.leases.begin() + tile.lease_count,
            tile.leases.begin() + static_cast<std::ptrdiff_t>(lease));
  --tile.lease_count;
  --counts_.in_flight;
}

// Call after a lease ended without a result: somebody else must have the tile.
void FrameLedger::make_pending(TileIndex index) {
  Tile& tile = tiles_[index];
  if (tile.is_done || tile.is_pending) return;
  if (const auto audit = audits_.find(index); audit != audits_.end()) {
    audit->second.wants_lease = true;
    if (audit->second.vote_count > 0) return;
  }
  if (tile.lease_count > 0) return;
  tile.is_pending = true;
  pending_.push_front(index);
}

void FrameLedger::finish(TileIndex index) {
  Tile& tile = tiles_[index];
  TESSERA_CHECK(!tile.is_done);
  tile.is_done = true;
  ++done_count_;
  if (tile.is_pending) {
    tile.is_pending = false;
    std::erase(pending_, index);
  }
  audits_.erase(index);
  losses_.done(index);
}

LedgerAnswer FrameLedger::accept(SessionId session, SceneVersion version, TileIndex index,
                                 Attempt attempt, std::uint64_t pixels, bool is_suspect) {
  if (version != version_) return {ResultVerdict::kWrongVersion};
  if (index >= tiles_.size()) return {};
  LedgerAnswer answer;
  if (const Answer& last = tiles_[index].answer;
      last.session == session && last.attempt == attempt && attempt != 0) {
    answer.verdict = ResultVerdict::kRepeated;
    return answer;
  }
  const std::span<const Lease> leases = tiles_[index].out();
  const auto found = std::find_if(leases.begin(), leases.end(), [&](const Lease& lease) {
    return lease.session == session && lease.attempt == attempt;
  });
  if (found == leases.end()) return answer;
  const TimePoint leased_at = found->since;
  end_lease(index, static_cast<std::size_t>(found - leases.begin()));
  const auto audit = audits_.find(index);
  const bool is_first = audit == audits_.end() || audit->second.vote_count == 0;
  if (tiles_[index].is_done) {
    answer.verdict = ResultVerdict::kDuplicate;
  } else if (is_suspect && is_first && refuse(index, session)) {
    answer.verdict = ResultVerdict::kFaulty;
    make_pending(index);
  } else {
    if (audit != audits_.end()) {
      answer = vote(index, audit->second, session, pixels);
    } else {
      answer.verdict = ResultVerdict::kAccepted;
      finish(index);
    }
    if (const auto refused = refused_.find(index); is_first && refused != refused_.end())
      answer.refused_of = refused->second.author;
  }
  answer.leased_at = leased_at;
  if (answer.verdict == ResultVerdict::kAccepted) tiles_[index].answer = {session, attempt};
  ++(answer.verdict == ResultVerdict::kAccepted ? counts_.accepted : counts_.rejected);
  return answer;
}

// Returns: whether the tile goes to another slave, since no other one's pixels were refused yet.
bool FrameLedger::refuse(TileIndex index, SessionId session) {
  const auto [refused, is_new] =
      refused_.try_emplace(index, Refusal{ResultAuthor::of(session), false});
  if (!is_new && refused->second.author.newest != session) return false;
  refused->second.is_waived = false;
  return true;
}

void FrameLedger::waive_refusals(SessionId only) {
  for (auto& [index, refusal] : refused_) {
    if (refusal.author.newest == only) refusal.is_waived = true;
  }
}

// Votes on an audited tile: the first result is written, the second confirms it or calls for a
// third.
LedgerAnswer FrameLedger::vote(TileIndex index, Audit& audit, SessionId session,
                               std::uint64_t pixels) {
  LedgerAnswer answer;
  if (audit.vote_count == 0) {
    audit.votes[0] = {ResultAuthor::of(session), pixels};
    audit.vote_count = 1;
    if (tiles_[index].lease_count == 0) audit.wants_lease = true;
    answer.verdict = ResultVerdict::kAccepted;
    return answer;
  }
  answer.first_vote = audit.votes[0].author;
  if (audit.votes[0].pixels == pixels) {
    if (audit.vote_count == 2) answer.outvoted = audit.votes[1].author;
    answer.verdict = ResultVerdict::kConfirmed;
    finish(index);
  } else if (audit.vote_count == 1) {
    audit.votes[1] = {ResultAuthor::of(session), pixels};
    audit.vote_count = 2;
    audit.wants_lease = true;
    answer.verdict = ResultVerdict::kDisputed;
  } else if (audit.votes[1].pixels == pixels) {
    answer.outvoted = audit.votes[0].author;
    answer.verdict = ResultVerdict::kAccepted;
    --counts_.accepted;  // the first one's pixels are overwritten
    ++counts_.rejected;
    finish(index);
  } else {
    answer.verdict = ResultVerdict::kUndecided;
  }
  return answer;
}

bool FrameLedger::hand_back(SessionId session, TileIndex index, Attempt attempt) {
  if (index >= tiles_.size()) return false;
  const std::span<const Lease> leases = tiles_[index].out();
  for (std::size_t i = 0; i < leases.size(); ++i) {
    if (leases[i].session != session || leases[i].attempt != attempt) continue;
    end_lease(index, i);
    ++counts_.abandoned;
    make_pending(index);
    return true;
  }
  return false;
}

template <typename Do>
void FrameLedger::for_each_author(const Do& act) {
  for (auto& [index, refusal] : refused_) act(refusal.author);
  for (auto& [index, audit] : audits_) {
    for (Vote& vote : audit.votes) act(vote.author);
  }
}

void FrameLedger::slave_joined(SessionId session, const SlaveIdentity& slave) {
  losses_.joined(session, slave);
  for_each_author([&](ResultAuthor& author) { author.joined(session, slave); });
}

std::optional<TileIndex> FrameLedger::lose_session(SessionId session, const SlaveIdentity& slave,
                                                   bool is_suspect, TimePoint now) {
  struct Lost {
    TileIndex tile;
    TimePoint since;
    Attempt attempt;
  };
  std::vector<Lost> lost;
  for (TileIndex index = 0; index < tile_count(); ++index) {
    for (const Lease& lease : tiles_[index].out()) {
      if (lease.session == session) lost.push_back({index, lease.since, lease.attempt});
    }
  }
  std::stable_sort(lost.begin(), lost.end(),
                   [](const Lost& a, const Lost& b) { return a.since < b.since; });
  std::optional<TileIndex> most;
  for (auto entry = lost.rbegin(); entry != lost.rend(); ++entry) {
    const Tile& tile = tiles_[entry->tile];
    if (!tile.is_done && is_suspect) losses_.lost(entry->tile, slave, now);
    if (!tile.is_done && (!most || tile.attempts > tiles_[*most].attempts)) most = entry->tile;
    hand_back(session, entry->tile, entry->attempt);
  }
  for_each_author([&](ResultAuthor& author) { author.left(session, slave); });
  return most;
}

bool FrameLedger::waive_audit(TileIndex tile) {
  const auto audit = audits_.find(tile);
  if (audit == audits_.end() || audit->second.vote_count != 1) return false;
  finish(tile);
  return true;
}

std::optional<FrameLedger::Dispute> FrameLedger::waive_audits(const std::vector<SessionId>& able) {
  std::vector<TileIndex> done;
  for (const auto& [index, audit] : audits_) {
    const auto is_out = [&](const Lease& lease) {
      return std::find(able.begin(), able.end(), lease.session) != able.end();
    };
    const std::span<const Lease> out = tiles_[index].out();
    const std::vector<SessionId> lost = losses_.sessions(index);
    const bool is_stuck =
        audit.vote_count > 0 && std::none_of(out.begin(), out.end(), is_out) &&
        std::all_of(able.begin(), able.end(), [&, tile = index](SessionId s) {
          return has_seen(tile, s) || std::find(lost.begin(), lost.end(), s) != lost.end();
        });
    if (!is_stuck) continue;
    if (audit.vote_count == 2) return Dispute{index, audit.votes[0].author, audit.votes[1].author};
    done.push_back(index);
  }
  for (const TileIndex index : done) finish(index);
  return std::nullopt;
}

void FrameLedger::audit_without(const std::set<SessionId>& silent) {
  for (auto& [index, audit] : audits_) {
    const std::span<const Lease> out = tiles_[index].out();
    const bool is_waiting =
        !out.empty() && std::all_of(out.begin(), out.end(),
                                    [&](const Lease& l) { return silent.contains(l.session); });
    if (is_waiting && tiles_[index].lease_count < kLeasesKeptMax) audit.wants_lease = true;
  }
}

std::uint64_t FrameLedger::abandon_all() {
  const std::uint64_t count = counts_.in_flight;
  counts_.abandoned += count;
  counts_.in_flight = 0;
  for (Tile& tile : tiles_) tile.lease_count = 0;
  return count;
}

}  // namespace tessera::master
