// SPDX-License-Identifier: Apache-2.0
// One end of a connection for tests: gathers records and the end of the link, and lets the test
// thread wait for them.
// Threads. Callbacks come on the connection's io thread; everything else is the test thread's.
#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <deque>
#include <optional>
#include <string>
#include <utility>

#include "common/base/clock.h"
#include "common/base/mutex.h"
#include "common/net/connection.h"
#include "common/net/io_thread.h"
#include "tests/support/patience.h"

namespace tessera::test {

inline net::RecordLimits open_limits(std::int64_t header_max = 1000,
                                     std::int64_t payload_max = 8 << 20) {
  net::RecordLimits limits{};
  for (net::RecordLimit& limit : limits) limit = {header_max, payload_max};
  return limits;
}

class NetPeer {
 public:
  explicit NetPeer(net::IoThread& io) : io_(io) {}
  ~NetPeer() { drop(); }

  void adopt(net::ConnectionPtr connection, const net::RecordLimits& limits = open_limits()) {
    io_.run_and_wait([&] {
      connection_ = std::move(connection);
      net::ConnectionCallbacks callbacks;
      callbacks.on_record = [this](net::ReceivedRecord record) {
        MutexLock lock(mutex_);
        records_.push_back(std::move(record));
        changed_.notify_all();
      };
      callbacks.on_closed = [this](Status status) {
        MutexLock lock(mutex_);
        end_ = std::move(status);
        changed_.notify_all();
      };
      connection_->start(std::move(callbacks), limits);
    });
  }

  void send(std::uint16_t type, std::string header, std::vector<std::byte> payload) {
    io_.run_and_wait([&] {
      connection_->send({type, std::move(header), net::SharedBytes::of(std::move(payload))});
    });
  }
  void drop() {
    io_.run_and_wait([&] { connection_.reset(); });
  }
  net::Connection& connection() { return *connection_; }  // io thread

  std::optional<net::ReceivedRecord> next_record() {
    const TimePoint deadline = Clock::now() + kPatience;
    MutexLock lock(mutex_);
    while (records_.empty()) {
      if (end_ || !changed_.wait_until(mutex_, deadline)) return std::nullopt;
    }
    net::ReceivedRecord record = std::move(records_.front());
    records_.pop_front();
    return record;
  }
  // Returns: how the link ended. The test fails when it does not end.
  Status wait_for_end() {
    const TimePoint deadline = Clock::now() + kPatience;
    MutexLock lock(mutex_);
    while (!end_) {
      if (!changed_.wait_until(mutex_, deadline)) {
        ADD_FAILURE() << "the link does not end";
        return {};
      }
    }
    return *end_;
  }

 private:
  net::IoThread& io_;
  net::ConnectionPtr connection_;  // io thread

  Mutex mutex_;
  CondVar changed_;
  std::deque<net::ReceivedRecord> records_ TESSERA_GUARDED_BY(mutex_);
  std::optional<Status> end_ TESSERA_GUARDED_BY(mutex_);
};

}  // namespace tessera::test
