// SPDX-License-Identifier: Apache-2.0
// Where a slave's tiles are rendered and its scenes are built, as the network half sees it.
//
// Threads. Called on the node's event loop; the answers (SlaveNode::on_tile_done, on_built) come
// there, too.
// Invariants. (1) A tile taken is answered once, unless remove_*() took it out. (2) A scene taken
// is answered once, kCancelled included, in the order of slave/build_order.h, unless it was retired
// while it waited or the workshop is being closed.
#pragma once

#include <cstddef>
#include <deque>

#include "common/net/link_counters.h"
#include "slave/frame_work.h"
#include "slave/scene_builder.h"

namespace tessera::slave {

class Workshop {
 public:
  virtual ~Workshop() = default;

  // Returns: false when it holds kTilesLeasedMax tiles.
  [[nodiscard]] virtual bool try_push(TileJob job) = 0;
  // Takes out the waiting jobs of one frame, or all.
  virtual void remove_frame(const FrameWork* frame) = 0;
  virtual std::deque<TileJob> remove_all() = 0;
  // While at least one frame is open, waiting for tiles counts as starved.
  virtual void set_open_frames(std::size_t frames) = 0;

  // observe_link() takes the counters of the link that results leave by, before each of them;
  // forget_link() tells that the link is gone.
  virtual void observe_link(const net::LinkCounters&) {}
  virtual void forget_link() {}

  // Returns: false when BuildOrder::kWaitingMax scenes wait.
  [[nodiscard]] virtual bool try_push(BuildTask task) = 0;
  // Gives up builds of `generation` older than `first_kept`, and all of earlier generations.
  virtual void retire(std::uint64_t generation, SceneVersion first_kept) = 0;
  // Lets go of the scene that was built last, which is otherwise kept for the next one.
  virtual void forget_newest() {}
};

}  // namespace tessera::slave
