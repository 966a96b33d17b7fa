// Traces rays through a scene, whatever structure and instruction set it has got: the calls that
// renderers make.
//
// Threads. Constant after construction; any number of threads.
#pragma once

#include <cstdint>
#include <variant>

#include "slave/core/accel/spatial_index.h"
#include "slave/core/kernel/kernel_table.h"

namespace tessera::core {

class SceneTracer {
 public:
  // Requires: both outlive it.
  SceneTracer(const SpatialIndex& index, const KernelTable& kernels) : kernels_(&kernels) {
    std::visit([this](const auto& structure) { view_ = view_of(structure); }, index.structure);
  }

  const KernelTable& kernels() const { return *kernels_; }

  // A ray's answer does not depend on its companions.
  void closest(const FanPacket& rays, PacketHits& hits) const {
    std::visit([&](const auto& v) { table(v).closest_fan(v, rays, hits); }, view_);
  }
  void closest(const RayPacket& rays, PacketHits& hits) const {
    std::visit([&](const auto& v) { table(v).closest_packet(v, rays, hits); }, view_);
  }
  SingleHit closest(const SingleRay& ray) const {
    SingleHit hit;
    std::visit([&](const auto& v) { table(v).closest_ray(v, ray, hit); }, view_);
    return hit;
  }
  // Bits of the rays that something blocks.
  std::uint64_t occluded(const FanPacket& rays) const {
    return std::visit([&](const auto& v) { return table(v).occluded_fan(v, rays); }, view_);
  }
  std::uint64_t occluded(const RayPacket& rays) const {
    return std::visit([&](const auto& v) { return table(v).occluded_packet(v, rays); }, view_);
  }
  bool occluded(const SingleRay& ray) const {
    return std::visit([&](const auto& v) { return table(v).occluded_ray(v, ray); }, view_);
  }

 private:
  template <int W>
  static BvhView<W> view_of(const Bvh<W>& bvh) {
    const Vec3f low = bvh.bounds.lower, high = bvh.bounds.upper;
    return {bvh.nodes.data(), bvh.blocks.data(), {low.x, low.y, low.z}, {high.x, high.y, high.z}};
  }
  const BvhKernels<8>& table(const BvhView<8>&) const { return kernels_->bvh8; }
  const BvhKernels<16>& table(const BvhView<16>&) const { return kernels_->bvh16; }

  const KernelTable* kernels_;
  std::variant<BvhView<8>, BvhView<16>> view_;
};

}  // namespace tessera::core
