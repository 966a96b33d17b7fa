// SPDX-License-Identifier: Apache-2.0
#include "slave/core/bsdf/albedo_table.h"

#include <cmath>

#include "slave/core/bsdf/microfacet.h"
#include "slave/core/sampling/sample_sequence.h"

namespace tessera::core {
namespace {

constexpr std::uint32_t kPoints = 1024;

SpecularAlbedo integrate(float cosine, float alpha) {
  const Vec3f viewer{std::sqrt(1 - cosine * cosine), 0, cosine};
  double whole = 0, bias = 0;
  for (std::uint32_t i = 0; i < kPoints; ++i) {
    const Vec3f half = visible_normal(viewer, alpha, sample_2d(0, i));
    const float along = dot(viewer, half);
    const float z_light = 2 * along * half.z - viewer.z;
    if (!(z_light > 0)) continue;
    const double weight = shadowing_weight(viewer.z, z_light, alpha);
    whole += weight;
    bias += weight * schlick_rise(along);
  }
  return {static_cast<float>((whole - bias) / kPoints), static_cast<float>(bias / kPoints)};
}

// Twice the integral over the cosine of a function times the cosine. The function is linear between
// nodes in t, the root of the cosine, so this is the integral of 4 t^3 (a + b t).
template <class Get>
float mean_of(Get get) {
  double sum = 0;
  constexpr int kLast = AlbedoTable::kNodes - 1;
  for (int i = 0; i < kLast; ++i) {
    const double t0 = static_cast<double>(i) / kLast, t1 = static_cast<double>(i + 1) / kLast;
    const double b = (get(i + 1) - get(i)) * kLast, a = get(i) - b * t0;
    const double fourth0 = t0 * t0 * t0 * t0, fourth1 = t1 * t1 * t1 * t1;
    sum += a * (fourth1 - fourth0) + b * 0.8 * (fourth1 * t1 - fourth0 * t0);
  }
  return static_cast<float>(sum);
}

}  // namespace

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
      nodes_[r][i] = integrate(root * root, alpha);
    }
    const auto& row = nodes_[r];
    const auto at = [&row](int i) { return row[static_cast<std::size_t>(i)]; };
    means_[r] = {mean_of([&](int i) { return double{at(i).scale}; }),
                 mean_of([&](int i) { return double{at(i).bias}; })};
  }
}

}  // namespace tessera::core
