// SPDX-License-Identifier: Apache-2.0
// How fast one slave is and how far away: what prefetch depth it needs so that its render threads
// never wait for the network, and when a tile leased to it now will be back. Pure.
//
// Depth. While a result and the next lease are under way (the round trip), every render thread must
// find tiles in the queue: (round trip / time per tile) of them for each thread, besides the one in
// work (Little's law). One more for each slave covers the result that is being sent. Where threads
// starved although tiles were there, the depth grows by up to its own size again: tile times and
// delays vary, and the averages do not show it.
//
// The round trip of a tile is what lies between lease and result less the time that the slave held
// the tile. It is limited by twice its smallest recent value, as BBR does (Cardwell et al. 2016): a
// link that is full shows long round trips, and more tiles under way would make them longer.
//
// Threads. One owner. Invariants. (1) threads <= depth() <= kTilesPerWorkerMax * threads. (2) Every
// figure is finite and not negative, whatever the slave reports.
#pragma once

#include <cstdint>
#include <deque>

#include "common/base/clock.h"

namespace tessera::master {

class SlavePace {
 public:
  // `prefetch_per_thread`: tiles waiting per thread, or kPrefetchAuto.
  static constexpr int kPrefetchAuto = -1;
  // Requires: threads >= 1.
  SlavePace(std::uint32_t threads, int prefetch_per_thread)
      : threads_(threads), prefetch_per_thread_(prefetch_per_thread) {}

  // Takes the round trip of heartbeats, which stands in until tiles have shown it.
  void round_trip_measured(double seconds);
  // A result came. `turnaround`: from lease to result; `held`: from the lease's arrival at the
  // slave to the result's departure; `render`: the part of that on a render thread.
  void tile_done(TimePoint now, double turnaround, double held, double render);
  // Render threads waited on an empty queue although the master had tiles for them.
  void starved();

  std::uint32_t threads() const { return threads_; }
  // Tiles that it may hold, the ones in work included.
  std::uint32_t depth() const;
  // False until the first result.
  bool is_known() const { return tile_seconds_ > 0; }
  double tile_seconds() const { return tile_seconds_; }  // on one thread, recent mean
  // Recent mean plus twice the mean deviation: nearly all tiles take less.
  double tile_seconds_high() const { return tile_seconds_ + 2 * tile_deviation_; }
  double round_trip_seconds() const;
  double tiles_per_second() const;  // 0 until known
  // Time until the answer to a tile leased now, with `held` tiles there already. `tile_seconds`
  // stands in while the slave's own time is not known.
  double completion_seconds(std::uint32_t held, double tile_seconds) const;

 private:
  const std::uint32_t threads_;
  const int prefetch_per_thread_;
  double tile_seconds_ = 0, tile_deviation_ = 0;
  double ping_seconds_ = 0;
  double link_seconds_ = 0;  // smoothed
  struct LinkSample {
    TimePoint when;
    double seconds = 0;
  };
  std::deque<LinkSample> link_minima_;  // ascending in both: the front is the window's least
  std::uint32_t extra_ = 0;             // against starvation
  TimePoint newest_, raised_;
};

}  // namespace tessera::master
