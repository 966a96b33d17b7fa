// A scripted master for tests of SlaveNode: takes its links over local pairs and gives the test
// thread every message in order; says only what the test tells it to (but for Pong).
//
// Threads. Constructor, expect(), send() and the like: the test thread.
#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <deque>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "common/base/clock.h"
#include "common/base/mutex.h"
#include "common/net/connection.h"
#include "common/wire/codec.h"
#include "slave/slave_node.h"

namespace tessera::slave {

inline constexpr std::chrono::seconds kPatience{20};

class FakeMaster {
 public:
  // What came: a message, or the end of a link.
  struct Event {
    std::size_t link = 0;  // in order of opening
    std::optional<wire::Message> message;
    std::string closed;
  };

  FakeMaster() : master_io_("fake"), slave_io_("net") {}
  ~FakeMaster() {
    master_io_.run_and_wait([this] { links_.clear(); });
  }

  net::IoThread& slave_io() { return slave_io_; }

  LinkFactory factory() {
    return [this](std::function<void(Result<net::ConnectionPtr>)> on_connected) {
      {
        MutexLock lock(mutex_);
        ++attempts_;
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
  // The master's thread does nothing for a while.
  void stall(std::chrono::milliseconds duration) {
    master_io_.post([duration] { std::this_thread::sleep_for(duration); });
  }
  int pings() {
    MutexLock lock(mutex_);
    return pings_;
  }
  int attempts() {
    MutexLock lock(mutex_);
    return attempts_;
  }

  // Any message but heartbeats, or the end of a link.
  std::optional<Event> next(std::chrono::milliseconds patience = kPatience) {
    const TimePoint deadline = Clock::now() + patience;
    MutexLock lock(mutex_);
    while (events_.empty()) {
      if (!arrived_.wait_until(mutex_, deadline) && events_.empty()) return std::nullopt;
    }
    Event event = std::move(events_.front());
    events_.pop_front();
    return event;
  }

  // The next event must be an M; a default one otherwise.
  template <typename M>
  M expect(std::size_t* link = nullptr) {
    const std::optional<Event> event = next();
    if (!event) {
      ADD_FAILURE() << "nothing came";
      return {};
    }
    if (!event->message || !std::holds_alternative<M>(*event->message)) {
      ADD_FAILURE() << "instead came "
                    << (event->message ? wire::message_name(*event->message) : event->closed);
      return {};
    }
    if (link != nullptr) *link = event->link;
    return std::get<M>(*event->message);
  }

  // Skips what comes before the end of a link.
  bool expect_closed(std::size_t link) {
    while (std::optional<Event> event = next()) {
      if (event->link == link && !event->message) return true;
    }
    return false;
  }

  void send(std::size_t link, wire::Message message) {
    master_io_.run_and_wait([&] { links_.at(link)->send(wire::encode(std::move(message))); });
  }
  void close(std::size_t link) {
    master_io_.run_and_wait([&] { links_.at(link)->close(); });
  }

  // Hello, Welcome, Join, Joined. Returns: tile and scene link.
  std::pair<std::size_t, std::size_t> shake_hands(std::uint32_t heartbeat_ms = 250) {
    std::size_t tile = 0;
    std::size_t scene = 0;
    skip_to_hello(&tile);  // what an earlier session left behind
    const wire::Welcome welcome{1, ++session_, 4711 + session_, heartbeat_ms, 4};
    send(tile, welcome);
    const wire::Join join = expect<wire::Join>(&scene);
    EXPECT_EQ(join.session, welcome.session);
    EXPECT_EQ(join.token, welcome.token);
    EXPECT_NE(tile, scene);
    send(scene, wire::Joined{});
    return {tile, scene};
  }
  const wire::Hello& hello() const { return hello_; }

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
        return links_.at(link)->send(wire::encode(wire::Pong{ping->sent_ns}));
      }
      if (!std::holds_alternative<wire::Pong>(*message)) put({link, std::move(*message), {}});
    };
    callbacks.on_closed = [this, link](Status status) {
      put({link, std::nullopt, "closed: " + status.message()});
    };
    end->start(std::move(callbacks), wire::session_limits());
  }

  void skip_to_hello(std::size_t* link) {
    while (const std::optional<Event> event = next()) {
      if (!event->message || !std::holds_alternative<wire::Hello>(*event->message)) continue;
      hello_ = std::get<wire::Hello>(*event->message);
      *link = event->link;
      return;
    }
    ADD_FAILURE() << "no Hello came";
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
  wire::Hello hello_;
  std::uint64_t session_ = 0;

  Mutex mutex_;
  CondVar arrived_;
  std::deque<Event> events_ TESSERA_GUARDED_BY(mutex_);
  bool is_away_ TESSERA_GUARDED_BY(mutex_) = false;
  int pings_ TESSERA_GUARDED_BY(mutex_) = 0;
  int attempts_ TESSERA_GUARDED_BY(mutex_) = 0;
};

}  // namespace tessera::slave
