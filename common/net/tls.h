// Mutual TLS 1.3 with one cluster CA. A credentials folder, made by tessera-keys, holds ca.crt,
// node.crt and node.key; the certificate's organizational unit is the role (master, slave, app),
// its common name the node's name.
#pragma once

#include <memory>
#include <string>

#include "common/base/status.h"

namespace tessera::net {

class TlsContext {
 public:
  // Reads and checks `folder`: files present, key not readable by others, key fits certificate,
  // certificate signed by the CA, in date, of role `role`. Returns: kPermissionDenied or kNotFound
  // with the command that mends it.
  static Result<std::shared_ptr<TlsContext>> load(const std::string& folder,
                                                  const std::string& role);

  ~TlsContext();
  const std::string& name() const;  // common name of our own certificate

  struct Impl;
  Impl& impl() const { return *impl_; }
  explicit TlsContext(std::unique_ptr<Impl> impl);

 private:
  std::unique_ptr<Impl> impl_;
};

}  // namespace tessera::net
