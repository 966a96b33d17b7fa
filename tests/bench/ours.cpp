#include <time.h>

#include <algorithm>

#include "slave/core/accel/bvh_builder.h"
#include "slave/core/accel/kd_builder.h"
#include "slave/core/kernel/kernel_table.h"
#include "slave/core/trace/ray_groups.h"
#include "tests/bench/contender.h"

namespace tessera::bench {
namespace {

double seconds_of(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

class Ours final : public Entrants {
 public:
  Ours(const core::TriangleStore& triangles, const std::vector<Bounds3f>& boxes, Isa isa)
      : kernels_(core::kernels_for(isa)) {
    double start = process_cpu_seconds();
    bvh_ = std::move(*core::build_bvh<8>(boxes, triangles.vertices, {1, nullptr}));
    builds.push_back(
        {"bvh8", process_cpu_seconds() - start, 1e-6 * static_cast<double>(bvh_.memory_bytes())});
    start = process_cpu_seconds();
    kd_ = std::move(*core::build_kd_tree(boxes, {1, nullptr}));
    builds.push_back(
        {"kd", process_cpu_seconds() - start, 1e-6 * static_cast<double>(kd_.memory_bytes())});
    const Vec3f low = bvh_.bounds.lower, high = bvh_.bounds.upper;
    bvh_view_ = {
        bvh_.nodes.data(), bvh_.blocks.data(), {low.x, low.y, low.z}, {high.x, high.y, high.z}};
    kd_view_ = {kd_.nodes().data(),
                kd_.primitive_refs().data(),
                triangles.vertices.data(),
                {low.x, low.y, low.z},
                {high.x, high.y, high.z}};
    const auto enter = [this](const char* name, RayKind kind, auto trace) {
      contenders.push_back({name, true, kind, [this, trace](const RayBlock& rays, BlockHits& hits) {
                              (this->*trace)(rays, hits);
                            }});
    };
    enter("bvh8 fan of 64", RayKind::kPrimary, &Ours::trace_fans);
    enter("bvh8 fan from light", RayKind::kShadow, &Ours::trace_light_fans);
    for (const RayKind kind : {RayKind::kPrimary, RayKind::kBounce}) {
      enter("bvh8 packet", kind, &Ours::trace_packets);
      enter("bvh8 single", kind, &Ours::trace_singles);
      enter("kd bundle of 16", kind, &Ours::trace_bundles);
    }
    enter("bvh8 packet", RayKind::kShadow, &Ours::occlude_packets);
    enter("bvh8 single", RayKind::kShadow, &Ours::occlude_singles);
    enter("kd bundle of 16", RayKind::kShadow, &Ours::occlude_bundles);
  }

 private:
  static core::SingleRay ray_of(const RayBlock& rays, int i) {
    return {{rays.origin[0][i], rays.origin[1][i], rays.origin[2][i]},
            {rays.direction[0][i], rays.direction[1][i], rays.direction[2][i]},
            0,
            rays.t_max[i]};
  }

  void trace_fans(const RayBlock& rays, BlockHits& hits) {
    core::FanPacket packet;
    core::PacketHits found;
    for (int first = 0; first < rays.count; first += core::kPacketRays) {
      const int count = std::min(core::kPacketRays, rays.count - first);
      packet.t_min = 0;
      packet.active = ~std::uint64_t{0} >> (core::kPacketRays - count);
      for (int a = 0; a < 3; ++a) {
        packet.origin[a] = rays.origin[a][first];
        std::copy_n(rays.direction[a] + first, count, packet.direction[a]);
      }
      std::copy_n(rays.t_max + first, count, packet.t_max);
      kernels_.bvh8.closest_fan(bvh_view_, packet, found);
      std::copy_n(found.t, count, hits.t + first);
      std::copy_n(found.primitive, count, hits.primitive + first);
    }
  }

  // The same segments, seen from the light.
  void trace_light_fans(const RayBlock& rays, BlockHits& hits) {
    const Vec3f light = {rays.origin[0][0] + rays.direction[0][0],
                         rays.origin[1][0] + rays.direction[1][0],
                         rays.origin[2][0] + rays.direction[2][0]};
    groups_.clear();
    for (int i = 0; i < rays.count; ++i)
      groups_.add({-rays.direction[0][i], -rays.direction[1][i], -rays.direction[2][i]});
    core::FanPacket packet;
    for (int a = 0; a < 3; ++a) packet.origin[a] = light[a];
    packet.t_min = 1e-4f;
    std::fill_n(packet.t_max, core::kPacketRays, 1.0f);
    const int group_count = groups_.form(kernels_);
    for (int g = 0; g < group_count; ++g) {
      groups_.fill(g, packet);
      std::uint64_t blocked = kernels_.bvh8.occluded_fan(bvh_view_, packet);
      for (const int ray : groups_.group(g)) {
        hits.t[ray] = 0;
        hits.primitive[ray] = (blocked & 1u) != 0 ? 0 : core::kNoPrimitive;
        blocked >>= 1;
      }
    }
  }

  static int fill(const RayBlock& rays, int first, core::RayPacket& packet) {
    const int count = std::min(core::kPacketRays, rays.count - first);
    packet.active = ~std::uint64_t{0} >> (core::kPacketRays - count);
    for (int a = 0; a < 3; ++a) {
      std::copy_n(rays.origin[a] + first, count, packet.origin[a]);
      std::copy_n(rays.direction[a] + first, count, packet.direction[a]);
    }
    std::fill_n(packet.t_min, count, 0.0f);
    std::copy_n(rays.t_max + first, count, packet.t_max);
    return count;
  }

  void trace_packets(const RayBlock& rays, BlockHits& hits) {
    core::RayPacket packet;
    core::PacketHits found;
    for (int first = 0; first < rays.count; first += core::kPacketRays) {
      const int count = fill(rays, first, packet);
      kernels_.bvh8.closest_packet(bvh_view_, packet, found);
      std::copy_n(found.t, count, hits.t + first);
      std::copy_n(found.primitive, count, hits.primitive + first);
    }
  }

  void occlude_packets(const RayBlock& rays, BlockHits& hits) {
    core::RayPacket packet;
    for (int first = 0; first < rays.count; first += core::kPacketRays) {
      const int count = fill(rays, first, packet);
      const std::uint64_t blocked = kernels_.bvh8.occluded_packet(bvh_view_, packet);
      for (int i = 0; i < count; ++i) {
        hits.t[first + i] = 0;
        hits.primitive[first + i] = (blocked >> i & 1u) != 0 ? 0 : core::kNoPrimitive;
      }
    }
  }

  void trace_singles(const RayBlock& rays, BlockHits& hits) {
    for (int i = 0; i < rays.count; ++i) {
      core::SingleHit hit;
      kernels_.bvh8.closest_ray(bvh_view_, ray_of(rays, i), hit);
      hits.t[i] = hit.t;
      hits.primitive[i] = hit.primitive;
    }
  }

  void occlude_singles(const RayBlock& rays, BlockHits& hits) {
    for (int i = 0; i < rays.count; ++i) {
      const bool is_blocked = kernels_.bvh8.occluded_ray(bvh_view_, ray_of(rays, i));
      hits.t[i] = 0;
      hits.primitive[i] = is_blocked ? 0 : core::kNoPrimitive;
    }
  }

  static int fill(const RayBlock& rays, int first, core::RayBundle& bundle) {
    const int count = std::min(core::kBundleRays, rays.count - first);
    bundle.active = 0xffffu >> (core::kBundleRays - count);
    for (int a = 0; a < 3; ++a) {
      std::copy_n(rays.origin[a] + first, count, bundle.origin[a]);
      std::copy_n(rays.direction[a] + first, count, bundle.direction[a]);
    }
    std::fill_n(bundle.t_min, count, 0.0f);
    std::copy_n(rays.t_max + first, count, bundle.t_max);
    return count;
  }

  void trace_bundles(const RayBlock& rays, BlockHits& hits) {
    core::RayBundle bundle;
    core::HitBundle found;
    for (int first = 0; first < rays.count; first += core::kBundleRays) {
      const int count = fill(rays, first, bundle);
      kernels_.trace_closest(kd_view_, bundle, found);
      std::copy_n(found.t, count, hits.t + first);
      std::copy_n(found.primitive, count, hits.primitive + first);
    }
  }

  void occlude_bundles(const RayBlock& rays, BlockHits& hits) {
    core::RayBundle bundle;
    for (int first = 0; first < rays.count; first += core::kBundleRays) {
      const int count = fill(rays, first, bundle);
      const std::uint32_t blocked = kernels_.trace_occluded(kd_view_, bundle);
      for (int i = 0; i < count; ++i) {
        hits.t[first + i] = 0;
        hits.primitive[first + i] = (blocked >> i & 1u) != 0 ? 0 : core::kNoPrimitive;
      }
    }
  }

  const core::KernelTable& kernels_;
  core::Bvh<8> bvh_;
  core::KdTree kd_;
  core::BvhView<8> bvh_view_{};
  core::SceneView kd_view_{};
  core::RayGroups groups_;
};

}  // namespace

double thread_cpu_seconds() { return seconds_of(CLOCK_THREAD_CPUTIME_ID); }
double process_cpu_seconds() { return seconds_of(CLOCK_PROCESS_CPUTIME_ID); }

std::unique_ptr<Entrants> make_ours(const core::TriangleStore& triangles,
                                    const std::vector<Bounds3f>& boxes, Isa isa) {
  return std::make_unique<Ours>(triangles, boxes, isa);
}

}  // namespace tessera::bench
