// SPDX-License-Identifier: Apache-2.0
// The building half of the scene pipeline: one thread that decodes complete scenes and prepares
// them for tracing, in the order that build_order.h decides. Beside render threads a build gives
// way to them (paced_gate.h); one that frames wait for has all threads. The scene that was built
// last is kept until the next one is built, whether or not a frame still needs it: what both have
// in common is not built again.
//
// Threads. push(), retire(), forget_newest(): network thread. set_rendering(): any. on_built runs
// on the builder's thread, and must not block. stop(): the owner's thread.
// Invariants. (1) Each pushed scene gets one on_built, kCancelled included, unless it was retired
// while it waited or stop() came first. (2) One scene at most is kept alive here.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <thread>

#include "common/base/ids.h"
#include "common/base/mutex.h"
#include "common/base/status.h"
#include "common/scene/pose.h"
#include "common/scene/scene_codec.h"
#include "slave/build_order.h"
#include "slave/core/scene/prepared_scene.h"
#include "slave/paced_gate.h"

namespace tessera::slave {

struct BuildOutcome {
  std::uint64_t generation = 0;
  SceneVersion version = 0;
  double seconds = 0;
  Result<std::shared_ptr<const core::PreparedScene>> scene;
  // Built or fitted; 0: the geometry is that of the scene before.
  std::uint64_t built_primitives = 0;
};

class SceneBuilder {
 public:
  using OnBuilt = std::function<void(BuildOutcome)>;

  // options.threads: how many a build may use. options.is_cancelled is the builder's own.
  // `pace`: how a build runs beside rendering.
  SceneBuilder(const core::BuildOptions& options, OnBuilt on_built);
  SceneBuilder(const core::BuildOptions& options, OnBuilt on_built, const BuildPace& pace);
  ~SceneBuilder();  // stop()

  // Returns: false when BuildOrder::kWaitingMax scenes wait.
  [[nodiscard]] bool try_push(BuildTask task);

  // Gives up builds of `generation` older than `first_kept`, and all of earlier generations.
  void retire(std::uint64_t generation, SceneVersion first_kept);

  // Lets go of the scene that was built last.
  void forget_newest();

  // How many render threads have a tile from now on. Takes a lock under which nothing is called.
  void set_rendering(int threads) { gate_.set_rendering(threads); }
  // Threads of a build that wait for render threads.
  int waiting_threads() const { return gate_.waiting(); }

  void stop();

 private:
  // What the next scene may share: a decoded scene's meshes and pictures live as long as it does,
  // and those that were posed as long as `posed`.
  struct Newest {
    Scene scene, posed;
    std::shared_ptr<const core::PreparedScene> prepared;
  };

  void cancel() TESSERA_REQUIRES(mutex_);
  void work();
  void run(const BuildTask& task);
  BuildOutcome build(const BuildTask& task);
  std::shared_ptr<const Newest> newest() const;
  const BuildTask* begin_next();  // null: stop() was called

  core::BuildOptions build_options_;
  const OnBuilt on_built_;
  SceneDecoder decoder_;  // builder thread
  ScenePoser poser_;      // builder thread

  mutable Mutex mutex_;
  std::shared_ptr<const Newest> newest_ TESSERA_GUARDED_BY(mutex_);  // null: nothing, or forgotten
  BuildOrder order_ TESSERA_GUARDED_BY(mutex_);
  CondVar has_next_;
  bool is_stopped_ TESSERA_GUARDED_BY(mutex_) = false;
  std::atomic<bool> is_cancelled_{false};  // of the current build
  PacedGate gate_;

  std::thread thread_;
};

}  // namespace tessera::slave
