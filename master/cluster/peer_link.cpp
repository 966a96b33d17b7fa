// SPDX-License-Identifier: Apache-2.0
#include "master/cluster/peer_link.h"

#include <algorithm>
#include <utility>

#include "common/base/clock.h"
#include "common/wire/codec.h"
#include "master/cluster/master_metrics.h"

namespace tessera::master {
namespace {

constexpr std::chrono::milliseconds kFarewell{500};  // to send the last record
constexpr std::size_t kPingsMax = 32;                // 8 s of them: no round trip is longer
constexpr double kRttWeight = 0.125;                 // of the newest sample, as in RFC 6298

std::uint64_t now_ns() { return nanoseconds(Clock::now()); }

// Whether this process was asleep since the last beat. A round trip over our own sleep would raise
// the mean, and a peer's death would be noticed late.
bool has_slept(const net::Liveness& liveness, TimePoint now) {
  return now > liveness.due() + liveness.heartbeat() / 2;
}

}  // namespace

PeerLink::PeerLink(net::EventLoop& io, net::ConnectionPtr connection,
                   const net::RecordLimits& limits, Callbacks callbacks)
    : connection_(std::move(connection)), callbacks_(std::move(callbacks)), heartbeat_(io) {
  net::ConnectionCallbacks link;
  link.on_record = [this](net::ReceivedRecord record) { on_record(std::move(record)); };
  link.on_closed = [this](Status status) { end(std::move(status)); };
  link.on_drained = [this] {
    if (const auto on_drained = callbacks_.on_drained) on_drained();
  };
  connection_->start(std::move(link), limits);
}

PeerLink::~PeerLink() { close(); }

void PeerLink::set_callbacks(Callbacks callbacks) {
  if (!is_over_) callbacks_ = std::move(callbacks);
}

void PeerLink::start_heartbeat(const net::Pulse& pulse) {
  liveness_ = net::Liveness({std::max(pulse.heartbeat_ms, 2u), pulse.missed_max});
  pings_heard_ = net::PingAllowance(pulse);
  connection_->set_record_grace(liveness_.silence_max());
  beat();
}

void PeerLink::send(wire::Message message) {
  if (!is_over_) connection_->send(wire::encode(std::move(message)));
}

void PeerLink::refuse(wire::RefuseCode code, const std::string& reason) {
  if (is_over_) return;
  master_metrics().refusals[static_cast<std::size_t>(code)].add();
  send(wire::Refuse{code, reason});
  const Callbacks dropped = let_go(kFarewell);
}

void PeerLink::say_goodbye(const std::string& reason) {
  if (is_over_) return;
  send(wire::Goodbye{reason});
  const Callbacks dropped = let_go(kFarewell);
}

void PeerLink::close() {
  if (is_over_) return;
  const Callbacks dropped = let_go(std::chrono::milliseconds(0));
}

PeerLink::Callbacks PeerLink::let_go(std::chrono::milliseconds grace) {
  is_over_ = true;
  heartbeat_.cancel();
  connection_->close(grace);
  return std::exchange(callbacks_, {});
}

std::string PeerLink::peer_text() const {
  const net::PeerIdentity& peer = connection_->peer();
  return peer.is_authenticated ? peer.role + " '" + peer.name + "' at " + peer.address
                               : peer.address;
}

void PeerLink::on_record(net::ReceivedRecord record) {
  if (is_over_) return;
  auto message = wire::decode(std::move(record));
  if (!message.is_ok()) return break_off(message.status());
  if (const auto* ping = std::get_if<wire::Ping>(&*message)) {
    if (!pings_heard_.admit(Clock::now()))
      return break_off(Status::data_loss("Ping far more often than once a heartbeat"));
    return send(wire::Pong{ping->sent_ns, now_ns()});
  }
  if (const auto* pong = std::get_if<wire::Pong>(&*message)) return on_pong(*pong);
  const auto on_message = callbacks_.on_message;  // a copy: the call may destroy us
  on_message(std::move(*message));
}

// A peer that hears no acknowledgement sends the same packets again, of which nothing is new to us.
void PeerLink::watch_silence() {
  const net::LinkCounters counters = connection_->link_counters();
  silence_ = counters.segments_heard == segments_heard_ ? Silence::kWhole
             : counters.on_the_way_bytes > 0            ? Silence::kOneWay
                                                        : Silence::kOfProcess;
}

void PeerLink::break_off(const Status& breach) {
  master_metrics().refusals[static_cast<std::size_t>(wire::RefuseCode::kProtocol)].add();
  send(wire::Refuse{wire::RefuseCode::kProtocol, breach.message()});
  end(breach);
}

void PeerLink::ping() {
  const TimePoint now = Clock::now();
  pinged_ = now;
  pings_.push_back(now);
  if (pings_.size() > kPingsMax) pings_.pop_front();
  send(wire::Ping{nanoseconds(now)});
}

// A pong that answers none of our pings tells nothing.
void PeerLink::on_pong(const wire::Pong& pong) {
  const auto sent = std::find_if(pings_.begin(), pings_.end(),
                                 [&](TimePoint ping) { return nanoseconds(ping) == pong.sent_ns; });
  if (sent == pings_.end()) return;
  const TimePoint now = Clock::now();
  if (has_slept(liveness_, now)) return pings_.clear();
  if (pong.answered_ns != 0) clock_.add(*sent, now, pong.answered_ns);
  const double sample = seconds(now - *sent);
  rtt_seconds_ += (rtt_seconds_ == 0 ? 1 : kRttWeight) * (sample - rtt_seconds_);
  pings_.erase(pings_.begin(), sent + 1);
}

void PeerLink::beat() {
  using std::chrono::milliseconds;
  const TimePoint now = Clock::now();
  if (has_slept(liveness_, now)) pings_.clear();
  liveness_.set_rtt(from_seconds(rtt_seconds_));
  if (connection_->last_received() != heard_at_) {
    heard_at_ = connection_->last_received();
    segments_heard_ = connection_->link_counters().segments_heard;
  }
  switch (liveness_.look(now, connection_->last_sent(), connection_->last_received())) {
    case net::LivenessAction::kNone:
      break;
    case net::LivenessAction::kPing:
      ping();
      break;
    case net::LivenessAction::kDead:
      watch_silence();
      return end(Status::deadline_exceeded("silent for too long"));
  }
  // Pings go out also while other records do: the round trip is wanted most when the link is busy.
  if (now - pinged_ >= liveness_.heartbeat()) ping();
  heartbeat_.start_once(std::chrono::ceil<milliseconds>(liveness_.due() - now), [this] { beat(); });
}

void PeerLink::end(Status status) {
  if (is_over_) return;
  const Callbacks last = let_go(kFarewell);
  if (last.on_ended) last.on_ended(std::move(status));  // the call may destroy us
}

}  // namespace tessera::master
