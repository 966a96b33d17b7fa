// SPDX-License-Identifier: Apache-2.0
#include "master/frame_loop/app_server.h"

#include <algorithm>
#include <utility>

#include "common/base/log.h"
#include "common/wire/codec.h"
#include "common/wire/record_types.h"

namespace tessera::master {
namespace {

constexpr std::uint64_t kPieceBytes = 512 * 1024;  // of a frame on its way to the application
static_assert(kPieceBytes <= kFrameChunkBytesMax && kPieceBytes < net::kSendQueueLowBytes);
constexpr std::size_t kStatusClientsMax = 64;
static_assert(kAppHeartbeatsMissedMax <= wire::kHeartbeatsMissedLimit);
static_assert(net::Pulse::kMissedMost <= wire::kHeartbeatsMissedLimit);
static_assert(net::Pulse::kHeartbeatMsMost <= wire::kHeartbeatMsMax);

}  // namespace

void AppServer::on_hello(std::unique_ptr<PeerLink> link, const wire::Hello& hello,
                         std::uint16_t version) {
  const bool is_app = hello.role == wire::Role::kApp;
  if (is_app && is_same_process(hello, link->connection().peer()))
    drop_application("its process is here with a new link");
  if (is_app && application_) {
    return turn_away(
        *link, hello, wire::RefuseCode::kBusy,
        "busy: application '" + application_->name + "' is connected; try again when it has ended");
  }
  if (!is_app && status_clients_.size() >= kStatusClientsMax)
    return turn_away(*link, hello, wire::RefuseCode::kFull, "too many status clients");
  const SessionId session = ++next_session_;
  const net::Pulse pulse = is_app ? net::application_pulse(pulse_) : pulse_;
  link->send(wire::Welcome{version, session, session, pulse.heartbeat_ms, pulse.missed_max,
                           is_app && certificate_wanted_ != nullptr});
  link->start_heartbeat(pulse);
  if (is_app) {
    add_application(session, std::move(link), hello);
  } else {
    add_status_client(session, std::move(link));
  }
}

void AppServer::turn_away(PeerLink& link, const wire::Hello& hello, wire::RefuseCode code,
                          const std::string& reason) {
  const bool is_app = hello.role == wire::Role::kApp;
  log_warn(is_app ? "application-refused" : "watcher-refused", reason,
           {{"name", hello.name}, {"peer", link.peer_text()}});
  link.refuse(code, reason);
}

// Whether the peer is the application itself, whose old link only seems to stand.
bool AppServer::is_same_process(const wire::Hello& hello, const net::PeerIdentity& peer) const {
  if (!application_ || hello.instance == 0 || hello.instance != application_->instance)
    return false;
  const net::PeerIdentity& known = application_->link->connection().peer();
  return peer.is_authenticated == known.is_authenticated && peer.name == known.name;
}

void AppServer::add_application(SessionId session, std::unique_ptr<PeerLink> link,
                                const wire::Hello& hello) {
  log_info("application-joined", "application '" + hello.name + "' is here",
           {{"peer", link->peer_text()}});
  PeerLink::Callbacks callbacks;
  callbacks.on_message = [this, session](wire::Message message) {
    if (is_application(session)) on_message(std::move(message));
  };
  callbacks.on_ended = [this, session](const Status& status) {
    if (is_application(session)) drop_application(status.message());
  };
  callbacks.on_drained = [this, session] {
    if (is_application(session)) pump();
  };
  link->set_callbacks(std::move(callbacks));
  application_ = std::make_shared<Application>(wire::SceneReceiver(
      [this](std::uint64_t) { return frames_.free_bytes(); }, wire::SceneReceiver::Use::kKept));
  application_->session = session;
  application_->instance = hello.instance;
  const net::PeerIdentity& peer = link->connection().peer();
  application_->name = peer.is_authenticated ? peer.name : hello.name;
  application_->link = std::move(link);
  frames_.set_outcome_callback([this](FrameOutcome outcome) { on_outcome(std::move(outcome)); });
}

void AppServer::add_status_client(SessionId session, std::unique_ptr<PeerLink> link) {
  PeerLink::Callbacks callbacks;
  callbacks.on_message = [this, session](const wire::Message& message) {
    on_status_message(session, message);
  };
  callbacks.on_ended = [this, session](const Status& status) {
    on_status_client_ended(session, status);
  };
  link->set_callbacks(std::move(callbacks));
  status_clients_.emplace(session, std::move(link));
}

void AppServer::on_status_message(SessionId session, const wire::Message& message) {
  const auto client = status_clients_.find(session);
  if (client == status_clients_.end()) return;
  PeerLink& link = *client->second;
  if (const auto* request = std::get_if<wire::StatusRequest>(&message))
    return link.send(status_reply(*request));
  if (!std::holds_alternative<wire::Goodbye>(message)) {
    const std::string what = wire::message_name(message);
    log_warn("watcher-refused", "a status client may only ask for the status, and sent " + what,
             {{"peer", link.peer_text()}});
    link.refuse(wire::RefuseCode::kRole, "a status client may only ask for the status");
  }
  status_clients_.erase(client);
}

// One that closes its connection has its answer, or no time left to wait for it.
void AppServer::on_status_client_ended(SessionId session, const Status& status) {
  const auto client = status_clients_.find(session);
  if (client == status_clients_.end()) return;
  if (status.code() != StatusCode::kUnavailable) {
    log_warn("watcher-refused", "a status client was closed: " + status.message(),
             {{"peer", client->second->peer_text()}});
  }
  status_clients_.erase(client);
}

wire::StatusReply AppServer::status_reply(const wire::StatusRequest& request) const {
  wire::StatusReply reply{frames_.status(), request.wants_details};
  if (request.wants_events) {
    LogMemory log = log_memory();
    reply.status.events = std::move(log.events);
    reply.status.suppressed = std::move(log.suppressed);
  }
  return reply;
}

void AppServer::on_message(wire::Message message) {
  wire::SceneReceiver::Actions actions;
  if (auto* announce = std::get_if<wire::SceneAnnounce>(&message)) {
    const Status status = application_->receiver.announce(std::move(*announce), actions);
    on_scene(status, std::move(actions));
  } else if (auto* chunk = std::get_if<wire::SceneChunk>(&message)) {
    const Status status = application_->receiver.chunk(*chunk, actions);
    on_scene(status, std::move(actions));
  } else if (auto* list = std::get_if<wire::SceneChunkList>(&message)) {
    const Status status = application_->receiver.list(std::move(*list), actions);
    on_scene(status, std::move(actions));
  } else if (auto* retire = std::get_if<wire::SceneRetire>(&message)) {
    application_->receiver.retire(retire->first_kept, actions);
    for (const wire::FrameSubmit& waiting : std::deque(application_->waiting)) {
      if (waiting.version >= retire->first_kept) continue;
      fail_waiting(waiting.version, Status::unavailable("its scene was retired"));
    }
    on_scene(Status::ok(), std::move(actions));
  } else if (auto* submit = std::get_if<wire::FrameSubmit>(&message)) {
    on_submit(std::move(*submit));
  } else if (auto* cancel = std::get_if<wire::FrameCancel>(&message)) {
    on_cancel(cancel->frame);
  } else if (auto* request = std::get_if<wire::StatusRequest>(&message)) {
    application_->link->send(status_reply(*request));
  } else if (auto* wish = std::get_if<wire::CertificateRequest>(&message)) {
    on_certificate_request(std::move(*wish));
  } else if (auto* goodbye = std::get_if<wire::Goodbye>(&message)) {
    drop_application("said goodbye: " + goodbye->reason);
  } else {
    violation(std::string(wire::message_name(message)) + " is not for an application to send");
  }
}

void AppServer::on_certificate_request(wire::CertificateRequest request) {
  if (!certificate_wanted_)
    return violation("CertificateRequest, though Welcome did not offer certificates");
  certificate_wanted_(application_->link->connection().peer(), std::move(request.der),
                      [this, session = application_->session](wire::CertificateGrant grant) {
                        if (is_application(session)) application_->link->send(std::move(grant));
                      });
}

void AppServer::on_scene(const Status& status, wire::SceneReceiver::Actions actions) {
  if (!status.is_ok()) return violation(status.message());
  for (wire::SceneReceiver::Complete& complete : actions.complete) {
    application_->unweighed.push_back(std::move(complete));
    weigh_next();
    if (!application_) return;
  }
  for (wire::SceneFailed& failed : actions.failed) {
    log_warn("scene-refused", "application '" + application_->name + "': " + failed.reason,
             {{"version", std::to_string(failed.version)}});
    fail_waiting(failed.version, Status::unavailable("its scene failed: " + failed.reason));
    application_->link->send(std::move(failed));
  }
  for (wire::SceneNeed& need : actions.need) application_->link->send(std::move(need));
  for (wire::SceneChunkNeed& need : actions.chunk_need) {
    application_->link->send(std::move(need));
  }
}

// Scenes are committed in their order, so one is weighed after the other. Those that wait are
// bounded by the frames that wait for them: a frame comes before the scene that follows its own, so
// all but the newest are passed over where none wants them.
void AppServer::weigh_next() {
  auto& unweighed = application_->unweighed;
  const auto& waiting = application_->waiting;
  const auto is_wanted = [&](SceneVersion version) {
    return std::any_of(waiting.begin(), waiting.end(),
                       [=](const wire::FrameSubmit& frame) { return frame.version == version; });
  };
  for (auto scene = unweighed.begin(); scene != unweighed.end() && scene + 1 != unweighed.end();) {
    if (is_wanted(scene->version)) {
      ++scene;
      continue;
    }
    application_->link->send(wire::SceneBuilt{scene->version, 0, 0, {}});
    scene = unweighed.erase(scene);
  }
  if (application_->is_weighing || unweighed.empty()) return;
  application_->is_weighing = true;
  const SceneVersion version = unweighed.front().version;
  EncodedScene scene = std::move(unweighed.front().scene);
  unweighed.pop_front();
  frames_.weigh(std::move(scene),
                [this, session = application_->session, version](EncodedScene weighed) {
                  if (is_application(session)) on_weighed(version, std::move(weighed));
                });
}

void AppServer::on_weighed(SceneVersion version, EncodedScene scene) {
  application_->is_weighing = false;
  const SceneVersion ours = next_version_++;
  application_->versions.clear();  // the loop keeps older ones for frames in work only
  application_->versions[version] = ours;
  frames_.commit_scene(ours, std::move(scene));
  application_->link->send(wire::SceneBuilt{version, 0, 0, {}});
  submit_waiting();  // before the next version replaces this one
  if (application_) weigh_next();
}

void AppServer::on_submit(wire::FrameSubmit submit) {
  if (frames_open() >= kOutstandingMax) {
    return violation("more than " + std::to_string(kOutstandingMax) + " frames submitted at once");
  }
  application_->waiting.push_back(std::move(submit));
  submit_waiting();
}

// Frames keep their order: one that waits for its scene holds up those behind it.
void AppServer::submit_waiting() {
  auto& waiting = application_->waiting;
  const auto& versions = application_->versions;
  while (!waiting.empty()) {
    const auto version = versions.find(waiting.front().version);
    if (version == versions.end()) {
      const bool is_past = !versions.empty() && waiting.front().version < versions.rbegin()->first;
      if (!is_past) return;  // its blocks are on their way
      return violation("a frame of scene version " + std::to_string(waiting.front().version) +
                       ", which is not here");
    }
    const FrameId ours = next_frame_++;
    application_->frames[ours] = {waiting.front().frame, waiting.front().version};
    const FrameSettings settings = waiting.front().settings;
    waiting.pop_front();  // first: the outcome may come back at once
    frames_.submit(ours, version->second, settings);
    if (!application_) return;
  }
}

void AppServer::on_cancel(FrameId theirs) {
  for (const auto& [ours, submitted] : application_->frames) {
    if (submitted.frame == theirs) return frames_.cancel(ours);
  }
  const auto waits = [theirs](const wire::FrameSubmit& s) { return s.frame == theirs; };
  if (std::erase_if(application_->waiting, waits) == 0) return;  // on its way back already
  give_back(theirs, Status::cancelled("cancelled"));
}

void AppServer::fail_waiting(SceneVersion version, const Status& status) {
  auto& waiting = application_->waiting;
  for (auto frame = waiting.begin(); frame != waiting.end();) {
    if (frame->version != version) {
      ++frame;
      continue;
    }
    const FrameId theirs = frame->frame;
    frame = waiting.erase(frame);
    give_back(theirs, status);
  }
}

// Gives back a frame that never reached the loop.
void AppServer::give_back(FrameId theirs, const Status& status) {
  Delivery delivery;
  delivery.outcome.frame = delivery.outcome.stats.frame = theirs;
  delivery.outcome.status = status;
  application_->deliveries.push_back(std::move(delivery));
  pump();
}

void AppServer::on_outcome(FrameOutcome outcome) {
  if (!application_) return;
  const auto frame = application_->frames.find(outcome.frame);
  if (frame == application_->frames.end()) return;
  outcome.frame = outcome.stats.frame = frame->second.frame;
  outcome.stats.scene_version = frame->second.version;
  application_->frames.erase(frame);
  application_->deliveries.push_back({std::move(outcome), 0});
  pump();
}

void AppServer::pump() {
  if (!application_) return;
  PeerLink& link = *application_->link;
  auto& deliveries = application_->deliveries;
  while (!deliveries.empty() && link.connection().queue_bytes() <= net::kSendQueueLowBytes) {
    Delivery& delivery = deliveries.front();
    const auto& image = delivery.outcome.image;
    if (image && delivery.sent_bytes < image->bytes.size()) {
      const std::uint64_t size =
          std::min<std::uint64_t>(image->bytes.size() - delivery.sent_bytes, kPieceBytes);
      net::SharedBytes piece{image, std::span(image->bytes).subspan(delivery.sent_bytes, size)};
      link.send(wire::FrameChunk{delivery.outcome.frame, delivery.sent_bytes, std::move(piece)});
      delivery.sent_bytes += size;
      continue;
    }
    wire::FrameDone done;
    done.stats = delivery.outcome.stats;
    done.error = delivery.outcome.status.message();
    done.is_final = delivery.outcome.status.code() == StatusCode::kResourceExhausted;
    if (image) done.tile_slave = image->tile_slave;
    link.send(std::move(done));
    deliveries.pop_front();
  }
}

void AppServer::violation(const std::string& reason) {
  application_->link->refuse(wire::RefuseCode::kProtocol, reason);
  drop_application("protocol violation: " + reason);
}

void AppServer::drop_application(const std::string& reason) {
  if (!application_) return;
  const auto gone = std::exchange(application_, nullptr);
  io_.post([gone] {});  // callers above us on the stack may still read it
  log_info("application-left", "application '" + gone->name + "' is gone", {{"reason", reason}});
  gone->link->close();
  frames_.cancel_all();
  frames_.free_scenes();
}

void AppServer::shutdown() {
  if (application_) application_->link->say_goodbye("the master ends");
  for (const auto& [session, client] : status_clients_) client->say_goodbye("the master ends");
  application_.reset();
  status_clients_.clear();
}

}  // namespace tessera::master
