// SPDX-License-Identifier: Apache-2.0
// Mutual TLS 1.3 with one cluster CA, and credentials that may change under way. A credentials
// folder, made by tessera-keys, holds ca.crt, node.crt and node.key, and crl.pem where something
// was revoked; the certificate's organizational unit is the role (master, slave, app), its common
// name the node's name.
//
// Threads. load(): any. Afterwards one io thread, the one of the connections made with it.
//
// Invariants. (1) What is in use fits together: a folder is taken over whole or not at all. (2) A
// connection lives on with the certificates that it began with, unless the peer's is revoked: then
// it ends as soon as the list is read. (3) A list older than the one in use is never taken.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "common/base/status.h"
#include "common/net/certificate_life.h"
#include "common/net/record.h"

namespace tessera::net {

class TlsContext {
 public:
  // Reads and checks `folder`: files present, key not readable by others, key fits certificate,
  // certificate signed by the CA, in date, not revoked, of role `role`. Returns: kPermissionDenied,
  // kNotFound or kUnavailable (key and certificate do not fit) with the command that mends it.
  static Result<std::shared_ptr<TlsContext>> load(const std::string& folder,
                                                  const std::string& role);

  // Reads the folder again. Connections from now on use what it holds; open ones whose peer is
  // revoked end (on_closed, kPermissionDenied). Returns: whether anything is new, or what is wrong.
  // In the second case certificate and key stay as they were, while a good crl.pem counts all the
  // same.
  Result<bool> reload();

  // What listeners say, over the encrypted link, to a peer whose certificate they refuse: a record
  // that holds the reason; then they close, and nothing is ever read from that peer. Without it
  // they close in silence. Call before any listener uses the context.
  void set_refusal(std::function<Record(const std::string& reason)> refusal);

  const std::string& folder() const;
  const std::string& name() const;       // common name of our own certificate
  std::string certificate_text() const;  // its serial number and last day, for logs
  std::string subject() const;           // "slave 'a'"
  CertificateLife life() const;          // of our own certificate, which ends with the CA's

  ~TlsContext();
  struct Impl;
  Impl& impl() const { return *impl_; }
  explicit TlsContext(std::unique_ptr<Impl> impl);

 private:
  std::unique_ptr<Impl> impl_;
};

}  // namespace tessera::net
