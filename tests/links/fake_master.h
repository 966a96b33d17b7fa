// SPDX-License-Identifier: Apache-2.0
// A scripted master with threads, for tests of SlaveHost: takes the slave's links over local pairs.
// It waits for what must come, and never judges how long that took.
//
// Threads. Constructor, next(), send() and the like: the test thread.
#pragma once

#include <chrono>
#include <deque>
#include <optional>
#include <utility>
#include <vector>

#include "common/base/clock.h"
#include "common/base/mutex.h"
#include "common/net/connection.h"
#include "common/net/connector.h"
#include "common/net/local_pair.h"
#include "slave/slave_node.h"
#include "tests/support/patience.h"
#include "tests/unit/slave/master_script.h"

namespace tessera::slave {

class FakeMaster final : public MasterScript {
 public:
  FakeMaster() : master_io_("fake"), slave_io_("net") {}
  ~FakeMaster() override {
    master_io_.run_and_wait([this] { links_.clear(); });
  }

  net::IoThread& slave_io() { return slave_io_; }

  net::LinkFactory factory() {
    return [this](std::function<void(Result<net::ConnectionPtr>)> on_connected) {
      {
        MutexLock lock(mutex_);
        if (is_away_) {
          on_connected(Status::unavailable("nobody is there"));
          return std::unique_ptr<net::ConnectAttempt>();
        }
      }
      auto [slave_end, master_end] = net::make_local_pair(slave_io_, master_io_);
      master_io_.post([this, end = std::move(master_end)] { adopt(end); });
      on_connected(std::move(slave_end));
      return std::unique_ptr<net::ConnectAttempt>();
    };
  }

  void set_away(bool is_away) {
    MutexLock lock(mutex_);
    is_away_ = is_away;
  }

  // Waits for so many more pings. Returns: false when they do not come.
  bool wait_for_pings(int count) {
    const TimePoint deadline = Clock::now() + test::kPatience;
    MutexLock lock(mutex_);
    const int wanted = pings_ + count;
    while (pings_ < wanted) {
      if (!arrived_.wait_until(mutex_, deadline) && pings_ < wanted) return false;
    }
    return true;
  }
  bool has_event() {
    MutexLock lock(mutex_);
    return !events_.empty();
  }

  std::optional<Event> next() override {
    const TimePoint deadline = Clock::now() + test::kPatience;
    MutexLock lock(mutex_);
    while (events_.empty()) {
      if (!arrived_.wait_until(mutex_, deadline) && events_.empty()) return std::nullopt;
    }
    Event event = std::move(events_.front());
    events_.pop_front();
    return event;
  }

  void send(std::size_t link, wire::Message message) override {
    master_io_.run_and_wait([&] { links_.at(link)->send(wire::encode(std::move(message))); });
  }
  void close(std::size_t link) override {
    master_io_.run_and_wait([&] { links_.at(link)->close(); });
  }

 private:
  void adopt(const net::ConnectionPtr& end) {
    const std::size_t link = links_.size();
    links_.push_back(end);
    net::ConnectionCallbacks callbacks;
    callbacks.on_record = [this, link](net::ReceivedRecord record) {
      Result<wire::Message> message = wire::decode(std::move(record));
      if (!message.is_ok()) return put({link, std::nullopt, message.status().message()});
      if (const auto* ping = std::get_if<wire::Ping>(&*message)) {
        {
          MutexLock lock(mutex_);
          ++pings_;
        }
        arrived_.notify_all();
        return links_.at(link)->send(wire::encode(wire::Pong{ping->sent_ns}));
      }
      if (!std::holds_alternative<wire::Pong>(*message)) put({link, std::move(*message), {}});
    };
    callbacks.on_closed = [this, link](Status status) {
      put({link, std::nullopt, "closed: " + status.message()});
    };
    end->start(std::move(callbacks), wire::session_limits());
  }

  void put(Event event) {
    {
      MutexLock lock(mutex_);
      events_.push_back(std::move(event));
    }
    arrived_.notify_all();
  }

  net::IoThread master_io_, slave_io_;
  std::vector<net::ConnectionPtr> links_;  // master_io_

  Mutex mutex_;
  CondVar arrived_;
  std::deque<Event> events_ TESSERA_GUARDED_BY(mutex_);
  bool is_away_ TESSERA_GUARDED_BY(mutex_) = false;
  int pings_ TESSERA_GUARDED_BY(mutex_) = 0;
};

}  // namespace tessera::slave
