// An application's end of the protocol: handshake, heartbeats, scene upload, frames submitted and
// received. The state behind RemoteSession, on its own net thread.
//
// Threads. Io thread only; callbacks run there. Never waits.
//
// Invariants. (1) on_ended comes once, and nothing after it. (2) Scene pieces are queued only while
// the connection's send queue is below its bound. (3) A frame is handed on only when all its bytes
// came and their digest is the one announced.
#pragma once

#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <string>

#include "common/base/clock.h"
#include "common/net/connection.h"
#include "common/scene/scene_codec.h"
#include "common/wire/messages.h"
#include "master/session/session.h"

namespace tessera::master {

class AppClient {
 public:
  struct Callbacks {
    std::function<void()> on_welcome;
    std::function<void(FrameResult)> on_frame;
    std::function<void(ClusterStatus)> on_status;
    std::function<void(Status)> on_ended;  // refused, closed, silent, protocol error
  };

  AppClient(net::IoThread& io, net::ConnectionPtr connection, wire::Role role, std::string name,
            Callbacks callbacks);
  ~AppClient();  // says goodbye

  void commit_scene(SceneVersion version, EncodedScene scene);
  void submit(FrameId frame, SceneVersion version, const FrameSettings& settings);
  void cancel_all();
  void request_status();

 private:
  struct IncomingFrame {
    FrameSettings settings;
    std::shared_ptr<FrameImage> image;
    std::uint64_t received_bytes = 0;
  };
  struct Upload {
    SceneVersion version = 0;
    std::uint32_t block = 0;
    std::uint64_t offset = 0;
  };

  void send(wire::Message message);
  void on_record(net::ReceivedRecord record);
  void handle(wire::Message message);
  void handle_frame_chunk(const wire::FrameChunk& chunk);
  void handle_frame_done(wire::FrameDone done);
  void pump_uploads();
  void heartbeat();
  void end(Status reason);

  net::IoThread& io_;
  net::ConnectionPtr connection_;
  Callbacks callbacks_;
  net::Timer heartbeat_timer_;
  std::uint32_t heartbeat_ms_;
  std::uint32_t heartbeats_missed_max_;
  std::map<SceneVersion, EncodedScene> scenes_;  // not yet acknowledged
  std::deque<Upload> uploads_;                   // blocks asked for, in order
  std::map<FrameId, IncomingFrame> frames_;      // submitted, not done
  bool has_ended_ = false;
};

}  // namespace tessera::master
