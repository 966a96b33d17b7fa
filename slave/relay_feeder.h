// SPDX-License-Identifier: Apache-2.0
// Feeds other slaves: takes their needs, sends each chunk as soon as it is here and checked, so
// that a scene flows through a chain of slaves in little more than the time of one link.
//
//   child -> RelayJoin (our token) -> SceneChunkNeed... ;  here -> SceneChunk...
//
// Threads. The event loop's thread only.
// Invariants. (1) A child that has not said the token is listened to for nothing else; the listener
// ends it after kHandshakeMs, and bounds how many of them there are. (2) Only chunks of versions
// that our master announced leave, and only checked ones. (3) At most kChildrenMax children have
// said the token, the oldest goes; what is queued for each is bounded by its connection's low mark
// and a chunk, and what waits behind that by the chunks that are here, however often they are asked
// for. (4) Callbacks of connections know their child by number and look it up: who is gone is not
// found.
#pragma once

#include <compare>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "common/net/connection.h"
#include "common/net/event_loop.h"
#include "common/net/listener.h"
#include "common/wire/codec_chooser.h"
#include "common/wire/link_rate.h"
#include "common/wire/scene_receiver.h"

namespace tessera::slave {

class RelayFeeder {
 public:
  // The master plans one child for each; a former one may still be leaving.
  static constexpr std::size_t kChildrenMax = 8;

  // `receiver` holds what is passed on, and outlives the feeder.
  RelayFeeder(net::EventLoop& loop, const wire::SceneReceiver& receiver, std::uint64_t token)
      : loop_(loop), receiver_(receiver), token_(token) {}
  ~RelayFeeder() { drop_all(); }

  // `listener` outlives the connection; may be null (tests).
  void accept(net::ConnectionPtr connection, net::Listener* listener);
  // The receiver has begun a version: what it keeps of it is sent to those who asked before.
  void on_begun(SceneVersion version);
  void on_arrived(const wire::SceneReceiver::Arrival& arrival);
  void drop_all();
  std::size_t child_count() const { return children_.size(); }  // who has no token yet included

 private:
  struct Place {
    SceneVersion version = 0;
    std::uint32_t block = 0, chunk = 0;
    auto operator<=>(const Place&) const = default;
  };
  struct Child {
    net::ConnectionPtr connection;
    bool has_joined = false;
    wire::ByteCodingMask codings = wire::kByteCodingsNone;
    std::map<std::pair<SceneVersion, std::uint32_t>, std::vector<bool>> wanted;  // not yet here
    std::uint64_t wanted_size = 0;  // chunks in `wanted`, asked for or not
    std::set<Place> ready;
    wire::LinkRate rate;
    wire::CodecChooser chooser;
  };
  using ChildNumber = std::uint64_t;  // in order of arrival

  void on_record(ChildNumber number, net::ReceivedRecord record, net::Listener* listener);
  // Returns: why the child is refused, empty when it is not.
  std::string on_need(Child& child, const wire::SceneChunkNeed& need);
  void make_room();
  void pump(Child& child);
  void send(Child& child, const Place& place, net::SharedBytes bytes);
  void on_closed(ChildNumber number, const Status& status);
  void refuse(ChildNumber number, const std::string& reason);

  net::EventLoop& loop_;
  const wire::SceneReceiver& receiver_;
  const std::uint64_t token_;
  std::map<ChildNumber, Child> children_;
  ChildNumber next_child_ = 0;
};

}  // namespace tessera::slave
