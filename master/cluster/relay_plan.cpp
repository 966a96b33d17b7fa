// SPDX-License-Identifier: Apache-2.0
#include "master/cluster/relay_plan.h"

#include <algorithm>

namespace tessera::master {

void RelayPlan::joined(SessionId session, bool can_feed, bool is_near) {
  slaves_[session] = {can_feed, is_near, false, std::nullopt};
}

std::vector<Feed> RelayPlan::lost(SessionId session, TimePoint now) {
  slaves_.erase(session);
  std::erase_if(transfers_, [&](const auto& entry) { return entry.first.second == session; });
  std::vector<Feed> feeds;
  for (auto& [key, transfer] : transfers_) {
    if (transfer.feeder == session && !transfer.is_complete) refeed(key, now, feeds);
  }
  return feeds;
}

SessionId RelayPlan::want(SessionId session, SceneVersion version, std::uint64_t bytes,
                          std::uint64_t total_bytes, bool may_relay, TimePoint now) {
  const Key key{version, session};
  Transfer& transfer = transfers_[key] = {};
  transfer.total_bytes = total_bytes;
  transfer.bytes = total_bytes - std::min(bytes, total_bytes);
  if (may_relay && bytes >= kBytesMin) {
    const auto usual = usual_feeder(session, version);
    feed(session, transfer, usual ? *usual : choose(session, version));
  }
  begin_window(key, transfer, now);
  return transfer.feeder;
}

void RelayPlan::progress(SessionId session, SceneVersion version, std::uint64_t bytes, TimePoint) {
  const auto found = transfers_.find({version, session});
  if (found == transfers_.end()) return;
  Transfer& transfer = found->second;
  transfer.bytes = std::max(transfer.bytes, std::min(bytes, transfer.total_bytes));
  if (bytes >= transfer.total_bytes) transfer.is_complete = true;
}

void RelayPlan::complete(SessionId session, SceneVersion version, std::uint64_t total_bytes) {
  if (!slaves_.contains(session)) return;
  Transfer& transfer = transfers_[{version, session}];
  transfer.bytes = transfer.total_bytes = total_bytes;
  transfer.is_complete = true;
}

void RelayPlan::gave_up(SessionId session, SceneVersion version) {
  transfers_.erase({version, session});  // its children will say that it has nothing
}

bool RelayPlan::may_feed(SessionId feeder, SessionId child, SceneVersion version) const {
  const auto slave = slaves_.find(feeder);
  const auto receiver = slaves_.find(child);
  if (feeder == child || slave == slaves_.end() || receiver == slaves_.end()) return false;
  if (!slave->second.can_feed || slave->second.is_barred) return false;
  if (slave->second.is_near && !receiver->second.is_near) return false;
  // Walks up the chain: it must not become a circle, nor too long.
  std::uint32_t depth = 1;
  for (SessionId up = feeder; up != kFedByMaster; ++depth) {
    const auto above = transfers_.find({version, up});
    if (up == child || depth > kDepthMax) return false;
    if (above == transfers_.end() || above->second.is_complete) break;
    up = above->second.feeder;
  }
  return true;
}

void RelayPlan::feed(SessionId child, Transfer& transfer, SessionId feeder) {
  transfer.feeder = feeder;
  if (const auto slave = slaves_.find(child); slave != slaves_.end()) {
    slave->second.last_feeder = feeder;
  }
}

// Counts children in work, and of this version also those that have been fed: they keep their place
// in the chain.
std::uint32_t RelayPlan::children_of(SessionId feeder, SceneVersion version, SessionId but) const {
  std::uint32_t count = 0;
  for (const auto& [key, transfer] : transfers_) {
    const bool is_counted = !transfer.is_complete || key.first == version;
    if (is_counted && transfer.feeder == feeder && key.second != but) ++count;
  }
  return count;
}

std::optional<SessionId> RelayPlan::usual_feeder(SessionId child, SceneVersion version) const {
  const auto slave = slaves_.find(child);
  if (slave == slaves_.end() || !slave->second.last_feeder) return std::nullopt;
  const SessionId usual = *slave->second.last_feeder;
  if (usual != kFedByMaster && !may_feed(usual, child, version)) return std::nullopt;
  if (children_of(usual, version, child) >= kChildrenMax) return std::nullopt;
  return usual;
}

// Chooses the slave that has most of the version. In a chain in work that is the last one, which
// alone has no child; of slaves that have the whole version it may be any.
SessionId RelayPlan::choose(SessionId child, SceneVersion version) const {
  const auto own = transfers_.find({version, child});
  SessionId best = kFedByMaster;
  std::uint64_t best_bytes = 0;
  if (own != transfers_.end() && own->second.tried.size() >= kFeedersMax) return best;
  std::map<SessionId, std::uint32_t> children;
  for (const auto& [key, transfer] : transfers_) {
    if (!transfer.is_complete && key.second != child) ++children[transfer.feeder];
  }
  for (auto entry = transfers_.lower_bound({version, 0});
       entry != transfers_.end() && entry->first.first == version; ++entry) {
    const SessionId feeder = entry->first.second;
    if (own != transfers_.end() && own->second.tried.contains(feeder)) continue;
    if (children[feeder] >= kChildrenMax || !may_feed(feeder, child, version)) continue;
    if (best != kFedByMaster && entry->second.bytes <= best_bytes) continue;
    best = feeder;
    best_bytes = entry->second.bytes;
  }
  return best;
}

void RelayPlan::refeed(const Key& child, TimePoint now, std::vector<Feed>& feeds) {
  Transfer& transfer = transfers_.at(child);
  if (transfer.feeder != kFedByMaster) transfer.tried.insert(transfer.feeder);
  transfer.feeder = kFedByMaster;
  feed(child.second, transfer, choose(child.second, child.first));
  begin_window(child, transfer, now);
  feeds.push_back({child.second, child.first, transfer.feeder});
}

std::vector<Feed> RelayPlan::failed(SessionId child, SceneVersion version, SessionId feeder,
                                    wire::RelayFault fault, TimePoint now) {
  std::vector<Feed> feeds;
  const auto found = transfers_.find({version, child});
  if (found == transfers_.end() || found->second.feeder != feeder || feeder == kFedByMaster) {
    return feeds;
  }
  if (fault == wire::RelayFault::kAltered) {
    if (const auto slave = slaves_.find(feeder); slave != slaves_.end()) {
      slave->second.is_barred = true;
    }
    for (auto& [key, transfer] : transfers_) {
      if (transfer.feeder == feeder && !transfer.is_complete) refeed(key, now, feeds);
    }
    return feeds;
  }
  refeed(found->first, now, feeds);
  return feeds;
}

void RelayPlan::begin_window(const Key& key, Transfer& transfer, TimePoint now) {
  transfer.window_began = now;
  transfer.bytes_then = transfer.bytes;
  const auto feeder = transfers_.find({key.first, transfer.feeder});
  transfer.feeder_bytes_then = feeder == transfers_.end() ? 0 : feeder->second.bytes;
}

// Requires: the window is over.
bool RelayPlan::holds_back(const Key& key, const Transfer& transfer) const {
  if (transfer.feeder == kFedByMaster) return false;
  if (!transfers_.contains({key.first, transfer.feeder})) return true;  // nothing to give
  const std::uint64_t gain = transfer.bytes - transfer.bytes_then;
  if (gain == 0) return transfer.feeder_bytes_then > transfer.bytes;
  if (transfer.feeder_bytes_then < transfer.bytes + kSlackBytes) return false;
  const double rate = static_cast<double>(gain) / seconds(kWindow);
  return 2 * rate < master_rate_;
}

std::vector<Feed> RelayPlan::tick(TimePoint now) {
  std::vector<Feed> feeds;
  for (auto& [key, transfer] : transfers_) {
    if (transfer.is_complete || now - transfer.window_began < kWindow) continue;
    if (transfer.feeder == kFedByMaster && transfer.bytes > transfer.bytes_then) {
      master_rate_ = static_cast<double>(transfer.bytes - transfer.bytes_then) /
                     seconds(now - transfer.window_began);
    }
    if (holds_back(key, transfer)) {
      refeed(key, now, feeds);
    } else {
      begin_window(key, transfer, now);
    }
  }
  return feeds;
}

void RelayPlan::retire(SceneVersion first_kept) {
  transfers_.erase(transfers_.begin(), transfers_.lower_bound({first_kept, 0}));
}

std::optional<SessionId> RelayPlan::feeder_of(SessionId child, SceneVersion version) const {
  const auto found = transfers_.find({version, child});
  if (found == transfers_.end()) return std::nullopt;
  return found->second.feeder;
}

}  // namespace tessera::master
