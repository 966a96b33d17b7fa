// SPDX-License-Identifier: Apache-2.0
// Carries out what the interactive loop decides: submits frames of the viewer's newest view, and of
// the scene as it is at the time, and publishes what comes back.
//
// Threads. run() is the pump thread's; the constructor's arguments outlive it. stop() and
// failure(): main thread.
#pragma once

#include <atomic>
#include <map>
#include <thread>

#include "master/commands/frame_source.h"
#include "master/commands/scene_reload.h"
#include "master/commands/stats_file.h"
#include "master/display/viewer.h"
#include "master/image/pass_mean.h"
#include "master/session/interactive_loop.h"
#include "master/session/playback.h"

namespace tessera::master {

class ViewPump {
 public:
  ViewPump(Session& session, FrameSource& source, const MasterOptions& options, Progress& progress,
           Viewer& viewer, StatsFile& stats, SceneReload& reload);
  ~ViewPump() { stop(); }

  void stop();
  bool has_ended() const { return has_ended_; }
  // Requires: stop() was called.
  const Status& failure() const { return failure_; }

 private:
  struct Asked {
    std::uint64_t revision = 0;  // of the view
    FrameSettings settings;
  };

  void run();
  Status settle();
  FrameSettings wanted() const;
  void follow_keys();
  void follow_file();
  bool is_playing() const;
  Status perform(const InteractiveLoop::Step& step);
  Status submit(FrameSettings settings);
  void ask_status();
  Status take(double seconds_max);
  void publish(FrameResult result, const InteractiveLoop::Arrival& arrival, const Asked& asked);

  Session& session_;
  FrameSource& source_;
  const MasterOptions& options_;
  Progress& progress_;
  Viewer& viewer_;
  StatsFile& stats_;
  SceneReload& reload_;
  InteractiveLoop loop_;
  Playback playback_;
  Viewer::View view_;               // newest seen
  PlayWish play_;                   // that playback_ follows
  std::map<FrameId, Asked> asked_;  // of the frames in flight
  PassMean mean_;                   // of the full frames of one view
  bool has_scene_ = false;
  double committed_seconds_ = -1;  // at which the session's scene stands; -1: none does
  SceneCost owed_;                 // of pictures that nobody sees; charged to the next frame
  bool is_alone_ = false, is_away_ = false;
  Status failure_;
  std::atomic<bool> is_stopping_{false};
  std::atomic<bool> has_ended_{false};
  std::thread thread_;  // last: starts when all else is there
};

}  // namespace tessera::master
