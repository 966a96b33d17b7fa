// SPDX-License-Identifier: Apache-2.0
// The building half of the scene pipeline: one thread that prepares complete scenes
// (scene_preparation.h), in the order that build_order.h decides. Beside render threads a build
// gives way to them (paced_gate.h); one that frames wait for has all threads.
//
// Threads. push(), retire(), forget_newest(): network thread. set_rendering(): any. on_built runs
// on the builder's thread, and must not block. stop(): the owner's thread.
// Invariants. Each pushed scene gets one on_built, kCancelled included, unless it was retired while
// it waited or stop() came first.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <thread>

#include "common/base/ids.h"
#include "common/base/mutex.h"
#include "common/base/status.h"
#include "slave/build_order.h"
#include "slave/core/scene/prepared_scene.h"
#include "slave/paced_gate.h"
#include "slave/scene_preparation.h"

namespace tessera::slave {

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
  void forget_newest() { preparation_.forget_newest(); }

  // How many render threads have a tile from now on. Takes a lock under which nothing is called.
  void set_rendering(int threads) { gate_.set_rendering(threads); }
  // Threads of a build that wait for render threads.
  int waiting_threads() const { return gate_.waiting(); }

  void stop();

 private:
  void cancel() TESSERA_REQUIRES(mutex_);
  void work();
  void run(const BuildTask& task);
  const BuildTask* begin_next();  // null: stop() was called

  core::BuildOptions build_options_;
  const OnBuilt on_built_;
  ScenePreparation preparation_;

  Mutex mutex_;
  BuildOrder order_ TESSERA_GUARDED_BY(mutex_);
  CondVar has_next_;
  bool is_stopped_ TESSERA_GUARDED_BY(mutex_) = false;
  std::atomic<bool> is_cancelled_{false};  // of the current build
  PacedGate gate_;

  std::thread thread_;
};

}  // namespace tessera::slave
