// SPDX-License-Identifier: Apache-2.0
#include "slave/core/integrate/direct/direct_integrator.h"

namespace tessera::core {
namespace {

struct Shade {
  DirectLight light;

  RayCounts add(const SurfaceBatch& batch, Vec3f* radiance) {
    RayCounts counts;
    counts.shadow = light.add(batch, radiance);
    return counts;
  }
};

}  // namespace

RayCounts DirectIntegrator::render(const RenderContext& context, const TileRect& rect,
                                   std::span<float> rgb) {
  Shade shade{{context, light_, DirectLight::Kind::kWhole}};
  return LitParts(context, parts_).render(shade, rect, rgb);
}

}  // namespace tessera::core
