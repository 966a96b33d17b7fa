// SPDX-License-Identifier: Apache-2.0
// When to send a Ping and when to call the peer dead, for one connection. Any byte counts as life;
// a peer is dead after heartbeat * (missed + 1) + round trip of silence.
//
// If our own thread slept (the machine was suspended or overloaded), bytes may wait unread; so a
// look that comes late never calls the peer dead, only the one after it may.
//
// Threads. Pure: times go in. One owner thread.
//
// Invariants. due() lies after the last look and not after the moment at which the peer would be
// dead. A caller that looks whenever a look is due finds death on time, not a fraction of a
// heartbeat after it.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>

#include "common/base/clock.h"
#include "common/base/limits.h"

namespace tessera::net {

// How often both ends of a link that say nothing else show that they live, and how many times that
// may be missed. The master decides, and tells every peer in Welcome.
struct Pulse {
  // What a person may ask for; the wire allows a shorter heartbeat (tests).
  static constexpr std::uint32_t kHeartbeatMsLeast = 20, kHeartbeatMsMost = 60'000;
  static constexpr std::uint32_t kMissedMost = 100;

  std::uint32_t heartbeat_ms = kHeartbeatMs;
  std::uint32_t missed_max = kHeartbeatsMissedMax;

  std::chrono::milliseconds silence_max() const {
    return std::chrono::milliseconds(std::uint64_t{heartbeat_ms} * (missed_max + 1));
  }
};

// The pulse between an application and a master whose slaves have `slaves`: never a shorter silence
// than kAppHeartbeatsMissedMax usual heartbeats, nor one that is shorter than theirs.
inline Pulse application_pulse(const Pulse& slaves) {
  constexpr std::uint32_t kSilenceMs = kHeartbeatMs * (kAppHeartbeatsMissedMax + 1);
  Pulse pulse;
  pulse.heartbeat_ms = std::max<std::uint32_t>(slaves.heartbeat_ms, kHeartbeatMs);
  const std::uint32_t beats = (kSilenceMs + pulse.heartbeat_ms - 1) / pulse.heartbeat_ms;
  pulse.missed_max = std::max({slaves.missed_max, beats - 1, 1u});
  return pulse;
}

enum class LivenessAction { kNone, kPing, kDead };

class Liveness {
 public:
  explicit Liveness(const Pulse& pulse)
      : Liveness(std::chrono::milliseconds(pulse.heartbeat_ms),
                 static_cast<int>(pulse.missed_max)) {}
  Liveness(std::chrono::milliseconds heartbeat, int missed_max)
      : heartbeat_(heartbeat), silence_max_(heartbeat * (missed_max + 1)) {}

  // Smoothed round trip of this connection; 0 until it is known.
  void set_rtt(Duration rtt) { rtt_ = rtt; }

  LivenessAction look(TimePoint now, TimePoint last_sent, TimePoint last_received) {
    const bool is_late = has_looked_ && now > due_ + heartbeat_ / 2;
    has_looked_ = true;
    const TimePoint dead_at = last_received + silence_max_ + rtt_;
    const bool must_ping = now - last_sent >= heartbeat_;
    due_ = std::min(dead_at, (must_ping ? now : last_sent) + heartbeat_);
    due_ = std::max(due_, now + (is_late ? heartbeat_ / 8 : std::chrono::milliseconds(1)));
    if (!is_late && now > dead_at) return LivenessAction::kDead;
    return must_ping ? LivenessAction::kPing : LivenessAction::kNone;
  }

  // When to look again at the latest.
  TimePoint due() const { return due_; }
  std::chrono::milliseconds heartbeat() const { return heartbeat_; }
  std::chrono::milliseconds silence_max() const { return silence_max_; }

 private:
  std::chrono::milliseconds heartbeat_;
  std::chrono::milliseconds silence_max_;
  Duration rtt_{};
  bool has_looked_ = false;
  TimePoint due_{};
};

// Bounds the Pings of a peer, each of which costs an answer. An honest peer sends one a heartbeat;
// after a stall of the network or of our own, all of the longest silence may come at once.
class PingAllowance {
 public:
  static constexpr double kPerHeartbeat = 4;
  static constexpr double kAtOnce = 64;  // beyond those of the longest silence

  explicit PingAllowance(const Pulse& pulse)
      : heartbeat_(std::chrono::milliseconds(std::max(pulse.heartbeat_ms, 1u))),
        most_(kAtOnce + kPerHeartbeat * (pulse.missed_max + 1)),
        left_(most_) {}

  // Counts a Ping. Returns: false for one too many.
  bool admit(TimePoint now) {
    if (last_ != TimePoint{})
      left_ = std::min(most_, left_ + kPerHeartbeat * seconds(now - last_) / seconds(heartbeat_));
    last_ = now;
    left_ -= 1;
    return left_ >= 0;
  }

 private:
  Duration heartbeat_;
  double most_;
  double left_;
  TimePoint last_{};
};

// The heartbeat of a new connection: `usual`, or longer where missed_max of them would not be more
// than two round trips, so that a far peer is not taken for a dead one.
inline std::chrono::milliseconds heartbeat_for(std::chrono::milliseconds usual, int missed_max,
                                               Duration rtt) {
  const auto least = std::chrono::floor<std::chrono::milliseconds>(2 * rtt / missed_max) +
                     std::chrono::milliseconds(1);
  return std::max(usual, least);
}

}  // namespace tessera::net
