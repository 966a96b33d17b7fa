#include "master/schedule/frame_ledger.h"

#include <algorithm>

#include "common/base/check.h"

namespace tessera::master {

const char* verdict_text(ResultVerdict verdict) {
  switch (verdict) {
    case ResultVerdict::kAccepted:
      return "accepted";
    case ResultVerdict::kDuplicate:
      return "a duplicate";
    case ResultVerdict::kFrameEnded:
      return "for a frame that is over";
    case ResultVerdict::kUnknownFrame:
      return "for a frame never begun";
    case ResultVerdict::kWrongVersion:
      return "of another scene version than the frame's";
    case ResultVerdict::kNotLeased:
      return "for a tile that was not leased to it";
  }
  return "unknown";
}

FrameLedger::FrameLedger(SceneVersion version, TileIndex tile_count)
    : version_(version), tiles_(tile_count) {
  TESSERA_CHECK_GE(tile_count, 1u);
  for (TileIndex tile = 0; tile < tile_count; ++tile) pending_.push_back(tile);
}

TileAssignment FrameLedger::lease(TileIndex index, SessionId session, TimePoint now) {
  Tile& tile = tiles_[index];
  tile.is_pending = false;
  if (++tile.attempts > 1) ++reissued_count_;
  tile.leases.push_back({session, tile.attempts, now});
  leased_.insert(index);
  ++counts_.issued;
  ++counts_.in_flight;
  return {index, tile.attempts};
}

std::optional<TileAssignment> FrameLedger::lease_next(SessionId session, TimePoint now) {
  if (pending_.empty()) return std::nullopt;
  const TileIndex index = pending_.front();
  pending_.pop_front();
  return lease(index, session, now);
}

std::optional<TileAssignment> FrameLedger::lease_again(SessionId session, TimePoint now,
                                                       Duration overdue) {
  std::optional<TileIndex> oldest;
  TimePoint oldest_since = now - overdue;
  for (const TileIndex index : leased_) {
    const Tile& tile = tiles_[index];
    if (tile.is_done || tile.leases.size() >= kLeasesPerTileMax) continue;
    if (tile.leases.front().session == session || tile.leases.front().since >= oldest_since)
      continue;
    oldest = index;
    oldest_since = tile.leases.front().since;
  }
  if (!oldest) return std::nullopt;
  return lease(*oldest, session, now);
}

void FrameLedger::end_lease(TileIndex index, std::size_t lease) {
  Tile& tile = tiles_[index];
  tile.leases.erase(tile.leases.begin() + static_cast<std::ptrdiff_t>(lease));
  if (tile.leases.empty()) leased_.erase(index);
  --counts_.in_flight;
}

void FrameLedger::make_pending(TileIndex index) {
  Tile& tile = tiles_[index];
  if (tile.is_done || tile.is_pending || !tile.leases.empty()) return;
  tile.is_pending = true;
  pending_.push_front(index);
}

ResultVerdict FrameLedger::accept(SessionId session, SceneVersion version, TileIndex index,
                                  Attempt attempt) {
  if (version != version_) return ResultVerdict::kWrongVersion;
  if (index >= tiles_.size()) return ResultVerdict::kNotLeased;
  Tile& tile = tiles_[index];
  const auto found = std::find_if(tile.leases.begin(), tile.leases.end(), [&](const Lease& lease) {
    return lease.session == session && lease.attempt == attempt;
  });
  if (found == tile.leases.end()) return ResultVerdict::kNotLeased;
  end_lease(index, static_cast<std::size_t>(found - tile.leases.begin()));
  if (tile.is_done) {
    ++counts_.rejected;
    return ResultVerdict::kDuplicate;
  }
  tile.is_done = true;
  ++counts_.accepted;
  return ResultVerdict::kAccepted;
}

bool FrameLedger::hand_back(SessionId session, TileIndex index, Attempt attempt) {
  if (index >= tiles_.size()) return false;
  Tile& tile = tiles_[index];
  for (std::size_t i = 0; i < tile.leases.size(); ++i) {
    if (tile.leases[i].session != session || tile.leases[i].attempt != attempt) continue;
    end_lease(index, i);
    ++counts_.abandoned;
    make_pending(index);
    return true;
  }
  return false;
}

int FrameLedger::lose_session(SessionId session, std::size_t suspect_count) {
  struct Lost {
    TileIndex tile;
    TimePoint since;
    Attempt attempt;
  };
  std::vector<Lost> lost;
  for (const TileIndex index : leased_) {
    for (const Lease& lease : tiles_[index].leases) {
      if (lease.session == session) lost.push_back({index, lease.since, lease.attempt});
    }
  }
  std::stable_sort(lost.begin(), lost.end(),
                   [](const Lost& a, const Lost& b) { return a.since < b.since; });
  int losses_max = 0;
  for (std::size_t i = 0; i < lost.size() && i < suspect_count; ++i) {
    Tile& tile = tiles_[lost[i].tile];
    if (!tile.is_done) losses_max = std::max(losses_max, ++tile.losses);
  }
  for (auto entry = lost.rbegin(); entry != lost.rend(); ++entry)
    hand_back(session, entry->tile, entry->attempt);
  return losses_max;
}

std::uint64_t FrameLedger::abandon_all() {
  std::uint64_t count = 0;
  for (const TileIndex index : leased_) {
    Tile& tile = tiles_[index];
    count += tile.leases.size();
    counts_.abandoned += tile.leases.size();
    counts_.in_flight -= tile.leases.size();
    tile.leases.clear();
  }
  leased_.clear();
  return count;
}

}  // namespace tessera::master
