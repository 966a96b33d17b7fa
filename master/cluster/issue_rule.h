// SPDX-License-Identifier: Apache-2.0
// Who may be given a new certificate over the wire: a slave or an application that has proved who
// it is, whose certificate is in its last third and has not ended, and only once an hour, so that a
// peer that is broken or bad cannot fill the authority's ledger.
//
// Threads. One owner. Pure: Unix time and steady time come in. Invariant. At most kNamesMax names
// are remembered.
#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "common/base/clock.h"
#include "common/net/connection.h"

namespace tessera::master {

class IssueRule {
 public:
  static constexpr std::chrono::hours kPause{1};
  static constexpr std::size_t kNamesMax = 4096;

  // Returns: why the peer gets none now; empty where it gets one, which is remembered.
  std::string refusal_of(const net::PeerIdentity& peer, std::int64_t now_s, TimePoint now);

 private:
  std::map<std::string, TimePoint> issued_;  // by name, in the last hour
};

}  // namespace tessera::master
