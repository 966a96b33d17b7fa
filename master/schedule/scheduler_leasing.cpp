// SPDX-License-Identifier: Apache-2.0
// The scheduler's choice of the next tile for a slave, and of the next slave for a tile.
#include <algorithm>
#include <set>
#include <tuple>
#include <utility>

#include "common/base/check.h"
#include "common/base/limits.h"
#include "master/schedule/scheduler.h"

namespace tessera::master {
namespace {

// A second lease must promise to be back in this share of the time that the first one still needs:
// both are estimates, and a copy that comes second is work thrown away.
constexpr double kDuplicateGain = 0.67;
constexpr Duration kDuplicateGainMin = std::chrono::milliseconds(5);
// A slave twice as slow per thread as the cluster is a straggler.
constexpr double kStraggler = 2;
// A slave from which nothing came for so many of its longest tile times (A of the fault matrix) is
// treated as lost: its tiles are leased again whatever that costs. Of a slave whose pace is not
// known, the cluster's mean says less.
constexpr double kSilentTiles = 2, kSilentTilesUnknown = 4;
// While nobody has returned a tile, this much: who is first and returns none must not hold up all.
constexpr std::chrono::seconds kSilenceUnmeasured{3};
// A stalled slave that holds nothing is given a tile again after half of the time that it has been
// silent with tiles, and after this at least: one tile of one frame in a while finds out.
constexpr std::chrono::seconds kProbePause{1};

}  // namespace

bool Scheduler::can_take(const Slave& slave, const Frame& frame, TimePoint now) const {
  return frame.state == FrameState::kOpen && now >= slave.rests_until &&
         slave.built.contains(frame.ledger.version());
}

// Slaves that hold the frame's scene.
std::size_t Scheduler::able_count(const Frame& frame) const {
  return static_cast<std::size_t>(
      std::count_if(slaves_.begin(), slaves_.end(), [&](const SlaveEntry& entry) {
        return entry.second.built.contains(frame.ledger.version());
      }));
}

// Whether the slave would have a tile back before the cluster is done with the frame and with those
// before it; if not, the tile is for others. Constant time: the mean of all slaves stands for them.
bool Scheduler::is_in_time(std::size_t frame, const SlaveEntry& entry, TimePoint now) const {
  if (rate_total_ <= 0) return true;  // nothing is known
  std::size_t left = 0;
  for (std::size_t i = 0; i <= frame; ++i) left += frames_[i].ledger.tiles_left();
  const double done = static_cast<double>(left) / rate_total_ + tile_seconds_ +
                      round_trip_total_ / static_cast<double>(slaves_.size());
  return back_seconds(entry.second, tiles_ahead(frame, entry), now) <= done;
}

// Tiles that the slave renders before one of that frame that it got now: older frames' go first,
// and those in work are not interrupted.
std::uint32_t Scheduler::tiles_ahead(std::size_t frame, const SlaveEntry& entry) const {
  std::uint32_t ahead = 0;
  for (std::size_t i = 0; i <= frame; ++i) {
    const auto held = frames_[i].held.find(entry.first);
    if (held != frames_[i].held.end()) ahead += held->second;
  }
  return std::max(ahead, std::min(entry.second.in_flight, entry.second.pace.threads()));
}

// How long nothing may come from a slave that holds tiles before something is wrong with it.
Duration Scheduler::silence_allowed(const Slave& slave) const {
  if (!has_measured_) return kSilenceUnmeasured;
  const double tiles = slave.pace.is_known() ? kSilentTiles : kSilentTilesUnknown;
  return from_seconds(std::max(tiles * std::max(slave.pace.tile_seconds_high(), tile_seconds_),
                               2 * slave.pace.round_trip_seconds()));
}

// Whether the slave holds tiles and has said nothing for longer than it should.
bool Scheduler::is_silent(const Slave& slave, TimePoint now) const {
  return slave.in_flight > 0 && now - slave.last_heard > silence_allowed(slave);
}

bool Scheduler::has_room(const Slave& slave, TimePoint now) const {
  if (slave.is_stalled) return slave.in_flight == 0 && now >= slave.probe_at;
  return slave.in_flight < std::min(slave.pace.depth(), allowance(slave));
}

// Room for a late tile of the oldest frame. It goes ahead of what the slave has of the next frame,
// so a full queue is no reason to let it wait for that frame's end.
bool Scheduler::has_late_room(const Slave& slave, TimePoint now) const {
  const std::uint32_t threads = slave.pace.threads();
  const std::uint32_t most =
      std::min(slave.pace.depth() + threads, threads * std::uint32_t{kTilesPerWorkerMax});
  return !slave.is_stalled && !is_silent(slave, now) &&
         slave.in_flight < std::min(most, allowance(slave));
}

// When a tile leased now would be back, with `ahead` tiles before it. A slave that has fallen
// silent is expected to stay so for as long again.
double Scheduler::back_seconds(const Slave& slave, std::uint32_t ahead, TimePoint now) const {
  const double usual = slave.pace.completion_seconds(ahead, tile_seconds_);
  return is_silent(slave, now) ? usual + seconds(now - slave.last_heard) : usual;
}

TimePoint Scheduler::due_at(const Slave& slave, TimePoint now) const {
  return now + from_seconds(back_seconds(slave, slave.in_flight, now));
}

void Scheduler::issue(SlaveEntry& entry, Frame& frame, TileAssignment tile, TimePoint now,
                      Actions& actions) {
  Slave& slave = entry.second;
  const bool is_newest = !slave.begun.empty() && *slave.begun.rbegin() == frame.id;
  if (!is_newest && slave.begun.insert(frame.id).second)
    actions.push_back({ActionKind::kBeginFrame, entry.first, frame.id, {}, false, ""});
  if (slave.in_flight++ == 0) slave.last_heard = slave.watched = now;
  if (slave.is_stalled) slave.probe_at = now + std::max<Duration>(slave.silence / 2, kProbePause);
  ++frame.held[entry.first];
  actions.push_back({ActionKind::kLease, entry.first, frame.id, tile, false, ""});
}

// Requires: there is a tile of the frame for the slave.
void Scheduler::lease_next(SlaveEntry& entry, Frame& frame, TimePoint now, Actions& actions) {
  const FrameLedger::LostTileFilter may_have = lost_tiles_for(frame, entry, now);
  const TileIndex next = *frame.ledger.next_for(entry.first, may_have);
  const bool is_for_audit = !entry.second.is_stalled && audits_.has_chosen(frame.id, next) &&
                            has_auditors(frame, FrameLedger::kVotesMax);
  const auto tile =
      frame.ledger.lease_next(entry.first, now, due_at(entry.second, now), is_for_audit, may_have);
  issue(entry, frame, *tile, now, actions);
}

bool Scheduler::lease_one(SlaveEntry& entry, TimePoint now, Actions& actions) {
  Slave& slave = entry.second;
  if (!is_started_ || !has_room(slave, now) || now < slave.rests_until) return false;
  for (std::size_t i = 0; i < active_count(); ++i) {
    Frame& frame = frames_[i];
    if (!can_take(slave, frame, now)) continue;
    if (options_.is_static) {
      if (lease_static(frame, entry, now, actions)) return true;
      continue;
    }
    const auto next = frame.ledger.next_for(entry.first, lost_tiles_for(frame, entry, now));
    if (!next || !is_in_time(i, entry, now)) continue;
    lease_next(entry, frame, now, actions);
    return true;
  }
  slave.was_dry = true;
  return false;
}

// Each tile goes to the slave that will have it back first (list scheduling; Graham 1969). When
// that one has no room, the tile waits for it, unless it is one that may have a few tiles only.
void Scheduler::spread(std::size_t index, TimePoint now, Actions& actions) {
  Frame& frame = frames_[index];
  if (frame.state != FrameState::kOpen || !frame.ledger.may_lease()) return;
  using Place = std::pair<double, SlaveEntry*>;
  const auto is_later = [](const Place& a, const Place& b) {
    return std::pair(a.first, a.second->first) > std::pair(b.first, b.second->first);
  };
  std::vector<Place> heap;
  for (SlaveEntry& entry : slaves_) {
    if (can_take(entry.second, frame, now))
      heap.emplace_back(back_seconds(entry.second, tiles_ahead(index, entry), now), &entry);
  }
  std::make_heap(heap.begin(), heap.end(), is_later);
  while (!heap.empty()) {
    std::pop_heap(heap.begin(), heap.end(), is_later);
    auto& [back, entry] = heap.back();
    const Slave& slave = entry->second;
    const bool is_limited = slave.is_stalled || slave.in_flight >= allowance(slave);
    if (is_limited || !frame.ledger.next_for(entry->first, lost_tiles_for(frame, *entry, now))) {
      heap.pop_back();
      continue;
    }
    // Tiles of the next frame are no reason to let one of the oldest frame wait.
    const bool may_overtake =
        index == 0 && has_late_room(slave, now) &&
        tiles_ahead(index, *entry) < std::min(slave.pace.depth(), slave.in_flight);
    if (!has_room(slave, now) && !may_overtake) return;
    lease_next(*entry, frame, now, actions);
    back = back_seconds(slave, tiles_ahead(index, *entry), now);
    std::push_heap(heap.begin(), heap.end(), is_later);
  }
}

// Tile i belongs to slave i modulo their number, however fast each is: what a cluster without
// balancing does.
bool Scheduler::lease_static(Frame& frame, SlaveEntry& entry, TimePoint now, Actions& actions) {
  std::size_t rank = 0, count = 0;
  for (const SlaveEntry& other : slaves_) {
    if (!other.second.built.contains(frame.ledger.version())) continue;
    if (other.first == entry.first) rank = count;
    ++count;
  }
  for (const TileIndex tile : frame.ledger.pending()) {
    if (tile % count != rank) continue;
    const TimePoint due = due_at(entry.second, now);
    issue(entry, frame, frame.ledger.lease_pending(tile, entry.first, now, due), now, actions);
    return true;
  }
  return false;
}

void Scheduler::fill(SlaveEntry& entry, TimePoint now, Actions& actions) {
  for (std::size_t i = 0; i < active_count(); ++i) count_able(frames_[i]);
  while (lease_one(entry, now, actions)) {
  }
}

// Tiles are leased in rounds, one for each slave, so that the first slave does not take all.
void Scheduler::fill_all(TimePoint now, Actions& actions) {
  if (!is_started_) return;
  for (std::size_t i = 0; i < active_count(); ++i) count_able(frames_[i]);
  if (!options_.is_static) {
    for (std::size_t i = 0; i < active_count(); ++i) spread(i, now, actions);
  }
  for (bool has_leased = true; has_leased;) {
    has_leased = false;
    for (SlaveEntry& entry : slaves_) has_leased = lease_one(entry, now, actions) || has_leased;
  }
}

// The slave that would have a tile back first if the tile went ahead of its queue, as tiles of the
// oldest frame do.
Scheduler::SlaveEntry* Scheduler::fastest_for(const Frame& frame, const TileLeaseView& lease,
                                              TimePoint now, double& best_seconds) {
  SlaveEntry* best = nullptr;
  for (SlaveEntry& entry : slaves_) {
    const Slave& slave = entry.second;
    if (entry.first == lease.session || !can_take(slave, frame, now) ||
        !has_late_room(slave, now) || !may_have_lost_tile(frame, entry, lease.tile, now)) {
      continue;
    }
    const double back = back_seconds(slave, std::min(slave.in_flight, slave.pace.threads()), now);
    // While nobody has returned a tile, nothing says who is fast, or returns any: many are tried.
    const bool is_better =
        best == nullptr || (has_measured_ ? back < best_seconds
                                          : std::pair(slave.in_flight, back) <
                                                std::pair(best->second.in_flight, best_seconds));
    if (is_better) {
      best = &entry;
      best_seconds = back;
    }
  }
  return best;
}

// A frame is done when its latest tile is. While nothing of it waits, tiles that will come late are
// leased a second time, the latest first, to whoever is back sooner.
void Scheduler::duplicate_late_tiles(Frame& frame, TimePoint now, Actions& actions) {
  struct Late {
    TileLeaseView lease;
    Slave* owner = nullptr;
    bool is_silent = false;
    Duration left{};
  };
  std::vector<Late> out;
  std::set<SessionId> stalled;
  for (const auto& [session, slave] : slaves_) {
    if (slave.is_stalled) stalled.insert(session);
  }
  for (const TileLeaseView& lease : frame.ledger.single_leases(stalled)) {
    const auto owner = slaves_.find(lease.session);
    if (owner == slaves_.end()) continue;
    Late late{lease, &owner->second, is_silent(owner->second, now), lease.due - now};
    // The later a tile is, the less is known of it: it may take as long again.
    if (lease.due <= now) late.left = (now - lease.due) + from_seconds(tile_seconds_);
    out.push_back(late);
  }
  std::sort(out.begin(), out.end(), [](const Late& a, const Late& b) {
    return std::tuple(b.is_silent, b.left, a.lease.tile) <
           std::tuple(a.is_silent, a.left, b.lease.tile);
  });
  count_able(frame);
  for (const Late& late : out) {
    double best_seconds = 0;
    SlaveEntry* best = fastest_for(frame, late.lease, now, best_seconds);
    if (best == nullptr && frame.ledger.losses().is_empty()) return;
    if (best == nullptr) continue;
    const Duration again = from_seconds(best_seconds);
    if (!late.is_silent && again + kDuplicateGainMin > late.left * kDuplicateGain) return;
    const SlavePace& pace = late.owner->pace;
    const bool is_straggler = pace.is_known() && pace.tile_seconds() > kStraggler * tile_seconds_;
    const bool is_free = late.is_silent && (pace.is_known() || late.owner->is_stalled);
    if (!is_free && !budget_.take(is_straggler)) return;
    if (const auto tile =
            frame.ledger.lease_again(late.lease.tile, best->first, now, now + again, stalled))
      issue(*best, frame, *tile, now, actions);
  }
}

Actions Scheduler::tick(TimePoint now) {
  Actions actions;
  if (!is_started_) return actions;
  watch_for_stalls(now, actions);
  fail_lost_tiles(now, actions);
  fail_hopeless(now, actions);  // whoever could hold their scene has not come back
  deliver(actions);
  fill_all(now, actions);  // what was handed back while nobody else was there
  if (options_.is_static) return actions;
  for (std::size_t i = 0; i < active_count(); ++i) {
    Frame& frame = frames_[i];
    if (frame.state == FrameState::kOpen && frame.ledger.pending_count() == 0)
      duplicate_late_tiles(frame, now, actions);
  }
  return actions;
}

}  // namespace tessera::master
