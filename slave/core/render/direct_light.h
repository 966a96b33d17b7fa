// Light that reaches 16 surface points straight from the scene's lights, through shadow bundles.
//
// Each lane is a pixel of one 4x4 block. Sums run over lights, then emitters, then samples, in that
// order and per lane alone: a pixel does not depend on its neighbours.
//
// Threads. One object per thread; holds the shadow bundle as scratch memory.
#pragma once

#include <cstdint>

#include "slave/core/kernel/kernel_table.h"
#include "slave/core/render/surface.h"

namespace tessera::core {

// One 4x4 block of pixels with what its primary rays have hit.
struct SurfaceBlock {
  std::uint32_t hit;  // bit i: lane i has a surface
  Surface surface[kBundleRays];
  std::uint32_t key[kBundleRays];  // pixel_key() of the lane's first dimension
  std::uint32_t sample_index = 0;  // of the pixel's samples, counts from 0
};

class DirectLight {
 public:
  // Keeps references until the next call. Requires: both outlive the calls of add().
  void begin(const PreparedScene::Impl& scene, const KernelTable& kernels, int light_samples);

  // Adds reflected direct light to radiance [kBundleRays]. Returns: shadow rays traced.
  std::uint64_t add(const SurfaceBlock& block, Vec3f* radiance);

 private:
  std::uint64_t add_light(const SurfaceBlock& block, const Light& light, Vec3f* radiance);
  std::uint64_t add_emitters(const SurfaceBlock& block, Vec3f* radiance);
  void aim(const SurfaceBlock& block, int lane, const Emitter& emitter, Vec2f sample, float weight);
  void set_ray(int lane, const Surface& surface, Vec3f target, float t_max);
  std::uint64_t trace(Vec3f* radiance);

  const PreparedScene::Impl* scene_ = nullptr;
  const KernelTable* kernels_ = nullptr;
  SceneView view_{};
  int light_samples_ = 1;
  RayBundle rays_{};
  Vec3f contribution_[kBundleRays];
};

}  // namespace tessera::core
