#include "master/cluster/peer_link.h"

#include <algorithm>
#include <utility>

#include "common/base/clock.h"
#include "common/wire/codec.h"

namespace tessera::master {
namespace {

constexpr std::chrono::milliseconds kFarewell{500};  // to send the last record
constexpr double kRttWeight = 0.125;                 // of the newest sample, as in RFC 6298

std::uint64_t now_ns() {
  return static_cast<std::uint64_t>(
      std::chrono::duration_cast<std::chrono::nanoseconds>(Clock::now().time_since_epoch())
          .count());
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

void PeerLink::set_callbacks(Callbacks callbacks) { callbacks_ = std::move(callbacks); }

void PeerLink::start_heartbeat(std::uint32_t heartbeat_ms, std::uint32_t missed_max) {
  liveness_ = net::Liveness(std::chrono::milliseconds(std::max(heartbeat_ms, 2u)),
                            static_cast<int>(missed_max));
  beat();
}

void PeerLink::send(wire::Message message) {
  if (!is_over_) connection_->send(wire::encode(std::move(message)));
}

void PeerLink::refuse(wire::RefuseCode code, const std::string& reason) {
  if (is_over_) return;
  send(wire::Refuse{code, reason});
  is_over_ = true;
  heartbeat_.cancel();
  connection_->close(kFarewell);
}

void PeerLink::say_goodbye(const std::string& reason) {
  if (is_over_) return;
  send(wire::Goodbye{reason});
  is_over_ = true;
  heartbeat_.cancel();
  connection_->close(kFarewell);
}

void PeerLink::close() {
  if (is_over_) return;
  is_over_ = true;
  heartbeat_.cancel();
  connection_->close();
}

std::string PeerLink::peer_text() const {
  const net::PeerIdentity& peer = connection_->peer();
  return peer.is_authenticated ? peer.role + " '" + peer.name + "' at " + peer.address
                               : peer.address;
}

void PeerLink::on_record(net::ReceivedRecord record) {
  if (is_over_) return;
  auto message = wire::decode(std::move(record));
  if (!message.is_ok()) {
    send(wire::Refuse{wire::RefuseCode::kProtocol, message.status().message()});
    return end(message.status());
  }
  if (const auto* ping = std::get_if<wire::Ping>(&*message)) return send(wire::Pong{ping->sent_ns});
  if (const auto* pong = std::get_if<wire::Pong>(&*message)) {
    const double sample = 1e-9 * static_cast<double>(now_ns() - std::min(pong->sent_ns, now_ns()));
    rtt_seconds_ += (rtt_seconds_ == 0 ? 1 : kRttWeight) * (sample - rtt_seconds_);
    return;
  }
  const auto on_message = callbacks_.on_message;  // it may destroy us
  on_message(std::move(*message));
}

void PeerLink::beat() {
  using std::chrono::milliseconds;
  const TimePoint now = Clock::now();
  liveness_.set_rtt(from_seconds(rtt_seconds_));
  switch (liveness_.look(now, connection_->last_sent(), connection_->last_received())) {
    case net::LivenessAction::kNone:
      break;
    case net::LivenessAction::kPing:
      send(wire::Ping{now_ns()});
      break;
    case net::LivenessAction::kDead:
      return end(Status::deadline_exceeded("silent for too long"));
  }
  heartbeat_.start_once(std::chrono::ceil<milliseconds>(liveness_.due() - now), [this] { beat(); });
}

void PeerLink::end(Status status) {
  if (is_over_) return;
  is_over_ = true;
  heartbeat_.cancel();
  connection_->close(kFarewell);
  const auto on_ended = callbacks_.on_ended;  // it may destroy us
  if (on_ended) on_ended(std::move(status));
}

}  // namespace tessera::master
