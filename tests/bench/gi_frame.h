// SPDX-License-Identifier: Apache-2.0
// One frame lit by VPLs, rendered by one thread, for measuring: through a table of kernels that
// keeps time and, if wanted, the shadow rays.
//
// Threads. One.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "common/frame/frame_settings.h"
#include "common/frame/frame_stats.h"
#include "slave/core/scene/prepared_scene.h"
#include "tests/bench/workload.h"

namespace tessera::bench {

// The parts of a frame that are timed. All but the last are kernels; kRest: what is outside of
// them, as packing rays, adding up and writing pixels.
enum class GiPart {
  kCamera,
  kShadow,
  kGroup,
  kStrength,
  kAdd,
  kFilter,
  kBounce,   // closest hits of rays that scatter, to compensate the bound
  kSurface,  // points where rays have met surfaces, and what is there
  kSample,   // points of the sequence, directions, lights, BSDFs
  kWalks,    // all kernels while VPLs are made
  kRest
};
inline constexpr int kGiParts = 11;
const char* gi_part_name(GiPart part);

struct GiFrame {
  std::vector<float> rgb;
  double cpu_seconds = 0;  // VPLs included
  RayCounts rays;
  std::array<double, kGiParts> share{};  // of cpu_seconds
  double seconds(GiPart part) const { return share[static_cast<std::size_t>(part)] * cpu_seconds; }
};

// Renders a whole frame with igi in tiles of settings.tile_edge_px.
GiFrame render_gi(const core::PreparedScene& scene, const FrameSettings& settings, Isa isa);

// Returns: the shadow rays from the points to the VPL, for every `one_in`-th pair of a VPL and a
// batch of points.
Workload shadow_rays_of(const core::PreparedScene& scene, const FrameSettings& settings, Isa isa,
                        int one_in);

// Renders with any renderer on all threads, without taking times.
std::vector<float> render_fast(const core::PreparedScene& scene, const FrameSettings& settings,
                               Isa isa);

double median(std::vector<double> values);

}  // namespace tessera::bench
