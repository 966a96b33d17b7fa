// SPDX-License-Identifier: Apache-2.0
// A node's half of the renewal of its certificate: a new private key, which never leaves the node,
// a request that shows its public half and is signed by it (PKCS#10, RFC 2986), and the taking over
// of the certificate that comes back. The other half is certify_key() of key_store.h.
//
// Threads. One owner. Invariant. Nothing in the folder changes before the certificate has been
// found to fit the new key, the folder's CA, and the name and role of the certificate in use.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "common/base/status.h"

namespace tessera::net {

class KeyRequest {
 public:
  KeyRequest();  // makes a key
  ~KeyRequest();
  KeyRequest(KeyRequest&&) noexcept;
  KeyRequest& operator=(KeyRequest&&) noexcept;

  // The request, DER.
  std::vector<std::byte> der() const;

  // Puts key and certificate (DER) into the node's folder, in the place of those there. Writes two
  // small files and waits for the disk. Returns: kPermissionDenied for a certificate that does not
  // fit, or a folder that cannot be written.
  Status take_over(const std::string& folder, std::span<const std::byte> certificate) const;

 private:
  struct Key;
  std::unique_ptr<Key> key_;
};

}  // namespace tessera::net
