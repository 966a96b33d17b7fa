// SPDX-License-Identifier: Apache-2.0
// The command line of tessera-slave: words in, checked options or an exit code out.
//
// Threads. Called once, by main.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/base/log.h"
#include "common/net/endpoint.h"
#include "slave/slave_node.h"

namespace tessera::slave {

inline constexpr const char* kRelayOff = "off";

struct SlaveCommand {
  SlaveOptions options;
  net::Endpoint master;
  bool is_name_given = false;            // without keys it counts
  int nice = 0;                          // 0..19, for the threads that render and build
  std::vector<int> cpus;                 // run on these alone; empty: on all that are allowed
  std::optional<net::Endpoint> metrics;  // a page of metrics there
  // Where other slaves fetch scenes: an address of this machine, or kRelayOff; nothing: where the
  // master is reached.
  std::optional<std::string> relay_listen;
  std::string keys_folder;  // empty: plain TCP, master on loopback
  LogLevel log_level = LogLevel::kInfo;
  LogFormat log_format = LogFormat::kText;
};

// Exactly one of the two is meaningful: with `exit_code` set, what had to be said has been printed.
struct ParsedCommand {
  SlaveCommand command;
  std::optional<int> exit_code;
};

ParsedCommand parse_command_line(int argc, char** argv);

}  // namespace tessera::slave
