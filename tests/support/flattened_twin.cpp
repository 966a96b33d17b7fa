// SPDX-License-Identifier: Apache-2.0
#include "tests/support/flattened_twin.h"

#include <gtest/gtest.h>

#include <bit>
#include <cstdint>

#include "slave/core/scene/prepared_scene_impl.h"
#include "tests/support/packets.h"

namespace tessera::test {

using namespace core;

namespace {

using Random = std::mt19937;

float unit(Random& random) { return std::uniform_real_distribution<float>(-1, 1)(random); }

bool is_same(const CastHit& a, const CastHit& b) {
  const auto bits = [](float x) { return std::bit_cast<std::uint32_t>(x); };
  return a.is_hit == b.is_hit && a.primitive == b.primitive && bits(a.t) == bits(b.t) &&
         bits(a.u) == bits(b.u) && bits(a.v) == bits(b.v);
}

Vec3f any_corner(const TriangleStore& triangles, Random& random) {
  return triangles.vertex(random() % triangles.primitive_count(), static_cast<int>(random() % 3));
}

}  // namespace

std::vector<CastRay> rays_around(const TriangleStore& triangles, std::size_t count,
                                 Random& random) {
  const Vec3f center = any_corner(triangles, random);
  const float size = length(any_corner(triangles, random) - center) + 1e-3f * length(center);
  std::vector<CastRay> rays;
  Vec3f eye{};
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t kind = i / 64 % 4;
    if (i % 64 == 0) eye = center + Vec3f{unit(random), unit(random), unit(random)} * (3 * size);
    const Vec3f target = any_corner(triangles, random);
    CastRay ray{eye, target - eye, 0, Bounds3f::kInf};
    if (kind == 1) {  // a bundle: origins apart, one way
      ray.origin = eye + Vec3f{unit(random), unit(random), unit(random)} * (0.05f * size);
      ray.direction =
          center - eye + Vec3f{unit(random), unit(random), unit(random)} * (0.2f * size);
    } else if (kind == 2) {  // from a surface, anywhere
      ray.origin = any_corner(triangles, random);
      ray.direction = {unit(random), unit(random), unit(random)};
      if (i % 3 == 0) ray.t_max = size;
    } else if (kind == 3) {  // a narrow fan, at a face
      const std::uint64_t number = (i / 64 * 7919) % triangles.primitive_count();
      const Vec3f a = triangles.vertex(number, 0), b = triangles.vertex(number, 1);
      const float share = static_cast<float>(i % 64) / 63;
      ray.direction = a + (b - a) * share - eye;
      if (i % 2 == 0) ray.direction = ray.direction * 1e-3f;
    }
    rays.push_back(ray);
  }
  return rays;
}

std::size_t compare_with_flattened(const PreparedScene& flat, const PreparedScene& instanced,
                                   const std::vector<CastRay>& rays) {
  std::size_t hit_count = 0;
  for (const Isa isa : isas_here()) {
    for (const int bundle : {1, 64}) {
      for (const bool is_any : {false, true}) {
        const CastOptions options{isa, bundle, 1, is_any};
        std::vector<CastHit> wanted(rays.size()), found(rays.size());
        cast_rays(flat, rays, options, wanted);
        cast_rays(instanced, rays, options, found);
        for (std::size_t i = 0; i < rays.size(); ++i) {
          EXPECT_TRUE(is_same(wanted[i], found[i]))
              << isa_name(isa) << (is_any ? ", any" : ", closest") << ", bundle " << bundle
              << ", ray " << i << ": " << wanted[i].primitive << " at " << wanted[i].t << ", found "
              << found[i].primitive << " at " << found[i].t;
          if (testing::Test::HasFailure()) return 0;
          hit_count += wanted[i].is_hit ? 1u : 0u;
        }
      }
    }
  }
  return hit_count;
}

}  // namespace tessera::test
