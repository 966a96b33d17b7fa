// SPDX-License-Identifier: Apache-2.0
// How fast a cluster is: the product's own master and slaves in virtual time, without faults, with
// an application inside the master's process that always has the next frame ready.
//
// Threads. One.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "tests/sim/cost_map.h"

namespace tessera::sim {

// The master's CPU-seconds for one tile, from `tessera-bench exchange`, line "plain, 64
// connections", column "cpu us" (with TLS 18 us). tessera-sim's --master-us and record_us replace
// it.
inline constexpr double kMasterTileSeconds = 11e-6;

struct ScalingCase {
  int slaves = 1;
  int threads = 1;  // of each slave
  int width_px = 640, height_px = 480;
  int tile_edge_px = 32;  // kTileEdgeAuto: as the master chooses
  // Costs of tiles: the recorded ones times cost_scale. Without a recording, tiles of tile_edge_px
  // cost tile_seconds on average, in waves of amplitude tile_spread over the picture, since
  // neighbouring tiles cost alike.
  std::shared_ptr<const CostMap> costs;
  double cost_scale = 1;
  double tile_seconds = 0.01;
  double tile_spread = 0.5;
  double master_bytes_per_s = 0;  // each direction; 0: no limit
  double slave_bytes_per_s = 0;
  double delay_seconds = 50e-6;                       // one way, between master and slave
  double master_record_seconds = kMasterTileSeconds;  // for each record that comes
  int frames_in_flight = 2;
  int prefetch_per_thread = -1;  // -1: as the product chooses
  int frames = 12;               // measured, after as many to warm up as the pipeline needs
};

struct ScalingResult {
  double frames_per_s = 0;
  double utilisation = 0;  // of the slaves' threads
  double wire_share = 0;   // of the master's downlink
  double master_cpu_share = 0;
  double bytes_per_frame = 0;  // from the slaves
  int tile_edge_px = 0;        // of the last frame
  std::uint64_t events = 0;
  // Returns: "slaves" when they are all at work, else what holds them up: "wire", "master CPU" or
  // "tail".
  std::string limit() const;
};

ScalingResult run_scaling(const ScalingCase& scaling);

struct SeriesOptions {
  std::string costs_folder;  // of record_costs.py
  double master_tile_seconds = kMasterTileSeconds;
};

// Prints the series of the README as CSV on stdout. Returns: the program's exit code.
int print_thesis_series(const SeriesOptions& options);
int print_large_series(const SeriesOptions& options);

}  // namespace tessera::sim
