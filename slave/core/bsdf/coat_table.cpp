// SPDX-License-Identifier: Apache-2.0
#include "slave/core/bsdf/coat_table.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "slave/core/bsdf/layers_layout.h"
#include "slave/core/bsdf/microfacet.h"
#include "slave/core/bsdf/root_cosine_mean.h"
#include "slave/core/sampling/sample_sequence.h"

namespace tessera::core {
namespace {

constexpr std::uint32_t kPoints = 512;
constexpr int kLast = CoatTable::kCosines - 1;

float roughness_at(std::size_t node, int count) {
  return static_cast<float>(node) / static_cast<float>(count - 1);
}
float cosine_at(std::size_t node) {
  const float root = static_cast<float>(node) / kLast;
  return root * root;
}

// A direction that facets reflect to the viewer from, and how much.
struct Reflected {
  plain::TableStep<float> at;  // among the nodes of cosines
  double scale, bias;
};

std::vector<Reflected> reflections(float cosine, float alpha) {
  const Vec3f viewer{std::sqrt(1 - cosine * cosine), 0, cosine};
  std::vector<Reflected> all;
  for (std::uint32_t i = 0; i < kPoints; ++i) {
    const Vec3f half = visible_normal(viewer, alpha, sample_2d(0, i));
    const float along = dot(viewer, half), z_light = 2 * along * half.z - viewer.z;
    if (!(z_light > 0)) continue;
    const double weight = double{shadowing_weight(viewer.z, z_light, alpha)} / kPoints;
    const double bias = weight * double{schlick_rise(along)};
    all.push_back(
        {plain::table_step(std::sqrt(z_light), CoatTable::kCosines), weight - bias, bias});
  }
  return all;
}

}  // namespace

const CoatTable& CoatTable::shared() {
  static const CoatTable table;
  return table;
}

CoatView CoatTable::none() {
  static constexpr float kNothing[2 * 2 * 2 * 2] = {};
  static constexpr CoatMeans kNoMeans[2 * 2] = {};
  return {{kNothing, kNothing, 2}, kNothing, kNoMeans, 2, 2, 2};
}

CoatTable::CoatTable() {
  for (std::size_t r = 0; r < kAlbedoNodes; ++r) {
    const float alpha = alpha_of(roughness_at(r, kAlbedoNodes));
    for (std::size_t i = 0; i < kAlbedoNodes; ++i) {
      const float root = static_cast<float>(i) / (kAlbedoNodes - 1);
      facets_[r][i] = albedo_by_points(root * root, alpha, kPoints);
    }
    const auto& row = facets_[r];
    facet_means_[r] = {
        mean_by_root_cosine(kAlbedoNodes, [&](std::size_t i) { return double{row[i].scale}; }),
        mean_by_root_cosine(kAlbedoNodes, [&](std::size_t i) { return double{row[i].bias}; })};
  }
  for (std::size_t c = 0; c < kCoats; ++c) {
    for (std::size_t i = 0; i < kCosines; ++i) {
      const SpecularAlbedo a = albedo_at(facets(), cosine_at(i), roughness_at(c, kCoats));
      albedo_[c][i] = kCoatF0 * a.scale + a.bias;
    }
  }
  for (std::size_t base = 0; base < kBases; ++base) fill(base);
}

void CoatTable::fill(std::size_t base) {
  const auto missing = [](SpecularAlbedo a) { return std::max(0.0f, 1 - (a.scale + a.bias)); };
  OfCosines<SpecularAlbedo> whole;
  for (std::size_t i = 0; i < kCosines; ++i) {
    whole[i] = albedo_at(facets(), cosine_at(i), roughness_at(base, kBases));
    const auto from = reflections(cosine_at(i), alpha_of(roughness_at(base, kBases)));
    for (std::size_t c = 0; c < kCoats; ++c) {
      const auto& albedo = albedo_[c];
      double scale = 0, bias = 0;
      for (const Reflected& r : from) {
        const auto node = static_cast<std::size_t>(r.at.node);
        const float there = albedo[node] * (1 - r.at.weight) + albedo[node + 1] * r.at.weight;
        const double more = std::max(0.0, double{there} - double{albedo[i]});
        scale += r.scale * more;
        bias += r.bias * more;
      }
      regained_[base][c][i] = {static_cast<float>(scale), static_cast<float>(bias)};
    }
  }
  for (std::size_t c = 0; c < kCoats; ++c) {
    const auto& albedo = albedo_[c];
    const auto& regained = regained_[base][c];
    const auto mean_of_products = [&](auto get) {
      return mean_by_root_cosine(
          kCosines, [&](std::size_t i) { return double{albedo[i]} * double{get(whole[i])}; });
    };
    CoatMeans& m = means_[base][c];
    m.albedo = mean_of_products([](SpecularAlbedo) { return 1.0f; });
    m.of_missing = mean_of_products(missing);
    const float all_missing =
        mean_by_root_cosine(kCosines, [&](std::size_t i) { return double{missing(whole[i])}; });
    m.share_of_missing = all_missing > 0 ? m.of_missing / all_missing : 0;
    m.of_scale = mean_of_products([](SpecularAlbedo a) { return a.scale; });
    m.of_bias = mean_of_products([](SpecularAlbedo a) { return a.bias; });
    m.regained_of_scale =
        mean_by_root_cosine(kCosines, [&](std::size_t i) { return double{regained[i].scale}; });
    m.regained_of_bias =
        mean_by_root_cosine(kCosines, [&](std::size_t i) { return double{regained[i].bias}; });
  }
}

}  // namespace tessera::core
