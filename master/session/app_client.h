// SPDX-License-Identifier: Apache-2.0
// An application's end of one link: handshake, scene upload, frames submitted and received. Above
// it is LastingClient, which goes from link to link; below it are the same link and scene sender
// that a master uses towards its slaves.
//
// Threads. Io thread only; callbacks run there, and may destroy the client. Never waits.
//
// Invariants. (1) on_ended comes once, and nothing after it. (2) A frame is handed on only when all
// its bytes came and their digest is the one announced.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>

#include "common/net/event_loop.h"
#include "common/net/key_renewal.h"
#include "common/scene/scene_codec.h"
#include "common/wire/messages.h"
#include "master/cluster/peer_link.h"
#include "master/cluster/scene_sender.h"
#include "master/session/session.h"

namespace tessera::master {

// What an application says of itself in each Hello.
struct AppIdentity {
  wire::Role role = wire::Role::kApp;
  std::string name;
  std::uint64_t instance = 0;  // random number of the process; 0: it does not say
};

class AppClient {
 public:
  struct Callbacks {
    std::function<void()> on_welcome;
    std::function<void(FrameResult)> on_frame;
    std::function<void(ClusterStatus)> on_status;
    // Refused, closed, silent: kUnavailable and others. kDataLoss: one end did not keep to the
    // protocol. kInvalidArgument: the master cannot hold the scene.
    std::function<void(Status)> on_ended;
  };

  AppClient(net::EventLoop& io, net::ConnectionPtr connection, const AppIdentity& identity,
            Callbacks callbacks, const net::RenewalAccess& renewal = {});
  ~AppClient();  // says goodbye

  void commit_scene(SceneVersion version, SharedScene scene);
  void submit(FrameId frame, SceneVersion version, const FrameSettings& settings);
  void cancel_all();
  void request_status(bool wants_events);

 private:
  struct IncomingFrame {
    FrameSettings settings;
    std::shared_ptr<FrameImage> image;
    std::uint64_t received_bytes = 0;
    Sha256 hash;  // of what came so far
    bool is_cancelled = false;
  };

  void on_message(wire::Message message);
  void on_answer(wire::Message message);
  void on_welcome(const wire::Welcome& welcome);
  void renew_when_due();
  void on_frame_chunk(const wire::FrameChunk& chunk);
  void on_frame_done(wire::FrameDone done);
  void on_lost(const Status& reason);
  void end(Status reason);

  Callbacks callbacks_;
  const net::RenewalAccess renewal_;
  PeerLink link_;
  SceneSender scenes_;
  std::map<FrameId, IncomingFrame> frames_;  // submitted, not done
  net::Timer renewal_timer_;
  bool is_welcomed_ = false, has_ended_ = false;
};

}  // namespace tessera::master
