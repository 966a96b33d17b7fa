// SPDX-License-Identifier: Apache-2.0
// Slaves that feed each other in virtual time, what went between them, and what they complain of.
// Threads. The test's.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "common/base/log.h"
#include "common/wire/record_types.h"
#include "tests/unit/slave/relay_slave.h"

namespace tessera::slave {

constexpr SceneVersion kVersion = 3;
constexpr std::uint32_t kChunks = 6;
inline const std::vector<wire::RelayFault> kNone, kOnceGone{wire::RelayFault::kGone};

class RelayTest : public testing::Test {
 protected:
  static void SetUpTestSuite() { init_log(LogLevel::kOff, LogFormat::kText); }
  RelayTest() {
    network_.events.on_queued = [this](const sim::Process&, int, std::uint64_t bytes) {
      queued_max_ = std::max(queued_max_, bytes);
    };
    network_.events.on_sent = [this](const sim::Process& from, int, const net::Record& record) {
      const bool is_chunk = record.type == wire::encode(wire::SceneChunk{}).type;
      if (is_chunk) ++chunks_sent_[from.name()];
    };
  }

  std::unique_ptr<RelaySlave> slave(const std::string& name, const sim::LinkModel& link = {}) {
    auto made = std::make_unique<RelaySlave>(queue_, network_, name, link);
    made->announce(kVersion, block_);
    return made;
  }
  void give(RelaySlave& to, const std::vector<std::uint32_t>& chunks) {
    for (const std::uint32_t i : chunks) to.give(kVersion, block_, i);
  }
  void give_all(RelaySlave& to) {
    for (std::uint32_t i = 0; i < chunk_count(block_.size()); ++i) to.give(kVersion, block_, i);
  }
  void run_for(Duration time) {
    bool is_over = false;
    queue_.after(time, [&is_over] { is_over = true; });
    while (!is_over) queue_.step();
  }
  // Until nothing is on its way and no deadline runs.
  void settle() {
    while (queue_.step()) {
    }
  }
  static std::vector<wire::RelayFault> faults(const RelaySlave& slave) {
    std::vector<wire::RelayFault> all;
    for (const wire::RelayFailed& failed : slave.failures) all.push_back(failed.fault);
    return all;
  }
  static wire::SceneChunkNeed need_of(SceneVersion version, std::uint32_t chunks,
                                      std::uint32_t block = 0) {
    return {version, block, std::vector<bool>(chunks, true)};
  }

  Bytes block_ = noise(kChunks);
  sim::EventQueue queue_{1};
  sim::Network network_{queue_, 1};
  std::uint64_t queued_max_ = 0;  // bytes in one send queue
  std::map<std::string, std::uint32_t> chunks_sent_;
};

}  // namespace tessera::slave
