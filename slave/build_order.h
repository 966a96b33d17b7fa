// SPDX-License-Identifier: Apache-2.0
// Which of the scenes that came to a slave is built next.
//
// The oldest one is built first, since its frame is shown first. But where every frame brings a
// scene and a build takes about as long as a frame, a slave that has fallen behind would stay there
// for ever: it begins each scene when the others begin to render it, and the scene is retired just
// before it is ready. So a slave whose build was retired aims ahead: it leaves what it builds for
// the newest scene that comes, once, and builds that one to its end. It then has the time of all
// frames in flight for one build, and from there on it keeps up if it can.
//
// Threads. One owner, or a lock around it. Pure.
// Invariants. (1) Scenes wait in the order in which they came; at most kWaitingMax, and one that
// gave way. (2) A build gives way at most once between two builds that reached their end.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>

#include "common/base/ids.h"
#include "common/scene/scene_codec.h"

namespace tessera::slave {

struct BuildTask {
  std::uint64_t generation = 0;  // of the session that asked
  SceneVersion version = 0;
  EncodedScene scene;
};

class BuildOrder {
 public:
  static constexpr std::size_t kWaitingMax = 16;

  // Returns: false when kWaitingMax scenes wait.
  [[nodiscard]] bool try_push(BuildTask task);

  // Forgets waiting scenes of `generation` older than `first_kept`, and all of earlier generations.
  void retire(std::uint64_t generation, SceneVersion first_kept);

  bool has_next() const { return !waiting_.empty(); }

  // Starts a build. Requires: has_next(), and none in work. The reference holds until finish().
  const BuildTask& start_next();

  // Whether the build in work shall end early: it was retired, or gives way.
  bool is_to_stop() const { return in_work_ && (is_retired(*in_work_) || gives_way_); }

  // The build in work has ended, at its end or stopped early.
  // Returns: whether it is to be answered; one that gave way waits again.
  bool finish(bool was_stopped);

 private:
  bool is_retired(const BuildTask& task) const;

  std::deque<BuildTask> waiting_;
  std::optional<BuildTask> in_work_;
  std::uint64_t generation_ = 0;
  SceneVersion first_kept_ = 0;
  bool is_late_ = false;   // a build was retired since one reached its end
  bool is_ahead_ = false;  // older scenes wait for the build in work
  bool gives_way_ = false;
};

}  // namespace tessera::slave
