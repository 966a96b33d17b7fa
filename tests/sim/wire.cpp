// SPDX-License-Identifier: Apache-2.0
#include "tests/sim/wire.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <utility>

namespace tessera::sim {
namespace {

constexpr std::uint64_t kSegmentBytes = 16 * 1024;
// A TCP sender tries again at growing intervals: after a cut it may be this late.
constexpr std::chrono::milliseconds kRetryFirst{200}, kRetryMax{1500};

// Copies what a socket would have copied.
net::ReceivedRecord received(const net::Record& record) {
  return {record.type, record.header,
          std::vector<std::byte>(record.payload.bytes.begin(), record.payload.bytes.end())};
}

class WireEnd final : public net::Connection {
 public:
  WireEnd(std::shared_ptr<Wire> wire, int side) : wire_(std::move(wire)), side_(side) {}
  ~WireEnd() override { wire_->close(side_, Duration::zero()); }

  void start(net::ConnectionCallbacks callbacks, const net::RecordLimits& limits) override {
    wire_->start(side_, std::move(callbacks), limits);
  }
  void set_limits(const net::RecordLimits& limits) override { wire_->set_limits(side_, limits); }
  void send(net::Record record) override { wire_->send(side_, std::move(record)); }
  std::uint64_t queue_bytes() const override { return end().queue_bytes; }
  void end_soon(Status why) override { wire_->end(side_, std::move(why)); }
  void close(std::chrono::milliseconds grace) override { wire_->close(side_, grace); }
  const net::PeerIdentity& peer() const override { return end().peer; }
  std::uint64_t bytes_sent() const override { return end().bytes_sent; }
  std::uint64_t bytes_received() const override { return end().bytes_received; }
  TimePoint last_received() const override { return end().last_received; }
  TimePoint last_sent() const override { return end().last_sent; }

 private:
  const Wire::End& end() const { return wire_->end_of(side_); }

  const std::shared_ptr<Wire> wire_;
  const int side_;
};

}  // namespace

Wire::Wire(Network& network, Process& a, Process& b) : network_(network) {
  const TimePoint now = network.queue_.now();
  const std::array<Process*, 2> processes = {&a, &b};
  for (std::size_t i = 0; i < 2; ++i) {
    ends_[i].process = processes[i];
    ends_[i].node = processes[i]->node();
    ends_[i].last_sent = ends_[i].last_received = now;
    ends_[i].peer.address = Network::address_of(processes[1 - i]->node());
  }
}

net::ConnectionPtr Wire::make_end(int side) {
  return std::make_shared<WireEnd>(shared_from_this(), side);
}

bool Wire::is_over() const {
  return std::all_of(std::begin(ends_), std::end(ends_), [](const End& end) {
    return end.state == State::kClosed || end.state == State::kDead;
  });
}

bool Wire::connects(int a, int b) const {
  return (ends_[0].node == a && ends_[1].node == b) || (ends_[0].node == b && ends_[1].node == a);
}

void Wire::start(int side, net::ConnectionCallbacks callbacks, const net::RecordLimits& limits) {
  End& end = ends_[side];
  end.callbacks = std::move(callbacks);
  end.limits = limits;
  end.is_started = true;
  end.process->post([self = shared_from_this(), side] { self->take(side); });
}

void Wire::send(int side, net::Record record) {
  End& end = ends_[side];
  if (end.state != State::kOpen) return;
  const std::uint64_t bytes =
      net::kRecordHeadBytes + record.header.size() + record.payload.bytes.size();
  if (end.queue_bytes + bytes > net::kSendQueueBytesMax) {
    return this->end(side, Status::resource_exhausted("its send queue is full"));
  }
  if (network_.events.on_sent) network_.events.on_sent(*end.process, ends_[1 - side].node, record);
  end.queue_bytes += bytes;
  end.was_above_low = end.was_above_low || end.queue_bytes > net::kSendQueueLowBytes;
  end.queue.push_back({std::move(record), bytes, 0});
  if (network_.events.on_queued) {
    network_.events.on_queued(*end.process, ends_[1 - side].node, end.queue_bytes);
  }
  pump(side);
}

void Wire::pump(int side) {
  while (send_segment(side)) {
  }
}

// Sends a segment, one at a time on the uplink. Returns: whether another may follow at once.
bool Wire::send_segment(int side) {
  End& end = ends_[side];
  if (end.is_transmitting || end.state == State::kDead || end.is_fin_sent) return false;
  const int to = ends_[1 - side].node;
  if (end.is_stalled || !network_.passes(end.node, to) || !network_.passes(to, end.node)) {
    // The window still takes a little; what matters is that nothing comes through.
    if (!std::exchange(end.is_held, true)) end.held_since = network_.queue_.now();
    return false;
  }
  if (end.queue.empty()) {
    if (end.state == State::kClosing || end.state == State::kClosed) {
      end.is_fin_sent = true;
      end.state = State::kClosed;
      Segment fin;
      fin.is_fin = true;
      transmit(side, std::move(fin));
    }
    return false;
  }
  if (end.unread_bytes >= network_.window_bytes_) return false;
  Outgoing& next = end.queue.front();
  Segment segment;
  segment.bytes = std::min(next.total_bytes - next.sent_bytes, kSegmentBytes);
  next.sent_bytes += segment.bytes;
  end.unread_bytes += segment.bytes;
  end.bytes_sent += segment.bytes;
  end.last_sent = network_.queue_.now();
  segment.is_last = next.sent_bytes == next.total_bytes;
  if (segment.is_last) {
    end.queue_bytes -= next.total_bytes;
    segment.record = std::move(next.record);
    end.queue.pop_front();
    if (end.was_above_low && end.queue_bytes < net::kSendQueueLowBytes) {
      end.was_above_low = false;
      end.process->post([self = shared_from_this(), side] {
        const End& mine = self->ends_[side];
        const auto on_drained = mine.callbacks.on_drained;
        if (mine.state == State::kOpen && on_drained) on_drained();
      });
    }
  }
  network_.bytes_[{end.node, to}] += segment.bytes;
  transmit(side, std::move(segment));
  return true;
}

void Wire::transmit(int side, Segment segment) {
  End& end = ends_[side];
  const int to = ends_[1 - side].node;
  const auto time_of = [&](double rate) {
    return rate > 0 ? from_seconds(static_cast<double>(segment.bytes) / rate) : Duration::zero();
  };
  EventQueue& queue = network_.queue_;
  Network::Node& sender = network_.nodes_[static_cast<std::size_t>(end.node)];
  Network::Node& receiver = network_.nodes_[static_cast<std::size_t>(to)];
  const Duration up = time_of(sender.link.up_bytes_per_s);
  const Duration down = time_of(receiver.link.down_bytes_per_s);
  const TimePoint gone = sender.up_free = std::max(queue.now(), sender.up_free) + up;
  const auto self = shared_from_this();
  if (up > Duration::zero()) {
    end.is_transmitting = true;
    queue.at(gone, [self, side] {
      self->ends_[side].is_transmitting = false;
      self->pump(side);
    });
  }
  end.last_arrival = std::max(end.last_arrival, gone + network_.travel(end.node, to));
  auto arrival = [self, side, segment = std::move(segment)]() mutable {
    self->arrive(1 - side, std::move(segment));
  };
  // The segment goes through the downlink, even if that is fast by now: what waits there goes
  // first.
  queue.at(end.last_arrival,
           [&queue, &network = network_, to, down, arrival = std::move(arrival)]() mutable {
             Network::Node& node = network.nodes_[static_cast<std::size_t>(to)];
             if (down == Duration::zero() && node.down_free < queue.now()) return arrival();
             node.down_free = std::max(queue.now(), node.down_free) + down;
             queue.at(node.down_free, std::move(arrival));
           });
}

// A segment arrives at the machine of `side`, whose process reads it when it gets to it.
void Wire::arrive(int side, Segment segment) {
  End& end = ends_[side];
  if (end.state == State::kDead) {  // the system answers for a process that is gone
    if (!segment.is_fin) {
      network_.queue_.after(network_.travel(end.node, ends_[1 - side].node),
                            [self = shared_from_this(), side] {
                              self->end(1 - side, Status::unavailable("connection reset by peer"));
                            });
    }
    return;
  }
  // Both ends may be over and forgotten by the network, and then the process may be gone, too.
  if (end.state == State::kClosed) return deliver(side, std::move(segment));
  const Duration cost = segment.is_last ? end.process->record_cost : Duration::zero();
  end.arrived.push_back(std::move(segment));
  if (!end.is_started) return;
  end.process->run_now(cost, [self = shared_from_this(), side] { self->take(side); });
}

void Wire::take(int side) {
  End& end = ends_[side];
  if (!end.is_started) return;
  while (!end.arrived.empty() && end.state != State::kDead) {
    Segment segment = std::move(end.arrived.front());
    end.arrived.pop_front();
    deliver(side, std::move(segment));
  }
}

void Wire::deliver(int side, Segment segment) {
  End& end = ends_[side];
  End& sender = ends_[1 - side];
  sender.unread_bytes -= segment.bytes;
  if (!sender.queue.empty()) pump(1 - side);
  if (segment.is_fin) {
    drop_queue(end);
    if (end.state == State::kOpen) return tell_closed(side, Status::unavailable("the peer closed"));
    end.state = State::kClosed;
    return;
  }
  if (end.state != State::kOpen) return;
  end.bytes_received += segment.bytes;
  end.last_received = network_.queue_.now();
  if (!segment.is_last) return;
  const net::RecordLimit& limit = end.limits[segment.record.type % net::kRecordTypesMax];
  if (static_cast<std::int64_t>(segment.record.header.size()) > limit.header_bytes_max ||
      static_cast<std::int64_t>(segment.record.payload.bytes.size()) > limit.payload_bytes_max) {
    drop_queue(end);
    return tell_closed(side,
                       Status::data_loss("a record of type " + std::to_string(segment.record.type) +
                                         " is not allowed here, or too long"));
  }
  network_.queue_.fold(segment.record.type + 64 * segment.bytes);
  const auto on_record = end.callbacks.on_record;  // it may destroy the end
  if (on_record) on_record(received(segment.record));
}

void Wire::tell_closed(int side, Status status) {
  End& end = ends_[side];
  end.state = State::kClosed;
  pump(side);  // the other end hears of it
  const auto on_closed = std::exchange(end.callbacks, {}).on_closed;
  if (on_closed) on_closed(std::move(status));
}

void Wire::drop_queue(End& end) {
  end.queue.clear();
  end.queue_bytes = 0;
}

void Wire::close(int side, Duration grace) {
  End& end = ends_[side];
  if (end.state == State::kClosed || end.state == State::kDead) return;
  end.callbacks = {};
  if (grace == Duration::zero() || end.queue.empty()) drop_queue(end);
  const bool was_closing = end.state == State::kClosing;
  end.state = State::kClosing;
  if (grace > Duration::zero() && !end.queue.empty() && !was_closing) {
    network_.queue_.after(grace, [self = shared_from_this(), side] {
      self->drop_queue(self->ends_[side]);
      self->pump(side);
    });
  }
  pump(side);
}

void Wire::set_stalled(int from_side, bool is_stalled) {
  ends_[from_side].is_stalled = is_stalled;
  if (!is_stalled) wake();
}

void Wire::wake() {
  for (int side : {0, 1}) {
    End& end = ends_[side];
    if (!std::exchange(end.is_held, false)) continue;
    const Duration outage = network_.queue_.now() - end.held_since;
    const Duration late =
        from_seconds(network_.random_.unit() * seconds(std::min<Duration>(outage, kRetryMax)));
    network_.queue_.after(std::max<Duration>(late, kRetryFirst),
                          [self = shared_from_this(), side] { self->pump(side); });
  }
}

void Wire::kill(int side, bool is_silent) {
  End& end = ends_[side];
  if (end.state == State::kDead) return;
  const bool was_closed = end.state == State::kClosed;
  end.state = State::kDead;
  end.callbacks = {};
  end.process = nullptr;
  end.arrived.clear();
  drop_queue(end);
  if (is_silent || was_closed || end.is_fin_sent) return;
  const int to = ends_[1 - side].node;
  if (!network_.passes(end.node, to)) return;  // the reset is lost
  end.is_fin_sent = true;
  Segment fin;
  fin.is_fin = true;
  transmit(side, std::move(fin));
}

void Wire::reset() {
  for (int side : {0, 1}) end(side, Status::unavailable("connection reset"));
}

void Wire::end(int side, Status status) {
  End& end = ends_[side];
  if (end.state != State::kOpen && end.state != State::kClosing) return;
  drop_queue(end);
  end.process->post([self = shared_from_this(), side, status = std::move(status)] {
    End& mine = self->ends_[side];
    if (mine.state == State::kOpen) {
      self->tell_closed(side, status);
    } else if (mine.state == State::kClosing) {
      mine.state = State::kClosed;
    }
  });
}

}  // namespace tessera::sim
