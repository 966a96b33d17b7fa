// SPDX-License-Identifier: Apache-2.0
#include "tests/sim/sim_slave.h"

#include <utility>

#include "tests/sim/door.h"
#include "tests/sim/lying_connection.h"
#include "tests/sim/random.h"

namespace tessera::sim {
namespace {

// Deadlines as in SlaveHost: first for tiles in work, then for their way to the wire.
constexpr std::chrono::seconds kFinishTiles{2}, kFlush{2};
constexpr std::chrono::milliseconds kLook{2}, kGoodbye{20};
constexpr std::uint16_t kRelayPort = 7500;

}  // namespace

SimSlave::SimSlave(EventQueue& queue, Network& network, std::string name, int node, int master_node,
                   WorkModel model)
    : queue_(queue),
      network_(network),
      name_(std::move(name)),
      node_(node),
      master_node_(master_node),
      model_(std::move(model)) {}

void SimSlave::start() {
  if (process_) return;
  is_leaving_ = false;
  process_ = std::make_unique<Process>(queue_, name_, node_);
  workshop_ = std::make_unique<SimWorkshop>(*process_, model_);
  slave::SlaveOptions options;
  options.name = name_;
  options.threads = model_.threads;
  options.isas = isa_bit(Isa::kScalar);
  options.instance = mix(mix(static_cast<std::uint64_t>(node_)) + ++starts_) | 1;
  if (model_.is_relaying) options.relay = relay_access();
  const auto open_link = [this](std::function<void(Result<net::ConnectionPtr>)> on_connected) {
    return network_.connect(*process_, master_node_, std::move(on_connected));
  };
  slave_ = std::make_unique<slave::SlaveNode>(*process_, options, open_link, *workshop_);
  workshop_->set_node(slave_.get());
  process_->post([this] { slave_->start(); });
}

slave::RelayAccess SimSlave::relay_access() {
  slave::RelayAccess access;
  access.listen = [this](const std::string& /*local_host*/,
                         std::function<void(net::ConnectionPtr)> on_accept) {
    auto door = std::make_unique<Door>(*process_, kRelayPort);
    network_.listen(*process_, [this, door = door.get(), on_accept](net::ConnectionPtr connection) {
      const auto link = std::make_shared<LyingConnection>(std::move(connection), is_altering_);
      door->accept(link);
      on_accept(link);
    });
    return Result<std::unique_ptr<net::Listener>>(std::move(door));
  };
  access.connect = [this](const net::Endpoint& feeder,
                          std::function<void(Result<net::ConnectionPtr>)> on_connected) {
    return network_.connect(*process_, network_.node_of(feeder.host), std::move(on_connected));
  };
  return access;
}

void SimSlave::kill(bool is_power_lost) {
  if (!process_) return;
  network_.on_process_ended(*process_, is_power_lost);
  process_->end();
  slave_.reset();
  workshop_.reset();
  process_.reset();
}

void SimSlave::set_hung(bool is_hung) {
  if (process_) process_->set_hung(is_hung);
}

void SimSlave::set_frozen(bool is_frozen) {
  if (workshop_) workshop_->set_frozen(is_frozen);
}

// Takes the steps of SlaveHost::stop(), without waiting.
void SimSlave::leave() {
  if (!process_ || is_leaving_) return;
  is_leaving_ = true;
  process_->post([this] {
    slave_->begin_leave();
    finish_leave(queue_.now() + kFinishTiles);
  });
}

void SimSlave::finish_leave(TimePoint deadline) {
  const bool is_late = queue_.now() >= deadline;
  if (is_late) slave_->give_up_tiles();
  const bool is_flushed = slave_->flush();
  if ((workshop_->working() > 0 || !is_flushed) && queue_.now() < deadline + kFlush) {
    return process_->run_at(queue_.now() + kLook, Duration::zero(),
                            [this, deadline] { finish_leave(deadline); });
  }
  slave_->say_goodbye();
  // The process is ended by an event, since ending it destroys the task that is running.
  process_->run_at(queue_.now() + kGoodbye, Duration::zero(), [this, process = process_.get()] {
    queue_.after(Duration::zero(), [this, process] {
      if (process_.get() == process) kill(false);
    });
  });
}

}  // namespace tessera::sim
