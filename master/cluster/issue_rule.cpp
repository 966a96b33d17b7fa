// SPDX-License-Identifier: Apache-2.0
#include "master/cluster/issue_rule.h"

namespace tessera::master {

std::string IssueRule::refusal_of(const net::PeerIdentity& peer, std::int64_t now_s,
                                  TimePoint now) {
  if (!peer.is_authenticated || (peer.role != "slave" && peer.role != "app"))
    return "only a slave or an application with a certificate gets a new one";
  if (now_s >= peer.life.end_s) return "the certificate in use has ended by the master's clock";
  if (!net::is_renewal_due(peer.life, now_s))
    return "the certificate in use is not in the last third of its life by the master's clock";
  std::erase_if(issued_, [now](const auto& entry) { return now - entry.second >= kPause; });
  if (issued_.contains(peer.name)) return "a certificate was made for this name within the hour";
  if (issued_.size() >= kNamesMax) return "too many certificates were made within the hour";
  issued_[peer.name] = now;
  return {};
}

}  // namespace tessera::master
