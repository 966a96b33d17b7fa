// SPDX-License-Identifier: Apache-2.0
#include "tests/sim/sim_master.h"

#include <map>
#include <utility>

#include "common/base/limits.h"
#include "common/net/listener.h"

namespace tessera::sim {

// What net::Listener does beside accepting: a connection that does not authenticate itself within
// kHandshakeMs is closed.
class SimMaster::Door final : public net::Listener {
 public:
  explicit Door(Process& process) : process_(process) {}

  std::uint16_t port(std::size_t /*endpoint*/) const override { return 7400; }
  void mark_authenticated(const net::Connection& connection) override {
    strangers_.erase(&connection);
  }

  void accept(const net::ConnectionPtr& connection) {
    strangers_[connection.get()] = connection;
    process_.run_at(process_.queue().now() + std::chrono::milliseconds(kHandshakeMs),
                    Duration::zero(), [this, connection = std::weak_ptr(connection)] {
                      const auto late = connection.lock();
                      if (!late || strangers_.erase(late.get()) == 0) return;
                      late->end_soon(Status::deadline_exceeded("the handshake took too long"));
                    });
  }

 private:
  Process& process_;
  std::map<const net::Connection*, std::weak_ptr<net::Connection>> strangers_;
};

SimMaster::SimMaster(EventQueue& queue, Network& network, int node,
                     const master::FrameLoopOptions& options, Duration record_cost)
    : queue_(queue), network_(network), node_(node), options_(options), record_cost_(record_cost) {}

SimMaster::~SimMaster() { kill(false); }

void SimMaster::start() {
  if (process_) return;
  process_ = std::make_unique<Process>(queue_, "master", node_);
  process_->record_cost = record_cost_;
  door_ = std::make_unique<Door>(*process_);
  loop_ = std::make_unique<master::FrameLoop>(*process_, options_);
  network_.listen(*process_, [this](const net::ConnectionPtr& connection) {
    door_->accept(connection);
    loop_->accept(connection, door_.get());
  });
}

void SimMaster::kill(bool is_power_lost) {
  if (!process_) return;
  network_.on_process_ended(*process_, is_power_lost);
  process_->end();
  loop_.reset();
  door_.reset();
  process_.reset();
}

void SimMaster::set_hung(bool is_hung) {
  if (process_) process_->set_hung(is_hung);
}

}  // namespace tessera::sim
