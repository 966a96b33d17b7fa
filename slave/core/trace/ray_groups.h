// SPDX-License-Identifier: Apache-2.0
// Rays grouped by where they go, seen from one point. Shadow rays of a light are grouped so, since
// neighbours on the picture need not be neighbours there.
//
// Threads. One object per thread; scratch memory, reused.
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "common/math/vec3.h"
#include "slave/core/kernels/kernel_table.h"
#include "slave/core/ray/excluded_primitives.h"

namespace tessera::core {

// Bits of the first `count` rays of a packet. Requires: 0 < count <= kPacketRays.
inline std::uint64_t bits_below(int count) { return ~std::uint64_t{0} >> (kPacketRays - count); }

class RayGroups {
 public:
  static constexpr int kRaysMax = kFanTargetsMax;

  RayGroups() : targets_(std::make_unique<FanTargets>()) {}

  void clear() {
    targets_->count = 0;
    excluded_.clear();
  }
  // Requires: count() < kRaysMax. Returns: the ray's number, from 0.
  int add(Vec3f direction) {
    const int i = targets_->count++;
    for (int a = 0; a < 3; ++a) targets_->direction[a][i] = direction[a];
    return i;
  }
  int count() const { return targets_->count; }
  // Says of a ray that it is known not to meet the primitive that it ends next to.
  void exclude(int ray, std::uint32_t primitive) { excluded_.exclude(ray, primitive); }

  // Returns: how many groups hold the rays; each ray is in one, each group has 1 to kPacketRays.
  int form(const KernelTable& kernels) {
    kernels.group_fans(*targets_);
    return targets_->group_count;
  }
  int group_count() const { return targets_->group_count; }
  // The numbers of the rays of a group. Requires: form() was called after the last add().
  std::span<const int> group(int g) const {
    const int begin = targets_->group[g], end = targets_->group[g + 1];
    return {targets_->order + begin, static_cast<std::size_t>(end - begin)};
  }
  // The groups as fans, one each, from a point. Requires: it is where the directions begin.
  ShadowFans fans_from(Vec3f origin, float t_min, float t_max) const {
    return {targets_.get(),     {origin.x, origin.y, origin.z}, t_min, t_max, kNoPrimitive,
            excluded_.numbers()};
  }

 private:
  std::unique_ptr<FanTargets> targets_;
  ExcludedPrimitives<kRaysMax> excluded_;
};

}  // namespace tessera::core
