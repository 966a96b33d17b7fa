// SPDX-License-Identifier: Apache-2.0
// A connection whose owner may alter the scene chunks that it sends, as a slave with broken memory
// or bad intent would. All else goes through as it is.
//
// Threads. The simulation's one.
#pragma once

#include <utility>
#include <vector>

#include "common/base/clock.h"
#include "common/net/connection.h"
#include "common/wire/record_types.h"

namespace tessera::sim {

class LyingConnection final : public net::Connection {
 public:
  // `is_altering` is looked at for each record, and outlives the connection.
  LyingConnection(net::ConnectionPtr connection, const bool& is_altering)
      : connection_(std::move(connection)), is_altering_(is_altering) {}

  void send(net::Record record) override {
    const bool is_chunk = record.type == static_cast<std::uint16_t>(wire::RecordType::kSceneChunk);
    if (is_altering_ && is_chunk) {
      std::vector<std::byte> bytes(record.payload.bytes.begin(), record.payload.bytes.end());
      bytes[bytes.size() / 2] ^= std::byte{1};
      record.payload = net::SharedBytes::of(std::move(bytes));
    }
    connection_->send(std::move(record));
  }

  void start(net::ConnectionCallbacks callbacks, const net::RecordLimits& limits) override {
    connection_->start(std::move(callbacks), limits);
  }
  void set_limits(const net::RecordLimits& limits) override { connection_->set_limits(limits); }
  std::uint64_t queue_bytes() const override { return connection_->queue_bytes(); }
  void end_soon(Status why) override { connection_->end_soon(std::move(why)); }
  void close(std::chrono::milliseconds grace) override { connection_->close(grace); }
  const net::PeerIdentity& peer() const override { return connection_->peer(); }
  std::uint64_t bytes_sent() const override { return connection_->bytes_sent(); }
  std::uint64_t bytes_received() const override { return connection_->bytes_received(); }
  TimePoint last_received() const override { return connection_->last_received(); }
  TimePoint last_sent() const override { return connection_->last_sent(); }
  net::LinkCounters link_counters() const override { return connection_->link_counters(); }

 private:
  const net::ConnectionPtr connection_;
  const bool& is_altering_;
};

}  // namespace tessera::sim
