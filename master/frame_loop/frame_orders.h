// SPDX-License-Identifier: Apache-2.0
// What an application asks of a master's frames, and what becomes of each. The frame loop carries
// the orders out; the application of this process or the one behind a link gives them.
//
// Threads. Net thread only; callbacks run there too.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>

#include "common/base/ids.h"
#include "common/base/status.h"
#include "common/frame/frame_image.h"
#include "common/frame/frame_settings.h"
#include "common/frame/frame_stats.h"
#include "common/scene/scene_codec.h"

namespace tessera::master {

struct FrameOutcome {
  FrameId frame = 0;
  Status status;  // ok: image is complete
  std::shared_ptr<const FrameImage> image;
  FrameStats stats;
};

class FrameOrders {
 public:
  virtual ~FrameOrders() = default;

  // Versions and frames count up; a frame's version was committed before. Every submitted frame
  // ends in exactly one outcome.
  virtual void set_outcome_callback(std::function<void(FrameOutcome)> on_outcome) = 0;
  // Reckons what slaves take to prepare a scene (EncodedScene::index_bytes), beside the net thread
  // where that takes a while, and gives the scene back on it: at once, or later, so that one may
  // overtake another. `on_weighed` is not called after the end of the orders' object.
  virtual void weigh(EncodedScene scene, std::function<void(EncodedScene)> on_weighed) = 0;
  // A scene that was not weighed is weighed here.
  virtual void commit_scene(SceneVersion version, EncodedScene scene) = 0;
  virtual void submit(FrameId frame, SceneVersion version, const FrameSettings& settings) = 0;
  virtual void cancel(FrameId frame) = 0;  // outcome kCancelled; nothing when it is over already
  virtual void cancel_all() = 0;
  virtual void free_scenes() = 0;
  virtual ClusterStatus status() const = 0;
  // Memory that scenes may take now; nothing where no limit is known.
  virtual std::optional<std::uint64_t> free_bytes() const = 0;
};

}  // namespace tessera::master
