// SPDX-License-Identifier: Apache-2.0
// Every BSDF keeps the light of a white sky (white furnace), and its samples agree with its values.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "slave/core/bsdf/albedo_table.h"
#include "slave/core/bsdf/dielectric.h"
#include "slave/core/bsdf/microfacet.h"
#include "slave/core/sampling/hemisphere.h"
#include "slave/core/sampling/sample_sequence.h"
#include "tests/support/plain_glossy.h"
#include "tests/support/seed.h"

namespace tessera::core {
namespace {

using test::BsdfSample;
using test::BsdfValue;
using test::evaluate;
using test::sample;

constexpr double kPi = 3.14159265358979323846;
constexpr float kRoughness[] = {0, 0.03f, 0.1f, 0.22f, 0.37f, 0.5f, 0.71f, 0.85f, 1};
constexpr float kCosines[] = {0.01f, 0.05f, 0.17f, 0.35f, 0.5f, 0.77f, 1};

struct Case {
  Material material;
  Surface surface;
  Vec3f to_viewer;

  Case(BsdfKind kind, Vec3f albedo, Vec3f specular, float roughness, float metalness,
       float cosine) {
    material.bsdf = surface.bsdf = kind;
    material.specular = specular;
    surface.albedo = albedo;
    surface.roughness = roughness;
    surface.metalness = metalness;
    surface.normal = surface.shading_normal = normalize({0.3f, -0.5f, 0.8f});
    to_viewer = direction(cosine, 0.3f);
  }
  const Surface& at() {
    surface.material = &material;
    return surface;
  }
  Vec3f direction(float cosine, float turn) const {
    const Basis basis = basis_about(surface.shading_normal);
    const float sine = std::sqrt(1 - cosine * cosine);
    const SinCos t = sin_cos_whole_turn(turn);
    return normalize(basis.tangent * (sine * t.cos) + basis.bitangent * (sine * t.sin) +
                     surface.shading_normal * cosine);
  }
};

Case metal(float roughness, float cosine) {
  return {BsdfKind::kGlossy, {1, 1, 1}, {0, 0, 0}, roughness, 1, cosine};
}
Case dielectric(float specular, float roughness, float cosine) {
  return {BsdfKind::kGlossy, {1, 1, 1}, {specular, specular, specular}, roughness, 0, cosine};
}

// Mean weight of samples: the light that a white sky makes the surface send to the viewer.
double furnace(Case c, std::uint32_t count = 16384) {
  double sum = 0;
  for (std::uint32_t i = 0; i < count; ++i) {
    const BsdfSample s = sample(c.at(), c.to_viewer, sample_2d(77, i));
    EXPECT_GE(s.weight.x, 0);
    EXPECT_TRUE(std::isfinite(s.weight.x));
    sum += s.weight.x;
  }
  return sum / count;
}

// The light of furnace(), and the integral of the pdf, from evaluate() over an even grid.
struct Integral {
  double light = 0, pdf = 0;
};
Integral integrate(Case c, int grid) {
  Integral sum;
  for (int i = 0; i < grid; ++i) {
    for (int j = 0; j < grid; ++j) {
      const float cosine = (static_cast<float>(i) + 0.5f) / static_cast<float>(grid);
      const float turn = (static_cast<float>(j) + 0.5f) / static_cast<float>(grid);
      const BsdfValue v = evaluate(c.at(), c.to_viewer, c.direction(cosine, turn));
      sum.light += 2 * double{v.times_pi.x} * cosine;
      sum.pdf += 2 * kPi * v.pdf;
    }
  }
  const double points = static_cast<double>(grid) * grid;
  return {sum.light / points, sum.pdf / points};
}

TEST(Bsdf, WhiteFurnaceOfMetalAtAnyRoughnessAndAngle) {
  double worst = 0;
  for (const float roughness : kRoughness) {
    for (const float cosine : kCosines) {
      const double light = furnace(metal(roughness, cosine));
      worst = std::max(worst, std::fabs(light - 1));
      EXPECT_NEAR(light, 1, 0.01) << "roughness " << roughness << " cosine " << cosine;
    }
  }
  RecordProperty("worst_percent", std::to_string(100 * worst));
  std::printf("metal: worst %.3f %%\n", 100 * worst);
}

TEST(Bsdf, WhiteFurnaceOfDielectricsAndHalfMetals) {
  double worst = 0;
  for (const float roughness : kRoughness) {
    for (const float cosine : kCosines) {
      for (const float specular : {0.0f, 0.04f, 0.5f, 1.0f}) {
        const double light = furnace(dielectric(specular, roughness, cosine));
        worst = std::max(worst, std::fabs(light - 1));
        EXPECT_NEAR(light, 1, 0.01) << specular << " " << roughness << " " << cosine;
      }
      Case half = dielectric(0.04f, roughness, cosine);
      half.surface.metalness = 0.5f;
      worst = std::max(worst, std::fabs(furnace(half) - 1));
      EXPECT_NEAR(furnace(half), 1, 0.01) << roughness << " " << cosine;
    }
  }
  std::printf("dielectric: worst %.3f %%\n", 100 * worst);
}

TEST(Bsdf, WhiteFurnaceOfDiffuseMirrorAndGlass) {
  for (const float cosine : kCosines) {
    EXPECT_NEAR(furnace({BsdfKind::kDiffuse, {1, 1, 1}, {}, 1, 0, cosine}), 1, 1e-6);
    EXPECT_NEAR(furnace({BsdfKind::kMirror, {}, {1, 1, 1}, 1, 0, cosine}), 1, 1e-6);
    for (const float ior : {1.0f, 1.33f, 1.5f, 2.4f}) {
      for (const bool is_front : {true, false}) {
        Case glass{BsdfKind::kGlass, {}, {1, 1, 1}, 1, 0, cosine};
        glass.material.ior = ior;
        glass.surface.is_front = is_front;
        EXPECT_NEAR(furnace(glass), 1, 1e-6) << ior;
      }
    }
  }
}

TEST(Bsdf, NoColourComesBackBrighterThanItIsSent) {
  for (const float roughness : kRoughness) {
    for (const float cosine : kCosines) {
      const double dark = furnace({BsdfKind::kGlossy, {0.2f, 0, 0}, {}, roughness, 0.3f, cosine});
      EXPECT_LT(dark, 0.7 + 0.35 * (1 - cosine)) << roughness << " " << cosine;
      EXPECT_GT(dark, 0);
    }
  }
}

TEST(Bsdf, SamplesAgreeWithEvaluationAndTheirPdfIntegratesToOne) {
  for (const float roughness : {0.4f, 0.6f, 1.0f}) {
    for (const float cosine : {0.1f, 0.5f, 1.0f}) {
      for (const bool is_metal : {true, false}) {
        const Case c = is_metal ? metal(roughness, cosine) : dielectric(0.04f, roughness, cosine);
        const Integral integral = integrate(c, 512);
        EXPECT_NEAR(integral.light, 1, 0.01) << roughness << " " << cosine << " " << is_metal;
        // Some facets that the viewer sees reflect into the surface. Those samples are lost, and
        // the pdf above the surface lacks as much.
        int lost = 0;
        Case copy = c;
        for (std::uint32_t i = 0; i < 16384; ++i) {
          lost += sample(copy.at(), c.to_viewer, sample_2d(5, i)).pdf > 0 ? 0 : 1;
        }
        EXPECT_NEAR(integral.pdf, 1 - lost / 16384.0, 0.01)
            << roughness << " " << cosine << " " << is_metal;
      }
    }
  }
}

// sample() returns the pdf and the weight that evaluate() has for its direction.
TEST(Bsdf, ASampleCarriesItsOwnPdfAndWeight) {
  for (const float roughness : {0.2f, 0.5f, 1.0f}) {
    Case c = dielectric(0.3f, roughness, 0.6f);
    c.surface.albedo = {0.5f, 0.3f, 0.9f};
    c.surface.metalness = 0.25f;
    for (std::uint32_t i = 0; i < 1024; ++i) {
      const BsdfSample s = sample(c.at(), c.to_viewer, sample_2d(3, i));
      if (!(s.pdf > 0)) continue;
      const float cosine = dot(s.direction, c.surface.shading_normal);
      const BsdfValue v = evaluate(c.at(), c.to_viewer, s.direction);
      // Directions are turned there and back, with some roundings of 2^-24, over alpha squared.
      const float slack = 64 * 0x1p-24f / (roughness * roughness * roughness * roughness);
      if (cosine < 1e-3f) continue;
      EXPECT_NEAR(s.pdf, v.pdf, slack * v.pdf + 1e-6f);
      EXPECT_NEAR(s.weight.y, v.times_pi.y * cosine / (kPi * v.pdf), slack * s.weight.y + 1e-6);
    }
  }
}

TEST(Bsdf, LightGoesBothWaysAlike) {
  std::mt19937 random(test::seed(11));
  std::uniform_real_distribution<float> unit(0.02f, 1);
  for (int i = 0; i < 4000; ++i) {
    Case c = dielectric(unit(random) * 0.9f, 0.15f + 0.85f * unit(random), unit(random));
    c.surface.albedo = {unit(random), unit(random), unit(random)};
    c.surface.metalness = i % 3 == 0 ? 0 : unit(random);
    const Vec3f other = c.direction(unit(random), unit(random));
    const Vec3f there = evaluate(c.at(), c.to_viewer, other).times_pi;
    const Vec3f back = evaluate(c.at(), other, c.to_viewer).times_pi;
    for (int a = 0; a < 3; ++a) ASSERT_NEAR(there[a], back[a], 2e-5f * (1 + there[a])) << i;
  }
}

// The table is compared with a quarter of a million points that are not its own 1024.
TEST(Bsdf, TheAlbedoTableIsTheIntegral) {
  double worst = 0;
  for (const float roughness : kRoughness) {
    for (const float cosine : kCosines) {
      const float alpha = alpha_of(roughness);
      const Vec3f viewer{std::sqrt(1 - cosine * cosine), 0, cosine};
      double whole = 0;
      constexpr std::uint32_t kCount = 1 << 18;
      for (std::uint32_t i = 0; i < kCount; ++i) {
        const Vec3f half = visible_normal(viewer, alpha, sample_2d(123, i));
        const float z = 2 * dot(viewer, half) * half.z - viewer.z;
        if (z > 0) whole += shadowing_weight(viewer.z, z, alpha) / double{kCount};
      }
      const SpecularAlbedo at = test::plain_albedo(cosine, roughness);
      worst = std::max(worst, std::fabs(whole - double{at.scale} - double{at.bias}));
    }
  }
  std::printf("table: worst %.5f\n", worst);
  EXPECT_LT(worst, 0.005);
}

TEST(Bsdf, FresnelOfADielectricIsTheClosedForm) {
  EXPECT_NEAR(refraction(1, 1.5f).reflectance, 0.04, 1e-6);
  EXPECT_NEAR(refraction(1, 1 / 1.5f).reflectance, 0.04, 1e-6);
  EXPECT_EQ(refraction(0.5f, 1 / 1.5f).reflectance, 1) << "beyond the critical angle";
  EXPECT_NEAR(refraction(1e-4f, 1.5f).reflectance, 1, 1e-3);
  // Brewster's angle: half of the light is not reflected at all.
  const double brewster = std::atan(1.5), sine = std::sin(brewster) / 1.5;
  const double crossed = (std::cos(brewster) - 1.5 * std::sqrt(1 - sine * sine)) /
                         (std::cos(brewster) + 1.5 * std::sqrt(1 - sine * sine));
  EXPECT_NEAR(refraction(static_cast<float>(std::cos(brewster)), 1.5f).reflectance,
              crossed * crossed / 2, 1e-6);
}

TEST(Bsdf, RefractionObeysSnellAndComesBackTheSameWay) {
  const Vec3f n{0, 0, 1};
  for (const float cosine : kCosines) {
    const Vec3f in{std::sqrt(1 - cosine * cosine), 0, cosine};
    const Vec3f out = refracted(in, n, refraction(cosine, 1.5f));
    EXPECT_LT(out.z, 0);
    EXPECT_NEAR(length(out), 1, 1e-6);
    EXPECT_NEAR(-out.x * 1.5, in.x, 1e-6);
    const Vec3f back = refracted(out, -n, refraction(-out.z, 1 / 1.5f));
    EXPECT_LT(length(back - in), 2e-3f);
  }
}

// Refraction divides the sine by the index from outside and multiplies it from inside, and mirrored
// rays leave at the angle at which they came.
TEST(Bsdf, GlassIsThinnerOutside) {
  for (const float cosine : {0.2f, 0.6f, 0.9f}) {
    Case glass{BsdfKind::kGlass, {}, {0.5f, 0.5f, 0.5f}, 1, 0, cosine};
    glass.material.ior = 1.6f;
    const Vec3f n = glass.surface.normal;
    const BsdfSample in = sample(glass.at(), glass.to_viewer, {0.999f, 0});
    ASSERT_TRUE(in.is_delta && in.is_through);
    EXPECT_EQ(in.weight.x, 0.5f);
    EXPECT_LT(length(cross(in.direction, n) * 1.6f + cross(glass.to_viewer, n)), 1e-6f);
    // The same interface, looked at from within along the way back.
    Case within = glass;
    within.surface.is_front = false;
    within.surface.normal = within.surface.shading_normal = -n;
    const BsdfSample out = sample(within.at(), in.direction, {0.999f, 0});
    ASSERT_TRUE(out.is_through);
    EXPECT_LT(length(out.direction - glass.to_viewer), 1e-5f);
    const BsdfSample mirrored = sample(glass.at(), glass.to_viewer, {0, 0});
    EXPECT_FALSE(mirrored.is_through);
    EXPECT_LT(length(mirrored.direction + glass.to_viewer - n * (2 * cosine)), 1e-5f);
  }
  Case within{BsdfKind::kGlass, {}, {1, 1, 1}, 1, 0, 0.5f};
  within.surface.is_front = false;
  EXPECT_FALSE(sample(within.at(), within.to_viewer, {0.999f, 0}).is_through) << "total reflection";
}

}  // namespace
}  // namespace tessera::core
