// SPDX-License-Identifier: Apache-2.0
#include "master/schedule/slave_pace.h"

#include <algorithm>
#include <cmath>

#include "common/base/limits.h"

namespace tessera::master {
namespace {

// Weight of the newest tile in the moving averages. Tiles of one frame differ; some sixteen of them
// tell their mean, and a change of scene is learnt within them.
constexpr double kTileWeight = 1.0 / 16;
constexpr double kLinkWeight = 1.0 / 8;  // as RFC 6298
// Time for which a least round trip counts: a few frames, to see the link idle at least once.
constexpr std::chrono::seconds kLinkWindow{10};
constexpr std::size_t kLinkSamplesMax = 256;
// Depth that starvation asked for is given back, one tile at a time, after so long without it.
constexpr std::chrono::seconds kExtraKept{2};
// Before anything is known, three tiles wait per thread, as in Benthin's experiments.
constexpr std::uint32_t kFirstPrefetch = 3;

// What a slave says goes into sums over all slaves and into times to come. So no tile counts as
// longer than an hour, and none as so short that one slave seems as fast as all others together.
constexpr double kSecondsMax = 3600;
constexpr double kTileSecondsMin = 1e-6;

double sane(double seconds) {
  return std::isfinite(seconds) ? std::clamp(seconds, 0.0, kSecondsMax) : 0.0;
}

}  // namespace

void SlavePace::round_trip_measured(double seconds) { ping_seconds_ = sane(seconds); }

void SlavePace::tile_done(TimePoint now, double turnaround, double held, double render) {
  newest_ = std::max(newest_, now);
  const double tile = std::max(sane(render), kTileSecondsMin);  // 0 would mean "not known"
  if (tile_seconds_ == 0) {
    tile_seconds_ = tile;
  } else {
    tile_deviation_ += kTileWeight * (std::abs(tile - tile_seconds_) - tile_deviation_);
    tile_seconds_ += kTileWeight * (tile - tile_seconds_);
  }
  const double link = sane(turnaround - sane(held));
  link_seconds_ += (link_minima_.empty() ? 1 : kLinkWeight) * (link - link_seconds_);
  while (!link_minima_.empty() && link_minima_.back().seconds >= link) link_minima_.pop_back();
  if (link_minima_.size() < kLinkSamplesMax) link_minima_.push_back({newest_, link});
  while (link_minima_.size() > 1 && newest_ - link_minima_.front().when > kLinkWindow)
    link_minima_.pop_front();
  if (extra_ > 0 && newest_ - raised_ > kExtraKept) {
    --extra_;
    raised_ = newest_;
  }
}

void SlavePace::starved() {
  extra_ += std::max(1u, threads_ / 4);
  raised_ = newest_;
}

double SlavePace::round_trip_seconds() const {
  if (link_minima_.empty()) return ping_seconds_;
  return std::min(link_seconds_, 2 * link_minima_.front().seconds + tile_seconds_);
}

std::uint32_t SlavePace::depth() const {
  const std::uint32_t most = threads_ * std::uint32_t{kTilesPerWorkerMax};
  if (prefetch_per_thread_ >= 0) {
    return std::min(threads_ * (static_cast<std::uint32_t>(prefetch_per_thread_) + 1), most);
  }
  if (!is_known()) return std::min(threads_ * (kFirstPrefetch + 1), most);
  const double under_way = std::ceil(round_trip_seconds() / tile_seconds_) * threads_;
  const auto needed = static_cast<std::uint32_t>(
      std::min(static_cast<double>(threads_) + under_way + 1, static_cast<double>(most)));
  return std::min(needed + std::min(extra_, needed), most);
}

double SlavePace::tiles_per_second() const {
  return is_known() ? static_cast<double>(threads_) / tile_seconds_ : 0;
}

double SlavePace::completion_seconds(std::uint32_t held, double tile_seconds) const {
  const double tile = is_known() ? tile_seconds_ : tile_seconds;
  const double waiting = held + 1 > threads_ ? static_cast<double>(held + 1 - threads_) : 0;
  return round_trip_seconds() + tile * (1 + waiting / static_cast<double>(threads_));
}

}  // namespace tessera::master
