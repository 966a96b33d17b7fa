// SPDX-License-Identifier: Apache-2.0
// Limits how fast one address may open connections, by a token bucket for each address. A
// connection takes a token, and one comes back every 1 / per_second seconds. A connection from an
// address without tokens is turned away at once, before any memory or handshake is spent on it.
//
// Threads. Pure: times go in. One owner thread.
//
// Invariants. (1) In any interval of s seconds an address is admitted at most burst + per_second *
// s times. (2) At most addresses_max addresses are told apart; while so many have tokens missing,
// the others share one bucket.
#pragma once

#include <cstddef>
#include <string>
#include <unordered_map>

#include "common/base/clock.h"

namespace tessera::net {

struct AcceptLimits {
  // A machine that runs 500 slaves opens 1,000 connections at once when the master comes back, and
  // an application with its status page some more.
  double burst = 1024;
  // A handshake costs the master a millisecond of its network thread: at this rate, a tenth of one
  // core. A slave that is turned away comes again after its pause (kReconnectMaxMs at most).
  double per_second = 100;
  // Each address takes 64 bytes and a node of the table: half a megabyte in all.
  std::size_t addresses_max = 4096;
};

class AcceptRate {
 public:
  explicit AcceptRate(const AcceptLimits& limits = {}) : limits_(limits) {}

  // Whether a connection from this address, made now, may stay. Requires: `now` never goes back.
  bool admit(const std::string& address, TimePoint now);

  std::size_t address_count() const { return buckets_.size(); }

 private:
  struct Bucket {
    double tokens = 0;
    TimePoint since;  // of `tokens`
  };
  double tokens_of(const Bucket& bucket, TimePoint now) const;
  bool take(Bucket& bucket, TimePoint now) const;

  const AcceptLimits limits_;
  std::unordered_map<std::string, Bucket> buckets_;  // of addresses with tokens missing, and some
  Bucket others_;                                    // since the epoch: full at first
  TimePoint sweep_at_{};                             // full buckets are not swept out before this
};

}  // namespace tessera::net
