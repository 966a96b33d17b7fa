// SPDX-License-Identifier: Apache-2.0
#include <time.h>

#include <algorithm>
#include <memory>
#include <utility>

#include "slave/core/kernels/kernel_table.h"
#include "slave/core/primitive/freeform/patched_index.h"
#include "slave/core/primitive/instance/instanced_index.h"
#include "slave/core/primitive/primitive_index.h"
#include "slave/core/primitive/triangle/triangle_clipper.h"
#include "slave/core/ray/fan_of.h"
#include "slave/core/trace/fan_window.h"
#include "slave/core/trace/scene_tracer.h"
#include "tests/bench/contender.h"

namespace tessera::bench {
namespace {

double seconds_of(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

// One acceleration structure and the ways to trace rays through it.
template <class Index>
class Structure {
  using View = decltype(core::view_of(std::declval<const Index&>()));

 public:
  Structure(Index index, const core::KernelTable& table, const std::string& name, bool with_sizes)
      : index_(std::move(index)),
        view_(core::view_of(index_)),
        table_(table),
        kernels_(core::kernels_of(table, view_)),
        name_(name),
        with_sizes_(with_sizes) {}

  void enter(std::vector<Contender>& contenders) {
    const auto add = [&](const char* way, RayKind kind, auto trace) {
      contenders.push_back(
          {name_ + " " + way, true, kind,
           [this, trace](const RayBlock& rays, BlockHits& hits) { (this->*trace)(rays, hits); },
           false});
    };
    add("fan of 64", RayKind::kPrimary, &Structure::trace_fans<64>);
    add("fan, entered", RayKind::kPrimary, &Structure::trace_fans<64, true>);
    if (with_sizes_) {
      add("fan of 32", RayKind::kPrimary, &Structure::trace_fans<32>);
      add("fan of 16", RayKind::kPrimary, &Structure::trace_fans<16>);
      add("fan of 8", RayKind::kPrimary, &Structure::trace_fans<8>);
    }
    add("fan from light", RayKind::kShadow, &Structure::trace_light_fans);
    for (const RayKind kind : {RayKind::kPrimary, RayKind::kBounce}) {
      add("packet", kind, &Structure::trace_packets);
      add("single", kind, &Structure::trace_singles);
    }
    add("packet", RayKind::kShadow, &Structure::occlude_packets);
    add("single", RayKind::kShadow, &Structure::occlude_singles);
  }

 private:
  static core::SingleRay ray_of(const RayBlock& rays, int i) {
    return {{rays.origin[0][i], rays.origin[1][i], rays.origin[2][i]},
            {rays.direction[0][i], rays.direction[1][i], rays.direction[2][i]},
            0,
            rays.t_max[i]};
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

  // Traces the shadow segments as fans from the light.
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
    const core::ShadowFans fans{targets.get(), {light.x, light.y, light.z}, 1e-4f, 1};
    std::uint64_t blocked[core::kFanTargetsMax];
    kernels_.occluded_fans(view_, fans, blocked);
    std::fill_n(hits.t, rays.count, 0.0f);
    for (int g = 0; g < targets->group_count; ++g) {
      for (int i = targets->group[g]; i < targets->group[g + 1]; ++i, blocked[g] >>= 1)
        hits.primitive[targets->order[i]] = (blocked[g] & 1u) != 0 ? 0 : core::kNoPrimitive;
    }
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

  void trace_packets(const RayBlock& rays, BlockHits& hits) {
    core::RayPacket packet;
    core::PacketHits found;
    for (int first = 0; first < rays.count; first += core::kPacketRays) {
      const int count = fill(rays, first, packet);
      kernels_.closest_packet(view_, packet, core::arrays_of(found));
      copy_rays<core::kPacketRays>(found.t, count, hits.t + first);
      copy_rays<core::kPacketRays>(found.primitive, count, hits.primitive + first);
    }
  }

  void occlude_packets(const RayBlock& rays, BlockHits& hits) {
    core::RayPacket packet;
    for (int first = 0; first < rays.count; first += core::kPacketRays) {
      const int count = fill(rays, first, packet);
      const std::uint64_t blocked = kernels_.occluded_packet(view_, packet);
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

class Ours final : public Entrants {
 public:
  Ours(const core::TriangleStore& triangles, const std::vector<Bounds3f>& boxes, Isa isa,
       const OursOptions& options)
      : options_(options) {
    const core::KernelTable& table = core::kernels_for(isa);
    if (table.lane_count >= 16) {
      build_all<16>(table, triangles, boxes);
    } else {
      build_all<8>(table, triangles, boxes);
    }
  }

  Ours(std::shared_ptr<const core::PatchStore> patches, const std::vector<Bounds3f>& boxes,
       Isa isa) {
    const core::KernelTable& table = core::kernels_for(isa);
    if (table.lane_count >= 16) {
      build_patched<16>(table, std::move(patches), boxes);
    } else {
      build_patched<8>(table, std::move(patches), boxes);
    }
  }

  Ours(const std::vector<core::TriangleStore>& frames, const std::vector<Bounds3f>& boxes,
       Isa isa) {
    const core::KernelTable& table = core::kernels_for(isa);
    if (table.lane_count >= 16) {
      build_deformed<16>(table, frames, boxes);
    } else {
      build_deformed<8>(table, frames, boxes);
    }
  }

  Ours(const Scene& scene, Isa isa) {
    const core::KernelTable& table = core::kernels_for(isa);
    if (table.lane_count >= 16) {
      build_instanced<16>(table, scene);
    } else {
      build_instanced<8>(table, scene);
    }
  }

 private:
  template <int W>
  void build_all(const core::KernelTable& table, const core::TriangleStore& triangles,
                 const std::vector<Bounds3f>& boxes) {
    const std::string width = std::to_string(W);
    const core::BuildControl alone{1, nullptr};
    const core::TriangleClipper clipper(triangles.vertices);
    build<core::IndexedBvh<W>>("bvh" + width, table, [&] {
      return core::index_by_bvh<W>(boxes, triangles.vertices, alone, core::usual_build(clipper));
    });
    if (!options_.with_kd) return;
    build<core::IndexedBvh<W>>("bvh" + width + "q", table, [&] {
      return core::index_by_bvh<W>(boxes, triangles.vertices, alone, core::spatial_build(clipper));
    });
    build<core::IndexedKd<W>>("kd" + width, table, [&] {
      return core::index_by_kd<W>(boxes, triangles.vertices, alone);
    });
    build<core::IndexedKd<W>>("kd" + width + "q", table, [&] {
      return core::index_by_kd<W>(boxes, triangles.vertices, alone, core::quality_build(clipper));
    });
  }

  template <int W>
  void build_deformed(const core::KernelTable& table,
                      const std::vector<core::TriangleStore>& frames,
                      const std::vector<Bounds3f>& boxes) {
    const core::BuildControl alone{1, nullptr};
    const std::span<const float> now = frames.back().vertices;
    build<core::IndexedBvh<W>>("built", table,
                               [&] { return core::index_by_bvh<W>(boxes, now, alone); });
    build<core::IndexedBvh<W>>("fast", table,
                               [&] { return core::index_fast<W>(boxes, now, alone); });
    const std::vector<Bounds3f> first_boxes = core::boxes_of(frames[0].vertices);
    auto fitted = core::index_by_bvh<W>(first_boxes, frames[0].vertices, alone);
    for (std::size_t frame = 1; frame + 1 < frames.size(); ++frame)
      fitted = core::fit_index<W>(*fitted, frames[frame].vertices, alone);
    build<core::IndexedBvh<W>>("fitted", table,
                               [&] { return core::fit_index<W>(*fitted, now, alone); });
  }

  template <int W>
  void build_instanced(const core::KernelTable& table, const Scene& scene) {
    const core::BuildControl alone{1, nullptr};
    build<core::InstancedBvh<W>>("instanced" + std::to_string(W), table, [&] {
      auto placed = core::place_instances<W>(scene, {core::Instancing::kAlways}, {}, alone);
      return core::index_instances<W>(std::move(*placed), {}, nullptr, alone);
    });
  }

  template <int W>
  void build_patched(const core::KernelTable& table,
                     std::shared_ptr<const core::PatchStore> patches,
                     const std::vector<Bounds3f>& boxes) {
    const double store = 1e-6 * static_cast<double>(patches->memory_bytes());
    build<core::PatchedBvh<W>>("patches", table, [&] {
      return core::index_patches<W>({{}, {}, {}, boxes}, patches, {1, nullptr});
    });
    builds.back().megabytes += store;
  }

  template <class Index, class Build>
  void build(const std::string& name, const core::KernelTable& table, const Build& build_index) {
    const double start = process_cpu_seconds(), start_wall = wall_seconds();
    Index index = std::move(*build_index());
    const double seconds = process_cpu_seconds() - start, wall = wall_seconds() - start_wall;
    builds.push_back({name, seconds, wall, 1e-6 * static_cast<double>(index.memory_bytes())});
    auto structure =
        std::make_shared<Structure<Index>>(std::move(index), table, name, options_.with_sizes);
    structure->enter(contenders);
    structures_.push_back(structure);
  }

  const OursOptions options_;
  std::vector<std::shared_ptr<void>> structures_;
};

}  // namespace

double wall_seconds() { return seconds_of(CLOCK_MONOTONIC); }
double thread_cpu_seconds() { return seconds_of(CLOCK_THREAD_CPUTIME_ID); }
double process_cpu_seconds() { return seconds_of(CLOCK_PROCESS_CPUTIME_ID); }

std::unique_ptr<Entrants> make_ours(const core::TriangleStore& triangles,
                                    const std::vector<Bounds3f>& boxes, Isa isa,
                                    const OursOptions& options) {
  return std::make_unique<Ours>(triangles, boxes, isa, options);
}

std::unique_ptr<Entrants> make_ours_deformed(const std::vector<core::TriangleStore>& frames,
                                             const std::vector<Bounds3f>& boxes, Isa isa) {
  return std::make_unique<Ours>(frames, boxes, isa);
}

std::unique_ptr<Entrants> make_ours_patched(std::shared_ptr<const core::PatchStore> patches,
                                            const std::vector<Bounds3f>& boxes, Isa isa) {
  return std::make_unique<Ours>(std::move(patches), boxes, isa);
}

std::unique_ptr<Entrants> make_ours_instanced(const Scene& scene, Isa isa) {
  return std::make_unique<Ours>(scene, isa);
}

}  // namespace tessera::bench
