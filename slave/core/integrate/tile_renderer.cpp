// SPDX-License-Identifier: Apache-2.0
#include "slave/core/integrate/tile_renderer.h"

#include <algorithm>
#include <map>

#include "common/base/check.h"
#include "slave/core/integrate/integrator.h"
#include "slave/core/kernels/kernel_table.h"
#include "slave/core/simd/isa_support.h"

namespace tessera::core {

struct TileRenderer::Scratch {
  std::map<Renderer, std::unique_ptr<Integrator>> integrators;  // those that were asked for

  Integrator& integrator(Renderer renderer) {
    std::unique_ptr<Integrator>& own = integrators[renderer];
    if (own == nullptr) {
      const auto row = std::ranges::find(core::integrators(), renderer, &IntegratorRow::renderer);
      TESSERA_CHECK(row != core::integrators().end());
      own = row->make();
    }
    return *own;
  }
};

IsaMask supported_isas() { return cpu_isas() & compiled_isas(); }

TileRenderer::TileRenderer() : scratch_(std::make_unique<Scratch>()) {}
TileRenderer::~TileRenderer() = default;

RayCounts TileRenderer::render(const PreparedScene& scene, const FrameSettings& settings, Isa isa,
                               const TileRect& rect, std::span<float> rgb,
                               const std::atomic<bool>* is_cancelled, FrameLight* frame_light) {
  TESSERA_CHECK_EQ(rgb.size(), 3 * static_cast<std::size_t>(rect.pixel_count()));
  const PreparedScene::Impl& impl = scene.impl();
  const SceneTracer tracer(impl.index, kernels_for(isa), impl.alpha.get(), settings.patch_method);
  const CameraRays camera(settings.camera, settings.width_px, settings.height_px);
  FrameLight own;
  const RenderContext context{
      impl, tracer, settings, camera, frame_light != nullptr ? *frame_light : own, is_cancelled};
  return scratch_->integrator(settings.renderer).render(context, rect, rgb);
}

}  // namespace tessera::core
