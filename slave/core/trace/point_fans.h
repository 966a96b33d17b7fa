// Rays from one point to many, such as shadow rays of a point light: taken together by where they
// go, seen from that point, since neighbours on the picture need not be neighbours there.
//
// Threads. One object per thread; scratch memory, reused.
#pragma once

#include <bit>
#include <cstdint>
#include <memory>

#include "common/math/vec3.h"
#include "slave/core/kernel/kernel_table.h"

namespace tessera::core {

class PointFans {
 public:
  static constexpr int kRaysMax = kFanTargetsMax;

  PointFans() : targets_(std::make_unique<FanTargets>()) {}

  // Starts with no rays. A hit counts for t_min <= t <= t_max of each ray. Requires: t_min >= 0.
  void begin(Vec3f origin, float t_min) {
    for (int a = 0; a < 3; ++a) packet_.origin[a] = origin[a];
    packet_.t_min = t_min;
    targets_->count = 0;
  }
  // Requires: count() < kRaysMax. Rays are numbered from 0.
  void add(Vec3f direction, float t_max) {
    const int i = targets_->count++;
    for (int a = 0; a < 3; ++a) targets_->direction[a][i] = direction[a];
    targets_->t_max[i] = t_max;
  }
  int count() const { return targets_->count; }

  // Calls occluded(packet), which returns the bits of the rays that are blocked, for packets that hold
  // each ray once, and then report(number, is_blocked) for each.
  template <typename Occluded, typename Report>
  void trace(const KernelTable& kernels, Occluded&& occluded, Report&& report) {
    kernels.group_fans(*targets_);
    for (int g = 0; g < targets_->group_count; ++g) {
      const int* const numbers = fill(g);
      const std::uint64_t blocked = occluded(std::as_const(packet_));
      const int count = std::popcount(packet_.active);
      for (int i = 0; i < count; ++i) report(numbers[i], (blocked >> i & 1u) != 0);
    }
  }

 private:
  // Returns: the numbers of the packet's rays.
  const int* fill(int group) {
    const int begin = targets_->group[group], count = targets_->group[group + 1] - begin;
    const int* const numbers = targets_->order + begin;
    packet_.active = ~std::uint64_t{0} >> (kPacketRays - count);
    for (int i = 0; i < count; ++i) {
      for (int a = 0; a < 3; ++a) packet_.direction[a][i] = targets_->direction[a][numbers[i]];
      packet_.t_max[i] = targets_->t_max[numbers[i]];
    }
    return numbers;
  }

  std::unique_ptr<FanTargets> targets_;
  FanPacket packet_;
};

}  // namespace tessera::core
