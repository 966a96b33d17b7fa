// SPDX-License-Identifier: Apache-2.0
#include "tests/sim/faults.h"

#include <vector>

namespace tessera::sim {
namespace {

bool is_between_slaves(const Fault& fault) {
  return fault.kind >= FaultKind::kRelayCut && fault.kind <= FaultKind::kRelayAlters;
}

}  // namespace

void Faults::begin(const Fault& fault) {
  const double until = fault.at + fault.duration + world_.oracle.bound_of_return();
  if (is_between_slaves(fault)) return begin_relay_fault(fault);
  if (fault.kind >= FaultKind::kMasterCrash && fault.kind != FaultKind::kFreeze) {  // of no slave
    if (fault.kind != FaultKind::kAppCancels) world_.oracle.trouble_all(until);
    return begin_other_fault(fault);
  }
  world_.oracle.trouble_slave(static_cast<std::size_t>(fault.slave), until);
  begin_slave_fault(fault);
}

void Faults::begin_slave_fault(const Fault& fault) {
  const auto index = static_cast<std::size_t>(fault.slave);
  SimSlave& slave = *world_.slaves[index];
  const int node = slave.node(), master = world_.master.node();
  switch (fault.kind) {
    case FaultKind::kKill:
    case FaultKind::kPowerLoss:
      if (slave.is_running()) world_.oracle.set_gone(index, true);
      slave.kill(fault.kind == FaultKind::kPowerLoss);
      break;
    case FaultKind::kHang:
      slave.set_hung(true);
      if (slave.is_running()) world_.oracle.set_gone(index, true);
      break;
    case FaultKind::kCutFrom:
      world_.network.cut(node, master);
      world_.oracle.set_gone(index, true);
      break;
    case FaultKind::kCutTo:
      world_.network.cut(master, node);
      break;
    case FaultKind::kCutBoth:
      world_.network.cut(node, master);
      world_.network.cut(master, node);
      world_.oracle.set_gone(index, true);
      break;
    case FaultKind::kStallOne:
      if (fault.variant / 2 == 0) {
        world_.network.stall(node, master, static_cast<std::size_t>(fault.variant % 2), true);
      } else {
        world_.network.stall(master, node, static_cast<std::size_t>(fault.variant % 2), true);
      }
      break;
    case FaultKind::kReset:
      world_.network.reset(node, master, static_cast<std::size_t>(fault.variant % 2));
      break;
    case FaultKind::kDelay:
      world_.network.link(node).delay += std::chrono::milliseconds(50);
      world_.network.link(node).jitter += std::chrono::milliseconds(20);
      break;
    case FaultKind::kSlowLink:
      world_.network.link(node).up_bytes_per_s = world_.network.link(node).down_bytes_per_s = 125e3;
      break;
    case FaultKind::kLeave:
      slave.leave();
      break;
    case FaultKind::kFreeze:
      slave.set_frozen(true);
      break;
    default:
      break;
  }
}

void Faults::begin_other_fault(const Fault& fault) {
  switch (fault.kind) {
    case FaultKind::kMasterCrash:
      world_.master.kill(fault.variant == 0);
      break;
    case FaultKind::kMasterHang:
      world_.master.set_hung(true);
      break;
    case FaultKind::kAppCrash:
      world_.app.kill(fault.variant == 0);
      break;
    case FaultKind::kAppHang:
    case FaultKind::kAppPause:
      world_.app.set_hung(true);
      break;
    case FaultKind::kWrongClock:
      world_.network.set_refusing(world_.master.node(), true);
      if (fault.variant > 0) world_.network.reset_all(world_.master.node());
      break;
    case FaultKind::kAppCancels:
      world_.app.cancel();
      break;
    default:
      break;
  }
}

// What happens between slaves is no excuse for anybody: the master has all chunks, too.
void Faults::begin_relay_fault(const Fault& fault) {
  SimSlave& slave = *world_.slaves[static_cast<std::size_t>(fault.slave)];
  const int node = slave.node(), other = peer_of(fault);
  switch (fault.kind) {
    case FaultKind::kRelayCut:
      world_.network.cut(node, other);
      world_.network.cut(other, node);
      break;
    case FaultKind::kRelayStall:
      stall_all(other, node, true);
      break;
    case FaultKind::kRelayReset:
      for (std::size_t i = world_.network.connections_between(node, other); i > 0; --i) {
        world_.network.reset(node, other, i - 1);
      }
      break;
    case FaultKind::kRelayAlters:
      slave.set_altering(true);
      world_.oracle.scenes().on_altering(static_cast<std::size_t>(fault.slave));
      break;
    default:
      break;
  }
}

void Faults::end_relay_fault(const Fault& fault) {
  SimSlave& slave = *world_.slaves[static_cast<std::size_t>(fault.slave)];
  const int node = slave.node(), other = peer_of(fault);
  world_.network.heal(node, other);
  world_.network.heal(other, node);
  stall_all(other, node, false);
  slave.set_altering(false);
}

// Machine of the other slave that a fault between two meets: one that the slave has a connection
// with, where it has any when the fault begins.
int Faults::peer_of(const Fault& fault) {
  const auto [entry, is_new] = peers_.try_emplace(&fault, -1);
  if (!is_new) return entry->second;
  const int node = world_.slaves[static_cast<std::size_t>(fault.slave)]->node();
  std::vector<int> linked, all;
  for (const auto& other : world_.slaves) {
    if (other->node() == node) continue;
    all.push_back(other->node());
    if (world_.network.connections_between(node, other->node()) > 0) linked.push_back(all.back());
  }
  const std::vector<int>& choice = linked.empty() ? all : linked;
  entry->second = choice[static_cast<std::size_t>(fault.variant) % choice.size()];
  return entry->second;
}

void Faults::stall_all(int from, int to, bool is_stalled) {
  for (std::size_t i = 0; i < world_.network.connections_between(from, to); ++i) {
    world_.network.stall(from, to, i, is_stalled);
  }
}

void Faults::end(const Fault& fault) {
  if (is_between_slaves(fault)) return end_relay_fault(fault);
  switch (fault.kind) {
    case FaultKind::kMasterCrash:
      if (!world_.master.is_running()) {
        world_.master.start();
        world_.oracle.on_master_started();
      }
      return;
    case FaultKind::kMasterHang:
      return world_.master.set_hung(false);
    case FaultKind::kAppCrash:
      return world_.app.start();
    case FaultKind::kAppHang:
    case FaultKind::kAppPause:
      return world_.app.set_hung(false);
    case FaultKind::kWrongClock:
      return world_.network.set_refusing(world_.master.node(), false);
    case FaultKind::kAppCancels:
      return;
    default:
      return end_slave_fault(fault);
  }
}

void Faults::end_slave_fault(const Fault& fault) {
  const auto index = static_cast<std::size_t>(fault.slave);
  SimSlave& slave = *world_.slaves[index];
  const int node = slave.node(), master = world_.master.node();
  world_.oracle.set_gone(index, false);
  slave.set_hung(false);
  slave.set_frozen(false);
  world_.network.heal(node, master);
  world_.network.heal(master, node);
  if (fault.kind == FaultKind::kStallOne) {
    for (const std::size_t which : {std::size_t{0}, std::size_t{1}}) {
      world_.network.stall(node, master, which, false);
      world_.network.stall(master, node, which, false);
    }
  }
  world_.network.link(node) = plan_.slaves[index].link;
  if (!slave.is_running()) slave.start();
}

}  // namespace tessera::sim
