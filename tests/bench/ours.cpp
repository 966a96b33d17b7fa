#include <time.h>

#include "slave/core/accel/bvh_builder.h"
#include "slave/core/accel/kd_builder.h"
#include "slave/core/kernel/kernel_table.h"
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
    contenders.push_back({"bvh8 fan of 64", true, [this](const auto& rays, auto& hits) {
                            kernels_.bvh8.closest_fan(bvh_view_, rays, hits);
                          }});
    contenders.push_back(
        {"bvh8 single", true, [this](const auto& rays, auto& hits) { trace_singles(rays, hits); }});
    contenders.push_back({"kd bundle of 16", true,
                          [this](const auto& rays, auto& hits) { trace_bundles(rays, hits); }});
  }

 private:
  void trace_singles(const core::FanPacket& rays, core::PacketHits& hits) const {
    for (int i = 0; i < core::kPacketRays; ++i) {
      const core::SingleRay ray{{rays.origin[0], rays.origin[1], rays.origin[2]},
                                {rays.direction[0][i], rays.direction[1][i], rays.direction[2][i]},
                                0,
                                rays.t_max[i]};
      core::SingleHit hit;
      kernels_.bvh8.closest_ray(bvh_view_, ray, hit);
      hits.t[i] = hit.t;
      hits.primitive[i] = hit.primitive;
    }
  }

  void trace_bundles(const core::FanPacket& rays, core::PacketHits& hits) const {
    for (int first = 0; first < core::kPacketRays; first += core::kBundleRays) {
      core::RayBundle bundle;
      bundle.active = 0xffff;
      for (int i = 0; i < core::kBundleRays; ++i) {
        for (int a = 0; a < 3; ++a) {
          bundle.origin[a][i] = rays.origin[a];
          bundle.direction[a][i] = rays.direction[a][first + i];
        }
        bundle.t_min[i] = 0;
        bundle.t_max[i] = rays.t_max[first + i];
      }
      core::HitBundle found;
      kernels_.trace_closest(kd_view_, bundle, found);
      for (int i = 0; i < core::kBundleRays; ++i) {
        hits.t[first + i] = found.t[i];
        hits.primitive[first + i] = found.primitive[i];
      }
    }
  }

  const core::KernelTable& kernels_;
  core::Bvh<8> bvh_;
  core::KdTree kd_;
  core::BvhView<8> bvh_view_{};
  core::SceneView kd_view_{};
};

}  // namespace

double thread_cpu_seconds() { return seconds_of(CLOCK_THREAD_CPUTIME_ID); }
double process_cpu_seconds() { return seconds_of(CLOCK_PROCESS_CPUTIME_ID); }

std::unique_ptr<Entrants> make_ours(const core::TriangleStore& triangles,
                                    const std::vector<Bounds3f>& boxes, Isa isa) {
  return std::make_unique<Ours>(triangles, boxes, isa);
}

}  // namespace tessera::bench
