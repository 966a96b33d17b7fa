// SPDX-License-Identifier: Apache-2.0
// What a node's credentials folder holds, read and checked: ca.crt, node.crt, node.key, and crl.pem
// where a certificate of the cluster has been revoked. For common/net alone.
//
// Threads. Any; nothing is shared.
#pragma once

#include <string>

#include "common/base/status.h"
#include "common/net/x509.h"

namespace tessera::net {

struct KeyFolder {
  Certificate ca, own;
  PrivateKey key;
  RevocationList revoked;  // null: no certificate is revoked
  std::string name;        // common name of our own certificate
};

// Returns: kNotFound or kPermissionDenied with the command that mends it; kUnavailable where
// node.key and node.crt do not belong together, as in the moment between the two renames of a
// renewal or in the middle of a copy: try again.
Result<KeyFolder> read_key_folder(const std::string& folder, const std::string& role);

// Whether nobody but its owner and root can change what `folder` holds, or put another one in its
// place: neither it nor a folder around it may be written by others or by a group that is not the
// owner's alone, except those with the sticky bit, such as /tmp, where nobody renames what is
// another's. Returns: kPermissionDenied with
// the command that mends it; ok where there is no such folder.
Status check_not_open_to_others(const std::string& folder);

// Reads crl.pem. Returns: the list, null where there is none; kPermissionDenied when it is not a
// list signed by this CA.
Result<RevocationList> read_revocations(const std::string& folder, X509* ca);

// Returns: a stamp of the folder, which differs from an earlier one when any of the files was
// written, replaced, added or removed since.
std::string stamp_of(const std::string& folder);

}  // namespace tessera::net
