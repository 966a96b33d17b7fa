// SPDX-License-Identifier: Apache-2.0
// What all work on a tile shares: the scene and how rays are traced through it, what the frame asks
// for, and whether it is still wanted. Constructors take it beside the memory that a thread keeps
// from tile to tile, so that no object can be used before its context is known.
//
// Threads. Constant; any number of threads may share one.
#pragma once

#include <atomic>

#include "common/frame/frame_settings.h"
#include "slave/core/camera/camera_rays.h"
#include "slave/core/ray/met_builds.h"
#include "slave/core/scene/prepared_scene_impl.h"
#include "slave/core/trace/scene_tracer.h"

namespace tessera::core {

class FrameLight;

// Requires: all that it names outlives it.
struct RenderContext {
  const PreparedScene::Impl& scene;
  const SceneTracer& tracer;
  const FrameSettings& settings;
  const CameraRays& camera;
  FrameLight& frame_light;  // what the tiles of one frame share beyond the scene
  const std::atomic<bool>* is_cancelled = nullptr;  // null: cannot be cancelled

  const KernelTable& kernels() const { return tracer.kernels(); }
  // Whether the tile is cancelled, or its answers are worth nothing (MetBuilds). Callers ask for
  // every packet or so, so that such a tile is left within some ten thousand rays.
  bool is_over() const {
    return (is_cancelled != nullptr && is_cancelled->load(std::memory_order_relaxed)) ||
           MetBuilds::is_to_leave();
  }
};

}  // namespace tessera::core
