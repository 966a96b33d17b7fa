// SPDX-License-Identifier: Apache-2.0
// What a cluster keeps of one slave, from its Hello to its loss. For the cluster's own files.
//
// Threads. Io thread only.
//
// Invariants. scene_link and sender come together, when the slave has joined.
#pragma once

#include <cstdint>
#include <memory>

#include "common/base/clock.h"
#include "common/base/ids.h"
#include "common/net/liveness.h"
#include "common/wire/messages.h"
#include "master/cluster/peer_link.h"
#include "master/cluster/scene_sender.h"
#include "master/cluster/tile_times.h"

namespace tessera::master {

struct SlaveEntry {
  wire::Hello hello;
  std::uint64_t token = 0;
  std::uint16_t ordinal = 0;
  net::Pulse pulse;  // of both connections
  TimePoint since = Clock::now();
  std::unique_ptr<PeerLink> tile_link;
  std::unique_ptr<PeerLink> scene_link;  // null until joined
  std::unique_ptr<SceneSender> sender;
  SceneVersion built = 0;
  std::uint64_t tiles_done = 0;
  std::uint32_t repeats = 0;  // results that it sent once more
  TileTimes tile_times;
  double busy_seconds = 0;  // of render threads, in this window
  double utilisation = 0;
  std::uint64_t tiles_at_window = 0;
  double tiles_per_second = 0;
  TimePoint window_start = Clock::now();

  bool is_joined() const { return scene_link != nullptr; }
};

}  // namespace tessera::master
