// SPDX-License-Identifier: Apache-2.0
// What of lamps and sky glossy surfaces see by rays of their own BSDF: the share that light samples
// leave to them (direct_light.h), since a sharp highlight is seldom found from the lamp. Part of
// direct light; of longer paths the next ray does the same.
//
// Threads. One object per thread; scratch memory.
#pragma once

#include <atomic>
#include <memory>

#include "slave/core/integrate/scattered_rays.h"

namespace tessera::core {

class GlossyLight {
 public:
  // Keeps references until the next call. Requires: all outlive the calls of add(); `samples` is
  // that of the light samples.
  void begin(const PreparedScene::Impl& scene, const SceneTracer& tracer, int samples,
             const std::atomic<bool>* is_cancelled);

  // Adds to radiance [pixel]; surfaces that are not glossy are passed over. Returns: rays traced.
  std::uint64_t add(const SurfaceBatch& batch, Vec3f* radiance);

 private:
  void trace(Vec3f* radiance);

  const PreparedScene::Impl* scene_ = nullptr;
  int samples_ = 1;
  const std::atomic<bool>* is_cancelled_ = nullptr;
  std::unique_ptr<ScatteredRays> rays_;  // made where a scene has glossy surfaces
};

}  // namespace tessera::core
