// SPDX-License-Identifier: Apache-2.0
#include "tests/sim/sim_master.h"

#include <utility>

namespace tessera::sim {
namespace {

constexpr std::uint16_t kMasterPort = 7400;

}  // namespace

SimMaster::SimMaster(EventQueue& queue, Network& network, int node,
                     const master::FrameLoopOptions& options, Duration record_cost)
    : queue_(queue), network_(network), node_(node), options_(options), record_cost_(record_cost) {}

SimMaster::~SimMaster() { kill(false); }

void SimMaster::start() {
  if (process_) return;
  process_ = std::make_unique<Process>(queue_, "master", node_);
  process_->record_cost = record_cost_;
  door_ = std::make_unique<Door>(*process_, kMasterPort);
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
