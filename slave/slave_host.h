// SPDX-License-Identifier: Apache-2.0
// One slave with its threads: a SlaveNode on an io thread, render threads and a builder thread. The
// daemon runs one; a master's process may hold some, over local pairs.
//
// Threads. Constructor, start(), stop(), destructor: the owner's thread (not the io thread).
// Everything with the connections happens on the IoThread given; rendering on own threads.
#pragma once

#include <memory>

#include "slave/slave_node.h"

namespace tessera::slave {

class SlaveHost {
 public:
  SlaveHost(net::IoThread& io, const SlaveOptions& options, net::LinkFactory open_link);
  ~SlaveHost();  // stop(), if not done

  // Connects, renders, reconnects, until stop().
  void start();

  // Orderly leave: finishes tiles being rendered, hands back the queue, says goodbye, joins the
  // threads.
  void stop();

 private:
  struct Impl;
  std::shared_ptr<Impl> impl_;
};

}  // namespace tessera::slave
