// SPDX-License-Identifier: Apache-2.0
// A process that speaks to a relay as it likes: it connects to a feeder and sends it records, or
// stands at a feeder's address and answers a child.
//
// Threads. The test's.
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "common/wire/codec.h"
#include "tests/sim/network.h"

namespace tessera::slave {

class RelayStranger {
 public:
  RelayStranger(sim::EventQueue& queue, sim::Network& network)
      : queue_(queue), network_(network), node_(network.add_node({})) {
    process_ = std::make_unique<sim::Process>(queue, "stranger", node_);
  }
  ~RelayStranger() {
    network_.on_process_ended(*process_, true);
    process_->end();
  }

  // Connects to a feeder; what is said before the connection stands follows then.
  void call(int feeder_node) {
    attempt_ = network_.connect(*process_, feeder_node, [this](Result<net::ConnectionPtr> link) {
      if (link.is_ok()) adopt(std::move(*link));
    });
  }
  // Waits for a child, and answers each of its needs with `lie`.
  void wait_for_child(wire::SceneChunk lie) {
    network_.listen(*process_, [this, lie = std::move(lie)](net::ConnectionPtr link) {
      on_need_ = [this, lie] { say(lie); };
      adopt(std::move(link));
    });
  }
  void say(wire::Message message) {
    if (link_) {
      link_->send(wire::encode(std::move(message)));
    } else {
      unsaid_.push_back(std::move(message));
    }
  }

  sim::Process& process() { return *process_; }
  int node() const { return node_; }

  std::vector<wire::Message> heard;
  std::optional<TimePoint> closed_at;

 private:
  void adopt(net::ConnectionPtr link) {
    link_ = std::move(link);
    net::ConnectionCallbacks callbacks;
    callbacks.on_record = [this](net::ReceivedRecord record) {
      Result<wire::Message> message = wire::decode(std::move(record));
      if (!message.is_ok()) return;
      if (std::holds_alternative<wire::SceneChunkNeed>(*message) && on_need_) on_need_();
      heard.push_back(std::move(*message));
    };
    callbacks.on_closed = [this](const Status&) { closed_at = queue_.now(); };
    net::RecordLimits limits = wire::session_limits();
    for (std::size_t i = 0; i < limits.size(); ++i) {
      const net::RecordLimit& join = wire::relay_join_limits()[i];
      if (join.header_bytes_max > limits[i].header_bytes_max) limits[i] = join;
    }
    link_->start(std::move(callbacks), limits);
    for (wire::Message& message : std::exchange(unsaid_, {})) say(std::move(message));
  }

  sim::EventQueue& queue_;
  sim::Network& network_;
  const int node_;
  std::unique_ptr<sim::Process> process_;
  std::unique_ptr<net::ConnectAttempt> attempt_;
  net::ConnectionPtr link_;
  std::function<void()> on_need_;
  std::vector<wire::Message> unsaid_;
};

}  // namespace tessera::slave
