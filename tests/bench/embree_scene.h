// SPDX-License-Identifier: Apache-2.0
// What scenes of Embree 3 (https://www.embree.org) are made of: its handles, what a device is asked
// for, and a geometry's triangles.
//
// Threads. As Embree's.
#pragma once

#include <embree3/rtcore.h>

#include <algorithm>
#include <cstdint>
#include <string>

#include "common/base/isa.h"
#include "slave/core/primitive/triangle/triangle_store.h"

namespace tessera::bench {

struct ReleaseEmbree {
  void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
  void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
};

inline std::string config_of(Isa isa, int threads) {
  static constexpr const char* kConfigs[] = {"sse2", "sse4.2", "avx2", "avx512"};
  return "threads=" + std::to_string(threads) +
         ",set_affinity=0,isa=" + kConfigs[static_cast<int>(isa)];
}

inline bool count_bytes(void* sum, ssize_t bytes, bool) {
  *static_cast<std::int64_t*>(sum) += bytes;
  return true;
}

// Vertices are not shared here: the hierarchy is what is measured, and it copies them. Returns: the
// geometry's vertices.
inline float* set_triangles(RTCGeometry geometry, const core::TriangleStore& triangles) {
  const auto count = static_cast<std::size_t>(triangles.primitive_count());
  auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0,
                                                               RTC_FORMAT_FLOAT3, 12, 3 * count));
  auto* indices = static_cast<unsigned*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, count));
  std::copy(triangles.vertices.begin(), triangles.vertices.end(), vertices);
  for (std::size_t i = 0; i < 3 * count; ++i) indices[i] = static_cast<unsigned>(i);
  return vertices;
}

}  // namespace tessera::bench
