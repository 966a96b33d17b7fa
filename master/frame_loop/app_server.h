// SPDX-License-Identifier: Apache-2.0
// The applications' side of `tessera-master serve`: one application at a time uploads scenes,
// submits frames and takes the finished ones; status clients ask how things are. When the
// application goes, its frames are cancelled, its scenes are freed, the slaves stay.
//
// Threads. Io thread only.
//
// Invariants. (1) At most one application is connected; the next one is told "busy". (2) Callbacks
// of links look their peer up by number; for a peer that is gone they do nothing. (3) Numbers of
// frames and versions inside the frame loop never repeat from one application to the next. (4)
// Pieces of frames are queued only while the send queue is short; pixels are shared with the image,
// never copied.
#pragma once

#include <deque>
#include <map>
#include <memory>
#include <utility>

#include "common/net/event_loop.h"
#include "common/wire/scene_receiver.h"
#include "master/cluster/certificate_wish.h"
#include "master/cluster/peer_link.h"
#include "master/frame_loop/frame_orders.h"

namespace tessera::master {

class AppServer {
 public:
  static constexpr std::size_t kOutstandingMax = 4;  // submitted, not yet sent back

  // `pulse`: of status clients; applications have a longer one (application_pulse()).
  // `certificate_wanted`: by the application; null: this master makes none.
  AppServer(net::EventLoop& io, FrameOrders& frames, const net::Pulse& pulse,
            CertificateWish certificate_wanted)
      : io_(io),
        frames_(frames),
        pulse_(pulse),
        certificate_wanted_(std::move(certificate_wanted)) {}

  void on_hello(std::unique_ptr<PeerLink> link, const wire::Hello& hello, std::uint16_t version);
  bool has_application() const { return application_ != nullptr; }
  // Frames submitted by the application and not yet sent back whole. Requires: has_application().
  std::size_t frames_open() const {
    return application_->frames.size() + application_->waiting.size() +
           application_->deliveries.size();
  }
  void shutdown();

 private:
  // A frame on its way to the application.
  struct Delivery {
    FrameOutcome outcome;  // numbered as the application does
    std::uint64_t sent_bytes = 0;
  };
  // A frame as the application numbers it.
  struct Submitted {
    FrameId frame = 0;
    SceneVersion version = 0;
  };
  struct Application {
    explicit Application(wire::SceneReceiver scenes) : receiver(std::move(scenes)) {}

    SessionId session = 0;
    std::uint64_t instance = 0;  // of its process; 0: it did not say
    std::string name;
    std::unique_ptr<PeerLink> link;
    wire::SceneReceiver receiver;
    std::deque<wire::SceneReceiver::Complete> unweighed;  // in order; one at a time is weighed
    bool is_weighing = false;
    std::map<SceneVersion, SceneVersion> versions;  // theirs -> ours
    std::map<FrameId, Submitted> frames;            // by our number
    std::deque<wire::FrameSubmit> waiting;          // in order, for scenes still on their way
    std::deque<Delivery> deliveries;
  };

  void on_message(wire::Message message);
  void on_certificate_request(wire::CertificateRequest request);
  void on_submit(wire::FrameSubmit submit);
  void submit_waiting();
  void on_cancel(FrameId theirs);
  void fail_waiting(SceneVersion version, const Status& status);
  void give_back(FrameId theirs, const Status& status);
  void on_scene(const Status& status, wire::SceneReceiver::Actions actions);
  void weigh_next();
  void on_weighed(SceneVersion version, EncodedScene scene);
  void on_outcome(FrameOutcome outcome);
  void pump();
  void violation(const std::string& reason);
  void drop_application(const std::string& reason);
  bool is_same_process(const wire::Hello& hello, const net::PeerIdentity& peer) const;
  void add_application(SessionId session, std::unique_ptr<PeerLink> link, const wire::Hello& hello);
  void turn_away(PeerLink& link, const wire::Hello& hello, wire::RefuseCode code,
                 const std::string& reason);
  void add_status_client(SessionId session, std::unique_ptr<PeerLink> link);
  void on_status_client_ended(SessionId session, const Status& status);
  void on_status_message(SessionId session, const wire::Message& message);
  bool is_application(SessionId session) const {
    return application_ != nullptr && application_->session == session;
  }
  wire::StatusReply status_reply(const wire::StatusRequest& request) const;

  net::EventLoop& io_;
  FrameOrders& frames_;
  const net::Pulse pulse_;
  const CertificateWish certificate_wanted_;
  std::shared_ptr<Application> application_;
  std::map<SessionId, std::unique_ptr<PeerLink>> status_clients_;
  SessionId next_session_ = 0;  // of applications and status clients
  FrameId next_frame_ = 0;
  SceneVersion next_version_ = 1;
};

}  // namespace tessera::master
