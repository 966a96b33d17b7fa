#include "master/session/app_client.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "common/base/limits.h"
#include "common/base/version.h"
#include "common/wire/codec.h"

namespace tessera::master {
namespace {

// Scene pieces are queued while less than this waits in the send queue: a few pieces, so that a
// frame submitted meanwhile waits for tens of milliseconds on a slow link, not for the whole scene.
constexpr std::uint64_t kUploadQueueBytesMax = 2 * kSceneChunkBytesMax;

std::uint64_t now_ns() {
  return static_cast<std::uint64_t>(
      std::chrono::duration_cast<std::chrono::nanoseconds>(Clock::now().time_since_epoch())
          .count());
}

}  // namespace

AppClient::AppClient(net::IoThread& io, net::ConnectionPtr connection, wire::Role role,
                     std::string name, Callbacks callbacks)
    : io_(io),
      connection_(std::move(connection)),
      callbacks_(std::move(callbacks)),
      heartbeat_timer_(io),
      heartbeat_ms_(kHeartbeatMs),
      heartbeats_missed_max_(kHeartbeatsMissedMax) {
  net::ConnectionCallbacks link;
  link.on_record = [this](net::ReceivedRecord record) { on_record(std::move(record)); };
  link.on_closed = [this](Status status) { end(std::move(status)); };
  link.on_drained = [this] { pump_uploads(); };
  connection_->start(std::move(link), wire::session_limits());
  wire::Hello hello;
  hello.role = role;
  hello.name = std::move(name);
  hello.build_id = kBuildId;
  send(std::move(hello));
  heartbeat_timer_.start_repeating(std::chrono::milliseconds(heartbeat_ms_ / 2),
                                   [this] { heartbeat(); });
}

AppClient::~AppClient() {
  if (has_ended_) return;
  send(wire::Goodbye{"the application ends"});
  connection_->close(std::chrono::milliseconds(500));
}

void AppClient::send(wire::Message message) { connection_->send(wire::encode(std::move(message))); }

void AppClient::commit_scene(SceneVersion version, EncodedScene scene) {
  if (has_ended_) return;
  wire::SceneAnnounce announce;
  announce.version = version;
  for (const SceneBlock& block : scene.blocks) {
    announce.digests.push_back(block.digest);
    announce.sizes.push_back(block.bytes->size());
  }
  scenes_[version] = std::move(scene);
  send(std::move(announce));
}

void AppClient::submit(FrameId frame, SceneVersion version, const FrameSettings& settings) {
  IncomingFrame incoming;
  incoming.settings = settings;
  frames_[frame] = std::move(incoming);
  if (!has_ended_) send(wire::FrameSubmit{frame, version, settings});
}

void AppClient::cancel_all() {
  if (has_ended_) return;
  for (const auto& [frame, incoming] : frames_) send(wire::FrameCancel{frame});
}

void AppClient::request_status() {
  if (!has_ended_) send(wire::StatusRequest{});
}

void AppClient::on_record(net::ReceivedRecord record) {
  auto message = wire::decode(std::move(record));
  if (!message.is_ok()) return end(message.status());
  handle(std::move(*message));
}

void AppClient::handle(wire::Message message) {
  if (auto* welcome = std::get_if<wire::Welcome>(&message)) {
    heartbeat_ms_ = std::max(welcome->heartbeat_ms, 1u);
    heartbeats_missed_max_ = welcome->heartbeats_missed_max;
    heartbeat_timer_.start_repeating(std::chrono::milliseconds(std::max(heartbeat_ms_ / 2, 1u)),
                                     [this] { heartbeat(); });
    if (callbacks_.on_welcome) callbacks_.on_welcome();
  } else if (auto* refuse = std::get_if<wire::Refuse>(&message)) {
    end(Status::unavailable("the master refused: " + refuse->reason));
  } else if (auto* ping = std::get_if<wire::Ping>(&message)) {
    send(wire::Pong{ping->sent_ns});
  } else if (auto* need = std::get_if<wire::SceneNeed>(&message)) {
    const auto scene = scenes_.find(need->version);
    for (const std::uint32_t block : need->blocks) {
      if (scene == scenes_.end() || block >= scene->second.blocks.size()) {
        return end(Status::data_loss("the master asked for a scene block that was not announced"));
      }
      uploads_.push_back({need->version, block, 0});
    }
    pump_uploads();
  } else if (auto* built = std::get_if<wire::SceneBuilt>(&message)) {
    scenes_.erase(scenes_.begin(), scenes_.upper_bound(built->version));
  } else if (auto* failed = std::get_if<wire::SceneFailed>(&message)) {
    end(Status::invalid_argument("the master cannot hold the scene: " + failed->reason));
  } else if (auto* chunk = std::get_if<wire::FrameChunk>(&message)) {
    handle_frame_chunk(*chunk);
  } else if (auto* done = std::get_if<wire::FrameDone>(&message)) {
    handle_frame_done(std::move(*done));
  } else if (auto* status = std::get_if<wire::StatusReply>(&message)) {
    if (callbacks_.on_status) callbacks_.on_status(std::move(status->status));
  } else if (auto* goodbye = std::get_if<wire::Goodbye>(&message)) {
    end(Status::unavailable("the master said goodbye: " + goodbye->reason));
  } else if (!std::holds_alternative<wire::Pong>(message)) {
    end(Status::data_loss(std::string("the master sent ") + wire::message_name(message) +
                          ", which an application never gets"));
  }
}

void AppClient::handle_frame_chunk(const wire::FrameChunk& chunk) {
  const auto found = frames_.find(chunk.frame);
  if (found == frames_.end())
    return end(Status::data_loss("the master sent a frame that was not asked for"));
  IncomingFrame& frame = found->second;
  if (!frame.image) {
    frame.image = std::make_shared<FrameImage>();
    frame.image->width_px = frame.settings.width_px;
    frame.image->height_px = frame.settings.height_px;
    frame.image->format = frame.settings.pixel_format;
    frame.image->tile_edge_px = frame.settings.tile_edge_px;
    frame.image->bytes.resize(
        static_cast<std::size_t>(frame.settings.width_px) *
        static_cast<std::size_t>(frame.settings.height_px) *
        static_cast<std::size_t>(bytes_per_pixel(frame.settings.pixel_format)));
  }
  auto& bytes = frame.image->bytes;
  if (chunk.offset != frame.received_bytes ||
      chunk.bytes.bytes.size() > bytes.size() - frame.received_bytes) {
    return end(Status::data_loss("the master sent pieces of a frame out of order"));
  }
  std::memcpy(bytes.data() + chunk.offset, chunk.bytes.bytes.data(), chunk.bytes.bytes.size());
  frame.received_bytes += chunk.bytes.bytes.size();
}

void AppClient::handle_frame_done(wire::FrameDone done) {
  const auto found = frames_.find(done.stats.frame);
  if (found == frames_.end())
    return end(Status::data_loss("the master finished a frame that was not asked for"));
  IncomingFrame frame = std::move(found->second);
  frames_.erase(found);
  FrameResult result;
  result.frame = done.stats.frame;
  result.stats = done.stats;
  if (!done.error.empty()) {
    result.status = Status::unavailable(done.error);
  } else if (!frame.image || frame.received_bytes != frame.image->bytes.size() ||
             frame.image->digest() != done.stats.digest) {
    return end(Status::data_loss("a frame arrived incomplete or damaged"));
  } else {
    frame.image->tile_slave = std::move(done.tile_slave);
    result.image = std::move(frame.image);
  }
  callbacks_.on_frame(std::move(result));
}

void AppClient::pump_uploads() {
  while (!has_ended_ && !uploads_.empty() && connection_->queue_bytes() < kUploadQueueBytesMax) {
    Upload& upload = uploads_.front();
    const auto scene = scenes_.find(upload.version);
    if (scene == scenes_.end()) {
      uploads_.pop_front();
      continue;
    }
    const BlockBytes& bytes = scene->second.blocks[upload.block].bytes;
    const std::uint64_t size =
        std::min<std::uint64_t>(bytes->size() - upload.offset, kSceneChunkBytesMax / 4);
    net::SharedBytes piece{bytes, std::span(*bytes).subspan(upload.offset, size)};
    send(wire::SceneChunk{upload.version, upload.block, upload.offset, std::move(piece)});
    upload.offset += size;
    if (upload.offset == bytes->size()) uploads_.pop_front();
  }
}

void AppClient::heartbeat() {
  if (has_ended_) return;
  const auto interval = std::chrono::milliseconds(heartbeat_ms_);
  const TimePoint now = Clock::now();
  if (now - connection_->last_received() > interval * (heartbeats_missed_max_ + 1)) {
    return end(Status::unavailable("the master has been silent for too long"));
  }
  if (now - connection_->last_sent() >= interval) send(wire::Ping{now_ns()});
  pump_uploads();
}

void AppClient::end(Status reason) {
  if (has_ended_) return;
  has_ended_ = true;
  heartbeat_timer_.cancel();
  connection_->close();
  callbacks_.on_ended(std::move(reason));
}

}  // namespace tessera::master
