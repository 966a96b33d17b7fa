// SPDX-License-Identifier: Apache-2.0
// Single rays, packets of 64 and their hits as the kernels see them.
// Fixed-size types only and no functions.
#pragma once

#include <stdint.h>

#include "slave/core/accel/bvh_layout.h"

namespace tessera::core {

inline constexpr int kPacketRays = 64;
inline constexpr uint32_t kNoPrimitive = 0xffffffffu;

// Bound of the relative error of a reported t, with room for the roundings of a comparison: limits
// of t are moved out by this share where boxes are compared with them.
inline constexpr float kTimeSlack = 0x1p-20f;

// Whether a caller's packets have paid lately. It is kept in the packet that the caller fills again
// and again, so that packets that do not pay, as for rays far apart in a scene of tiny primitives,
// are not tried each time. It changes nothing but time. It belongs to one thread, as the packet
// does.
struct PacketHabit {
  int alone = 0;  // number of packets still to be traced ray by ray
  int wait = 1;   // number of them after the next that does not pay
};

// Where traversal begins for the fans that leave one point through one window: at the subtrees that
// the window meets, found once for all of them. In a kd-tree it is one subtree: the number of a
// node and its voxel.
inline constexpr int kEntryWidth = 16;
struct alignas(64) FanEntry {
  BvhNode<kEntryWidth> top;  // the nearest child first; kBvhNoChild behind the last
  int axis;                  // as in FanWindow; the fans' main axis
  float side;
};

// Directions d with d[axis] * side > 0 and low[k] <= d[(axis + 1 + k) % 3] / |d[axis]| <= high[k].
struct FanWindow {
  float origin[3];
  int axis;
  float side;  // 1 or -1
  float low[2], high[2];
};

// Rays that leave one point: camera rays, and shadow rays of a point light seen from the light.
// P(t) = origin + t * direction; a hit needs t_min <= t <= t_max, and t_min is not negative.
// Neighbours in the array are to be neighbours in space: 8 rays in a row are culled together.
struct alignas(64) FanPacket {
  float direction[3][kPacketRays];
  float t_max[kPacketRays];
  float origin[3];
  float t_min;
  uint64_t active;  // bit i: ray i is to be traced; the arrays need not be set for the others
  // Where traversal begins; null: at the root. Requires: it was found for this structure and a
  // window of this origin that all active rays pass. It changes nothing but time.
  const FanEntry* entry = nullptr;
  mutable PacketHabit habit;
};

// A FanPacket as kernels take it: its arrays stay where they are, with room for kPacketRays and at
// multiples of 64 bytes. See fan_of() in slave/core/ray/fan_of.h.
struct Fan {
  const float* direction[3];
  const float* t_max;
  float origin[3];
  float t_min;
  uint64_t active;
  const FanEntry* entry;
  PacketHabit* habit;
};

// Rays with origins and directions of their own, in as many packets as there are: packet p has the
// rays kPacketRays * p and those behind it. Arrays stay where they are: at multiples of 64 bytes,
// with room for kPacketRays rays a packet. Rays of one packet that form a bundle are traced
// together, and all others are, whatever packets they are in. See many_of() in
// slave/core/ray/many_of.h.
struct ManyRays {
  const float* origin[3];
  const float* direction[3];
  const float* t_min;
  const float* t_max;
  const uint64_t* active;  // by packet, as in FanPacket
  int packet_count;
  PacketHabit* habit;
  const uint32_t* excluded =
      nullptr;  // by ray, as ShadowFans::excluded_at_end; null: none is known
};

// 64 of such rays. A hit needs t_min <= t <= t_max.
struct alignas(64) RayPacket {
  float origin[3][kPacketRays];
  float direction[3][kPacketRays];
  float t_min[kPacketRays];
  float t_max[kPacketRays];
  uint64_t active;  // as in FanPacket
  mutable PacketHabit habit;
};

// Rays from one point that are still to be made into fans (see slave/core/trace/ray_groups.h).
inline constexpr int kFanTargetsMax = 1024;
inline constexpr int kFanTargetsRoom = kFanTargetsMax + kPacketRays;  // registers are loaded whole
struct alignas(64) FanTargets {
  float direction[3][kFanTargetsRoom];
  int count;

  // Made by group_fans(): fan g takes the rays order[group[g]] to order[group[g + 1] - 1], at most
  // kPacketRays of them and at least one. They leave a cube around their origin through the face
  // 2 * axis + (1 where they go down the axis).
  int group_count;
  int group[kFanTargetsMax + 1];
  int face[kFanTargetsMax];  // by group
  alignas(64) int order[kFanTargetsRoom];
  // Of the rays in `order`, where d is the direction and a the axis: the components of d along the
  // axes (a + 1) % 3 and (a + 2) % 3, over |d[a]|; and 1 / |d[a]|.
  alignas(64) float projected[3][kFanTargetsRoom];
};

// The fans of FanTargets, of which only is asked whether something blocks them. The excluded
// primitives are ones that a ray is known not to meet, although it begins or ends next to them (see
// horizon_layout.h). Traversal may skip their tests, which changes nothing but time, except for
// hits that the rounding of where the ray begins or ends has made.
struct ShadowFans {
  const FanTargets* targets;  // grouped
  float origin[3];
  float t_min, t_max;                          // of all rays
  uint32_t excluded_at_origin = kNoPrimitive;  // no ray meets it
  const uint32_t* excluded_at_end = nullptr;   // by number of the ray, or null: it does not meet it
  mutable PacketHabit habit = {};
};

// A hit needs t_min <= t <= t_max.
struct SingleRay {
  float origin[3];
  float direction[3];
  float t_min;
  float t_max;
  uint32_t excluded[2] = {kNoPrimitive, kNoPrimitive};  // see ShadowFans
};

struct SingleHit {
  float t;             // 0 for a miss
  uint32_t primitive;  // kNoPrimitive for a miss
};

// Misses have primitive kNoPrimitive and t 0.
struct alignas(64) PacketHits {
  float t[kPacketRays];
  uint32_t primitive[kPacketRays];
};

// PacketHits as kernels write them: arrays with room for kPacketRays, at multiples of 64 bytes.
struct HitArrays {
  float* t;
  uint32_t* primitive;
};

// A box that registers of 4 lanes can load; the fourth number is 0.
struct alignas(16) SceneBox {
  float lower[4], upper[4];
  float farthest[4];  // from 0: max(|lower|, |upper|)
};

}  // namespace tessera::core
