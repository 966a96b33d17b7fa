// When to send a Ping and when to call the peer dead, for one connection. Any byte counts as life;
// a peer is dead after heartbeat * (missed + 1) of silence.
//
// If our own thread slept (the machine was suspended or overloaded), bytes may wait unread; so a
// look that comes late never calls the peer dead, only the one after it may.
//
// Threads. Pure: times go in. One owner thread.
#pragma once

#include <chrono>

#include "common/base/clock.h"

namespace tessera::slave {

enum class LivenessAction { kNone, kPing, kDead };

class Liveness {
 public:
  Liveness(std::chrono::milliseconds heartbeat, int missed_max)
      : heartbeat_(heartbeat), silence_max_(heartbeat * (missed_max + 1)) {}

  LivenessAction look(TimePoint now, TimePoint last_sent, TimePoint last_received) {
    const bool is_late = has_looked_ && now - looked_ > heartbeat_;
    has_looked_ = true;
    looked_ = now;
    if (!is_late && now - last_received > silence_max_) return LivenessAction::kDead;
    return now - last_sent >= heartbeat_ ? LivenessAction::kPing : LivenessAction::kNone;
  }

  std::chrono::milliseconds silence_max() const { return silence_max_; }

 private:
  std::chrono::milliseconds heartbeat_;
  std::chrono::milliseconds silence_max_;
  bool has_looked_ = false;
  TimePoint looked_{};
};

}  // namespace tessera::slave
