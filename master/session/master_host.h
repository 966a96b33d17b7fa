// SPDX-License-Identifier: Apache-2.0
// A master inside this process: the net thread, the frame loop on it, the listener, and slaves
// inside the process over local pairs (the same protocol code; nothing listens for them). `serve`
// runs one by itself; the in-process session wraps one.
//
// Threads. The owner's thread constructs, uses and destroys; frame_loop() is used on io() only.
#pragma once

#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "common/base/status.h"
#include "common/net/credentials_watch.h"
#include "common/net/endpoint.h"
#include "common/net/http_page.h"
#include "common/net/io_thread.h"
#include "common/net/listener.h"
#include "master/frame_loop/frame_loop.h"
#include "master/session/certificate_desk.h"
#include "master/session/session.h"
#include "slave/core/scene/patch_footprint.h"
#include "slave/slave_host.h"

namespace tessera::master {

class MasterHost {
 public:
  // Requires: options.connect is empty. Returns: one line for a person.
  static Result<std::unique_ptr<MasterHost>> start(const SessionOptions& options,
                                                   bool serves_applications);
  ~MasterHost();  // says goodbye to every peer, joins every thread

  net::IoThread& io() { return io_; }
  FrameLoop& frame_loop() { return *frame_loop_; }
  std::uint16_t listen_port() const { return listener_ ? listener_->port() : std::uint16_t{0}; }
  ClusterStatus status();

 private:
  MasterHost();
  Status listen_at(const SessionOptions& options);
  Status serve_metrics(const std::string& address);
  Status start_trace(const SessionOptions& options);
  Status start_local_slaves(const SessionOptions& options);
  void wait_for_local_slaves();
  net::LinkFactory local_link_factory();

  net::IoThread io_{"master-net"};
  core::PatchFootprint footprint_;                      // hasher_'s thread; of applications' scenes
  net::IoThread hasher_{"master-hash"};                 // its tasks post to io_, which outlives it
  std::unique_ptr<FrameLoop> frame_loop_;               // io_ thread
  std::unique_ptr<net::Listener> listener_;             // io_ thread; null when nothing listens
  std::unique_ptr<net::CredentialsWatch> credentials_;  // io_ thread; null without keys
  std::unique_ptr<CertificateDesk> desk_;    // io_ thread; null: certificates are not made
  std::unique_ptr<net::HttpPage> metrics_;   // io_ thread; null when not wanted
  std::thread trace_writer_;                 // started on the io_ thread, joined when that is over
  std::unique_ptr<net::IoThread> slave_io_;  // of the local slaves; null without
  std::vector<std::unique_ptr<slave::SlaveHost>> slaves_;
};

// Checks that options name what `endpoint` demands: keys, or plain on loopback. Returns:
// kInvalidArgument with the commands that mend it. Opens nothing.
Status check_credentials(const SessionOptions& options, const net::Endpoint& endpoint,
                         const std::string& role);

// The credentials that options name, or null for plain. Returns: what check_credentials() says, or
// what is wrong in the folder.
Result<std::shared_ptr<net::TlsContext>> load_credentials(const SessionOptions& options,
                                                          const net::Endpoint& endpoint,
                                                          const std::string& role);

}  // namespace tessera::master
