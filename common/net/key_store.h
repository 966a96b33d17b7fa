// SPDX-License-Identifier: Apache-2.0
// Makes, renews and revokes the credentials of a cluster: one CA, and a folder for each node. The
// program tessera-keys calls these functions.
//
// Layout. DIR/ca.crt, DIR/ca.key (0600), DIR/issued.txt ("SERIAL ROLE NAME" of each certificate
// ever made), DIR/crl.pem once something was revoked; DIR/NAME/{ca.crt, node.crt, node.key (0600),
// crl.pem}, and renewed.crt where the node got a newer certificate for a key of its own. EC P-256,
// X.509 v3; the role is the organizational unit, the node's name the common name.
//
// Threads. Any; processes that change the same DIR wait for each other.
//
// Invariants. (1) init and add never overwrite anything. (2) A file that is replaced is replaced
// whole, by a rename. (3) A certificate stands in issued.txt before it can be used, so that
// revoking a name revokes all that was ever made for it.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "common/base/status.h"

namespace tessera::net {

inline constexpr int kNodeDays = 365;

// Returns: kInvalidArgument when DIR has a CA already, kPermissionDenied naming the file that
// cannot be written.
Status init_key_store(const std::string& folder);

// role: master, slave or app. name: 1..kNameBytesMax of [A-Za-z0-9._-]. days: life of the
// certificate; negative makes one that expired so many days ago; starts_in_days > 0 one that is
// not valid yet, and < 0 one that has been for so long, for tests. Returns: kInvalidArgument (role,
// name, name used twice), kNotFound (no CA), kPermissionDenied.
Status add_key(const std::string& folder, const std::string& role, const std::string& name,
               int days, int starts_in_days = 0);

// Makes a new key and certificate in DIR/NAME, for the same name and role. The old certificate
// stays valid until it expires or is revoked. Returns: kNotFound (no CA, no such node),
// kPermissionDenied.
Status renew_key(const std::string& folder, const std::string& name, int days);

// Whether certificates that are made in DIR are of the cluster to which the node folder belongs.
// Returns: what is wrong with DIR otherwise.
Status check_issuing_folder(const std::string& folder, const std::string& node_folder);

// Makes a certificate for the key of a request (KeyRequest::der()), for a node that has proved to
// be `name` of `role`, and whose private key is elsewhere. It stands in issued.txt, and as
// DIR/NAME/renewed.crt where that folder is. Returns: the certificate, DER; kInvalidArgument for
// what is no request, is not signed by its own key, or holds a key other than P-256; kNotFound (no
// CA); kPermissionDenied.
Result<std::vector<std::byte>> certify_key(const std::string& folder, const std::string& role,
                                           const std::string& name,
                                           std::span<const std::byte> request, int days);

// Revokes every certificate made for this name until now, in the crl.pem of DIR and of each node's
// folder. To revoke a name again is no error. Returns: kNotFound (no CA, nothing made for this
// name), kPermissionDenied.
Status revoke_key(const std::string& folder, const std::string& name);

enum class KeyState { kGood, kRenewalDue, kEndsInADay, kEnded, kNotYet, kRevoked };

// Contents of a certificate of DIR.
struct KeyFacts {
  std::string role, name;  // empty for the CA
  std::string last_day;    // of its life, which ends with the CA's; UTC, "2027-11-22"
  KeyState state = KeyState::kGood;
};
// Reads DIR/NAME/node.crt, or DIR/ca.crt where `name` is empty. Returns: kNotFound.
Result<KeyFacts> read_key_facts(const std::string& folder, const std::string& name = "");
// Facts of the CA and then of every node that has a folder in DIR, by name. The CA's key is not
// needed. Returns: kNotFound where there is no CA; kPermissionDenied for a damaged crl.pem.
Result<std::vector<KeyFacts>> list_key_facts(const std::string& folder);

}  // namespace tessera::net
