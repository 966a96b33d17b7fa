// SPDX-License-Identifier: Apache-2.0
#include "slave/core/bsdf/layers.h"

#include <algorithm>

#include "slave/core/bsdf/coat_table.h"
#include "slave/core/bsdf/layers_layout.h"
#include "slave/core/bsdf/sheen_table.h"

namespace tessera::core {

float passed_by_layers(const SurfaceLobes& lobes, Vec3f normal, Vec3f to_viewer) {
  float passed = 1;
  if (lobes.coat > 0) {
    const float cosine = std::max(dot(lobes.coat_normal, to_viewer), 0.0f);
    const SpecularAlbedo a = albedo_at(CoatTable::shared().facets(), cosine, lobes.coat_roughness);
    passed *= 1 - lobes.coat * (kCoatF0 * a.scale + a.bias);
  }
  if (!is_black(lobes.sheen)) {
    const float cosine = std::max(dot(normal, to_viewer), 0.0f);
    const float roughness = std::max(lobes.sheen_roughness, kSheenRoughnessMin);
    const float most = std::max({lobes.sheen.x, lobes.sheen.y, lobes.sheen.z});
    const float albedo = albedo_at(SheenTable::shared().view(), cosine, roughness).scale;
    passed *= 1 - most * std::min(albedo, 1.0f);
  }
  return passed;
}

}  // namespace tessera::core
