// SPDX-License-Identifier: Apache-2.0
// The series of runs behind the figures of tests/sim/README.md.
#include <array>
#include <cstdio>
#include <utility>
#include <vector>

#include "common/base/limits.h"
#include "tests/sim/scaling.h"

namespace tessera::sim {
namespace {

constexpr double kMiB = 1048576;
constexpr double kThesisLink = 22 * kMiB;                         // "more than 22 MB/s", 8.5
constexpr double kThesisSlaveLink = 100e6 / 8;                    // switched 100 Mbit Ethernet
constexpr double kFilteredBytes = 912e3, kUnfilteredBytes = 5e6;  // per frame, 9.6: 4 to 6 MB
constexpr double kFilterOverhead = 1.1;  // tiles overlap when slaves filter, 9.6

constexpr std::array<int, 9> kThesisSlaves = {1, 2, 4, 8, 16, 24, 32, 40, 48};
constexpr std::array<int, 12> kLargeSlaves = {1, 2, 5, 10, 20, 50, 100, 200, 300, 500, 700, 1000};

// Recorded scenes, from the fastest to the slowest. The thesis plots four of its own without
// figures; these make curves as 8.4 shows them.
constexpr std::array<const char*, 4> kScenes = {"waves", "cornell", "teapot", "room"};
// 9.6: global illumination runs at 20 frames/s on 48 CPUs at video resolution.
constexpr double kGlobalFramesPerSecond = 20.0 / 48;

using Costs = std::shared_ptr<const CostMap>;

// Returns: one for each of kScenes, or nothing after saying why.
std::vector<Costs> read_scenes(const SeriesOptions& options) {
  std::vector<Costs> scenes;
  for (const char* name : kScenes) {
    Result<CostMap> map = CostMap::read(options.costs_folder + "/" + name + ".csv");
    if (!map.is_ok()) {
      std::fprintf(stderr, "tessera-sim scaling: %s\n", map.status().message().c_str());
      return {};
    }
    scenes.push_back(std::make_shared<const CostMap>(std::move(*map)));
  }
  return scenes;
}

void print_head() {
  std::printf(
      "series,slaves,frames_per_s,speed_up,utilisation,wire_share,master_cpu_share,bytes_per_frame,"
      "tile_px,limit\n");
}

template <typename Counts>
void print_series(const std::string& name, ScalingCase scaling, const Counts& counts,
                  double byte_scale) {
  double alone = 0;
  for (const int slaves : counts) {
    scaling.slaves = slaves;
    const ScalingResult r = run_scaling(scaling);
    if (alone == 0) alone = r.frames_per_s / slaves;
    std::printf("%s,%d,%.3f,%.2f,%.4f,%.4f,%.4f,%.0f,%d,%s\n", name.c_str(), slaves, r.frames_per_s,
                r.frames_per_s / alone, r.utilisation, r.wire_share, r.master_cpu_share,
                r.bytes_per_frame * byte_scale, r.tile_edge_px, r.limit().c_str());
    std::fflush(stdout);
  }
}

ScalingCase thesis_case(const SeriesOptions& options, const Costs& costs) {
  ScalingCase scaling;
  scaling.costs = costs;
  scaling.master_bytes_per_s = kThesisLink;
  scaling.slave_bytes_per_s = kThesisSlaveLink;
  scaling.master_record_seconds = options.master_tile_seconds;
  return scaling;
}

// A picture of 3840x2160 pixels, in tiles as large as the master chooses.
ScalingCase large_case(const SeriesOptions& options, const Costs& costs, double gbit) {
  ScalingCase scaling;
  scaling.costs = costs;
  scaling.width_px = 3840;
  scaling.height_px = 2160;
  scaling.tile_edge_px = kTileEdgeAuto;
  scaling.master_bytes_per_s = gbit * 1e9 / 8;
  scaling.slave_bytes_per_s = 1e9 / 8;
  scaling.master_record_seconds = options.master_tile_seconds;
  return scaling;
}

}  // namespace

int print_thesis_series(const SeriesOptions& options) {
  const std::vector<Costs> scenes = read_scenes(options);
  if (scenes.empty()) return 1;
  print_head();
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    print_series(kScenes[i], thesis_case(options, scenes[i]), kThesisSlaves, 1);
  }
  ScalingCase filtered = thesis_case(options, scenes.back());
  filtered.cost_scale = 1 / (kGlobalFramesPerSecond * scenes.back()->frame_seconds(0));
  print_series("filter on slaves", filtered, kThesisSlaves, 1);
  // More bytes over the same link are the same bytes over a slower one.
  ScalingCase unfiltered = filtered;
  unfiltered.cost_scale /= kFilterOverhead;
  unfiltered.master_bytes_per_s *= kFilteredBytes / kUnfilteredBytes;
  unfiltered.slave_bytes_per_s *= kFilteredBytes / kUnfilteredBytes;
  print_series("filter on master", unfiltered, kThesisSlaves, kUnfilteredBytes / kFilteredBytes);
  return 0;
}

int print_large_series(const SeriesOptions& options) {
  const std::vector<Costs> scenes = read_scenes(options);
  if (scenes.empty()) return 1;
  print_head();
  for (const double gbit : {10.0, 25.0}) {
    const std::string link = std::to_string(static_cast<int>(gbit)) + " Gbit/s";
    for (const std::size_t i : {std::size_t{0}, scenes.size() - 1}) {
      const std::string scene = std::string(kScenes[i]) + " 2160p " + link;
      ScalingCase large = large_case(options, scenes[i], gbit);
      print_series(scene, large, kLargeSlaves, 1);
      if (gbit > 10) continue;  // the master's CPU is the limit on any link
      large.tile_edge_px = 32;
      print_series(scene + " tiles of 32", large, kLargeSlaves, 1);
    }
    ScalingCase small = large_case(options, scenes.back(), gbit);
    small.width_px = 1280;
    small.height_px = 720;
    small.frames = 30;
    print_series(std::string(kScenes.back()) + " 720p " + link, small, kLargeSlaves, 1);
  }
  return 0;
}

}  // namespace tessera::sim
