// SPDX-License-Identifier: Apache-2.0
// Traces rays through a scene, whatever structure and instruction set it has got: the calls that
// renderers make.
//
// Threads. Constant after construction; any number of threads.
#pragma once

#include <bit>
#include <cstdint>
#include <optional>
#include <variant>

#include "slave/core/kernels/kernel_table.h"
#include "slave/core/kernels/place_kernels.h"
#include "slave/core/primitive/freeform/patch_store.h"
#include "slave/core/primitive/patch/methods/patch_methods.h"
#include "slave/core/primitive/patch/patch_support.h"
#include "slave/core/primitive/primitive_index.h"
#include "slave/core/ray/fan_of.h"
#include "slave/core/ray/many_of.h"
#include "slave/core/trace/method_tracer.h"

namespace tessera::core {

// A structure as the kernels see it. Valid as long as the structure is.
template <int W>
TriangleBvh<W> view_of(const IndexedBvh<W>& bvh) {
  return {bvh.structure.nodes.data(), {bvh.triangles.data()}, scene_box(bvh.structure.bounds)};
}
template <int W>
TriangleKd<W> view_of(const IndexedKd<W>& kd) {
  return {kd.structure.nodes.data(),
          kd.structure.leaves.data(),
          {kd.triangles.data()},
          scene_box(kd.structure.bounds)};
}

template <int W>
InstancedView<W> view_of(const InstancedBvh<W>& bvh) {
  return {bvh.structure.nodes.data(),
          {bvh.blocks.data(), bvh.triangles.data(), bvh.instances.data(), bvh.shapes.data()},
          scene_box(bvh.structure.bounds)};
}

template <int W>
PatchedView<W> view_of(const PatchedBvh<W>& bvh) {
  return {bvh.structure.nodes.data(),
          {bvh.blocks.data(), bvh.triangles.data(), bvh.patches->parts.data(),
           bvh.patches->patches.data()},
          scene_box(bvh.structure.bounds)};
}

template <int W>
PlacedView<W> view_of(const PlacedBvh<W>& bvh) {
  return {bvh.structure.nodes.data(), bvh.kernel_shapes(), scene_box(bvh.structure.bounds)};
}

inline const auto& kernels_of(const KernelTable& table, const TriangleBvh<8>&) {
  return table.bvh8;
}
inline const auto& kernels_of(const KernelTable& table, const TriangleBvh<16>&) {
  return table.bvh16;
}
inline const auto& kernels_of(const KernelTable& table, const TriangleKd<8>&) { return table.kd8; }
inline const auto& kernels_of(const KernelTable& table, const TriangleKd<16>&) {
  return table.kd16;
}

inline const auto& kernels_of(const KernelTable& table, const InstancedView<8>&) {
  return table.instanced8;
}
inline const auto& kernels_of(const KernelTable& table, const InstancedView<16>&) {
  return table.instanced16;
}

inline const auto& kernels_of(const KernelTable& table, const PatchedView<8>&) {
  return table.patched8;
}
inline const auto& kernels_of(const KernelTable& table, const PatchedView<16>&) {
  return table.patched16;
}

inline const auto& kernels_of(const KernelTable& table, const PlacedView<8>&) {
  return place_kernels(table.isa).by8;
}
inline const auto& kernels_of(const KernelTable& table, const PlacedView<16>&) {
  return place_kernels(table.isa).by16;
}

class AlphaSurfaces;
struct PassingRays;

class SceneTracer {
 public:
  // `alpha`: what rays go through; null: they go through nothing. Requires: all outlive it.
  SceneTracer(const PrimitiveIndex& index, const KernelTable& kernels,
              const AlphaSurfaces* alpha = nullptr, PatchMethod method = PatchMethod::kAuto)
      : kernels_(&kernels), alpha_(alpha), bounds_(index.bounds()), patch_method_(method) {
    std::visit([this](const auto& any) { view_ = view_of(any); }, index.any);
    if (const PatchMethodCall* const call = patch_method_call(method))
      by_method_ = MethodTracer::make(index, *call, kernels.isa);
  }

  // How rays meet patches.
  PatchMethod patch_method() const { return patch_method_; }

  const KernelTable& kernels() const { return *kernels_; }

  // Bounds of all triangles; empty where there are none.
  const Bounds3f& bounds() const { return bounds_; }

  // Finds where the traversal of fans through a window begins.
  void enter(const FanWindow& window, FanEntry& entry) const {
    std::visit([&](const auto& v) { table(v).enter_fans(v, window, entry); }, view_);
  }
  // A ray's answer does not depend on its companions.
  void closest(const FanPacket& rays, PacketHits& hits) const {
    if (is_by_method()) return by_method(rays, hits);
    const Fan fan = fan_of(rays);
    const HitArrays found = arrays_of(hits);
    std::visit([&](const auto& v) { table(v).closest_fan(v, fan, found); }, view_);
    if (alpha_ != nullptr) go_through(rays, found);
  }
  // The same for any number of rays with origins of their own.
  void closest(const ManyRays& rays, const HitArrays& hits) const {
    nearest(rays, hits);
    if (alpha_ != nullptr) go_through(rays, hits);
  }
  void closest(const RayPacket& rays, PacketHits& hits) const {
    closest(many_of(rays), arrays_of(hits));
  }
  SingleHit closest(const SingleRay& ray) const {
    SingleHit hit = nearest(ray);
    if (alpha_ != nullptr) go_through(ray, hit);
    return hit;
  }
  // Bits of the rays that something blocks.
  std::uint64_t occluded(const FanPacket& rays) const {
    if (alpha_ != nullptr || is_by_method()) return stopped(rays);
    const Fan fan = fan_of(rays);
    return std::visit([&](const auto& v) { return table(v).occluded_fan(v, fan); }, view_);
  }
  // The same for each of many fans: blocked [fans.targets->group_count].
  void occluded(const ShadowFans& fans, std::uint64_t* blocked) const {
    if (alpha_ != nullptr || is_by_method()) return stopped(fans, blocked);
    std::visit([&](const auto& v) { table(v).occluded_fans(v, fans, blocked); }, view_);
  }
  // The same for any number of rays with origins of their own: blocked [rays.packet_count].
  void occluded(const ManyRays& rays, std::uint64_t* blocked) const {
    if (alpha_ != nullptr || is_by_method()) return stopped(rays, blocked);
    std::visit([&](const auto& v) { table(v).occluded_many(v, rays, blocked); }, view_);
  }
  std::uint64_t occluded(const RayPacket& rays) const {
    std::uint64_t blocked = 0;
    occluded(many_of(rays), &blocked);
    return blocked;
  }
  bool occluded(const SingleRay& ray) const {
    if (alpha_ != nullptr) return closest(ray).primitive != kNoPrimitive;
    if (is_by_method()) return by_method_->occluded(ray);
    return std::visit([&](const auto& v) { return table(v).occluded_ray(v, ray); }, view_);
  }

 private:
  bool is_by_method() const { return kKnowsPatches && by_method_.has_value(); }
  // Nearest hit of all triangles, whether the ray goes through them or not.
  SingleHit nearest(const SingleRay& ray) const {
    if (is_by_method()) return by_method_->closest(ray);
    SingleHit hit;
    std::visit([&](const auto& v) { table(v).closest_ray(v, ray, hit); }, view_);
    return hit;
  }
  // The same for packets where a method answers for patches: ray by ray.
  void by_method(const FanPacket& rays, PacketHits& hits) const;
  // Replaces hits that are passed by the first behind them that is not. Requires: alpha_ is not
  // null.
  void go_through(SingleRay ray, SingleHit& hit) const;
  void go_through(const FanPacket& rays, const HitArrays& hits) const;
  void go_through(const ManyRays& rays, const HitArrays& hits) const;
  template <class Rays>
  void go_through_all(const Rays& rays, const HitArrays& hits) const;
  void go_behind(PassingRays& passing, const HitArrays& hits) const;
  // Nearest hits of any number of rays, as nearest().
  void nearest(const ManyRays& rays, const HitArrays& hits) const;
  // What is blocked, where the kernels for any hit do not do: rays go through something, or a
  // method answers for patches.
  std::uint64_t stopped(const FanPacket& rays) const;
  void stopped(const ManyRays& rays, std::uint64_t* blocked) const;
  void stopped(const ShadowFans& fans, std::uint64_t* blocked) const;

  template <class View>
  const ViewKernels<View>& table(const View& view) const {
    return kernels_of(*kernels_, view);
  }

  const KernelTable* kernels_;
  const AlphaSurfaces* alpha_;
  Bounds3f bounds_;
  PatchMethod patch_method_;
  std::optional<MethodTracer> by_method_;  // where the scene has patches and the frame a method
  std::variant<TriangleBvh<8>, TriangleBvh<16>, TriangleKd<8>, TriangleKd<16>, InstancedView<8>,
               InstancedView<16>, PatchedView<8>, PatchedView<16>, PlacedView<8>, PlacedView<16>>
      view_;
};

}  // namespace tessera::core
