// SPDX-License-Identifier: Apache-2.0
// What scenes cost a sequence of frames: structures that slaves build, frames that wait for them,
// bytes that travel between frames. Pure: events and times go in, a frame's account comes out.
//
// Threads. One owner. Invariants. (1) What was counted is charged to one frame, the next that is
// completed. (2) Only versions that are not retired are remembered.
#pragma once

#include <map>
#include <optional>

#include "common/base/clock.h"
#include "common/base/ids.h"
#include "common/frame/frame_stats.h"

namespace tessera::master {

class SceneCosts {
 public:
  // A slave has built this version.
  void built(SceneVersion version, double build_seconds, std::uint64_t primitives);
  void retire(SceneVersion first_kept);

  // Says whether frames wait for a scene from now on.
  void look(bool is_waiting, TimePoint now);

  // Fills in what `stats.scene_version` took to build, and what all scenes have cost since the call
  // before. `scene_bytes_sent`: since the master began.
  void charge(FrameStats& stats, std::uint64_t scene_bytes_sent);

 private:
  struct Build {
    double seconds = 0;            // of the slowest slave
    std::uint64_t primitives = 0;  // of the slave that built most
    std::uint64_t charged = 0;     // of these primitives
  };
  std::map<SceneVersion, Build> builds_;
  std::uint64_t owed_primitives_ = 0;  // of versions that are retired
  std::optional<TimePoint> waiting_since_;
  double waited_seconds_ = 0;
  std::uint64_t bytes_charged_ = 0;
};

}  // namespace tessera::master
