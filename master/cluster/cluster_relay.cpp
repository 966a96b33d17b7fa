// SPDX-License-Identifier: Apache-2.0
// What a cluster does about slaves that feed slaves: asks the plan, tells the slaves, logs faults.
#include <utility>

#include "common/base/log.h"
#include "common/net/endpoint.h"
#include "master/cluster/cluster.h"

namespace tessera::master {
namespace {

const char* fault_text(wire::RelayFault fault) {
  switch (fault) {
    case wire::RelayFault::kUnreachable:
      return "unreachable";
    case wire::RelayFault::kGone:
      return "gone";
    case wire::RelayFault::kAltered:
      return "altered";
  }
  return "?";
}

net::Endpoint address_of(const PeerLink& link) {
  const auto address = net::parse_endpoint(link.connection().peer().address);
  return address.is_ok() ? *address : net::Endpoint{};  // "local": inside this process
}

}  // namespace

void Cluster::join_relay(SessionId session) {
  const SlaveEntry& slave = *slaves_.at(session);
  const net::Endpoint address = address_of(*slave.tile_link);
  const bool can_feed = is_relaying_ && slave.hello.relay_port != 0 && !address.host.empty();
  relay_.joined(session, can_feed, !address.host.empty() && net::is_loopback(address));
}

bool Cluster::feed_by_slave(SessionId session, SceneVersion version, std::uint64_t bytes) {
  const auto scene = scenes_.find(version);
  if (scene == scenes_.end()) return false;
  // A slave that joins beside frames in work is fed from here, where its data yields to them.
  const SlaveEntry& slave = *slaves_.at(session);
  const bool may_relay = is_relaying_ && slave.hello.relay_port != 0 && !is_behind(session);
  const std::uint64_t all_bytes = summarizer_.of(scene->second->blocks).bytes;
  const SessionId feeder = relay_.want(session, version, bytes, all_bytes, may_relay, Clock::now());
  if (feeder != kFedByMaster) tell_feed({session, version, feeder});
  return feeder != kFedByMaster;
}

void Cluster::tell_feed(const Feed& feed) {
  const auto child = slaves_.find(feed.child);
  if (child == slaves_.end() || !child->second->is_joined()) return;
  wire::RelayFrom from;
  from.version = feed.version;
  const auto feeder = slaves_.find(feed.feeder);
  if (feed.feeder != kFedByMaster && feeder != slaves_.end()) {
    from.feeder = feed.feeder;
    from.host = address_of(*feeder->second->tile_link).host;
    from.port = feeder->second->hello.relay_port;
    from.token = feeder->second->hello.relay_token;
  }
  log_debug("relay-feed", "slave '" + child->second->hello.name + "' is fed",
            {{"by", from.feeder == 0 ? "the master" : feeder->second->hello.name},
             {"version", std::to_string(feed.version)}});
  child->second->scene_link->send(std::move(from));
}

void Cluster::apply(const std::vector<Feed>& feeds) {
  for (const Feed& feed : feeds) tell_feed(feed);
}

void Cluster::on_relay_failed(SessionId session, const wire::RelayFailed& failed) {
  const auto feeder = slaves_.find(failed.feeder);
  log_warn("relay-failed",
           "slave '" + slaves_.at(session)->hello.name + "' gives up who fed it: " + failed.reason,
           {{"feeder", feeder == slaves_.end() ? "gone" : feeder->second->hello.name},
            {"fault", fault_text(failed.fault)},
            {"version", std::to_string(failed.version)}});
  apply(relay_.failed(session, failed.version, failed.feeder, failed.fault, Clock::now()));
}

void Cluster::watch_relay() {
  const std::vector<Feed> feeds = relay_.tick(Clock::now());
  for (const Feed& feed : feeds) {
    const auto child = slaves_.find(feed.child);
    if (child == slaves_.end()) continue;
    log_warn("relay-bypassed", "who fed slave '" + child->second->hello.name + "' held back",
             {{"version", std::to_string(feed.version)}});
  }
  apply(feeds);
}

}  // namespace tessera::master
