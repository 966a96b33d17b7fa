// SPDX-License-Identifier: Apache-2.0
// What a frame loop is made of. For the files of the loop alone.
//
// Threads. Net thread only.
//
// Invariants. frames holds every submitted frame until its outcome was delivered.
#pragma once

#include <map>
#include <memory>
#include <set>
#include <vector>

#include "common/base/clock.h"
#include "common/net/event_loop.h"
#include "master/cluster/cluster.h"
#include "master/cluster/master_metrics.h"
#include "master/cluster/reception.h"
#include "master/frame_loop/app_server.h"
#include "master/frame_loop/frame_admission.h"
#include "master/frame_loop/frame_authors.h"
#include "master/frame_loop/frame_loop.h"
#include "master/frame_loop/frame_work.h"
#include "master/frame_loop/loop_gap.h"
#include "master/frame_loop/observer.h"
#include "master/frame_loop/outcome_line.h"
#include "master/frame_loop/scene_costs.h"
#include "master/frame_loop/scene_moments.h"
#include "master/schedule/scheduler.h"
#include "master/schedule/tile_size.h"

namespace tessera::master {

struct FrameLoop::Impl {
  // Interval at which late tiles are looked for. A frame ends at most so much later than it could.
  static constexpr std::chrono::milliseconds kTick{10};

  net::EventLoop& io;
  const FrameLoopOptions options;
  Scheduler scheduler;
  Cluster cluster;
  Observer observer;
  AppServer apps;
  Reception reception;
  net::Timer tick;
  std::map<FrameId, FrameWork> frames;
  FrameAdmission admission;
  std::vector<std::weak_ptr<const FrameImage>> finished;  // those that somebody may still hold
  LoopGap loop_gap{kTick};
  int performing = 0;        // lists of actions, each within the one before
  int convictions = 0;       // that are being carried out
  Actions after_conviction;  // follow from one, and from what was decided with it
  Actions spare_actions;     // empty; its memory serves the next result
  TileSize tile_size;
  SceneCosts scene_costs;
  FrameAuthors authors;
  OutcomeLine outcomes;
  std::map<SceneVersion, SharedScene> held_scenes;  // committed, not yet sent to slaves
  SceneMoments moments;
  const TimePoint started = Clock::now();
  bool is_over = false;
  std::shared_ptr<int> alive = std::make_shared<int>(0);  // looked at by the hasher's tasks

  Impl(FrameLoop& loop, net::EventLoop& io_thread, const FrameLoopOptions& o)
      : io(io_thread),
        options(o),
        scheduler({o.prefetch_per_thread, o.frames_in_flight, o.is_static, o.audit}),
        cluster(io_thread, o.isa, o.is_isa_mixed, cluster_events(), o.is_relaying, o.pulse),
        observer(cluster),
        apps(io_thread, loop, o.pulse, o.certificate_wanted),
        reception(io_thread, reception_callbacks()),
        tick(io_thread),
        admission(o.memory) {
    tick.start_repeating(kTick, [this] {
      master_metrics().loop_gap_seconds.observe(seconds(loop_gap.tick(Clock::now())));
      if (!admission.is_empty()) admit();
      if (scheduler.has_open_frames()) perform(scheduler.tick(Clock::now()));
      observer.tick(Clock::now());
    });
  }

  ClusterEvents cluster_events();
  Reception::Callbacks reception_callbacks();
  void start_when_ready();
  // In the order in which the scheduler has decided them.
  void perform(const Actions& actions);
  FrameHoldings holdings();
  // Lets frames go on that memory is there for, and refuses those that it never is for.
  void admit();
  // What is said of a slave whose pixels were found wrong: which frames hold tiles of it.
  std::string conviction(const Action& action);
  void begin_frame(const Action& action);
  bool is_forgiven(SessionId session, ResultVerdict verdict);
  void on_result(SessionId session, wire::TileResult result);
  void on_faulty_tile(SessionId session, ResultVerdict verdict, FrameWork& work,
                      wire::TileResult& result);
  void complete(FrameId frame);
  void fail(const Action& action);
  void retire();
  // The frames that wait for memory count, which the scheduler does not know yet.
  SceneVersion oldest_version_needed(SceneVersion newest) const;
  void release_scenes();
  void send(const SceneMoments::Moment& moment);
  // Notes whether frames wait for a scene now; called whenever that may have changed.
  void look_at_waiting();
};

}  // namespace tessera::master
