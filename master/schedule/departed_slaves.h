// SPDX-License-Identifier: Apache-2.0
// Slaves that are gone, for a while: a frame whose scene only one of them could hold is not given
// up before it can have come back. Pure, as the scheduler that owns it: times are given, nothing
// fails.
//
// Threads. The scheduler's.
#pragma once

#include <deque>
#include <set>
#include <string>

#include "common/base/clock.h"
#include "common/base/ids.h"
#include "common/base/limits.h"

namespace tessera::master {

class DepartedSlaves {
 public:
  // What a slave that lost its link takes until it has joined again, at most: it notices the loss,
  // makes the longest pause between two attempts and shakes hands.
  static constexpr Duration kReturn = std::chrono::milliseconds(
      kHeartbeatMs * (kHeartbeatsMissedMax + 1) + kReconnectMaxMs + kHandshakeMs);
  // Slaves that are remembered; of more, those that left first are forgotten.
  static constexpr std::size_t kMax = 64;

  struct Slave {
    std::string name;
    std::set<SceneVersion> refused;
    TimePoint left_at{};

    bool may_return(TimePoint now) const { return now - left_at < kReturn; }
  };

  void left(Slave slave) {
    if (slaves_.size() == kMax) slaves_.pop_front();
    slaves_.push_back(std::move(slave));
  }

  // Forgets slaves of this name: one is here (again).
  void joined(const std::string& name) {
    std::erase_if(slaves_, [&](const Slave& slave) { return slave.name == name; });
  }

  // Returns: who left last of those that had not refused the version; null when there is none, or
  // when it has been gone for so long that its leaving explains nothing.
  const Slave* last_able(SceneVersion version, TimePoint now) const {
    for (auto slave = slaves_.rbegin(); slave != slaves_.rend(); ++slave) {
      if (now - slave->left_at >= 2 * kReturn) break;
      if (!slave->refused.contains(version)) return &*slave;
    }
    return nullptr;
  }

 private:
  std::deque<Slave> slaves_;  // in the order in which they left
};

}  // namespace tessera::master
