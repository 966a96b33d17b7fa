// SPDX-License-Identifier: Apache-2.0
// What is remembered of slaves that were lost, by identity: a slave that comes back has to earn the
// trust that a new one is given. Pure; times are given.
//
// Threads. The scheduler's.
//
// Invariants. At most kMax slaves are remembered; of more, the one whose loss is oldest is
// forgotten.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <map>
#include <string>

#include "common/base/clock.h"
#include "common/base/limits.h"
#include "master/schedule/slave_identity.h"

namespace tessera::master {

class SlaveHistory {
 public:
  static constexpr std::chrono::hours kForgiven{1};
  static constexpr std::size_t kMax = kConnectionsMax;

  struct Past {
    bool was_lost = false;
    // The most tiles that a process of this slave took with it when it ended: so many must it bring
    // before it is trusted with tiles that slaves were lost with.
    std::uint32_t debt_tiles = 0;
    bool has_brought = false;  // it goes on as it was, and brought tiles before
  };

  void lost(const SlaveIdentity& slave, std::uint32_t tiles_held, bool has_brought, TimePoint now) {
    if (records_.size() >= kMax && !records_.contains(slave.id())) {
      records_.erase(
          std::min_element(records_.begin(), records_.end(),
                           [](const auto& a, const auto& b) { return a.second.at < b.second.at; }));
    }
    Record& record = records_[slave.id()];
    record = {slave, now, std::max(record.debt_tiles, record.held_tiles), tiles_held, has_brought};
  }

  // A slave is here, perhaps again. The loss of a process that goes on is no debt.
  Past joined(const SlaveIdentity& slave, TimePoint now) {
    const auto found = records_.find(slave.id());
    if (found == records_.end()) return {};
    Record& record = found->second;
    if (now - record.at > kForgiven) {
      records_.erase(found);
      return {};
    }
    const bool goes_on = slave.is_same_process(record.slave);
    if (!goes_on) record.debt_tiles = std::max(record.debt_tiles, std::max(record.held_tiles, 1u));
    record.held_tiles = 0;
    return {true, record.debt_tiles, goes_on && record.has_brought};
  }

 private:
  struct Record {
    SlaveIdentity slave;  // as it was when it was lost
    TimePoint at{};
    std::uint32_t debt_tiles = 0;
    std::uint32_t held_tiles = 0;  // at its last loss, until that is known to be a crash or none
    bool has_brought = false;
  };
  std::map<std::string, Record> records_;
};

}  // namespace tessera::master
