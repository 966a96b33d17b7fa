// SPDX-License-Identifier: Apache-2.0
#include "slave/master_link.h"

#include <algorithm>
#include <utility>

#include "common/base/entropy.h"
#include "common/base/limits.h"
#include "common/base/log.h"
#include "common/wire/codec.h"
#include "slave/slave_metrics.h"

namespace tessera::slave {

namespace {

using std::chrono::milliseconds;

// The log has a line about a master that is not there at most this often.
constexpr std::chrono::seconds kWaitLogPause{5};
// Time for a last word to get out.
constexpr milliseconds kLastWordGrace{200};

milliseconds default_heartbeat() { return milliseconds(kHeartbeatMs); }

std::uint64_t now_ns() { return nanoseconds(Clock::now()); }

}  // namespace

MasterLink::MasterLink(net::EventLoop& io, wire::Hello hello, net::LinkFactory open_link,
                       MasterLinkEvents events)
    : io_(io),
      hello_(std::move(hello)),
      open_link_(std::move(open_link)),
      events_(std::move(events)),
      backoff_(entropy()),
      tile_liveness_(net::Pulse()),
      scene_liveness_(net::Pulse()),
      tick_(io),
      retry_(io) {}

MasterLink::~MasterLink() {
  state_ = State::kEnded;
  close_links(milliseconds(0));
}

void MasterLink::start() { open(State::kTileLink); }

void MasterLink::open(State next) {
  if (next == State::kTileLink) {
    ++generation_;
    parting_tile_.reset();
    parting_scene_.reset();
  }
  state_ = next;
  // The answer goes by way of the queue: the factory may call back from inside its call, and
  // nothing of its own may be destroyed while it is on the stack.
  const auto on_connected = [this, alive = std::weak_ptr<int>(alive_), generation = generation_,
                             next](Result<net::ConnectionPtr> link) {
    if (alive.expired()) return;
    io_.post([this, alive, generation, next, link = std::move(link)]() mutable {
      if (alive.expired() || generation != generation_ || state_ != next) return;
      on_opened(std::move(link));
    });
  };
  attempt_ = open_link_(on_connected);
}

void MasterLink::on_opened(Result<net::ConnectionPtr> link) {
  attempt_.reset();
  if (!link.is_ok()) {
    if (link.status().code() == StatusCode::kPermissionDenied) return lose_refused(link.status());
    return lose(link.status());
  }
  handshake_deadline_ = Clock::now() + milliseconds(kHandshakeMs);
  if (state_ == State::kTileLink) {
    state_ = State::kHello;
    tile_ = std::move(*link);
    watch(tile_, false);
    if (events_.on_reached) events_.on_reached(tile_->peer().local_host, hello_);
    tile_->send(wire::encode(hello_));
    look_again();
  } else {
    state_ = State::kJoin;
    scene_ = std::move(*link);
    watch(scene_, true);
    scene_->set_record_grace(scene_liveness_.silence_max());
    scene_->send(wire::encode(wire::Join{welcome_.version, welcome_.session, welcome_.token}));
  }
}

void MasterLink::watch(const net::ConnectionPtr& link, bool is_scene) {
  net::ConnectionCallbacks callbacks;
  const auto is_current = [this, generation = generation_] {
    return generation == generation_ && state_ != State::kIdle && state_ != State::kEnded;
  };
  callbacks.on_record = [this, is_current, is_scene](net::ReceivedRecord record) {
    if (is_current()) on_record(std::move(record), is_scene);
  };
  callbacks.on_closed = [this, is_current](Status status) {
    if (!is_current()) return;
    // The answer to our certificate is a refusal, at first or because it was revoked meanwhile.
    const bool is_answer = state_ == State::kHello;
    if (is_answer && status.code() == StatusCode::kPermissionDenied) return lose_refused(status);
    const std::string text = status.is_ok() ? "the master closed the connection" : status.message();
    const bool may_want_keys = is_answer && !was_welcomed_ && !tile_->peer().is_authenticated;
    lose(Status::unavailable(may_want_keys ? text + "; if it uses keys, give --keys DIR" : text));
  };
  callbacks.on_drained = [this, is_current, is_scene] {
    if (is_current() && !is_scene && state_ == State::kReady) events_.on_drained();
  };
  link->start(std::move(callbacks), wire::session_limits());
}

void MasterLink::on_record(net::ReceivedRecord record, bool is_scene) {
  Result<wire::Message> message = wire::decode(std::move(record));
  if (!message.is_ok()) return break_off(message.status());
  on_message(std::move(*message), is_scene);
}

void MasterLink::on_message(wire::Message message, bool is_scene) {
  net::Connection& link = is_scene ? *scene_ : *tile_;
  if (const auto* ping = std::get_if<wire::Ping>(&message)) {
    return link.send(wire::encode(wire::Pong{ping->sent_ns, now_ns()}));
  }
  if (std::holds_alternative<wire::Pong>(message)) return;
  if (const auto* refuse = std::get_if<wire::Refuse>(&message)) return on_refused(*refuse);
  if (const auto* goodbye = std::get_if<wire::Goodbye>(&message)) {
    return lose(Status::unavailable("the master left: " + goodbye->reason));
  }
  if (const auto* welcome = std::get_if<wire::Welcome>(&message);
      welcome != nullptr && state_ == State::kHello && !is_scene) {
    return on_welcome(*welcome);
  }
  if (std::holds_alternative<wire::Joined>(message) && state_ == State::kJoin && is_scene) {
    return on_joined();
  }
  if (state_ != State::kReady) {
    return break_off(Status::data_loss(std::string(wire::message_name(message)) +
                                       " came before the handshake was complete"));
  }
  const Status status = is_scene ? events_.on_scene_message(std::move(message))
                                 : events_.on_tile_message(std::move(message));
  if (!status.is_ok()) break_off(status);
}

void MasterLink::on_welcome(const wire::Welcome& welcome) {
  if (welcome.version < hello_.version_min || welcome.version > hello_.version_max) {
    return break_off(Status::data_loss("Welcome.version " + std::to_string(welcome.version) +
                                       " was not offered"));
  }
  welcome_ = welcome;
  const net::Pulse pulse{welcome.heartbeat_ms, welcome.heartbeats_missed_max};
  tile_liveness_ = net::Liveness(pulse);
  scene_liveness_ = net::Liveness(pulse);
  tile_->set_record_grace(pulse.silence_max());
  open(State::kSceneLink);
}

void MasterLink::on_joined() {
  state_ = State::kReady;
  was_welcomed_ = true;
  was_wait_logged_ = false;
  refusal_told_.clear();
  backoff_.session_began(Clock::now());
  log_info("master-joined", "joined the master",
           {{"address", tile_->peer().address}, {"session", std::to_string(welcome_.session)}});
  slave_metrics().sessions.add();
  slave_metrics().is_connected.set(1);
  events_.on_ready();
}

void MasterLink::on_refused(const wire::Refuse& refuse) {
  const Status why = Status::unavailable("the master refuses: " + refuse.reason);
  switch (refuse.code) {
    case wire::RefuseCode::kVersion:
      log_warn("version-refused", why.message());
      return lose_for(why, milliseconds(kReconnectMaxMs));
    case wire::RefuseCode::kName:
      // After a break, our own last session may still be closing there; at first the name is used
      // twice.
      if (was_welcomed_) return lose(why);
      return lose_refused(Status::unavailable("the master refuses the name '" + hello_.name +
                                              "', which another slave uses: " + refuse.reason));
    case wire::RefuseCode::kRole:
    case wire::RefuseCode::kIsa:
      return lose_refused(why);
    case wire::RefuseCode::kProtocol:
      log_error("protocol-refused", why.message());
      return lose(why);
    case wire::RefuseCode::kBusy:
    case wire::RefuseCode::kSession:
    case wire::RefuseCode::kFull:
      break;
  }
  lose(why);
}

void MasterLink::on_tick() {
  if (state_ == State::kIdle || state_ == State::kEnded) return;
  if (state_ != State::kReady && Clock::now() > handshake_deadline_ + milliseconds(kHandshakeMs)) {
    return lose(Status::deadline_exceeded("the master did not finish the handshake"));
  }
  if (state_ == State::kHello || state_ == State::kTileLink) return look_again();
  if (!keep_alive(*tile_, tile_liveness_, "tile")) return;
  if (state_ == State::kReady && !keep_alive(*scene_, scene_liveness_, "scene")) return;
  look_again();
}

// Starts the timer for when a link has to be looked at; in the handshake that is often enough to
// end it on time.
void MasterLink::look_again() {
  const TimePoint now = Clock::now();
  const bool is_ready = state_ == State::kReady;
  const TimePoint due = is_ready ? std::min(tile_liveness_.due(), scene_liveness_.due())
                                 : now + default_heartbeat() / 4;
  tick_.start_once(std::chrono::ceil<milliseconds>(std::max(due - now, Duration(milliseconds(1)))),
                   [this] { on_tick(); });
}

bool MasterLink::keep_alive(net::Connection& link, net::Liveness& liveness, const char* which) {
  switch (liveness.look(Clock::now(), link.last_sent(), link.last_received())) {
    case net::LivenessAction::kNone:
      break;
    case net::LivenessAction::kPing:
      link.send(wire::encode(wire::Ping{now_ns()}));
      break;
    case net::LivenessAction::kDead:
      lose(Status::deadline_exceeded("the master was silent on the " + std::string(which) +
                                     " connection for " +
                                     std::to_string(liveness.silence_max().count()) + " ms"));
      return false;
  }
  return true;
}

void MasterLink::break_off(const Status& why) {
  log_error("master-broke-protocol", why.message());
  const wire::Refuse refuse{wire::RefuseCode::kProtocol, why.message()};
  if (tile_) tile_->send(wire::encode(refuse));
  if (scene_) scene_->send(wire::encode(refuse));
  lose(why);
}

void MasterLink::lose(const Status& why) { lose_for(why, backoff_.next()); }

void MasterLink::lose_for(const Status& why, milliseconds pause) {
  const bool was_ready = state_ == State::kReady;
  state_ = State::kIdle;
  close_links(kLastWordGrace);
  backoff_.session_ended(Clock::now());
  if (was_ready) {
    log_warn("master-lost", why.message(), {{"pause_ms", std::to_string(pause.count())}});
    events_.on_lost();
  } else {
    log_waiting(why, pause);
  }
  retry_.start_once(pause, [this] { open(State::kTileLink); });
}

void MasterLink::log_waiting(const Status& why, milliseconds pause) {
  const TimePoint now = Clock::now();
  if (was_wait_logged_ && now - wait_logged_ < kWaitLogPause) return;
  was_wait_logged_ = true;
  wait_logged_ = now;
  const bool is_refused = !refusal_told_.empty() && refusal_told_ == why.message();
  log_event(is_refused ? LogLevel::kWarn : LogLevel::kInfo,
            is_refused ? "master-refuses" : "master-not-there", why.message() + "; will try again",
            {{"pause_ms", std::to_string(pause.count())}});
}

// Says the reason at once where it is another than before, and now and then while it stays.
void MasterLink::lose_refused(const Status& why) {
  if (std::exchange(refusal_told_, why.message()) != why.message()) was_wait_logged_ = false;
  lose(why);
}

void MasterLink::close_links(milliseconds grace) {
  slave_metrics().is_connected.set(0);
  tick_.cancel();
  attempt_.reset();
  if (tile_) tile_->close(grace);
  if (scene_) scene_->close(grace);
  parting_tile_ = std::move(tile_);
  parting_scene_ = std::move(scene_);
  tile_.reset();
  scene_.reset();
}

void MasterLink::send_tile(wire::Message message) {
  if (state_ == State::kReady) tile_->send(wire::encode(std::move(message)));
}

void MasterLink::send_scene(wire::Message message) {
  if (state_ == State::kReady) scene_->send(wire::encode(std::move(message)));
}

std::uint64_t MasterLink::tile_queue_bytes() const {
  return state_ == State::kReady ? tile_->queue_bytes() : 0;
}

net::LinkCounters MasterLink::tile_counters() const {
  return state_ == State::kReady ? tile_->link_counters() : net::LinkCounters{};
}

void MasterLink::leave(const std::string& reason, milliseconds grace) {
  if (state_ == State::kEnded) return;
  if (state_ == State::kReady) send_scene(wire::Goodbye{reason});
  if (tile_) tile_->send(wire::encode(wire::Goodbye{reason}));  // also in mid-handshake
  state_ = State::kEnded;
  retry_.cancel();
  close_links(grace);
}

}  // namespace tessera::slave
