// SPDX-License-Identifier: Apache-2.0
// The optional lobes of glossy surfaces keep the light and add none, their samples agree with their
// values, light may be sent either way, and every instruction set has the same bits.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>

#include "slave/core/bsdf/transmission.h"
#include "slave/core/sampling/hemisphere.h"
#include "slave/core/sampling/sample_sequence.h"
#include "slave/core/simd/power.h"
#include "tests/support/bsdf_at.h"
#include "tests/support/packets.h"
#include "tests/support/seed.h"

namespace tessera::core {
namespace {

constexpr float kRoughness[] = {0, 0.1f, 0.3f, 0.6f, 1};
constexpr float kCosines[] = {0.05f, 0.3f, 0.7f, 1};

struct Layered {
  Material material;
  Surface surface;
  SurfaceLobes lobes;

  Layered(Vec3f albedo, float roughness, float metalness) {
    material.bsdf = surface.bsdf = BsdfKind::kGlossy;
    surface.albedo = albedo;
    surface.roughness = roughness;
    surface.metalness = metalness;
    surface.normal = surface.shading_normal = normalize({0.3f, -0.5f, 0.8f});
    lobes.specular = {0.04f, 0.04f, 0.04f};
    lobes.coat_normal = surface.normal;
    lobes.tangent = basis_about(surface.normal).tangent;
    look(1, 0.3f);
  }
  Vec3f direction(float cosine, float turn) const {
    const Basis basis = basis_about(surface.shading_normal);
    const float sine = std::sqrt(1 - cosine * cosine);
    const SinCos t = sin_cos_whole_turn(turn);
    return normalize(basis.tangent * (sine * t.cos) + basis.bitangent * (sine * t.sin) +
                     surface.shading_normal * cosine);
  }
  void look(float cosine, float turn) { surface.to_viewer = direction(cosine, turn); }
  Surface at() {
    surface.material = &material;
    return surface;
  }
  Layered from(Vec3f to_viewer) const {
    Layered other = *this;
    other.surface.to_viewer = to_viewer;
    return other;
  }
};

struct Value {
  Vec3f times_pi;
  float pdf;
};
Value evaluate(Layered c, Vec3f to_light, const KernelTable& kernels = test::widest_kernels()) {
  BsdfPacket& packet = test::empty_packet();
  packet.add(c.at(), &c.lobes, to_light);
  packet.evaluate(kernels, kLayeredSlot);
  return {packet.times_pi(0), packet.pdf(0)};
}

// Mean weight of samples under a white sky; integrate() has it by values, and the pdf's integral.
double furnace(Layered c, std::uint32_t count = 4096) {
  double sum = 0;
  for (std::uint32_t i = 0; i < count;) {
    BsdfPacket& packet = test::empty_packet();
    for (; packet.count() < BsdfPacket::kMax; ++i) packet.add(c.at(), &c.lobes, sample_2d(77, i));
    packet.sample(test::widest_kernels(), kLayeredSlot);
    for (int k = 0; k < packet.count(); ++k) {
      EXPECT_TRUE(is_finite(packet.weight(k)) && packet.weight(k).x >= 0);
      sum += packet.weight(k).x;
    }
  }
  return sum / count;
}
struct Integral {
  double light = 0, pdf = 0;
};
Integral integrate(Layered c, int grid) {
  Integral sum;
  for (int i = 0; i < grid; ++i) {
    for (int j = 0; j < grid; ++j) {
      const float cosine = (static_cast<float>(i) + 0.5f) / static_cast<float>(grid);
      const float turn = (static_cast<float>(j) + 0.5f) / static_cast<float>(grid);
      const Value v = evaluate(c, c.direction(cosine, turn));
      sum.light += 2 * double{v.times_pi.x} * cosine;
      sum.pdf += 2 * 3.14159265358979 * v.pdf;
    }
  }
  return {sum.light / (grid * grid), sum.pdf / (grid * grid)};
}

Layered with_coat(Layered c, float weight, float roughness) {
  c.lobes.coat = weight;
  c.lobes.coat_roughness = roughness;
  return c;
}
Layered with_sheen(Layered c, float roughness) {
  c.lobes.sheen = {1, 1, 1};
  c.lobes.sheen_roughness = roughness;
  return c;
}

TEST(Lobes, WithoutAnyTheyAreThePlainGlossyBsdf) {
  for (const float roughness : kRoughness) {
    for (const float cosine : kCosines) {
      Layered c({0.7f, 0.4f, 0.1f}, roughness, 0.3f);
      c.material.specular = c.lobes.specular;
      c.look(cosine, 0.3f);
      const Vec3f to_light = c.direction(0.6f, 0.75f);
      const test::BsdfValue plain = test::evaluate(c.at(), c.surface.to_viewer, to_light);
      const Value value = evaluate(c, to_light);
      EXPECT_LT(length(value.times_pi - plain.times_pi), 3e-5f * (1 + length(plain.times_pi)));
      EXPECT_NEAR(value.pdf, plain.pdf, 3e-5f * (1 + plain.pdf));
    }
  }
}

// Whatever the roughness of both, and from all sides. Rare samples weigh much at grazing angles.
TEST(Lobes, VarnishOnWhiteSurfacesKeepsTheLight) {
  constexpr float kBetween[] = {0, 0.03f, 0.05f, 0.08f, 0.1f, 0.15f, 0.2f, 0.3f, 0.45f, 0.6f, 1};
  for (const bool is_metal : {false, true}) {
    double least = 1, most = 1;
    for (const float base : kBetween)
      for (const float layer : kBetween)
        for (float root = 0.1f; root < 1.01f; root += 0.05f)  // cosines from 0.01 to 1
          for (const float weight : {0.5f, 1.0f}) {
            const float cosine = std::min(root * root, 1.0f);
            Layered c({1, 1, 1}, base, is_metal ? 1.0f : 0.0f);
            c.look(cosine, 0.3f);
            double light = furnace(with_coat(c, weight, layer));
            if (std::fabs(light - 1) > 0.004) light = furnace(with_coat(c, weight, layer), 131072);
            least = std::min(least, light), most = std::max(most, light);
            EXPECT_NEAR(light, 1, 0.007) << base << " " << layer << " " << cosine << is_metal;
          }
    std::printf("varnish on white %s: %.4f to %.4f\n", is_metal ? "metal" : "paint", least, most);
  }
}

// A white surface under sheen sends everything back, but for a loss: sheen passes 1 minus its
// albedo, seen from the viewer or from the light, whichever is less.
TEST(Lobes, LayersOnWhiteSurfacesKeepTheLightAndNeverAddAny) {
  double least = 1, most = 0;
  for (const float base : kRoughness)
    for (const float layer : kRoughness)
      for (const float cosine : kCosines)
        for (const bool is_metal : {false, true}) {
          Layered c({1, 1, 1}, base, is_metal ? 1.0f : 0.0f);
          c.look(cosine, 0.3f);
          for (const Layered& layered :
               {with_sheen(c, layer), with_coat(with_sheen(c, layer), 0.5f, layer)}) {
            const double light = furnace(layered);
            least = std::min(least, light);
            most = std::max(most, light);
            EXPECT_LT(light, 1.015) << base << " " << layer << " " << cosine << " " << is_metal;
            EXPECT_GT(light, 0.80) << base << " " << layer << " " << cosine << " " << is_metal;
          }
        }
  std::printf("white surfaces under sheen: %.3f to %.3f\n", least, most);
}

// The light that anisotropic facets lose to multiple scattering is put back by the table of
// isotropic ones. That is right unless the facets are very narrow one way and wide the other; there
// half of the light may be missing, as it would be if nothing was put back.
TEST(Lobes, StretchedMetalKeepsMostOfTheLightAndAddsLittle) {
  double least = 1, most = 0;
  for (const float roughness : kRoughness) {
    for (const float stretch : {0.3f, 0.7f, 1.0f}) {
      for (const float cosine : kCosines) {
        for (const float turn : {0.0f, 0.1f, 0.25f}) {
          Layered c({1, 1, 1}, roughness, 1);
          c.lobes.stretch = stretch;
          c.look(cosine, turn);
          const double light = furnace(c);
          least = std::min(least, light);
          most = std::max(most, light);
          const bool is_mild = stretch < 0.5f;
          EXPECT_GT(light, is_mild ? 0.93 : 0.5)
              << roughness << " " << stretch << " " << cosine << " " << turn;
          EXPECT_LT(light, is_mild ? 1.04 : 1.13)
              << roughness << " " << stretch << " " << cosine << " " << turn;
        }
      }
    }
  }
  std::printf("stretched white metal: %.3f to %.3f\n", least, most);
}

TEST(Lobes, SamplesAgreeWithValuesAndTheirPdfIntegratesToOne) {
  for (const float roughness : {0.4f, 0.8f}) {
    for (const float cosine : {0.2f, 0.8f}) {
      Layered plain({0.6f, 0.6f, 0.6f}, roughness, 0);
      plain.look(cosine, 0.3f);
      Layered stretched = plain;
      stretched.lobes.stretch = 0.6f;
      Layered tilted = with_coat(plain, 1, 0.5f);
      tilted.lobes.coat_normal = normalize(tilted.surface.normal + Vec3f{0.2f, 0.1f, 0});
      for (const Layered& c : {with_coat(plain, 0.7f, 0.4f), with_sheen(plain, 0.5f), stretched,
                               with_coat(with_sheen(stretched, 0.4f), 0.5f, 0.6f)}) {
        const Integral by_values = integrate(c, 300);
        EXPECT_NEAR(by_values.light, furnace(c, 65536), 0.01 * by_values.light);
        EXPECT_LT(by_values.pdf, 1.005);  // less than 1: samples below the surface are lost
        EXPECT_GT(by_values.pdf, 0.8);
      }
      const Integral by_values = integrate(tilted, 300);
      EXPECT_NEAR(by_values.light, furnace(tilted, 65536), 0.02 * by_values.light);
    }
  }
}

TEST(Lobes, LightMayBeSentEitherWay) {
  Layered c({0.7f, 0.5f, 0.2f}, 0.3f, 0.4f);
  c.lobes.stretch = 0.5f;
  c.lobes.specular_f90 = 0.6f;
  c = with_coat(with_sheen(c, 0.4f), 0.6f, 0.2f);
  std::mt19937 random(test::seed(7));
  std::uniform_real_distribution<float> any(0, 1);
  for (int i = 0; i < 2000; ++i) {
    const Vec3f a = c.direction(0.02f + 0.97f * any(random), any(random));
    const Vec3f b = c.direction(0.02f + 0.97f * any(random), any(random));
    const Vec3f there = evaluate(c.from(a), b).times_pi, back = evaluate(c.from(b), a).times_pi;
    EXPECT_LT(length(there - back), 2e-4f * (0.01f + length(there)));
  }
}

TEST(Lobes, WhatReflectsNothingAtNormalAndGrazingIncidenceIsDiffuse) {
  Layered c({0.5f, 0.5f, 0.5f}, 0.3f, 0);
  c.lobes.specular = {};
  c.lobes.specular_f90 = 0;
  for (const float cosine : kCosines) {
    c.look(cosine, 0.1f);
    EXPECT_NEAR(evaluate(c, c.direction(0.5f, 0.6f)).times_pi.x, 0.5f, 1e-4f);
  }
}

TEST(Lobes, EveryInstructionSetHasTheSameBits) {
  std::mt19937 random(test::seed(11));
  std::uniform_real_distribution<float> any(0, 1);
  std::vector<Layered> all;
  for (int i = 0; i < BsdfPacket::kMax; ++i) {
    Layered c({any(random), any(random), any(random)}, any(random), any(random));
    c = with_coat(with_sheen(c, any(random)), any(random), any(random));
    c.lobes.stretch = i % 3 == 0 ? 0 : any(random);
    c.lobes.coat_normal = normalize(c.surface.normal + Vec3f{0.1f * any(random), 0, 0});
    c.look(any(random), any(random));
    all.push_back(c);
  }
  std::vector<float> first;
  for (const Isa isa : test::isas_here()) {
    const KernelTable& kernels = kernels_for(isa);
    std::vector<float> made;
    BsdfPacket packet;
    const auto keep = [&] {
      for (int k = 0; k < packet.count(); ++k) {
        for (int a = 0; a < 3; ++a) {
          made.push_back(packet.direction(k)[a]);
          made.push_back(packet.weight(k)[a]);
        }
        made.push_back(packet.pdf(k));
      }
    };
    for (std::size_t i = 0; i < all.size(); ++i)
      packet.add(all[i].at(), &all[i].lobes, sample_2d(5, static_cast<std::uint32_t>(i)));
    packet.sample(kernels, kLayeredSlot);
    keep();
    packet.clear();
    for (Layered& c : all) packet.add(c.at(), &c.lobes, c.direction(0.4f, 0.2f));
    packet.evaluate(kernels, kLayeredSlot);
    keep();
    if (first.empty()) first = made;
    ASSERT_EQ(first.size(), made.size());
    EXPECT_EQ(0, std::memcmp(first.data(), made.data(), first.size() * sizeof(float)))
        << isa_name(isa);
  }
}

TEST(Power, IsWithinWhatItSays) {
  double worst = 0, worst_log = 0;
  for (int i = 1; i < 200000; ++i) {
    const float x = static_cast<float>(i) / 100000.0f;
    worst_log = std::max(worst_log, std::fabs(log2_of(x) - std::log2(double{x})) /
                                        std::max(1.0, std::fabs(std::log2(double{x}))));
    const float y = 10 - static_cast<float>(i) / 10000.0f;
    worst = std::max(worst, std::fabs(exp2_of(y) / std::exp2(double{y}) - 1));
  }
  std::printf("log2 off by %.2g, exp2 by %.2g of itself\n", worst_log, worst);
  EXPECT_LT(worst_log, 0x1p-22);
  EXPECT_LT(worst, 4 * 0x1p-24);
  EXPECT_EQ(0, power(0, 2));
  EXPECT_EQ(1, power(0, 0));
  EXPECT_EQ(1, power(1, 1e6f));
  EXPECT_NEAR(0.5f, power(0.25f, 0.5f), 1e-7f);
}

// Light of a white sky that a transmissive surface sends to the viewer: a part is chosen by its
// chance and carries its weight, then it is sampled.
struct Part {
  Surface surface;
  SurfaceLobes lobes;
};
double passing_furnace(const Layered& c, float share, bool is_thin, bool is_front, bool has_lobes) {
  Layered whole = c;
  whole.material.transmission.weight = 1;
  whole.material.transmission.is_thin = is_thin;
  whole.surface.is_front = is_front;
  double sum = 0;
  constexpr std::uint32_t kCount = 16384;
  for (std::uint32_t i = 0; i < kCount; ++i) {
    const float chance = unit_float(hash_combine(mix_bits(i), 3));
    Part part{whole.at(), whole.lobes};
    if (has_lobes) part.surface.lobes = 0;
    choose_part(part.surface, has_lobes ? &part.lobes : nullptr, share, chance);
    const Vec2f square = sample_2d(91, i);
    Vec3f weight;
    if (part.surface.bsdf == BsdfKind::kGlass) {
      const SpecularSample s = sample_specular(part.surface, part.surface.to_viewer, square);
      EXPECT_TRUE(is_finite(s.direction) && is_finite(s.weight));
      weight = s.weight;
    } else {
      BsdfPacket& packet = test::empty_packet();
      packet.add(part.surface, has_lobes ? &part.lobes : nullptr, square);
      packet.sample(test::widest_kernels(), slot_of(part.surface));
      weight = packet.weight(0);
    }
    sum += double{weight.x} * double{part.surface.weight.x};
  }
  return sum / kCount;
}

TEST(Transmission, WhitePassesAndReflectsTheLightAndAddsNone) {
  double least = 2, most = 0;
  for (const float roughness : kRoughness) {
    for (const float cosine : {0.3f, 0.7f, 1.0f}) {
      for (const float share : {0.4f, 1.0f}) {
        for (const bool is_thin : {true, false}) {
          for (const bool is_front : {true, false}) {
            Layered c({1, 1, 1}, roughness, 0);
            c.material.specular = {0.04f, 0.04f, 0.04f};
            c.look(cosine, 0.2f);
            const double light = passing_furnace(c, share, is_thin, is_front, false);
            least = std::min(least, light);
            most = std::max(most, light);
            // A solid does not get back the light that meets facets more than once.
            const bool is_kept = is_thin || roughness <= 0.3f;
            EXPECT_GT(light, is_kept ? 0.9 : 0.4)
                << roughness << " " << cosine << is_thin << is_front;
            EXPECT_LT(light, is_thin ? 1.06 : 1.01)
                << roughness << " " << cosine << is_thin << is_front;
          }
        }
      }
    }
  }
  std::printf("white surfaces that pass light: %.3f to %.3f\n", least, most);
}

TEST(Transmission, VarnishOnGlassKeepsTheLight) {
  for (const float roughness : {0.0f, 0.4f}) {
    Layered c = with_coat(Layered({1, 1, 1}, roughness, 0), 1, 0.1f);
    c.look(0.8f, 0.2f);
    EXPECT_NEAR(passing_furnace(c, 1, true, true, true), 1, 0.06) << roughness;
  }
}

TEST(Transmission, AThinSmoothSheetDoesNotBendLight) {
  Layered c({0.5f, 0.6f, 0.7f}, 0, 0);
  c.material.transmission.weight = 1;
  c.look(0.6f, 0.2f);
  Surface s = c.at();
  choose_part(s, nullptr, 1, 0.5f);
  ASSERT_EQ(BsdfKind::kGlass, s.bsdf);
  const SpecularSample out = sample_specular(s, s.to_viewer, {0.999f, 0.5f});
  EXPECT_TRUE(out.is_through);
  EXPECT_LT(length(out.direction + s.to_viewer), 1e-6f);
  EXPECT_EQ(c.surface.albedo, out.weight);
}

TEST(Transmission, WhatIsInsideDimsByLength) {
  Transmission t;
  t.is_thin = false;
  t.attenuation_color = {0.5f, 1, 0};
  t.attenuation_distance = 2;
  EXPECT_LT(length(absorbed(t, 2) - Vec3f{0.5f, 1, 0}), 1e-6f);
  EXPECT_LT(length(absorbed(t, 4) - Vec3f{0.25f, 1, 0}), 1e-6f);
  EXPECT_EQ(Vec3f({1, 1, 1}), absorbed(t, 0));
  t.is_thin = true;
  EXPECT_EQ(Vec3f({1, 1, 1}), absorbed(t, 4));
}

}  // namespace
}  // namespace tessera::core
