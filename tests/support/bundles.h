// Single rays through the bundle interface of the kernels.
// Fills bundles of 16 in the given order, so that a test chooses a ray's companions.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "slave/core/kernel/kernel_table.h"
#include "slave/core/render/tile_renderer.h"
#include "tests/support/reference_tracer.h"

namespace tessera::test {

struct Hit {
  std::uint32_t primitive = core::kNoPrimitive;
  float t = 0, u = 0, v = 0;
  bool is_hit() const { return primitive != core::kNoPrimitive; }
  bool operator==(const Hit&) const = default;
};

inline void set_lane(core::RayBundle& bundle, int lane, const Ray& ray) {
  for (int a = 0; a < 3; ++a) {
    bundle.origin[a][lane] = ray.origin[a];
    bundle.direction[a][lane] = ray.direction[a];
  }
  bundle.t_min[lane] = ray.t_min;
  bundle.t_max[lane] = ray.t_max;
  bundle.active |= 1u << lane;
}

inline Hit lane_of(const core::HitBundle& hits, int lane) {
  return {hits.primitive[lane], hits.t[lane], hits.u[lane], hits.v[lane]};
}

// Traces rays in bundles of 16, in order.
inline std::vector<Hit> trace_bundled(const core::KernelTable& kernels, const core::SceneView& view,
                                      const std::vector<Ray>& rays) {
  std::vector<Hit> hits;
  for (std::size_t first = 0; first < rays.size(); first += core::kBundleRays) {
    core::RayBundle bundle{};
    core::HitBundle out;
    const int count =
        static_cast<int>(std::min<std::size_t>(core::kBundleRays, rays.size() - first));
    for (int lane = 0; lane < count; ++lane) {
      set_lane(bundle, lane, rays[first + static_cast<std::size_t>(lane)]);
    }
    kernels.trace_closest(view, bundle, out);
    for (int lane = 0; lane < count; ++lane) hits.push_back(lane_of(out, lane));
  }
  return hits;
}

inline Hit trace_single(const core::KernelTable& kernels, const core::SceneView& view,
                        const Ray& ray, int lane = 0) {
  core::RayBundle bundle{};
  core::HitBundle out;
  set_lane(bundle, lane, ray);
  kernels.trace_closest(view, bundle, out);
  return lane_of(out, lane);
}

inline std::vector<Isa> isas_here() {
  std::vector<Isa> isas;
  for (int i = 0; i < 4; ++i) {
    if (core::supported_isas() >> i & 1u) isas.push_back(static_cast<Isa>(i));
  }
  return isas;
}

}  // namespace tessera::test
