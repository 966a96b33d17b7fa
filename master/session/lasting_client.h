// SPDX-License-Identifier: Apache-2.0
// An application's session that outlives its links: what was said of scenes and frames is kept
// until it is answered, and said again to the master that is found next. So a master may be killed
// and started again, cut off, or silent, and each frame comes all the same, once and in order.
//
//   connecting -> Hello/Welcome -> there -> (link lost) -> away -> connecting ...
//
// Threads. The loop's thread only; callbacks run there, and may destroy the client. Never waits.
//
// Invariants. (1) Each submitted frame has one outcome, in the order of submission, whatever number
// of links it takes. (2) Frames that are given up while the master is away are over at once. (3) It
// keeps the newest scene and those that frames without an outcome show, which its owner bounds by
// the frames that it submits. (4) Before the first Welcome nothing is tried again, since a person
// waits for the word; afterwards everything is, but what repeating cannot mend: a scene that the
// master cannot hold, and kBreachesMax links in a row that end in nonsense without a frame between.
// (5) on_ended comes at most once, and nothing after it.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>

#include "common/net/backoff.h"
#include "common/net/event_loop.h"
#include "common/net/link_factory.h"
#include "master/session/app_client.h"

namespace tessera::master {

class LastingClient {
 public:
  static constexpr int kBreachesMax = 3;

  struct Callbacks {
    std::function<void()> on_welcome;  // by each master, or by one again
    std::function<void(FrameResult)> on_frame;
    std::function<void(ClusterStatus)> on_status;
    std::function<void(const Status& why)> on_away;  // at each failure until the next on_welcome
    std::function<void(Status)> on_ended;
  };

  LastingClient(net::EventLoop& loop, AppIdentity identity, net::LinkFactory open_link,
                Callbacks callbacks, net::RenewalAccess renewal = {});
  ~LastingClient();  // says goodbye

  void start() { connect(); }
  void commit_scene(SceneVersion version, EncodedScene scene);
  // Requires: `version` is the newest that was committed.
  void submit(FrameId frame, SceneVersion version, const FrameSettings& settings);
  void cancel_all();
  // Nothing comes while the master is away.
  void request_status(bool wants_events = false);

 private:
  struct Frame {
    FrameId frame = 0;
    SceneVersion version = 0;
    FrameSettings settings;
    bool is_cancelled = false;
  };

  void connect();
  void on_connected(Result<net::ConnectionPtr> link);
  void on_welcome();
  void on_frame(FrameResult result);
  void lose(const Status& why);
  void end(Status reason);
  void give_up_cancelled();
  void forget_scenes();

  net::EventLoop& loop_;
  const AppIdentity identity_;
  const net::LinkFactory open_link_;
  Callbacks callbacks_;
  const net::RenewalAccess renewal_;  // of the certificate that it shows
  net::Backoff backoff_;
  net::Timer timer_;              // to the next attempt, or of the handshake
  std::uint64_t generation_ = 0;  // of the attempt; what comes from an older one is ignored
  std::unique_ptr<net::ConnectAttempt> attempt_;
  std::unique_ptr<AppClient> client_;  // null while there is no link
  bool is_there_ = false;              // client_ is welcome
  bool was_welcomed_ = false;          // ever
  bool has_ended_ = false;
  int breaches_ = 0;
  std::map<SceneVersion, SharedScene> scenes_;
  std::deque<Frame> frames_;  // without an outcome, in the order of submission
  std::shared_ptr<int> alive_ = std::make_shared<int>(0);
};

}  // namespace tessera::master
