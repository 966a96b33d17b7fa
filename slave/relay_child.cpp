// SPDX-License-Identifier: Apache-2.0
#include "slave/relay_child.h"

#include <utility>

#include "common/wire/codec.h"

namespace tessera::slave {

std::optional<wire::RelayFault> relay_fault_of(wire::SceneReceiver::Verdict verdict) {
  switch (verdict) {
    case wire::SceneReceiver::Verdict::kStored:
    case wire::SceneReceiver::Verdict::kLate:
      return std::nullopt;
    case wire::SceneReceiver::Verdict::kNoMemory:
      return wire::RelayFault::kGone;
    case wire::SceneReceiver::Verdict::kNotAskedFor:
    case wire::SceneReceiver::Verdict::kMalformed:
    case wire::SceneReceiver::Verdict::kWrongDigest:
      break;
  }
  return wire::RelayFault::kAltered;
}

void RelayChild::follow(const wire::RelayFrom& from, std::vector<wire::SceneChunkNeed> needs) {
  const bool is_at_hand = connection_ || attempt_;
  if (!is_at_hand || from.feeder != feeder_ || from.token != token_) connect(from);
  version_ = from.version;
  waiting_ = std::move(needs);
  if (connection_) send_waiting();
}

void RelayChild::connect(const wire::RelayFrom& from) {
  stop();
  feeder_ = from.feeder;
  token_ = from.token;
  const auto on_answer = [this, alive = std::weak_ptr<int>(alive_),
                          generation = generation_](Result<net::ConnectionPtr> connection) {
    if (alive.expired()) return;
    // The answer goes by way of the queue, since it may come from inside the call.
    loop_.post([this, alive, generation, connection = std::move(connection)]() mutable {
      if (!alive.expired() && generation == generation_) on_connected(std::move(connection));
    });
  };
  attempt_ = access_.connect({from.host, from.port}, on_answer);
}

void RelayChild::on_connected(Result<net::ConnectionPtr> connection) {
  attempt_.reset();
  if (!connection.is_ok()) {
    return fail(wire::RelayFault::kUnreachable, connection.status().message());
  }
  connection_ = std::move(*connection);
  net::ConnectionCallbacks callbacks;
  callbacks.on_record = [this, generation = generation_](net::ReceivedRecord record) {
    if (generation == generation_) on_record(std::move(record));
  };
  callbacks.on_closed = [this, generation = generation_](const Status& status) {
    if (generation == generation_) fail(wire::RelayFault::kGone, status.message());
  };
  connection_->start(std::move(callbacks), wire::relay_child_limits());
  connection_->send(wire::encode(wire::RelayJoin{token_, wire::kByteCodingsAll}));
  send_waiting();
}

void RelayChild::send_waiting() {
  for (wire::SceneChunkNeed& need : std::exchange(waiting_, {})) want(std::move(need));
}

void RelayChild::want(wire::SceneChunkNeed need) {
  if (!connection_) {
    waiting_.push_back(std::move(need));
  } else {
    connection_->send(wire::encode(std::move(need)));
  }
}

void RelayChild::on_record(net::ReceivedRecord record) {
  Result<wire::Message> message = wire::decode(std::move(record));
  if (!message.is_ok()) return fail(wire::RelayFault::kAltered, message.status().message());
  if (const auto* refuse = std::get_if<wire::Refuse>(&*message)) {
    return fail(wire::RelayFault::kGone, "it refuses: " + refuse->reason);
  }
  const auto& chunk = std::get<wire::SceneChunk>(*message);  // the limits allow nothing else
  const std::uint64_t generation = generation_;
  const std::optional<wire::RelayFault> fault = events_.on_chunk(chunk);
  if (generation != generation_ || !fault) return;
  const std::string place =
      "block " + std::to_string(chunk.block) + ", offset " + std::to_string(chunk.offset);
  fail(*fault, *fault == wire::RelayFault::kAltered ? place + " is not what it should be"
                                                    : "no memory here for " + place);
}

void RelayChild::fail(wire::RelayFault fault, const std::string& reason) {
  const wire::RelayFailed failed{version_, feeder_, fault, reason};
  stop();
  if (failed.version != 0) events_.on_failed(failed);
}

void RelayChild::rest() {
  version_ = 0;
  waiting_.clear();
}

void RelayChild::stop() {
  ++generation_;
  version_ = 0;
  waiting_.clear();
  attempt_.reset();
  if (!connection_) return;
  connection_->close();
  loop_.post([connection = std::move(connection_)] {});  // its callback may be running
  connection_.reset();
}

}  // namespace tessera::slave
