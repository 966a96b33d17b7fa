// SPDX-License-Identifier: Apache-2.0
// The way of a scene from its blocks to what rays meet: decoded, posed at its time, prepared for
// tracing. The scene that was prepared last is kept until the next one is, whether or not a frame
// still needs it: what both have in common is neither decoded nor built again.
//
// Threads. prepare(): one at a time. forget_newest(): any.
// Invariants. One scene at most is kept alive here.
#pragma once

#include <memory>

#include "common/base/ids.h"
#include "common/base/mutex.h"
#include "common/base/status.h"
#include "common/scene/pose.h"
#include "common/scene/scene_codec.h"
#include "slave/build_order.h"
#include "slave/core/scene/prepared_scene.h"

namespace tessera::slave {

struct BuildOutcome {
  std::uint64_t generation = 0;
  SceneVersion version = 0;
  double seconds = 0;
  Result<std::shared_ptr<const core::PreparedScene>> scene;
  // Built or fitted; 0: the geometry is that of the scene before.
  std::uint64_t built_primitives = 0;
};

class ScenePreparation {
 public:
  // options.other is set here. outcome.seconds is left to the caller.
  BuildOutcome prepare(const BuildTask& task, core::BuildOptions options);

  // Lets go of the scene that was prepared last.
  void forget_newest();

 private:
  // What the next scene may share: a decoded scene's meshes and pictures live as long as it does,
  // and those that were posed as long as `posed`.
  struct Newest {
    std::shared_ptr<const Scene> scene, posed;
    std::shared_ptr<const core::PreparedScene> prepared;
  };

  // The scene itself where nothing of it moves.
  Result<std::shared_ptr<const Scene>> posed_at(const std::shared_ptr<const Scene>& scene,
                                                double seconds);
  std::shared_ptr<const Newest> newest() const;

  SceneDecoder decoder_;
  ScenePoser poser_;

  mutable Mutex mutex_;
  std::shared_ptr<const Newest> newest_ TESSERA_GUARDED_BY(mutex_);  // null: nothing, or forgotten
};

}  // namespace tessera::slave
