// SPDX-License-Identifier: Apache-2.0
#include "slave/core/bsdf/sheen_table.h"

#define TESSERA_PLAIN_TEXT

#include <algorithm>
#include <cmath>

#include "common/math/vec3.h"
#include "slave/core/bsdf/layers_layout.h"
#include "slave/core/bsdf/sheen-inl.h"
#include "slave/core/sampling/hemisphere.h"

namespace tessera::core {
namespace {

// Numbers of directions to the light: spaced evenly in the cosine, and over half a turn, for the
// other half mirrors it.
constexpr int kCosines = 64, kTurns = 64;

float integrate(float cosine, float roughness) {
  const Vec3f viewer{std::sqrt(1 - cosine * cosine), 0, cosine};
  double sum = 0;
  for (int i = 0; i < kCosines; ++i) {
    const float z = (static_cast<float>(i) + 0.5f) / kCosines, flat = std::sqrt(1 - z * z);
    for (int j = 0; j < kTurns; ++j) {
      const SinCos t = sin_cos_whole_turn((static_cast<float>(j) + 0.5f) / (2 * kTurns));
      const Vec3f half = normalize(viewer + Vec3f{flat * t.cos, flat * t.sin, z});
      sum += 2 * double{sheen_times_pi(roughness, half.z, cosine, z)} * double{z};
    }
  }
  return static_cast<float>(sum / (kCosines * kTurns));
}

}  // namespace

float sheen_times_pi(float roughness, float z_half, float z_viewer, float z_light) {
  const float exponent = 1 / (roughness * roughness);
  return plain::fibres_times_pi(exponent, z_half, z_viewer, z_light);
}

const SheenTable& SheenTable::shared() {
  static const SheenTable table;
  return table;
}

SheenTable::SheenTable() {
  for (std::size_t r = 0; r < kNodes; ++r) {
    const float roughness = std::max(kSheenRoughnessMin, static_cast<float>(r) / (kNodes - 1));
    for (std::size_t i = 0; i < kNodes; ++i) {
      const float root = static_cast<float>(i) / (kNodes - 1);
      nodes_[r][i] = {integrate(root * root, roughness), 0};
    }
  }
}

}  // namespace tessera::core
