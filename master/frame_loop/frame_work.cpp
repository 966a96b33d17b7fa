// SPDX-License-Identifier: Apache-2.0
#include "master/frame_loop/frame_work.h"

#include <algorithm>

namespace tessera::master {

void FrameWork::slave_begins(Isa isa, Cluster& cluster) {
  FrameStats& stats = assembly.stats();
  if (!has_begun_) {
    has_begun_ = true;
    begin_ = Clock::now();
    bytes_sent_at_begin_ = cluster.bytes_sent();
    bytes_received_at_begin_ = cluster.bytes_received();
    stats.isa = cluster.bind_isa();
  }
  available_threads_ = std::max<double>(available_threads_, cluster.thread_count());
  if (isa != stats.isa) stats.is_mixed = true;
}

void FrameWork::add(SessionId session, const wire::TileResult& result, std::uint16_t slave_ordinal,
                    bool is_settled) {
  assembly.write_tile(result.tile, result.pixels, slave_ordinal);
  if (is_settled) assembly.settle_tile(result.tile);
  assembly.stats().rays += result.rays;
  assembly.stats().render_seconds += result.seconds;
  starved_seconds_ += result.starved_seconds;
  slaves_.insert(session);
}

void FrameWork::settle(const Cluster& cluster, const Scheduler& scheduler) {
  FrameStats& stats = assembly.stats();
  stats.seconds = seconds(Clock::now() - begin_);
  stats.slave_count = static_cast<std::uint32_t>(slaves_.size());
  stats.bytes_to_slaves = cluster.bytes_sent() - bytes_sent_at_begin_;
  stats.bytes_from_slaves = cluster.bytes_received() - bytes_received_at_begin_;
  const double available = stats.seconds * std::max(available_threads_, 1.0);
  stats.utilisation = std::clamp(1 - starved_seconds_ / std::max(available, 1e-9), 0.0, 1.0);
  for (const SessionId session : slaves_) {
    const SlavePace* pace = scheduler.pace(session);
    if (pace == nullptr) continue;
    stats.prefetch_max = std::max(stats.prefetch_max, pace->depth());
    stats.prefetch_min =
        stats.prefetch_min == 0 ? pace->depth() : std::min(stats.prefetch_min, pace->depth());
  }
}

}  // namespace tessera::master
