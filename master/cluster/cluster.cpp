// SPDX-License-Identifier: Apache-2.0
#include "master/cluster/cluster.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/base/check.h"
#include "common/base/entropy.h"
#include "common/base/limits.h"
#include "common/base/log.h"
#include "common/wire/codec.h"
#include "common/wire/record_types.h"
#include "master/cluster/master_metrics.h"
#include "master/cluster/reception.h"

namespace tessera::master {
namespace {

constexpr std::chrono::milliseconds kSweep{500};

// Pulse of a slave: slower than usual when its connecting had a long round trip.
net::Pulse pulse_of(const net::Pulse& slaves, const PeerLink& link, const std::string& name) {
  const Duration rtt = from_seconds(link.connection().peer().rtt_seconds);
  const std::chrono::milliseconds usual(slaves.heartbeat_ms);
  const auto heartbeat =
      std::min(net::heartbeat_for(usual, static_cast<int>(slaves.missed_max), rtt),
               std::chrono::milliseconds(wire::kHeartbeatMsMax));
  if (heartbeat > usual) {
    log_warn("heartbeat-raised",
             "slave '" + name + "' is far away: its silence is noticed later than usual",
             {{"rtt_ms", std::to_string(std::llround(1e3 * seconds(rtt)))},
              {"heartbeat_ms", std::to_string(heartbeat.count())}});
  }
  return {static_cast<std::uint32_t>(heartbeat.count()), slaves.missed_max};
}

}  // namespace

Cluster::Cluster(net::EventLoop& io, std::optional<Isa> isa, bool is_isa_mixed,
                 ClusterEvents events, bool is_relaying, const net::Pulse& pulse)
    : io_(io),
      wanted_isa_(isa),
      is_isa_mixed_(is_isa_mixed),
      events_(std::move(events)),
      is_relaying_(is_relaying),
      pulse_(pulse),
      cause_(2 * pulse.silence_max()),
      sweep_(io),
      gentle_pump_(io),
      not_offered_timer_(io) {
  sweep_.start_repeating(kSweep, [this] { sweep(); });
}

Cluster::~Cluster() = default;

std::optional<std::pair<wire::RefuseCode, std::string>> Cluster::refusal_of(
    const wire::Hello& hello, const net::PeerIdentity& peer) const {
  if (const auto held = quarantine_.find(key_of(hello, peer), Clock::now())) {
    return std::pair(wire::RefuseCode::kFull,
                     "slave '" + held->name + "' is held back for " +
                         std::to_string(static_cast<int>(std::ceil(held->seconds))) +
                         " s more: " + held->reason);
  }
  for (const auto& [session, slave] : slaves_) {
    const net::PeerIdentity& other = slave->tile_link->connection().peer();
    if (peer.is_authenticated && other.name == peer.name) {
      return std::pair(wire::RefuseCode::kName,
                       "the certificate '" + peer.name + "' is in use by slave '" +
                           slave->hello.name +
                           "'; make this one its own with 'tessera-keys add DIR slave NAME'");
    }
    if (slave->hello.name == hello.name) {
      return std::pair(
          wire::RefuseCode::kName,
          "the name '" + hello.name + "' is used twice; give this slave another --name");
    }
  }
  const std::optional<Isa> needed = bound_isa_ ? bound_isa_ : wanted_isa_;
  if (needed && !is_isa_mixed_ && (hello.isas & isa_bit(*needed)) == 0) {
    return std::pair(wire::RefuseCode::kIsa,
                     "this session renders with " + std::string(isa_name(*needed)) +
                         ", which slave '" + hello.name +
                         "' does not have; start the master with --isa-policy mixed to admit it");
  }
  if (hello.threads == 0 || (hello.isas & kIsaMaskAll) == 0) {
    return std::pair(wire::RefuseCode::kProtocol,
                     std::string("a slave needs threads and an instruction set"));
  }
  return std::nullopt;
}

// Calls the slave by its name in force. A slave inside this process, which has no certificate,
// makes way for who has that name in one: its owner could never mend the conflict.
void Cluster::take_name(const PeerLink& link, wire::Hello& hello) {
  const net::PeerIdentity& peer = link.connection().peer();
  std::string name = name_in_force(peer, hello);
  if (name != hello.name) {
    log_info("slave-renamed",
             "a slave that calls itself '" + hello.name + "' is called as its certificate, '" +
                 name + "'",
             {{"peer", link.peer_text()}});
    hello.name = std::move(name);
  }
  if (!peer.is_authenticated) return;
  const auto other = std::find_if(slaves_.begin(), slaves_.end(), [&](const auto& entry) {
    return entry.second->hello.name == hello.name &&
           !entry.second->tile_link->connection().peer().is_authenticated;
  });
  if (other != slaves_.end())
    lose(other->first, "its name is that of a certificate, whose owner is here");
}

const std::string& Cluster::key_of(const wire::Hello& hello, const net::PeerIdentity& peer) {
  return peer.is_authenticated ? peer.name : hello.name;
}

PeerLink::Callbacks Cluster::callbacks_of(SessionId session, bool is_tile_link) {
  PeerLink::Callbacks callbacks;
  callbacks.on_message = [this, session, is_tile_link](wire::Message message) {
    is_tile_link ? on_tile_message(session, std::move(message))
                 : on_scene_message(session, std::move(message));
  };
  callbacks.on_ended = [this, session, is_tile_link](const Status& status) {
    lose(session, status.message(), kind_of(session, status, is_tile_link));
  };
  if (!is_tile_link) {
    callbacks.on_drained = [this, session] {
      const auto slave = slaves_.find(session);
      if (slave == slaves_.end()) return;
      set_pace(session);
      slave->second->sender->pump();
    };
  }
  return callbacks;
}

void Cluster::on_hello(std::unique_ptr<PeerLink> link, wire::Hello hello, std::uint16_t version) {
  take_name(*link, hello);
  welcome_back(hello, link->connection().peer());
  if (const auto refusal = refusal_of(hello, link->connection().peer())) {
    log_warn("slave-refused", refusal->second,
             {{"slave", hello.name}, {"peer", link->peer_text()}});
    return link->refuse(refusal->first, refusal->second);
  }
  const SessionId session = entropy();
  auto slave = std::make_unique<SlaveEntry>();
  slave->hello = std::move(hello);
  slave->token = entropy();
  link->set_callbacks(callbacks_of(session, true));
  const net::Pulse pulse = pulse_of(pulse_, *link, slave->hello.name);
  slave->pulse = pulse;
  link->send(wire::Welcome{version, session, slave->token, pulse.heartbeat_ms, pulse.missed_max,
                           events_.certificate_wanted != nullptr});
  link->start_heartbeat(pulse);
  link->ping();
  slave->tile_link = std::move(link);
  slaves_[session] = std::move(slave);
}

void Cluster::on_join(std::unique_ptr<PeerLink> link, const wire::Join& join) {
  const auto found = slaves_.find(join.session);
  const bool is_good = found != slaves_.end() && found->second->token == join.token &&
                       !found->second->is_joined() &&
                       found->second->tile_link->connection().peer().name ==
                           link->connection().peer().name;  // both connections of one certificate
  if (!is_good) {
    log_warn("join-refused", "a scene connection for a session that does not exist",
             {{"peer", link->peer_text()}});
    return link->refuse(wire::RefuseCode::kSession, "no such session; connect anew");
  }
  SlaveEntry& slave = *found->second;
  if (bound_isa_ && !is_isa_mixed_ && (slave.hello.isas & isa_bit(*bound_isa_)) == 0) {
    link->refuse(wire::RefuseCode::kIsa,
                 "the session was bound to " + std::string(isa_name(*bound_isa_)) + " meanwhile");
    return lose(join.session, "it does not have the session's instruction set");
  }
  link->set_callbacks(callbacks_of(join.session, false));
  link->send(wire::Joined{});
  link->start_heartbeat(slave.pulse);
  link->ping();
  slave.scene_link = std::move(link);
  slave.sender = std::make_unique<SceneSender>(
      *slave.scene_link, [this, session = join.session](SceneVersion version, std::uint64_t bytes) {
        return feed_by_slave(session, version, bytes);
      });
  join_relay(join.session);
  slave.ordinal = next_ordinal_++;
  cause_.joined();
  master_metrics().slaves_joined.add();
  if (names_seen_.contains(slave.hello.name)) master_metrics().reconnects.add();
  if (names_seen_.size() < kConnectionsMax) names_seen_.insert(slave.hello.name);
  log_info("slave-joined", "slave '" + slave.hello.name + "' is here",
           {{"peer", slave.tile_link->connection().peer().address},
            {"threads", std::to_string(slave.hello.threads)},
            {"isa", std::string(isa_name(widest_isa(slave.hello.isas)))}});
  for (const auto& [version, scene] : scenes_) {
    slave.sender->need(version);
    offer(join.session, version, scene);
  }
  const net::PeerIdentity& peer = slave.tile_link->connection().peer();
  events_.slave_joined(
      join.session,
      {slave.hello.name, peer.is_authenticated ? peer.name : "", slave.hello.instance},
      slave.hello.threads);
}

std::size_t Cluster::slave_count() const {
  return static_cast<std::size_t>(std::count_if(
      slaves_.begin(), slaves_.end(), [](const auto& entry) { return entry.second->is_joined(); }));
}

Isa Cluster::bind_isa() {
  if (bound_isa_) return *bound_isa_;
  if (wanted_isa_) {
    bound_isa_ = wanted_isa_;
    return *bound_isa_;
  }
  IsaMask common = kIsaMaskAll;
  for (const auto& [session, slave] : slaves_) {
    if (slave->is_joined()) common &= slave->hello.isas;
  }
  bound_isa_ = widest_isa(common != 0 ? common : isa_bit(Isa::kScalar));
  return *bound_isa_;
}

Isa Cluster::isa_of(SessionId session) const {
  TESSERA_CHECK(bound_isa_.has_value());
  const auto slave = slaves_.find(session);
  if (slave == slaves_.end() || (slave->second->hello.isas & isa_bit(*bound_isa_)) != 0)
    return *bound_isa_;
  return widest_isa(slave->second->hello.isas);
}

void Cluster::send(SessionId session, wire::Message message) {
  const auto slave = slaves_.find(session);
  if (slave == slaves_.end()) return;
  watch_frames(session, message);
  slave->second->tile_link->send(std::move(message));
}

void Cluster::on_tile_message(SessionId session, wire::Message message) {
  const auto slave = slaves_.find(session);
  if (slave == slaves_.end()) return;
  if (!slave->second->is_joined() && !std::holds_alternative<wire::Goodbye>(message)) {
    return expel(session,
                 std::string(wire::message_name(message)) + " before the scene connection stands");
  }
  if (auto* result = std::get_if<wire::TileResult>(&message)) {
    events_.tile_result(session, std::move(*result));
  } else if (auto* returned = std::get_if<wire::TileReturned>(&message)) {
    events_.tile_returned(session, *returned);
  } else if (auto* goodbye = std::get_if<wire::Goodbye>(&message)) {
    leave(session, goodbye->reason);
  } else if (auto* refuse = std::get_if<wire::Refuse>(&message)) {
    lose(session, "refused us: " + refuse->reason);
  } else {
    expel(session,
          std::string(wire::message_name(message)) + " does not belong on a tile connection");
  }
}

void Cluster::on_scene_message(SessionId session, wire::Message message) {
  const auto slave = slaves_.find(session);
  if (slave == slaves_.end()) return;
  SceneSender& sender = *slave->second->sender;
  set_pace(session);
  if (auto* need = std::get_if<wire::SceneNeed>(&message)) {
    if (const Status status = sender.on_need(*need); !status.is_ok())
      expel(session, status.message());
  } else if (auto* need = std::get_if<wire::SceneChunkNeed>(&message)) {
    if (const Status status = sender.on_chunk_need(std::move(*need)); !status.is_ok())
      expel(session, status.message());
  } else if (auto* built = std::get_if<wire::SceneBuilt>(&message)) {
    const auto scene = scenes_.find(built->version);
    if (scene == scenes_.end()) return sender.on_answered(built->version);  // retired
    const SceneSummary summary = summarizer_.of(scene->second->blocks);
    if (built->scene != summary.digest) {
      const std::string reason = "slave '" + slave->second->hello.name +
                                 "' built another scene than the one it was sent: its digest is " +
                                 built->scene.hex() + "; look for broken memory there";
      log_error("scene-differs", reason, {{"version", std::to_string(built->version)}});
      relay_.gave_up(session, built->version);  // what it has is fit for nobody
      sender.on_answered(built->version);
      return events_.scene_failed(session, built->version, reason);
    }
    slave->second->built = std::max(slave->second->built, built->version);
    relay_.complete(session, built->version, summary.bytes);
    sender.on_answered(built->version);
    events_.scene_built(session, *built);
  } else if (const auto* progress = std::get_if<wire::SceneProgress>(&message)) {
    relay_.progress(session, progress->version, progress->bytes, Clock::now());
  } else if (const auto* relay_failed = std::get_if<wire::RelayFailed>(&message)) {
    on_relay_failed(session, *relay_failed);
  } else if (auto* failed = std::get_if<wire::SceneFailed>(&message)) {
    on_scene_failed(session, std::move(*failed));
  } else if (auto* request = std::get_if<wire::CertificateRequest>(&message)) {
    on_certificate_request(session, std::move(*request));
  } else if (auto* goodbye = std::get_if<wire::Goodbye>(&message)) {
    leave(session, goodbye->reason);
  } else if (auto* refuse = std::get_if<wire::Refuse>(&message)) {
    lose(session, "refused us: " + refuse->reason);
  } else {
    expel(session,
          std::string(wire::message_name(message)) + " does not belong on a scene connection");
  }
}

void Cluster::on_certificate_request(SessionId session, wire::CertificateRequest request) {
  if (!events_.certificate_wanted)
    return expel(session, "CertificateRequest, though Welcome did not offer certificates");
  events_.certificate_wanted(slaves_.at(session)->scene_link->connection().peer(),
                             std::move(request.der), [this, session](wire::CertificateGrant grant) {
                               const auto slave = slaves_.find(session);
                               if (slave == slaves_.end()) return;
                               slave->second->scene_link->send(std::move(grant));
                             });
}

// Loses slaves that said Hello but never opened a scene connection; ends utilisation windows.
void Cluster::sweep() {
  log_summaries();
  const TimePoint now = Clock::now();
  watch_relay();
  std::vector<SessionId> late;
  for (auto& [session, slave] : slaves_) {
    if (!slave->is_joined() && now - slave->since > std::chrono::milliseconds(kHandshakeMs))
      late.push_back(session);
    if (slave->is_joined() && slave->tile_link->rtt_seconds() > 0)
      events_.round_trip(session, slave->tile_link->rtt_seconds());
    if (const double window = seconds(now - slave->window_start); window >= 1) {
      const double available = window * slave->hello.threads;
      slave->utilisation = std::clamp(slave->busy_seconds / available, 0.0, 1.0);
      slave->busy_seconds = 0;
      slave->tiles_per_second =
          static_cast<double>(slave->tiles_done - slave->tiles_at_window) / window;
      slave->tiles_at_window = slave->tiles_done;
      slave->window_start = now;
    }
  }
  for (const SessionId session : late) lose(session, "the scene connection did not come in time");
}

bool Cluster::forgive_repeat(SessionId session) {
  const auto slave = slaves_.find(session);
  return slave == slaves_.end() ||
         ++slave->second->repeats <=
             slave->second->hello.threads * std::uint32_t{kTilesPerWorkerMax};
}

void Cluster::count_tile(SessionId session) {
  if (const auto slave = slaves_.find(session); slave != slaves_.end()) ++slave->second->tiles_done;
}

void Cluster::add_busy_time(SessionId session, double render_seconds) {
  const auto slave = slaves_.find(session);
  if (slave == slaves_.end()) return;
  slave->second->busy_seconds += render_seconds;
  slave->second->tile_times.add(render_seconds);
}

std::uint16_t Cluster::ordinal_of(SessionId session) const {
  const auto slave = slaves_.find(session);
  return slave == slaves_.end() ? std::uint16_t{0} : slave->second->ordinal;
}

std::string Cluster::name_of(SessionId session) const {
  const auto slave = slaves_.find(session);
  return slave == slaves_.end() ? std::string() : slave->second->hello.name;
}

void Cluster::shutdown() {
  sweep_.cancel();
  gentle_pump_.cancel();
  for (auto& [session, slave] : slaves_) {
    slave->tile_link->say_goodbye("the master ends");
    if (slave->is_joined()) slave->scene_link->say_goodbye("the master ends");
  }
  slaves_.clear();
}

}  // namespace tessera::master
