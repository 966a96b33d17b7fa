// SPDX-License-Identifier: Apache-2.0
// One frame as a slave knows it between FrameBegin and FrameEnd, shared by its tiles: a tile holds
// its frame, the frame its prepared scene, so that older scenes live as long as tiles need them.
//
// Threads. Immutable after construction, apart from is_cancelled and failure, which any thread may
// set, and light, which the first render thread makes.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>

#include "common/base/clock.h"
#include "common/base/mutex.h"
#include "common/base/status.h"
#include "common/frame/tile_grid.h"
#include "common/wire/messages.h"
#include "slave/core/integrate/frame_light.h"
#include "slave/core/scene/prepared_scene.h"

namespace tessera::slave {

// The first of several failures. Any thread.
class FirstFailure {
 public:
  void add(const Status& failure) {
    MutexLock lock(mutex_);
    if (status_.is_ok()) status_ = failure;
  }
  Status get() const {
    MutexLock lock(mutex_);
    return status_;
  }

 private:
  mutable Mutex mutex_;
  Status status_ TESSERA_GUARDED_BY(mutex_);
};

struct FrameWork {
  FrameWork(const wire::FrameBegin& frame_begin,
            std::shared_ptr<const core::PreparedScene> prepared, std::uint64_t session_generation)
      : begin(frame_begin),
        scene(std::move(prepared)),
        grid(begin.settings.width_px, begin.settings.height_px, begin.settings.tile_edge_px),
        generation(session_generation) {}

  const wire::FrameBegin begin;
  const std::shared_ptr<const core::PreparedScene> scene;  // null: version was retired meanwhile
  const TileGrid grid;
  const std::uint64_t generation;  // which session of ours it belongs to
  std::atomic<bool> is_cancelled{false};
  FirstFailure failure;    // of what rays have met and could not be built
  core::FrameLight light;  // made by the first tile that needs it
};

struct TileJob {
  std::shared_ptr<FrameWork> frame;
  TileIndex tile = 0;
  Attempt attempt = 0;
  TimePoint arrived;           // when its lease came
  bool has_come_back = false;  // it was left for a mesh that another thread built
};

}  // namespace tessera::slave
