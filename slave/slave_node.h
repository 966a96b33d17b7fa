// One slave: the tile pipeline (receive -> FIFO queue -> render threads -> FIFO queue -> send) and
// the scene pipeline (receive -> scene queue -> build beside the render threads) over two
// connections to one master. The daemon runs one; a master's process may hold some, over local
// pairs.
//
// Threads. Constructor, start(), stop(), destructor: the owner's thread (not the io thread).
// Everything with the connections happens on the IoThread given; rendering on the node's own
// workers.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "common/base/isa.h"
#include "common/base/status.h"
#include "common/net/connection.h"
#include "slave/core/render/prepared_scene.h"

namespace tessera::slave {

struct SlaveOptions {
  std::string name;  // 1..kNameBytesMax printable bytes
  int threads = 1;   // render threads, 1..kWorkersMax
  IsaMask isas = 0;  // subset of core::supported_isas()
  int tile_sleep_ms =
      0;  // test option: each tile takes this long instead of being rendered (black pixels)
  core::Structure structure = core::Structure::kAuto;  // what rays go through
};

// Opens one link to the master; called on the io thread, calls back on the io thread. The daemon
// passes net::connect(), a master's process a local pair. Called first for the tile, then for the
// scene connection of each session. The attempt is given up when the returned handle is destroyed
// (may be null).
using LinkFactory = std::function<std::unique_ptr<net::ConnectAttempt>(
    std::function<void(Result<net::ConnectionPtr>)> on_connected)>;

class SlaveNode {
 public:
  SlaveNode(net::IoThread& io, const SlaveOptions& options, LinkFactory open_link);
  ~SlaveNode();  // stop(), if not done

  // Connects, renders, reconnects with growing pauses (kReconnectFirstMs * 2^k * random 0.5..1.5,
  // at most kReconnectMaxMs), until stop(). `on_fatal`: the master refused for a reason that trying
  // again cannot mend (role, name, certificate); called once, on the io thread.
  void start(std::function<void(Status)> on_fatal);

  // Orderly leave: finishes tiles being rendered, hands back the queue, says goodbye, joins the
  // workers.
  void stop();

 private:
  struct Impl;
  std::shared_ptr<Impl> impl_;
};

}  // namespace tessera::slave
