// SPDX-License-Identifier: Apache-2.0
#include "master/session/app_client.h"

#include <cstring>
#include <utility>

#include "common/base/version.h"
#include "common/wire/codec.h"

namespace tessera::master {

AppClient::AppClient(net::EventLoop& io, net::ConnectionPtr connection, const AppIdentity& identity,
                     Callbacks callbacks, const net::RenewalAccess& renewal)
    : callbacks_(std::move(callbacks)),
      renewal_(renewal),
      link_(io, std::move(connection), wire::session_limits(),
            {[this](wire::Message message) { on_message(std::move(message)); },
             [this](const Status& status) { on_lost(status); }, [this] { scenes_.pump(); }}),
      scenes_(link_),
      renewal_timer_(io) {
  wire::Hello hello;
  hello.role = identity.role;
  hello.name = identity.name;
  hello.instance = identity.instance;
  hello.build_id = kBuildId;
  link_.send(std::move(hello));
  link_.start_heartbeat();
}

AppClient::~AppClient() { link_.say_goodbye("the application ends"); }

void AppClient::commit_scene(SceneVersion version, SharedScene scene) {
  if (!has_ended_) scenes_.commit(version, std::move(scene));
}

void AppClient::submit(FrameId frame, SceneVersion version, const FrameSettings& settings) {
  if (has_ended_) return;
  frames_[frame].settings = settings;
  scenes_.need(version);
  link_.send(wire::FrameSubmit{frame, version, settings});
}

void AppClient::cancel_all() {
  for (auto& [frame, incoming] : frames_) {
    if (std::exchange(incoming.is_cancelled, true)) continue;
    link_.send(wire::FrameCancel{frame});
  }
}

void AppClient::request_status(bool wants_events) {
  link_.send(wire::StatusRequest{true, wants_events});
}

void AppClient::on_message(wire::Message message) {
  if (const auto* chunk = std::get_if<wire::FrameChunk>(&message)) return on_frame_chunk(*chunk);
  if (auto* done = std::get_if<wire::FrameDone>(&message)) return on_frame_done(std::move(*done));
  if (const auto* need = std::get_if<wire::SceneNeed>(&message)) {
    if (Status status = scenes_.on_need(*need); !status.is_ok()) end(std::move(status));
    return;
  }
  if (auto* need = std::get_if<wire::SceneChunkNeed>(&message)) {
    if (Status status = scenes_.on_chunk_need(std::move(*need)); !status.is_ok())
      end(std::move(status));
    return;
  }
  if (const auto* built = std::get_if<wire::SceneBuilt>(&message)) {
    return scenes_.on_answered(built->version);
  }
  on_answer(std::move(message));
}

void AppClient::on_answer(wire::Message message) {
  if (const auto* welcome = std::get_if<wire::Welcome>(&message)) {
    on_welcome(*welcome);
  } else if (auto* status = std::get_if<wire::StatusReply>(&message)) {
    if (const auto on_status = callbacks_.on_status) on_status(std::move(status->status));
  } else if (const auto* grant = std::get_if<wire::CertificateGrant>(&message);
             grant != nullptr && renewal_.granted) {
    renewal_.granted(grant->der, grant->reason);
  } else if (const auto* refuse = std::get_if<wire::Refuse>(&message)) {
    const std::string why = "the master refused: " + refuse->reason;
    end(refuse->code == wire::RefuseCode::kProtocol ? Status::data_loss(why)
                                                    : Status::unavailable(why));
  } else if (const auto* failed = std::get_if<wire::SceneFailed>(&message)) {
    end(Status::invalid_argument("the master cannot hold the scene: " + failed->reason));
  } else if (const auto* goodbye = std::get_if<wire::Goodbye>(&message)) {
    end(Status::unavailable("the master said goodbye: " + goodbye->reason));
  } else {
    end(Status::data_loss(std::string("the master sent ") + wire::message_name(message) +
                          ", which an application never gets"));
  }
}

void AppClient::on_welcome(const wire::Welcome& welcome) {
  is_welcomed_ = true;
  link_.start_heartbeat({welcome.heartbeat_ms, welcome.heartbeats_missed_max});
  if (welcome.issues_certificates && renewal_.request) {
    renewal_timer_.start_repeating(net::kRenewalLook, [this] { renew_when_due(); });
    renew_when_due();
  }
  if (const auto on_welcome = callbacks_.on_welcome) on_welcome();
}

void AppClient::renew_when_due() {
  if (auto request = renewal_.request()) link_.send(wire::CertificateRequest{std::move(*request)});
}

void AppClient::on_frame_chunk(const wire::FrameChunk& chunk) {
  const auto found = frames_.find(chunk.frame);
  if (found == frames_.end())
    return end(Status::data_loss("the master sent a frame that was not asked for"));
  IncomingFrame& frame = found->second;
  if (!frame.image) {
    frame.image = std::make_shared<FrameImage>();
    frame.image->width_px = frame.settings.width_px;
    frame.image->height_px = frame.settings.height_px;
    frame.image->format = frame.settings.pixel_format;
    frame.image->planes = frame.settings.planes;
    frame.image->bytes.resize(frame.image->pixel_count() * frame.image->layout().pixel_bytes());
  }
  auto& bytes = frame.image->bytes;
  if (chunk.offset != frame.received_bytes ||
      chunk.bytes.bytes.size() > bytes.size() - frame.received_bytes) {
    return end(Status::data_loss("the master sent pieces of a frame out of order"));
  }
  std::memcpy(bytes.data() + chunk.offset, chunk.bytes.bytes.data(), chunk.bytes.bytes.size());
  frame.received_bytes += chunk.bytes.bytes.size();
  frame.hash.update(chunk.bytes.bytes);
}

void AppClient::on_frame_done(wire::FrameDone done) {
  const auto found = frames_.find(done.stats.frame);
  if (found == frames_.end())
    return end(Status::data_loss("the master finished a frame that was not asked for"));
  IncomingFrame frame = std::move(found->second);
  frames_.erase(found);
  FrameResult result;
  result.frame = done.stats.frame;
  result.stats = done.stats;
  if (!done.error.empty()) {
    result.status = frame.is_cancelled ? Status::cancelled(done.error)
                    : done.is_final    ? Status::resource_exhausted(done.error)
                                       : Status::unavailable(done.error);
  } else if (!frame.image || frame.received_bytes != frame.image->bytes.size() ||
             frame.hash.finish() != done.stats.digest) {
    return end(Status::data_loss("a frame arrived incomplete or damaged"));
  } else {
    frame.image->tile_edge_px = static_cast<int>(done.stats.tile_edge_px);
    frame.image->tile_slave = std::move(done.tile_slave);
    result.image = std::move(frame.image);
  }
  const auto on_frame = callbacks_.on_frame;
  on_frame(std::move(result));
}

void AppClient::on_lost(const Status& reason) {
  const bool may_want_keys = !is_welcomed_ && !link_.connection().peer().is_authenticated;
  const char* const hint = may_want_keys ? "; if it uses keys, give --keys DIR" : "";
  end({reason.code(), reason.message() + hint});
}

void AppClient::end(Status reason) {
  if (has_ended_) return;
  has_ended_ = true;
  renewal_timer_.cancel();
  link_.close();
  const Callbacks last = std::exchange(callbacks_, {});
  last.on_ended(std::move(reason));
}

}  // namespace tessera::master
