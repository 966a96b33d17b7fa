// The series of runs behind the figures of tests/sim/README.md.
#include <array>
#include <cstdio>

#include "tests/sim/scaling.h"

namespace tessera::sim {
namespace {

constexpr double kMiB = 1048576;
constexpr double kThesisLink = 22 * kMiB;                         // "more than 22 MB/s", 8.5
constexpr double kThesisSlaveLink = 100e6 / 8;                    // switched 100 Mbit Ethernet
constexpr double kFilteredBytes = 912e3, kUnfilteredBytes = 5e6;  // per frame, 9.6: 4 to 6 MB
constexpr double kFilterOverhead = 1.1;  // tiles overlap when slaves filter, 9.6

struct Scene {
  const char* name;
  double frames_per_s;  // of one CPU of the thesis's cluster
};
// The thesis plots its four scenes without figures; these make curves as 8.4 shows them: the
// simplest reaches the plateau with a quarter of the slaves, the most complex hardly at all.
constexpr std::array<Scene, 4> kScenes = {
    {{"simple", 2.1}, {"medium", 1.2}, {"complex", 0.8}, {"huge", 0.5}}};
// 9.6: 20 frames/s with 48 CPUs at video resolution.
constexpr Scene kGlobalIllumination = {"global illumination", 20.0 / 48};

constexpr std::array<int, 9> kThesisSlaves = {1, 2, 4, 8, 16, 24, 32, 40, 48};
constexpr std::array<int, 10> kLargeSlaves = {1, 2, 5, 10, 20, 50, 100, 200, 500, 1000};

void print_head() {
  std::printf(
      "series,slaves,frames_per_s,speed_up,utilisation,wire_share,master_cpu_share,bytes_per_frame,"
      "limit\n");
}

template <typename Counts>
void print_series(const char* name, ScalingCase scaling, const Counts& counts, double byte_scale) {
  double alone = 0;
  for (const int slaves : counts) {
    scaling.slaves = slaves;
    const ScalingResult r = run_scaling(scaling);
    if (alone == 0) alone = r.frames_per_s / slaves;
    std::printf("%s,%d,%.3f,%.2f,%.4f,%.4f,%.4f,%.0f,%s\n", name, slaves, r.frames_per_s,
                r.frames_per_s / alone, r.utilisation, r.wire_share, r.master_cpu_share,
                r.bytes_per_frame * byte_scale, r.limit().c_str());
    std::fflush(stdout);
  }
}

ScalingCase thesis_case(const Scene& scene) {
  ScalingCase scaling;
  const double tiles = 20 * 15;  // 640 x 480 in tiles of 32
  scaling.tile_seconds = 1 / (scene.frames_per_s * tiles);
  scaling.master_bytes_per_s = kThesisLink;
  scaling.slave_bytes_per_s = kThesisSlaveLink;
  return scaling;
}

}  // namespace

int print_thesis_series() {
  print_head();
  for (const Scene& scene : kScenes) {
    print_series(scene.name, thesis_case(scene), kThesisSlaves, 1);
  }
  ScalingCase filtered = thesis_case(kGlobalIllumination);
  print_series("filter on slaves", filtered, kThesisSlaves, 1);
  // More bytes over the same link are the same bytes over a slower one.
  ScalingCase unfiltered = filtered;
  unfiltered.tile_seconds /= kFilterOverhead;
  unfiltered.master_bytes_per_s *= kFilteredBytes / kUnfilteredBytes;
  unfiltered.slave_bytes_per_s *= kFilteredBytes / kUnfilteredBytes;
  print_series("filter on master", unfiltered, kThesisSlaves, kUnfilteredBytes / kFilteredBytes);
  return 0;
}

// 3840 x 2160 at 5 ms a tile (41 CPU seconds a frame) and 1280 x 720 at 2 ms (1.8 s).
int print_large_series() {
  print_head();
  for (const double gbit : {10.0, 25.0}) {
    ScalingCase large;
    large.width_px = 3840;
    large.height_px = 2160;
    large.tile_seconds = 5e-3;
    large.master_bytes_per_s = gbit * 1e9 / 8;
    large.slave_bytes_per_s = 1e9 / 8;
    large.frames = 6;
    char name[64];
    for (const double cpu : {5e-6, 1e-6}) {
      large.master_record_seconds = cpu;
      std::snprintf(name, sizeof(name), "2160p %.0f Gbit/s %.0f us/tile", gbit, 1e6 * cpu);
      print_series(name, large, kLargeSlaves, 1);
    }
    ScalingCase small = large;
    small.width_px = 1280;
    small.height_px = 720;
    small.tile_seconds = 2e-3;
    small.frames = 30;
    small.master_record_seconds = 5e-6;
    std::snprintf(name, sizeof(name), "720p %.0f Gbit/s 5 us/tile", gbit);
    print_series(name, small, kLargeSlaves, 1);
  }
  return 0;
}

}  // namespace tessera::sim
