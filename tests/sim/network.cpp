// SPDX-License-Identifier: Apache-2.0
#include "tests/sim/network.h"

#include <algorithm>
#include <utility>

#include "common/base/limits.h"
#include "tests/sim/wire.h"

namespace tessera::sim {
namespace {

constexpr int kSynTries = 2;  // a second apart, within the product's deadline of 2 s

}  // namespace

struct Network::Attempt {
  Process* from = nullptr;
  int to = 0;
  std::function<void(Result<net::ConnectionPtr>)> on_connected;  // null: given up
};

Network::~Network() = default;

int Network::add_node(const LinkModel& link) {
  Node node;
  node.link = link;
  nodes_.push_back(std::move(node));
  return static_cast<int>(nodes_.size()) - 1;
}

int Network::node_of(const std::string& host) const {
  for (int node = 0; node < static_cast<int>(nodes_.size()); ++node) {
    if (host_of(node) == host) return node;
  }
  return -1;
}

Duration Network::travel(int from, int to) {
  const LinkModel& a = nodes_[static_cast<std::size_t>(from)].link;
  const LinkModel& b = nodes_[static_cast<std::size_t>(to)].link;
  const Duration jitter = a.jitter + b.jitter;
  Duration sum = a.delay + b.delay;
  if (jitter > Duration::zero()) sum += from_seconds(random_.unit() * seconds(jitter));
  return sum;
}

void Network::listen(Process& process, OnAccept on_accept) {
  Node& node = nodes_[static_cast<std::size_t>(process.node())];
  node.listener = &process;
  node.on_accept = std::move(on_accept);
}

std::unique_ptr<net::ConnectAttempt> Network::connect(
    Process& from, int to_node, std::function<void(Result<net::ConnectionPtr>)> on_connected) {
  struct Handle final : net::ConnectAttempt {
    explicit Handle(std::shared_ptr<Attempt> a) : attempt(std::move(a)) {}
    ~Handle() override { attempt->on_connected = nullptr; }
    std::shared_ptr<Attempt> attempt;
  };
  auto attempt = std::make_shared<Attempt>(Attempt{&from, to_node, std::move(on_connected)});
  try_connect(attempt, kSynTries);
  return std::make_unique<Handle>(attempt);
}

// A try takes a round trip; the last one ends at the handshake's deadline.
void Network::try_connect(const std::shared_ptr<Attempt>& attempt, int tries_left) {
  const int from = attempt->from->node();
  const int to = attempt->to;
  const auto answer = [attempt](TimePoint time, const std::function<void()>& what) {
    attempt->from->run_at(time, Duration::zero(), [attempt, what] {
      if (attempt->on_connected) what();
    });
  };
  if (to < 0) {
    return answer(queue_.now(), [attempt] {
      std::exchange(attempt->on_connected, {})(Status::unavailable("no machine has this name"));
    });
  }
  if (!passes(from, to) || !passes(to, from)) {
    const auto next = queue_.now() + std::chrono::milliseconds(kHandshakeMs / kSynTries);
    return answer(next, [this, attempt, tries_left] {
      if (tries_left > 1) return try_connect(attempt, tries_left - 1);
      std::exchange(attempt->on_connected, {})(Status::unavailable("no answer within 2 s"));
    });
  }
  const TimePoint there = queue_.now() + travel(from, to);
  const TimePoint back = there + travel(to, from);
  queue_.at(there, [this, attempt, answer, back, to] {
    if (!attempt->on_connected) return;
    Node& node = nodes_[static_cast<std::size_t>(to)];
    if (node.listener == nullptr) {
      return answer(back, [attempt] {
        std::exchange(attempt->on_connected, {})(Status::unavailable("connection refused"));
      });
    }
    if (node.is_refusing) {
      return answer(back, [attempt] {
        std::exchange(attempt->on_connected,
                      {})(Status::permission_denied("the certificate is not valid yet"));
      });
    }
    const auto wire = std::make_shared<Wire>(*this, *attempt->from, *node.listener);
    std::erase_if(wires_, [](const auto& old) { return old->is_over(); });
    wires_.push_back(wire);
    const auto ours = wire->make_end(0);
    node.listener->post(
        [on_accept = node.on_accept, theirs = wire->make_end(1)] { on_accept(theirs); });
    answer(back, [attempt, ours] { std::exchange(attempt->on_connected, {})(ours); });
  });
}

void Network::heal(int from, int to) {
  if (cuts_.erase({from, to}) == 0) return;
  for (const auto& wire : wires_between(from, to)) wire->wake();
}

void Network::heal_all() {
  cuts_.clear();
  for (const auto& wire : std::vector(wires_)) {
    for (const int side : {0, 1}) wire->set_stalled(side, false);
  }
}

std::vector<std::shared_ptr<Wire>> Network::wires_between(int a, int b) {
  std::vector<std::shared_ptr<Wire>> found;
  for (const auto& wire : wires_) {
    if (wire->connects(a, b)) found.push_back(wire);
  }
  return found;
}

void Network::stall(int from, int to, std::size_t which, bool is_stalled) {
  const auto wires = wires_between(from, to);
  if (which >= wires.size()) return;
  wires[which]->set_stalled(wires[which]->node(0) == from ? 0 : 1, is_stalled);
}

void Network::reset(int a, int b, std::size_t which) {
  const auto wires = wires_between(a, b);
  if (which < wires.size()) wires[which]->reset();
}

void Network::reset_all(int node) {
  for (const auto& wire : std::vector(wires_)) {
    if (wire->node(0) == node || wire->node(1) == node) wire->reset();
  }
}

void Network::on_process_ended(const Process& process, bool is_power_lost) {
  Node& node = nodes_[static_cast<std::size_t>(process.node())];
  if (node.listener == &process) {
    node.listener = nullptr;
    node.on_accept = {};
  }
  for (const auto& wire : std::vector(wires_)) {
    for (const int side : {0, 1}) {
      if (wire->belongs_to(side, process)) wire->kill(side, is_power_lost);
    }
  }
}

std::size_t Network::open_ends(const Process& process) const {
  std::size_t count = 0;
  for (const auto& wire : wires_) {
    for (const int side : {0, 1}) {
      count += wire->belongs_to(side, process) && wire->is_open(side) ? 1u : 0u;
    }
  }
  return count;
}

TimePoint Network::heard_from(const Process& process, int node) const {
  TimePoint heard = queue_.now();
  for (const auto& wire : wires_) {
    for (const int side : {0, 1}) {
      if (!wire->belongs_to(side, process) || !wire->is_open(side) || wire->node(1 - side) != node)
        continue;
      const Wire::End& end = wire->end_of(side);
      if (end.bytes_received > 0) heard = std::min(heard, end.last_received);
    }
  }
  return heard;
}

std::uint64_t Network::bytes_between(int from, int to) const {
  const auto found = bytes_.find({from, to});
  return found == bytes_.end() ? 0 : found->second;
}

}  // namespace tessera::sim
