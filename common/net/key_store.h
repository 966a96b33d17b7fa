// Makes the credentials of a cluster: one CA, and a folder for each node. Behind tessera-keys.
//
// Layout. DIR/ca.crt, DIR/ca.key (0600); DIR/NAME/{ca.crt, node.crt, node.key (0600)}. EC P-256,
// X.509 v3; the role is the organizational unit, the node's name the common name. Nothing is ever
// overwritten.
#pragma once

#include <string>

#include "common/base/status.h"

namespace tessera::net {

inline constexpr int kCaDays = 3650;
inline constexpr int kNodeDays = 365;

// Returns: kInvalidArgument when DIR has a CA already, kPermissionDenied naming the file that
// cannot be written.
Status init_key_store(const std::string& folder);

// role: master, slave or app. name: 1..kNameBytesMax of [A-Za-z0-9._-]. days: life of the
// certificate; negative makes one that expired so many days ago, for tests. Returns:
// kInvalidArgument (role, name, name used twice), kNotFound (no CA), kPermissionDenied.
Status add_key(const std::string& folder, const std::string& role, const std::string& name,
               int days);

}  // namespace tessera::net
