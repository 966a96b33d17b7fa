// SPDX-License-Identifier: Apache-2.0
#include "slave/relay_feeder.h"

#include <algorithm>
#include <string>
#include <variant>

#include "common/base/log.h"
#include "common/wire/chunk_coding.h"
#include "common/wire/codec.h"

namespace tessera::slave {
namespace {

constexpr std::chrono::milliseconds kFarewell{500};  // to send the last record
// Most blocks not here yet that a child may wait for: those of the largest scene.
constexpr std::size_t kNeedsMax = kSceneBlocksMax;
// Nothing says how large a version is that is not announced yet. So many chunks are a scene of 1
// TiB, and a list of them takes 2 MiB.
constexpr std::uint64_t kWantedChunksMax = std::uint64_t{1} << 24;

}  // namespace

void RelayFeeder::accept(net::ConnectionPtr connection, net::Listener* listener) {
  const net::PeerIdentity& peer = connection->peer();
  if (peer.is_authenticated && peer.role != "slave") {
    log_warn("relay-refused",
             "only slaves may be fed by a slave; this is a certificate of another role",
             {{"peer", peer.address}, {"role", peer.role}});
    return;  // closes
  }
  const ChildNumber number = next_child_++;
  net::ConnectionCallbacks callbacks;
  callbacks.on_record = [this, number, listener](net::ReceivedRecord record) {
    on_record(number, std::move(record), listener);
  };
  callbacks.on_closed = [this, number](const Status& status) { on_closed(number, status); };
  callbacks.on_drained = [this, number] {
    if (const auto child = children_.find(number); child != children_.end()) pump(child->second);
  };
  Child& child = children_[number];
  child.connection = std::move(connection);
  child.connection->start(std::move(callbacks), wire::relay_join_limits());
}

// Ends the oldest of the children where there is no room for one more. Who has not said the token
// is no child: strangers who knock push out none of those who are fed.
void RelayFeeder::make_room() {
  const auto has_joined = [](const auto& entry) { return entry.second.has_joined; };
  if (std::count_if(children_.begin(), children_.end(), has_joined) <
      static_cast<std::ptrdiff_t>(kChildrenMax))
    return;
  const auto oldest = std::find_if(children_.begin(), children_.end(), has_joined);
  log_warn("relay-refused", "another child has come, and this is the oldest of as many as may be",
           {{"peer", oldest->second.connection->peer().address}});
  children_.erase(oldest);
}

// A child that was let in and goes has what it wanted, or another feeder.
void RelayFeeder::on_closed(ChildNumber number, const Status& status) {
  const auto child = children_.find(number);
  if (child == children_.end()) return;
  if (!child->second.has_joined || status.code() != StatusCode::kUnavailable) {
    log_warn("relay-refused", "a child has gone: " + status.message(),
             {{"peer", child->second.connection->peer().address}});
  }
  children_.erase(child);
}

void RelayFeeder::refuse(ChildNumber number, const std::string& reason) {
  const net::ConnectionPtr connection = children_.at(number).connection;
  log_warn("relay-refused", reason, {{"peer", connection->peer().address}});
  connection->send(wire::encode(wire::Refuse{wire::RefuseCode::kProtocol, reason}));
  connection->close(kFarewell);
  children_.erase(number);
  loop_.post([connection] {});  // its callback may be running
}

void RelayFeeder::on_record(ChildNumber number, net::ReceivedRecord record,
                            net::Listener* listener) {
  const auto found = children_.find(number);
  if (found == children_.end()) return;
  Child& child = found->second;
  Result<wire::Message> message = wire::decode(std::move(record));
  if (!message.is_ok()) return refuse(number, message.status().message());
  if (const auto* join = std::get_if<wire::RelayJoin>(&*message)) {
    if (child.has_joined || join->token != token_) return refuse(number, "a wrong token");
    make_room();
    child.has_joined = true;
    child.codings = join->codings;
    if (listener != nullptr) listener->mark_authenticated(*child.connection);
    return child.connection->set_limits(wire::relay_feeder_limits());
  }
  const auto* need = std::get_if<wire::SceneChunkNeed>(&*message);
  if (need == nullptr || !child.has_joined)
    return refuse(number, "it does not keep to the protocol");
  if (const std::string breach = on_need(child, *need); !breach.empty()) refuse(number, breach);
}

std::string RelayFeeder::on_need(Child& child, const wire::SceneChunkNeed& need) {
  // A child that asks for a version is done with those before.
  const auto newer = child.wanted.lower_bound({need.version, 0});
  for (auto it = child.wanted.begin(); it != newer; it = child.wanted.erase(it))
    child.wanted_size -= it->second.size();
  child.ready.erase(child.ready.begin(), child.ready.lower_bound({need.version, 0, 0}));
  if (child.wanted.size() >= kNeedsMax) return "it asks for too much at once";
  std::vector<bool> later(need.chunks.size());
  bool is_any_later = false;
  for (std::uint32_t i = 0; i < need.chunks.size(); ++i) {
    if (!need.chunks[i]) continue;
    net::SharedBytes bytes;
    switch (receiver_.find(need.version, need.block, i, bytes)) {
      case wire::SceneReceiver::Holding::kHere:
        child.ready.insert({need.version, need.block, i});
        break;
      case wire::SceneReceiver::Holding::kNotYet:
        later[i] = is_any_later = true;
        break;
      case wire::SceneReceiver::Holding::kNever:
        return "scene version " + std::to_string(need.version) + " is not here";
    }
  }
  if (is_any_later) {
    std::vector<bool>& wanted = child.wanted[{need.version, need.block}];
    child.wanted_size += later.size() - wanted.size();
    wanted = std::move(later);
  }
  if (child.wanted_size > kWantedChunksMax) return "it asks for too much at once";
  pump(child);
  return {};
}

void RelayFeeder::on_begun(SceneVersion version) {
  net::SharedBytes bytes;
  for (auto& [number, child] : children_) {
    for (auto wanted = child.wanted.lower_bound({version, 0});
         wanted != child.wanted.end() && wanted->first.first == version; ++wanted) {
      const std::uint32_t block = wanted->first.second;
      for (std::uint32_t chunk = 0; chunk < wanted->second.size(); ++chunk) {
        if (!wanted->second[chunk] ||
            receiver_.find(version, block, chunk, bytes) != wire::SceneReceiver::Holding::kHere)
          continue;
        wanted->second[chunk] = false;
        child.ready.insert({version, block, chunk});
      }
    }
    pump(child);
  }
}

void RelayFeeder::on_arrived(const wire::SceneReceiver::Arrival& arrival) {
  for (auto& [number, child] : children_) {
    const auto wanted = child.wanted.find({arrival.version, arrival.block});
    if (wanted == child.wanted.end() || arrival.chunk >= wanted->second.size()) continue;
    if (!wanted->second[arrival.chunk]) continue;
    wanted->second[arrival.chunk] = false;
    child.ready.insert({arrival.version, arrival.block, arrival.chunk});
    pump(child);
  }
}

void RelayFeeder::pump(Child& child) {
  while (!child.ready.empty() && child.connection->queue_bytes() <= net::kSendQueueLowBytes) {
    const Place place = *child.ready.begin();
    child.ready.erase(child.ready.begin());
    net::SharedBytes bytes;
    // A chunk that was given up meanwhile is not sent: the master will see that the child gets no
    // further.
    if (receiver_.find(place.version, place.block, place.chunk, bytes) ==
        wire::SceneReceiver::Holding::kHere) {
      send(child, place, std::move(bytes));
    }
  }
}

void RelayFeeder::send(Child& child, const Place& place, net::SharedBytes bytes) {
  child.rate.observe(child.connection->link_counters());
  child.chooser.set_link(child.rate.bytes_per_second());
  wire::SceneChunk chunk{place.version, place.block, std::uint64_t{place.chunk} * kSceneChunkBytes,
                         std::move(bytes)};
  wire::code_chunk(child.chooser, child.codings, chunk);
  child.connection->send(wire::encode(std::move(chunk)));
}

void RelayFeeder::drop_all() { children_.clear(); }

}  // namespace tessera::slave
