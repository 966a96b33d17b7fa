// SPDX-License-Identifier: Apache-2.0
// The scheduler's choice of the next tile for a slave, and of the next slave for a tile.
#include <algorithm>
#include <utility>

#include "common/base/check.h"
#include "master/schedule/scheduler.h"

namespace tessera::master {
namespace {

// A second lease must promise to be back in this share of the time that the first one still needs:
// both are estimates, and a copy that comes second is work thrown away.
constexpr double kDuplicateGain = 0.67;
constexpr Duration kDuplicateGainMin = std::chrono::milliseconds(5);
// A slave twice as slow per thread as the cluster is a straggler.
constexpr double kStraggler = 2;
// A slave from which nothing came for so many of its longest tile times, with a late tile, is
// treated as lost: its tiles are leased again whatever that costs.
constexpr double kSilentTiles = 4;

// 64 bits in which every bit of the input matters (Steele, Lea, Flood 2014: SplitMix64).
std::uint64_t mix(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15u;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
  return x ^ (x >> 31);
}

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

// Slaves that hold the frame's scene or may yet hold it. Slaves that are still building it count:
// otherwise the one that is done first would never be audited.
std::vector<SessionId> Scheduler::auditors(const Frame& frame) const {
  std::vector<SessionId> sessions;
  for (const auto& [session, slave] : slaves_) {
    if (!slave.failed.contains(frame.ledger.version())) sessions.push_back(session);
  }
  return sessions;
}

// Whether the slave would have a tile back before the cluster is done with the frame and with those
// before it; if not, the tile is for others. Constant time: the mean of all slaves stands for them.
bool Scheduler::is_in_time(std::size_t frame, const Slave& slave, TimePoint now) const {
  if (rate_total_ <= 0) return true;  // nothing is known
  std::size_t left = 0;
  for (std::size_t i = 0; i <= frame; ++i) left += frames_[i].ledger.tiles_left();
  const double done = static_cast<double>(left) / rate_total_ + tile_seconds_ +
                      round_trip_total_ / static_cast<double>(slaves_.size());
  return back_seconds(slave, slave.in_flight, now) <= done;
}

// Whether a tile is audited depends on its name alone, so that a frame can be rendered again.
bool Scheduler::is_audited(FrameId frame, TileIndex tile) const {
  const double draw = static_cast<double>(mix(mix(frame) ^ tile) >> 11) * 0x1p-53;
  return draw < options_.audit_share;
}

// How long nothing may come from a slave that holds tiles before something is wrong with it.
Duration Scheduler::silence_allowed(const Slave& slave) const {
  return from_seconds(
      std::max(kSilentTiles * std::max(slave.pace.tile_seconds_high(), tile_seconds_),
               2 * slave.pace.round_trip_seconds()));
}

// When a tile leased now would be back, with `ahead` tiles before it. A slave that has fallen
// silent is expected to stay so for as long again.
double Scheduler::back_seconds(const Slave& slave, std::uint32_t ahead, TimePoint now) const {
  const double usual = slave.pace.completion_seconds(ahead, tile_seconds_);
  if (slave.in_flight == 0) return usual;
  const Duration silence = now - slave.last_heard;
  return silence > silence_allowed(slave) ? usual + seconds(silence) : usual;
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
  if (slave.in_flight++ == 0) slave.last_heard = now;
  ++frame.held[entry.first];
  actions.push_back({ActionKind::kLease, entry.first, frame.id, tile, false, ""});
}

// Requires: there is a tile of the frame for the slave.
void Scheduler::lease_next(SlaveEntry& entry, Frame& frame, TimePoint now, Actions& actions) {
  const TileIndex next = *frame.ledger.next_for(entry.first);
  const bool is_for_audit =
      options_.audit_share > 0 && is_audited(frame.id, next) && auditors(frame).size() >= 2;
  const auto tile =
      frame.ledger.lease_next(entry.first, now, due_at(entry.second, now), is_for_audit);
  issue(entry, frame, *tile, now, actions);
}

bool Scheduler::lease_one(SlaveEntry& entry, TimePoint now, Actions& actions) {
  Slave& slave = entry.second;
  if (!is_started_ || !has_room(slave) || now < slave.rests_until) return false;
  for (std::size_t i = 0; i < active_count(); ++i) {
    Frame& frame = frames_[i];
    if (!can_take(slave, frame, now)) continue;
    if (options_.is_static) {
      if (lease_static(frame, entry, now, actions)) return true;
      continue;
    }
    if (!frame.ledger.next_for(entry.first) || !is_in_time(i, slave, now)) continue;
    lease_next(entry, frame, now, actions);
    return true;
  }
  slave.was_dry = true;
  return false;
}

// Each tile goes to the slave that will have it back first (list scheduling; Graham 1969). When
// that one has no room, the tile waits for it.
void Scheduler::spread(Frame& frame, TimePoint now, Actions& actions) {
  if (frame.state != FrameState::kOpen || !frame.ledger.may_lease()) return;
  using Place = std::pair<double, SlaveEntry*>;
  const auto is_later = [](const Place& a, const Place& b) {
    return std::pair(a.first, a.second->first) > std::pair(b.first, b.second->first);
  };
  std::vector<Place> heap;
  for (SlaveEntry& entry : slaves_) {
    if (can_take(entry.second, frame, now))
      heap.emplace_back(back_seconds(entry.second, entry.second.in_flight, now), &entry);
  }
  std::make_heap(heap.begin(), heap.end(), is_later);
  while (!heap.empty()) {
    std::pop_heap(heap.begin(), heap.end(), is_later);
    auto& [back, entry] = heap.back();
    if (!frame.ledger.next_for(entry->first)) {
      heap.pop_back();
      continue;
    }
    if (!has_room(entry->second)) return;
    lease_next(*entry, frame, now, actions);
    back = back_seconds(entry->second, entry->second.in_flight, now);
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
  while (lease_one(entry, now, actions)) {
  }
}

// Tiles are leased in rounds, one for each slave, so that the first slave does not take all.
void Scheduler::fill_all(TimePoint now, Actions& actions) {
  if (!is_started_) return;
  if (!options_.is_static) {
    for (std::size_t i = 0; i < active_count(); ++i) spread(frames_[i], now, actions);
  }
  for (bool has_leased = true; has_leased;) {
    has_leased = false;
    for (SlaveEntry& entry : slaves_) has_leased = lease_one(entry, now, actions) || has_leased;
  }
}

// The slave that would have a tile back first if the tile went ahead of its queue, as tiles of the
// oldest frame do.
Scheduler::SlaveEntry* Scheduler::fastest_for(const Frame& frame, SessionId except, TimePoint now,
                                              double& best_seconds) {
  SlaveEntry* best = nullptr;
  for (SlaveEntry& entry : slaves_) {
    const Slave& slave = entry.second;
    if (entry.first == except || !can_take(slave, frame, now) || !has_room(slave)) continue;
    const double back = back_seconds(slave, std::min(slave.in_flight, slave.pace.threads()), now);
    if (best == nullptr || back < best_seconds) {
      best = &entry;
      best_seconds = back;
    }
  }
  return best;
}

// A frame is done when its latest tile is. While nothing of it waits, tiles that will come late are
// leased a second time, the latest first, to whoever is back sooner.
void Scheduler::duplicate_late_tiles(Frame& frame, TimePoint now, Actions& actions) {
  std::vector<TileLeaseView> out = frame.ledger.single_leases();
  const auto left = [&](const TileLeaseView& lease) {
    // The later a tile is, the less is known of it: it may take as long again.
    return lease.due > now ? lease.due - now : (now - lease.due) + from_seconds(tile_seconds_);
  };
  std::sort(out.begin(), out.end(), [&](const auto& a, const auto& b) {
    return std::pair(left(b), a.tile) < std::pair(left(a), b.tile);
  });
  for (const TileLeaseView& lease : out) {
    const auto owner = slaves_.find(lease.session);
    double best_seconds = 0;
    SlaveEntry* best = fastest_for(frame, lease.session, now, best_seconds);
    if (owner == slaves_.end() || best == nullptr) return;
    const Duration again = from_seconds(best_seconds);
    if (again + kDuplicateGainMin > left(lease) * kDuplicateGain) return;
    const SlavePace& pace = owner->second.pace;
    const bool is_silent =
        now > lease.due && now - owner->second.last_heard > silence_allowed(owner->second);
    const bool is_straggler = pace.is_known() && pace.tile_seconds() > kStraggler * tile_seconds_;
    if (!is_silent && !budget_.take(is_straggler)) return;
    if (const auto tile = frame.ledger.lease_again(lease.tile, best->first, now, now + again))
      issue(*best, frame, *tile, now, actions);
  }
}

Actions Scheduler::tick(TimePoint now) {
  Actions actions;
  if (!is_started_) return actions;
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
