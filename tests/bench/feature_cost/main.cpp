// SPDX-License-Identifier: Apache-2.0
// Traces a number of fans, given as argument, through a generated mesh with one kernel: for
// feature_cost.sh, which counts instructions.
#include <cstdio>
#include <cstdlib>

#include "slave/core/primitive/primitive_index.h"
#include "slave/core/primitive/triangle/triangle_store.h"
#include "slave/core/ray/fan_of.h"
#include "slave/core/simd/isa_support.h"
#include "slave/core/trace/scene_tracer.h"
#include "tests/bench/feature_cost/kernels.h"
#include "tests/support/test_meshes.h"

namespace tessera::core {
namespace {

// 8x8 camera rays of a picture of 512x512 towards the mesh.
FanPacket make_fan(int number) {
  FanPacket fan{};
  fan.origin[0] = 0.3f;
  fan.origin[1] = 3;
  fan.origin[2] = 2.5f;
  const int left = number * 8 % 512, top = number / 64 * 8 % 512;
  for (int i = 0; i < kPacketRays; ++i) {
    const float x = static_cast<float>(left + i % 8) / 256 - 1;
    const float y = static_cast<float>(top + i / 8) / 256 - 1;
    fan.direction[0][i] = 0.6f * x - 0.1f;
    fan.direction[1][i] = -0.75f + 0.5f * y;
    fan.direction[2][i] = -0.65f - 0.4f * y;
    fan.t_max[i] = 1e30f;
  }
  fan.active = ~0ull;
  return fan;
}

int run(int fan_count) {
  if ((cpu_isas() & isa_bit(Isa::kAvx2)) == 0) {
    std::printf("no AVX2\n");
    return 77;
  }
  std::vector<Bounds3f> boxes;
  const TriangleStore store =
      make_triangle_store(test::make_scene(test::make_torus(150, 60)), boxes);
  const auto bvh = index_by_bvh<8>(boxes, store.vertices, {1, nullptr});
  const auto kd = index_by_kd<8>(boxes, store.vertices, {1, nullptr});
  const FeatureScene scene{view_of(*bvh), view_of(*kd)};
  PacketHits hits{};
  std::uint64_t sum = 0;
  for (int i = 0; i < fan_count; ++i) {
    const FanPacket fan = make_fan(i);
    sum += trace_once(scene, fan_of(fan), arrays_of(hits)) + hits.primitive[i % kPacketRays];
  }
  std::printf("%llu\n", static_cast<unsigned long long>(sum));
  return 0;
}

}  // namespace
}  // namespace tessera::core

int main(int argc, char** argv) { return argc == 2 ? tessera::core::run(std::atoi(argv[1])) : 2; }
