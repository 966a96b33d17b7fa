// SPDX-License-Identifier: Apache-2.0
#include "slave/core/bsdf/albedo_table.h"

#include <cmath>

#include "slave/core/bsdf/microfacet.h"
#include "slave/core/bsdf/root_cosine_mean.h"
#include "slave/core/sampling/sample_sequence.h"

namespace tessera::core {
namespace {

constexpr std::uint32_t kPoints = 1024;

}  // namespace

SpecularAlbedo albedo_by_points(float cosine, float alpha, std::uint32_t points) {
  const Vec3f viewer{std::sqrt(1 - cosine * cosine), 0, cosine};
  double whole = 0, bias = 0;
  for (std::uint32_t i = 0; i < points; ++i) {
    const Vec3f half = visible_normal(viewer, alpha, sample_2d(0, i));
    const float along = dot(viewer, half);
    const float z_light = 2 * along * half.z - viewer.z;
    if (!(z_light > 0)) continue;
    const double weight = shadowing_weight(viewer.z, z_light, alpha);
    whole += weight;
    bias += weight * schlick_rise(along);
  }
  return {static_cast<float>((whole - bias) / points), static_cast<float>(bias / points)};
}

SpecularAlbedo albedo_at(const AlbedoView& table, float cosine, float roughness) {
  const auto terms = plain::AlbedoLookup<float>(table).at(cosine, roughness);
  return {terms.scale, terms.bias};
}

const AlbedoTable& AlbedoTable::shared() {
  static const AlbedoTable table;
  return table;
}

AlbedoTable::AlbedoTable() {
  for (std::size_t r = 0; r < kNodes; ++r) {
    const float alpha = alpha_of(static_cast<float>(r) / (kNodes - 1));
    for (std::size_t i = 0; i < kNodes; ++i) {
      const float root = static_cast<float>(i) / (kNodes - 1);
      nodes_[r][i] = albedo_by_points(root * root, alpha, kPoints);
    }
    const auto& row = nodes_[r];
    means_[r] = {mean_by_root_cosine(kNodes, [&](std::size_t i) { return double{row[i].scale}; }),
                 mean_by_root_cosine(kNodes, [&](std::size_t i) { return double{row[i].bias}; })};
  }
}

}  // namespace tessera::core
