// SPDX-License-Identifier: Apache-2.0
// Property: the kernels compute and sample the BSDFs of many surfaces to the bit as plain
// arithmetic does for each alone, on every instruction set and whatever stands beside it.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <random>

#include "slave/core/sampling/hemisphere.h"
#include "tests/support/packets.h"
#include "tests/support/plain_glossy.h"
#include "tests/support/seed.h"

namespace tessera::core {
namespace {

constexpr int kGlossySlot = static_cast<int>(BsdfKind::kGlossy);

bool same_bits(Vec3f a, Vec3f b) { return std::memcmp(&a, &b, sizeof(a)) == 0; }

class AnySurface {
 public:
  explicit AnySurface(unsigned seed) : random_(test::seed(seed)) {}

  Vec3f unit_vector() {
    const float odd[] = {0, -0.0f, 1, -1, 1e-20f};
    const auto part = [&] { return random_() % 6 == 0 ? odd[random_() % 5] : 2 * share() - 1; };
    for (;;) {
      const Vec3f v{part(), part(), part()};
      if (length(v) > 1e-3f) return normalize(v);
    }
  }
  // A direction above the surface, at times grazing, rarely below.
  Vec3f above(Vec3f normal) {
    const Vec3f v = cosine_direction(normal, {share(), share()});
    if (random_() % 8 == 0) return normalize(v - normal * (0.999f * dot(v, normal)));
    return random_() % 50 == 0 ? -v : normalize(v);
  }
  // A number in [0, 1), often one of its ends.
  float share() {
    if (random_() % 16 == 0) return random_() % 2 == 0 ? 0 : 1 - 0x1p-24f;
    return std::uniform_real_distribution<float>(0, 1 - 0x1p-24f)(random_);
  }
  float whole_share() { return random_() % 8 == 0 ? 1 : share(); }
  Vec3f colour() { return {whole_share(), whole_share(), whole_share()}; }
  unsigned below(unsigned limit) { return static_cast<unsigned>(random_() % limit); }

 private:
  std::mt19937 random_;
};

struct Glossy {
  Material material;
  Surface surface;
  Vec3f to_light;
  Vec2f square;

  void set(AnySurface& any) {
    material.specular = any.colour();
    surface.bsdf = BsdfKind::kGlossy;
    surface.material = &material;
    surface.albedo = any.colour();
    surface.roughness = any.whole_share();
    surface.metalness = any.below(3) == 0 ? 0 : any.whole_share();
    surface.shading_normal = surface.normal = any.unit_vector();
    surface.to_viewer = any.above(surface.shading_normal);
    to_light = any.above(surface.shading_normal);
    square = {any.share(), any.share()};
  }
};

TEST(BsdfPackets, GlossySurfacesAreThoseOfPlainArithmetic) {
  for (const Isa isa : test::isas_here()) {
    const KernelTable& kernels = kernels_for(isa);
    AnySurface any(21);
    int samples = 0;
    for (int round = 0; round < 3000; ++round) {
      Glossy one[BsdfPacket::kMax];
      const int count = 1 + static_cast<int>(any.below(BsdfPacket::kMax));
      BsdfPacket sampled, evaluated;
      for (int i = 0; i < count; ++i) {
        one[i].set(any);
        sampled.add(one[i].surface, nullptr, one[i].square);
        evaluated.add(one[i].surface, nullptr, one[i].to_light);
      }
      sampled.sample(kernels, kGlossySlot);
      evaluated.evaluate(kernels, kGlossySlot);
      for (int i = 0; i < count; ++i) {
        const test::PlainGlossy plain(one[i].surface, one[i].surface.to_viewer);
        const test::BsdfSample s = plain.sample(one[i].square);
        const test::BsdfValue v = plain.evaluate(one[i].to_light);
        ASSERT_TRUE(same_bits(s.direction, sampled.direction(i))) << isa_name(isa) << " " << i;
        ASSERT_TRUE(same_bits(s.weight, sampled.weight(i))) << isa_name(isa) << " " << i;
        ASSERT_EQ(s.pdf, sampled.pdf(i));
        ASSERT_TRUE(same_bits(v.times_pi, evaluated.times_pi(i))) << isa_name(isa) << " " << i;
        ASSERT_EQ(v.pdf, evaluated.pdf(i));
        samples += s.pdf > 0 ? 1 : 0;
      }
    }
    EXPECT_GT(samples, 50000) << isa_name(isa);
  }
}

TEST(BsdfPackets, DiffuseDirectionsAreThoseOfPlainArithmetic) {
  for (const Isa isa : test::isas_here()) {
    AnySurface any(22);
    for (int round = 0; round < 10000; ++round) {
      Vec3f normal[BsdfPacket::kMax];
      Vec2f square[BsdfPacket::kMax];
      const int count = 1 + static_cast<int>(any.below(BsdfPacket::kMax));
      BsdfPacket packet;
      for (int i = 0; i < count; ++i) {
        normal[i] = any.unit_vector();
        square[i] = any.below(8) == 0 ? Vec2f{0.5f, any.share()} : Vec2f{any.share(), any.share()};
        if (any.below(32) == 0) square[i] = {0.5f, 0.5f};
        packet.add_diffuse(normal[i], square[i]);
      }
      packet.sample_diffuse(kernels_for(isa));
      for (int i = 0; i < count; ++i) {
        const Vec3f plain = cosine_direction(normal[i], square[i]);
        ASSERT_TRUE(same_bits(plain, packet.direction(i)))
            << isa_name(isa) << " " << square[i].x << " " << square[i].y;
        ASSERT_EQ(dot(plain, normal[i]) * 0.318309886f, packet.pdf(i));
      }
    }
  }
}

}  // namespace
}  // namespace tessera::core
