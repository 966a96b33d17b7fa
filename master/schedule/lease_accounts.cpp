// SPDX-License-Identifier: Apache-2.0
#include "master/schedule/lease_accounts.h"

#include <algorithm>

namespace tessera::master {
namespace {

void add(TileAccounts& sum, const TileAccounts& counts) {
  sum.issued += counts.issued;
  sum.accepted += counts.accepted;
  sum.rejected += counts.rejected;
  sum.abandoned += counts.abandoned;
  sum.in_flight += counts.in_flight;
}

std::uint64_t key_of(const TileAssignment& tile) {
  return std::uint64_t{tile.tile} << 32 | tile.attempt;
}

template <typename Leases>
auto find(Leases& leases, const TileAssignment& tile) {
  return std::find_if(leases.begin(), leases.end(),
                      [key = key_of(tile)](const auto& lease) { return lease.key == key; });
}

}  // namespace

void LeaseAccounts::leased(SessionId session, FrameId frame, const TileAssignment& tile,
                           TimePoint now) {
  Account& account = accounts_[session];
  ++account.counts.issued;
  ++account.counts.in_flight;
  account.outstanding[frame].push_back({key_of(tile), now});
}

std::optional<TimePoint> LeaseAccounts::leased_at(SessionId session, FrameId frame,
                                                  const TileAssignment& tile) const {
  const auto account = accounts_.find(session);
  if (account == accounts_.end()) return std::nullopt;
  const auto held = account->second.outstanding.find(frame);
  if (held == account->second.outstanding.end()) return std::nullopt;
  const auto lease = find(held->second, tile);
  return lease == held->second.end() ? std::nullopt : std::optional(lease->since);
}

// Returns: the account whose lease it was, null when no such lease is outstanding.
LeaseAccounts::Account* LeaseAccounts::end_lease(SessionId session, FrameId frame,
                                                 const TileAssignment& tile) {
  const auto found = accounts_.find(session);
  if (found == accounts_.end()) return nullptr;
  const auto held = found->second.outstanding.find(frame);
  if (held == found->second.outstanding.end()) return nullptr;
  std::vector<Lease>& leases = held->second;
  const auto lease = find(leases, tile);
  if (lease == leases.end()) return nullptr;
  *lease = leases.back();
  leases.pop_back();
  if (leases.empty()) found->second.outstanding.erase(held);
  --found->second.counts.in_flight;
  return &found->second;
}

void LeaseAccounts::answered(SessionId session, FrameId frame, const TileAssignment& tile,
                             bool is_accepted) {
  if (Account* account = end_lease(session, frame, tile))
    ++(is_accepted ? account->counts.accepted : account->counts.rejected);
}

void LeaseAccounts::overruled(SessionId session) {
  const auto found = accounts_.find(session);
  TileAccounts& counts = found == accounts_.end() ? gone_ : found->second.counts;
  if (counts.accepted == 0) return;
  --counts.accepted;
  ++counts.rejected;
}

void LeaseAccounts::handed_back(SessionId session, FrameId frame, const TileAssignment& tile) {
  if (Account* account = end_lease(session, frame, tile)) ++account->counts.abandoned;
}

void LeaseAccounts::frame_ended(SessionId session, FrameId frame) {
  const auto found = accounts_.find(session);
  if (found == accounts_.end()) return;
  const auto held = found->second.outstanding.find(frame);
  if (held == found->second.outstanding.end()) return;
  found->second.counts.in_flight -= held->second.size();
  found->second.counts.abandoned += held->second.size();
  found->second.outstanding.erase(held);
}

void LeaseAccounts::slave_lost(SessionId session) {
  const auto found = accounts_.find(session);
  if (found == accounts_.end()) return;
  TileAccounts& counts = found->second.counts;
  counts.abandoned += counts.in_flight;
  counts.in_flight = 0;
  add(gone_, counts);
  accounts_.erase(found);
}

TileAccounts LeaseAccounts::of(SessionId session) const {
  const auto found = accounts_.find(session);
  return found == accounts_.end() ? TileAccounts{} : found->second.counts;
}

TileAccounts LeaseAccounts::total() const {
  TileAccounts sum = gone_;
  for (const auto& [session, account] : accounts_) add(sum, account.counts);
  return sum;
}

}  // namespace tessera::master
