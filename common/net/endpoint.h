// SPDX-License-Identifier: Apache-2.0
// Where to listen or to connect: a host and a port, as they stand on a command line.
//
// Threads. Any.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/base/status.h"

namespace tessera::net {

struct Endpoint {
  std::string host;  // name, IPv4 or IPv6 (without brackets)
  std::uint16_t port = 0;
  std::string text() const;  // "host:port", IPv6 in brackets
};
// Parses "host:port", "[::1]:7400" or ":7400" (all interfaces). Returns: kInvalidArgument.
Result<Endpoint> parse_endpoint(const std::string& text);
// Parses endpoints with commas in between: a machine with more than one link listens on each.
Result<std::vector<Endpoint>> parse_endpoints(const std::string& text);
// Whether the endpoint is on loopback. Names such as "localhost" are resolved; one that does not
// resolve is not.
bool is_loopback(const Endpoint& endpoint);

}  // namespace tessera::net
