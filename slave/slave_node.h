// SPDX-License-Identifier: Apache-2.0
// The network half of one slave: the tile pipeline (receive -> workshop -> FIFO queue -> send) and
// the scene pipeline (receive -> workshop -> acknowledge) over two connections to one master. Who
// renders and builds is the workshop's affair: threads in the product (SlaveHost), a model in
// tests/sim.
//
// Threads. The event loop's thread only, construction and destruction included.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "common/base/isa.h"
#include "common/base/memory_room.h"
#include "common/base/status.h"
#include "common/net/event_loop.h"
#include "common/net/key_renewal.h"
#include "common/net/link_factory.h"
#include "slave/core/scene/prepared_scene.h"
#include "slave/relay_access.h"
#include "slave/test_hooks.h"
#include "slave/workshop.h"

namespace tessera::slave {

struct SlaveOptions {
  std::string name;                                    // 1..kNameBytesMax printable bytes
  int threads = 1;                                     // render threads, 1..kWorkersMax
  IsaMask isas = 0;                                    // subset of core::supported_isas()
  std::uint64_t instance = 0;                          // random number of the process; 0: none
  core::Structure structure = core::Structure::kAuto;  // what rays go through
  bool is_on_demand = false;  // meshes are built when the first ray reaches them
  // Tells limit and free bytes of memory; null: unknown, every scene is taken.
  std::function<std::optional<MemoryRoom>()> memory = {};
  net::RenewalAccess renewal = {};
  RelayAccess relay = {};  // empty: neither feeds other slaves nor is fed by them
  TestHooks hooks = {};
};

class SlaveNode {
 public:
  // `loop` and `workshop` outlive the node.
  SlaveNode(net::EventLoop& loop, const SlaveOptions& options, net::LinkFactory open_link,
            Workshop& workshop);
  ~SlaveNode();  // closes without a word

  // Connects, reconnects with growing pauses (kReconnectFirstMs * 2^k * random 0.5..1.5, at most
  // kReconnectMaxMs), also where it is refused, until it leaves.
  void start();

  // Called by the workshop, for each tile and scene that it took. No result: the tile was given up.
  void on_tile_done(const TileJob& job, std::optional<wire::TileResult> result);
  void on_built(BuildOutcome outcome);

  // The steps of leaving in order: hand back what waits; give up the tiles in work if they take too
  // long; send the results (returns: whether all are on the wire); say goodbye.
  void begin_leave();
  void give_up_tiles();
  [[nodiscard]] bool flush();
  void say_goodbye();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tessera::slave
