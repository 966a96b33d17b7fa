// SPDX-License-Identifier: Apache-2.0
// The ways to trace rays through one of our structures.
//
// Threads. As contenders.
#pragma once

#include <algorithm>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "slave/core/ray/fan_of.h"
#include "slave/core/ray/many_of.h"
#include "slave/core/trace/fan_window.h"
#include "slave/core/trace/scene_tracer.h"
#include "tests/bench/contender.h"

namespace tessera::bench {

// One acceleration structure, of which view_of() and kernels_of() are known.
template <class Index>
class StructureWays {
  using View = decltype(view_of(std::declval<const Index&>()));

 public:
  StructureWays(Index index, const core::KernelTable& table, const std::string& name,
                bool with_sizes)
      : index_(std::move(index)),
        view_(view_of(index_)),
        table_(table),
        kernels_(kernels_of(table, view_)),
        name_(name),
        with_sizes_(with_sizes) {}

  void enter(std::vector<Contender>& contenders) {
    const auto add = [&](const char* way, RayKind kind, auto trace) {
      contenders.push_back(
          {name_ + " " + way, true, kind,
           [this, trace](const RayBlock& rays, BlockHits& hits) { (this->*trace)(rays, hits); },
           false});
    };
    add("fan of 64", RayKind::kPrimary, &StructureWays::trace_fans<64>);
    add("fan, entered", RayKind::kPrimary, &StructureWays::trace_fans<64, true>);
    if (with_sizes_) {
      add("fan of 32", RayKind::kPrimary, &StructureWays::trace_fans<32>);
      add("fan of 16", RayKind::kPrimary, &StructureWays::trace_fans<16>);
      add("fan of 8", RayKind::kPrimary, &StructureWays::trace_fans<8>);
    }
    add("fan from light", RayKind::kShadow, &StructureWays::trace_light_fans<0>);
    if (with_sizes_) {
      add("fan of 64", RayKind::kShadow, &StructureWays::trace_light_fans<64>);
      add("fan of 32", RayKind::kShadow, &StructureWays::trace_light_fans<32>);
      add("fan of 16", RayKind::kShadow, &StructureWays::trace_light_fans<16>);
      add("fan of 8", RayKind::kShadow, &StructureWays::trace_light_fans<8>);
    }
    for (const RayKind kind : {RayKind::kPrimary, RayKind::kBounce}) {
      add("packet", kind, &StructureWays::trace_packets);
      add("many", kind, &StructureWays::trace_many);
      add("single", kind, &StructureWays::trace_singles);
    }
    add("packet", RayKind::kShadow, &StructureWays::occlude_packets);
    add("many", RayKind::kShadow, &StructureWays::occlude_many);
    add("single", RayKind::kShadow, &StructureWays::occlude_singles);
  }

 private:
  // Bits of the rays of a block.
  struct Bits {
    std::uint64_t of[kBlockRays / core::kPacketRays];
  };

  static core::SingleRay ray_of(const RayBlock& rays, int i) {
    return {{rays.origin[0][i], rays.origin[1][i], rays.origin[2][i]},
            {rays.direction[0][i], rays.direction[1][i], rays.direction[2][i]},
            0,
            rays.t_max[i],
            {rays.has_excluded ? rays.excluded[i] : core::kNoPrimitive, core::kNoPrimitive}};
  }

  // Finds the node where the fans of a block of 32x32 pixels begin. Returns: whether there is such
  // a node.
  bool enter(const RayBlock& rays, core::FanEntry& entry) const {
    if (rays.count != kBlockRays) return false;
    constexpr int kCorners[] = {0, 0x155, 0x2aa, 0x3ff};  // of a Morton square
    Vec3f outermost[4];
    for (int c = 0; c < 4; ++c) {
      for (int a = 0; a < 3; ++a) (&outermost[c].x)[a] = rays.direction[a][kCorners[c]];
    }
    const Vec3f origin{rays.origin[0][0], rays.origin[1][0], rays.origin[2][0]};
    const auto window = core::fan_window(origin, outermost);
    if (window) kernels_.enter_fans(view_, *window, entry);
    return window.has_value();
  }

  template <int kRays, bool kIsEntered = false>
  void trace_fans(const RayBlock& rays, BlockHits& hits) {
    core::FanEntry entry;
    core::PacketHabit habit;
    const bool is_entered = kIsEntered && enter(rays, entry);
    for (int first = 0; first < rays.count; first += kRays) {
      const int count = std::min(kRays, rays.count - first);
      if constexpr (kRays == core::kPacketRays) {
        kernels_.closest_fan(view_,
                             fan_at(rays, first, count, is_entered ? &entry : nullptr, habit),
                             {hits.t + first, hits.primitive + first});
      } else {
        copy_small_fan(rays, first, count, hits);
      }
    }
  }

  static core::Fan fan_at(const RayBlock& rays, int first, int count, const core::FanEntry* entry,
                          core::PacketHabit& habit) {
    return {{rays.direction[0] + first, rays.direction[1] + first, rays.direction[2] + first},
            rays.t_max + first,
            {rays.origin[0][0], rays.origin[1][0], rays.origin[2][0]},
            0,
            ~std::uint64_t{0} >> (core::kPacketRays - count),
            entry,
            &habit};
  }

  // Arrays of fewer rays do not begin where kernels want them to.
  void copy_small_fan(const RayBlock& rays, int first, int count, BlockHits& hits) {
    core::FanPacket packet;
    core::PacketHits found;
    packet.t_min = 0;
    packet.active = ~std::uint64_t{0} >> (core::kPacketRays - count);
    for (int a = 0; a < 3; ++a) {
      packet.origin[a] = rays.origin[a][first];
      std::copy_n(rays.direction[a] + first, count, packet.direction[a]);
    }
    std::copy_n(rays.t_max + first, count, packet.t_max);
    kernels_.closest_fan(view_, core::fan_of(packet), core::arrays_of(found));
    std::copy_n(found.t, count, hits.t + first);
    std::copy_n(found.primitive, count, hits.primitive + first);
  }

  // Traces the shadow segments as fans from the light, of at most kRays each, one by one; 0: as
  // grouping made them, and by twos where the kernel does that.
  template <int kRays>
  void trace_light_fans(const RayBlock& rays, BlockHits& hits) {
    const Vec3f light = {rays.origin[0][0] + rays.direction[0][0],
                         rays.origin[1][0] + rays.direction[1][0],
                         rays.origin[2][0] + rays.direction[2][0]};
    static thread_local const auto targets = std::make_unique<core::FanTargets>();
    targets->count = rays.count;
    for (int a = 0; a < 3; ++a) {
      for (int i = 0; i < rays.count; ++i) targets->direction[a][i] = -rays.direction[a][i];
    }
    table_.group_fans(*targets);
    const core::ShadowFans fans{targets.get(),
                                {light.x, light.y, light.z},
                                1e-4f,
                                1,
                                core::kNoPrimitive,
                                rays.has_excluded ? rays.excluded : nullptr};
    std::fill_n(hits.t, rays.count, 0.0f);
    if constexpr (kRays > 0) return trace_light_fans_of(kRays, fans, *targets, hits);
    std::uint64_t blocked[core::kFanTargetsMax];
    kernels_.occluded_fans(view_, fans, blocked);
    for (int g = 0; g < targets->group_count; ++g)
      take(blocked[g], *targets, targets->group[g], targets->group[g + 1], hits);
  }

  // Each fan is made the only group.
  void trace_light_fans_of(int most, const core::ShadowFans& fans, core::FanTargets& targets,
                           BlockHits& hits) {
    const int count = targets.group_count;
    std::vector<int> begins(targets.group, targets.group + count + 1);
    std::vector<int> faces(targets.face, targets.face + count);
    targets.group_count = 1;
    for (std::size_t g = 0; g < faces.size(); ++g) {
      targets.face[0] = faces[g];
      for (int begin = begins[g]; begin < begins[g + 1]; begin += most) {
        targets.group[0] = begin;
        targets.group[1] = std::min(begin + most, begins[g + 1]);
        std::uint64_t blocked = 0;
        kernels_.occluded_fans(view_, fans, &blocked);
        take(blocked, targets, begin, targets.group[1], hits);
      }
    }
  }

  // blocked: bits of the rays in places `begin` to `end` of targets.order.
  static void take(std::uint64_t blocked, const core::FanTargets& targets, int begin, int end,
                   BlockHits& hits) {
    for (int i = begin; i < end; ++i, blocked >>= 1)
      hits.primitive[targets.order[i]] = (blocked & 1u) != 0 ? 0 : core::kNoPrimitive;
  }

  static int fill(const RayBlock& rays, int first, core::RayPacket& packet) {
    const int count = std::min(core::kPacketRays, rays.count - first);
    packet.active = ~std::uint64_t{0} >> (core::kPacketRays - count);
    for (int a = 0; a < 3; ++a) {
      copy_rays<core::kPacketRays>(rays.origin[a] + first, count, packet.origin[a]);
      copy_rays<core::kPacketRays>(rays.direction[a] + first, count, packet.direction[a]);
    }
    std::fill_n(packet.t_min, count, 0.0f);
    copy_rays<core::kPacketRays>(rays.t_max + first, count, packet.t_max);
    return count;
  }

  // A block as it lies.
  static core::ManyRays many_of(const RayBlock& rays, Bits& active, core::PacketHabit& habit) {
    alignas(64) static constexpr float kZeros[kBlockRays] = {};
    const int packets = (rays.count + core::kPacketRays - 1) / core::kPacketRays;
    std::fill_n(active.of, packets, ~std::uint64_t{0});
    active.of[packets - 1] >>= packets * core::kPacketRays - rays.count;
    return {{rays.origin[0], rays.origin[1], rays.origin[2]},
            {rays.direction[0], rays.direction[1], rays.direction[2]},
            kZeros,
            rays.t_max,
            active.of,
            packets,
            &habit,
            rays.has_excluded ? rays.excluded : nullptr};
  }

  void trace_many(const RayBlock& rays, BlockHits& hits) {
    Bits active;
    core::PacketHabit habit;
    kernels_.closest_many(view_, many_of(rays, active, habit), {hits.t, hits.primitive});
  }

  void occlude_many(const RayBlock& rays, BlockHits& hits) {
    Bits active, blocked;
    core::PacketHabit habit;
    kernels_.occluded_many(view_, many_of(rays, active, habit), blocked.of);
    for (int i = 0; i < rays.count; ++i) {
      const bool is_blocked =
          (blocked.of[i / core::kPacketRays] >> i % core::kPacketRays & 1u) != 0;
      hits.t[i] = 0;
      hits.primitive[i] = is_blocked ? 0 : core::kNoPrimitive;
    }
  }

  void trace_packets(const RayBlock& rays, BlockHits& hits) {
    core::RayPacket packet;
    core::PacketHits found;
    for (int first = 0; first < rays.count; first += core::kPacketRays) {
      const int count = fill(rays, first, packet);
      kernels_.closest_many(view_, core::many_of(packet), core::arrays_of(found));
      copy_rays<core::kPacketRays>(found.t, count, hits.t + first);
      copy_rays<core::kPacketRays>(found.primitive, count, hits.primitive + first);
    }
  }

  void occlude_packets(const RayBlock& rays, BlockHits& hits) {
    core::RayPacket packet;
    for (int first = 0; first < rays.count; first += core::kPacketRays) {
      const int count = fill(rays, first, packet);
      std::uint64_t blocked = 0;
      kernels_.occluded_many(view_, core::many_of(packet), &blocked);
      for (int i = 0; i < count; ++i) {
        hits.t[first + i] = 0;
        hits.primitive[first + i] = (blocked >> i & 1u) != 0 ? 0 : core::kNoPrimitive;
      }
    }
  }

  void trace_singles(const RayBlock& rays, BlockHits& hits) {
    for (int i = 0; i < rays.count; ++i) {
      core::SingleHit hit;
      kernels_.closest_ray(view_, ray_of(rays, i), hit);
      hits.t[i] = hit.t;
      hits.primitive[i] = hit.primitive;
    }
  }

  void occlude_singles(const RayBlock& rays, BlockHits& hits) {
    for (int i = 0; i < rays.count; ++i) {
      const bool is_blocked = kernels_.occluded_ray(view_, ray_of(rays, i));
      hits.t[i] = 0;
      hits.primitive[i] = is_blocked ? 0 : core::kNoPrimitive;
    }
  }

  Index index_;
  View view_;
  const core::KernelTable& table_;
  const core::ViewKernels<View>& kernels_;
  std::string name_;
  bool with_sizes_;
};

}  // namespace tessera::bench
