// SPDX-License-Identifier: Apache-2.0
// Makes new certificates with the cluster's authority, where its owner has laid it beside the
// master: for slaves and applications that ask over the wire, and for the master itself at two
// thirds of the life of its own.
//
// Threads. The io thread of the master; folders are locked and written on a thread of the desk's
// own, since another process may hold the lock. The destructor, on neither of the two, waits for
// what is in work; answers are posted to the io thread before it returns.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/net/io_thread.h"
#include "common/net/key_request.h"
#include "common/net/tls.h"
#include "common/wire/messages.h"
#include "master/cluster/issue_rule.h"

namespace tessera::master {

class CertificateDesk {
 public:
  // `folder`: the authority's, checked by net::check_issuing_folder().
  CertificateDesk(net::IoThread& io, std::string folder, std::shared_ptr<net::TlsContext> tls);
  ~CertificateDesk();

  // Answers on the io thread, some time later.
  void ask(const net::PeerIdentity& peer, std::vector<std::byte> request,
           std::function<void(wire::CertificateGrant)> answer);
  void start();  // begins to watch the master's own certificate
  void close();  // ends that; must be called before the io thread ends

 private:
  void look_at_own();

  net::IoThread& io_;
  const std::string folder_;
  const std::shared_ptr<net::TlsContext> tls_;
  IssueRule rule_;
  TimePoint own_next_{};  // no earlier is the master's own asked for
  std::unique_ptr<net::Timer> timer_;
  net::IoThread files_{"master-keys"};
};

}  // namespace tessera::master
