// SPDX-License-Identifier: Apache-2.0
// Who feeds whom while scenes go out. The master feeds the first slave that lacks a version; each
// later one is fed by the last of the chain, chunk by chunk. So the master's link carries each byte
// about once, and every slave's link each byte once in and once out.
//
// Slaves form a chain since links are as fast in one direction as in the other: in a tree a slave
// with two children sends each byte twice and halves the rate below it. What a chain costs more is
// the time of one chunk for each of its links (master/README.md has the sum). Chains end at
// kDepthMax; then the master begins another.
//
// Versions follow each other: a slave keeps its feeder from one to the next, even when the feeder
// has not yet asked for the new one itself, so that their connection stands and its window is open.
//
// A feeder is bypassed when its child says so (it cannot be reached, went away, altered a chunk),
// when it is lost, and when it holds back what it has: over a whole window it had more than its
// child, and the child got less than half of what the master gives those whom it feeds itself.
//
// Threads. One owner (the io thread). Pure: time comes in. Invariants. (1) Feeding never goes in a
// circle. (2) A slave feeds at most kChildrenMax others at a time. (3) A child is given at most
// kFeedersMax feeders for a version, none of them twice; then the master feeds it. So each fault
// costs a bounded number of new plans.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <vector>

#include "common/base/clock.h"
#include "common/base/ids.h"
#include "common/wire/messages.h"

namespace tessera::master {

inline constexpr SessionId kFedByMaster = 0;

// `child` is to be fed by `feeder` from now on.
struct Feed {
  SessionId child = 0;
  SceneVersion version = 0;
  SessionId feeder = kFedByMaster;
};

class RelayPlan {
 public:
  // A slave that lacks less is fed by the master: sending that is quicker than arranging a relay.
  static constexpr std::uint64_t kBytesMin = 1 << 20;
  static constexpr std::uint32_t kChildrenMax = 1, kFeedersMax = 4, kDepthMax = 32;
  // Time over which a feeder is judged: T_hs of the fault matrix.
  static constexpr std::chrono::milliseconds kWindow{kHandshakeMs};
  // How far a feeder may be ahead of its child without holding back: chunks on the way.
  static constexpr std::uint64_t kSlackBytes = 1 << 20;

  // `can_feed`: the slave listens for others. `is_near`: it came over loopback, and only slaves
  // that did so too can reach it.
  void joined(SessionId session, bool can_feed, bool is_near);
  std::vector<Feed> lost(SessionId session, TimePoint now);

  // A slave lacks `bytes` of a version of `total_bytes`. Returns: who feeds it.
  SessionId want(SessionId session, SceneVersion version, std::uint64_t bytes,
                 std::uint64_t total_bytes, bool may_relay, TimePoint now);
  // The slave has `bytes` bytes of the version; with all of them it is complete.
  void progress(SessionId session, SceneVersion version, std::uint64_t bytes, TimePoint now);
  // The slave has the whole version; it may have lacked nothing, so that want() was never called.
  void complete(SessionId session, SceneVersion version, std::uint64_t total_bytes);
  void gave_up(SessionId session, SceneVersion version);  // the scene failed there

  // A child gives its feeder up. A stale report (the child has another one by now) changes nothing.
  std::vector<Feed> failed(SessionId child, SceneVersion version, SessionId feeder,
                           wire::RelayFault fault, TimePoint now);
  std::vector<Feed> tick(TimePoint now);
  void retire(SceneVersion first_kept);

  std::optional<SessionId> feeder_of(SessionId child, SceneVersion version) const;

 private:
  struct Slave {
    bool can_feed = false, is_near = false;
    bool is_barred = false;  // it altered a chunk
    std::optional<SessionId> last_feeder;
  };
  struct Transfer {
    SessionId feeder = kFedByMaster;
    std::uint64_t total_bytes = 0, bytes = 0;
    bool is_complete = false;
    std::set<SessionId> tried;
    TimePoint window_began{};
    std::uint64_t bytes_then = 0, feeder_bytes_then = 0;
  };
  using Key = std::pair<SceneVersion, SessionId>;

  SessionId choose(SessionId child, SceneVersion version) const;
  // The child's feeder of the version before; nothing when it cannot feed the child this time.
  std::optional<SessionId> usual_feeder(SessionId child, SceneVersion version) const;
  std::uint32_t children_of(SessionId feeder, SceneVersion version, SessionId but) const;
  void feed(SessionId child, Transfer& transfer, SessionId feeder);
  bool may_feed(SessionId feeder, SessionId child, SceneVersion version) const;
  void refeed(const Key& child, TimePoint now, std::vector<Feed>& feeds);
  void begin_window(const Key& key, Transfer& transfer, TimePoint now);
  bool holds_back(const Key& key, const Transfer& transfer) const;

  std::map<SessionId, Slave> slaves_;
  std::map<Key, Transfer> transfers_;
  double master_rate_ = 0;  // bytes per second to a slave that it feeds; 0: not seen
};

}  // namespace tessera::master
