// SPDX-License-Identifier: Apache-2.0
// A scripted master in virtual time (tests/sim), for tests of SlaveNode. Time passes only while
// something is waited for, and every run has the same times, to the nanosecond.
//
// Threads. The test's.
#pragma once

#include <algorithm>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "common/net/connector.h"
#include "slave/slave_node.h"
#include "tests/sim/network.h"
#include "tests/unit/slave/master_script.h"

namespace tessera::slave {

class VirtualMaster final : public MasterScript {
 public:
  explicit VirtualMaster(sim::EventQueue& queue)
      : queue_(queue), network_(queue, 1), node_(network_.add_node({})) {
    process_ = std::make_unique<sim::Process>(queue_, "master", node_);
    network_.listen(*process_, [this](net::ConnectionPtr link) { adopt(std::move(link)); });
  }
  ~VirtualMaster() override { network_.on_process_ended(*process_, true); }

  sim::Network& network() { return network_; }

  // Returns: a factory of links from the process `slave`, which is on another node.
  net::LinkFactory factory(sim::Process& slave) {
    return [this, &slave](std::function<void(Result<net::ConnectionPtr>)> on_connected) {
      ++attempts_;
      const Status refusal = is_away_ ? Status::unavailable("nobody is there") : refusal_;
      if (refusal.is_ok()) return network_.connect(slave, node_, std::move(on_connected));
      on_connected(refusal);
      return std::unique_ptr<net::ConnectAttempt>();
    };
  }

  void set_away(bool is_away) { is_away_ = is_away; }
  // Links fail with this status, unless it is ok: no trust between us, say.
  void set_refused(Status refusal) { refusal_ = std::move(refusal); }
  // A hung master reads and answers nothing, while its system still acknowledges.
  void set_hung(bool is_hung) { process_->set_hung(is_hung); }
  int attempts() const { return attempts_; }
  // Times at which the pings came over `link`.
  const std::vector<TimePoint>& pings(std::size_t link) { return pings_[link]; }

  // Lets virtual time pass.
  void run_for(Duration time) {
    bool is_over = false;
    queue_.after(time, [&is_over] { is_over = true; });
    while (!is_over) queue_.step();
  }

  std::optional<Event> next() override {
    const TimePoint deadline = queue_.now() + std::chrono::minutes(5);
    while (events_.empty()) {
      if (queue_.now() > deadline || !queue_.step()) return std::nullopt;
    }
    Event event = std::move(events_.front());
    events_.pop_front();
    return event;
  }

  void send(std::size_t link, wire::Message message) override {
    links_.at(link)->send(wire::encode(std::move(message)));
  }
  void close(std::size_t link) override { links_.at(link)->close(); }

 private:
  void adopt(net::ConnectionPtr end) {
    const std::size_t link = links_.size();
    links_.push_back(std::move(end));
    net::ConnectionCallbacks callbacks;
    callbacks.on_record = [this, link](net::ReceivedRecord record) {
      Result<wire::Message> message = wire::decode(std::move(record));
      if (!message.is_ok()) {
        events_.push_back({link, std::nullopt, message.status().message()});
      } else if (const auto* ping = std::get_if<wire::Ping>(&*message)) {
        pings_[link].push_back(queue_.now());
        send(link, wire::Pong{ping->sent_ns});
      } else if (!std::holds_alternative<wire::Pong>(*message)) {
        events_.push_back({link, std::move(*message), {}});
      }
    };
    callbacks.on_closed = [this, link](const Status& status) {
      events_.push_back({link, std::nullopt, "closed: " + status.message()});
    };
    links_.back()->start(std::move(callbacks), wire::session_limits());
  }

  sim::EventQueue& queue_;
  sim::Network network_;
  const int node_;
  std::unique_ptr<sim::Process> process_;
  std::vector<net::ConnectionPtr> links_;
  std::deque<Event> events_;
  std::map<std::size_t, std::vector<TimePoint>> pings_;
  int attempts_ = 0;
  bool is_away_ = false;
  Status refusal_;
};

}  // namespace tessera::slave
