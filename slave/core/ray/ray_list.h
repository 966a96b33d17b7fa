// SPDX-License-Identifier: Apache-2.0
// Rays with origins of their own that a caller puts together and has traced by one call.
//
// Threads. One object per thread; scratch memory, reused.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "common/math/vec3.h"
#include "slave/core/ray/excluded_primitives.h"
#include "slave/core/ray/packet_layout.h"
#include "slave/core/simd/axis_arrays.h"

namespace tessera::core {

// The ray in place i is in packet i / kPacketRays. Rays of one packet are to look alike where the
// caller knows of any that do; those of others may be anything. Places may stay empty.
class RayList {
 public:
  static constexpr int kRaysMax = kFanTargetsMax;
  static constexpr int kPacketsMax = kRaysMax / kPacketRays;
  static constexpr float kNoEnd = std::numeric_limits<float>::infinity();

  void clear() {
    std::fill_n(active_, packet_count_, std::uint64_t{0});
    packet_count_ = 0;
    excluded_.clear();
  }
  // Puts a ray in a place. Requires: it is empty, and below kRaysMax.
  void put(int place, Vec3f origin, Vec3f direction, float t_max = kNoEnd, float t_min = 0) {
    put_vector(origin, origin_, place);
    put_vector(direction, direction_, place);
    t_min_[place] = t_min;
    t_max_[place] = t_max;
    active_[place / kPacketRays] |= std::uint64_t{1} << place % kPacketRays;
    packet_count_ = std::max(packet_count_, place / kPacketRays + 1);
  }
  // Says of a ray that was put that it is known not to meet a primitive (ManyRays::excluded).
  void exclude(int place, std::uint32_t primitive) { excluded_.exclude(place, primitive); }
  int packet_count() const { return packet_count_; }
  // Bits of the rays of a packet.
  std::uint64_t active(int packet) const { return active_[packet]; }
  Vec3f origin(int place) const { return vector_at(origin_, place); }
  std::uint32_t excluded(int place) const { return excluded_.of(place); }
  Vec3f direction(int place) const { return vector_at(direction_, place); }

  ManyRays many() const {
    return {{origin_[0], origin_[1], origin_[2]},
            {direction_[0], direction_[1], direction_[2]},
            t_min_,
            t_max_,
            active_,
            packet_count_,
            &habit_,
            excluded_.numbers()};
  }
  void copy_packet(int packet, RayPacket& to) const {
    const auto at = static_cast<std::size_t>(packet) * kPacketRays;
    for (int a = 0; a < 3; ++a) {
      std::copy_n(origin_[a] + at, kPacketRays, to.origin[a]);
      std::copy_n(direction_[a] + at, kPacketRays, to.direction[a]);
    }
    std::copy_n(t_min_ + at, kPacketRays, to.t_min);
    std::copy_n(t_max_ + at, kPacketRays, to.t_max);
    to.active = active_[packet];
  }

 private:
  alignas(64) float origin_[3][kRaysMax];
  alignas(64) float direction_[3][kRaysMax];
  alignas(64) float t_min_[kRaysMax];
  alignas(64) float t_max_[kRaysMax];
  std::uint64_t active_[kPacketsMax] = {};  // by packet
  int packet_count_ = 0;
  ExcludedPrimitives<kRaysMax> excluded_;
  mutable PacketHabit habit_;
};

// What the rays of a RayList have hit, by place; see PacketHits.
struct ListHits {
  alignas(64) float t[RayList::kRaysMax];
  alignas(64) std::uint32_t primitive[RayList::kRaysMax];

  HitArrays arrays() { return {t, primitive}; }
  void copy_packet(int packet, PacketHits& to) const {
    const auto at = static_cast<std::size_t>(packet) * kPacketRays;
    std::copy_n(t + at, kPacketRays, to.t);
    std::copy_n(primitive + at, kPacketRays, to.primitive);
  }
};

}  // namespace tessera::core
