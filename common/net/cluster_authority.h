// SPDX-License-Identifier: Apache-2.0
// The CA of a cluster, which makes the certificates of nodes and the list of revoked ones. It
// stands behind key_store.h and is for common/net alone.
//
// Threads. Any; nothing is shared.
#pragma once

#include <string>
#include <vector>

#include "common/base/status.h"
#include "common/net/x509.h"

namespace tessera::net {

inline constexpr int kCaDays = 3650;

struct NodeIdentity {
  std::string role;
  std::string name;
};

// Life of a certificate, in days from now. days < 0: it expired so many days ago.
struct Validity {
  int days = 0;
  int starts_in_days = 0;
};

struct KeyPair {
  PrivateKey key;
  Certificate certificate;
};

class ClusterAuthority {
 public:
  static KeyPair make();
  // Reads ca.crt and ca.key. Returns: kNotFound with the command that makes them;
  // kPermissionDenied where others may write the folder.
  static Result<ClusterAuthority> open(const std::string& folder);

  KeyPair issue(const NodeIdentity& node, const Validity& validity) const;
  // A certificate for a key whose private half is elsewhere.
  Certificate certify(EVP_PKEY* key, const NodeIdentity& node, const Validity& validity) const;
  // Returns: a list of the entries of `old` (may be null) and these serial numbers, under the next
  // number.
  RevocationList revoke(X509_CRL* old, const std::vector<std::string>& serials) const;
  X509* certificate() const { return ca_.certificate.get(); }

 private:
  explicit ClusterAuthority(KeyPair ca) : ca_(std::move(ca)) {}
  KeyPair ca_;
};

}  // namespace tessera::net
