// SPDX-License-Identifier: Apache-2.0
#include "master/look/usual_samples.h"

#include <algorithm>

namespace tessera {
namespace {

bool is_noisy(const Material& m) {
  return scattering_of(m.bsdf) == Scattering::kLobes || m.bsdf == BsdfKind::kGlass ||
         m.alpha.mode != AlphaMode::kOpaque;
}

}  // namespace

int usual_samples(const Scene& scene, Renderer renderer) {
  switch (renderer) {
    case Renderer::kIgi:
      return std::any_of(scene.materials.begin(), scene.materials.end(), is_noisy) ? 16 : 4;
    case Renderer::kDirect:
      return 4;
    case Renderer::kPath:
      return 64;
    case Renderer::kPrimary:
      break;
  }
  return 1;
}

}  // namespace tessera
