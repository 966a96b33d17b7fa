// SPDX-License-Identifier: Apache-2.0
// Property: rays that are cast into scenes of patches and meshes find what brute force finds, with
// the numbers that users count, whatever the bundle and the instruction set, and what is trimmed
// away lets them through.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdlib>

#include "slave/core/primitive/patch/patch_answer_abi.h"
#include "slave/core/scene/prepared_scene_impl.h"
#include "slave/core/scene/ray_caster.h"
#include "slave/core/simd/isa_support.h"
#include "tests/support/packets.h"
#include "tests/support/patch_rays.h"
#include "tests/support/patch_scene_of.h"
#include "tests/support/seed.h"
#include "tests/support/test_meshes.h"

namespace tessera::core {
namespace {

// Everything that the scene's rays may meet, one by one.
class BruteForce {
 public:
  explicit BruteForce(const Scene& scene) {
    Scene meshes;
    meshes.materials = scene.materials;
    meshes.meshes = scene.meshes;
    std::uint32_t number = 0;
    for (const Instance& instance : scene.instances) {
      if (instance.kind == ObjectKind::kMesh) {
        meshes.instances.push_back(instance);
        const auto count =
            static_cast<std::uint32_t>(scene.meshes[instance.mesh]->triangles.size());
        for (std::uint32_t i = 0; i < count; ++i) triangle_numbers_.push_back(number++);
        continue;
      }
      const auto count = static_cast<std::uint32_t>(scene.surfaces[instance.mesh]->patches.size());
      for (std::uint32_t i = 0; i < count; ++i) patch_numbers_.push_back(number++);
    }
    std::vector<Bounds3f> boxes;
    patches_ = make_patch_store(scene, boxes);
    meshes_ = PreparedScene::build(meshes, {}).value();
  }

  CastHit trace(const CastRay& ray) {
    CastHit best;
    CastOptions options;
    options.bundle = 1;
    cast_rays(*meshes_, {&ray, 1}, options, {&best, 1});
    if (best.is_hit) best.primitive = triangle_numbers_[best.primitive];
    const PatchRay as_patches_see{{ray.origin.x, ray.origin.y, ray.origin.z},
                                  {ray.direction.x, ray.direction.y, ray.direction.z},
                                  ray.t_min};
    if (!(ray.t_min <= ray.t_max)) return {};
    for (const SubPatch& part : patches_.parts) {
      const PatchAnswer hit =
          patch_answer(patches_.patches[part.patch], part, as_patches_see.origin,
                       as_patches_see.direction, ray.t_min);
      const float t = hit.t;
      if (!hit.is_hit || t < ray.t_min || t > ray.t_max) continue;
      const std::uint32_t number = patch_numbers_[part.patch];
      if (best.is_hit && !(t < best.t || (t == best.t && number < best.primitive))) continue;
      best = {true, number, t, static_cast<float>(hit.u), static_cast<float>(hit.v), {}};
    }
    return best;
  }

 private:
  std::vector<std::uint32_t> triangle_numbers_, patch_numbers_;
  PatchStore patches_;
  std::shared_ptr<const PreparedScene> meshes_;
};

std::vector<CastRay> rays_at(const std::string& shape, std::size_t count) {
  constexpr test::PatchRays kKinds[] = {test::PatchRays::kCamera, test::PatchRays::kBorder,
                                        test::PatchRays::kInside, test::PatchRays::kGrazing};
  const test::PatchScene scene(test::patch_shape(shape));
  test::PatchRayMaker maker(scene, shape == "torus", test::seed(41));
  std::vector<CastRay> rays;
  PatchRay ray{};
  while (rays.size() < count) {
    // Neighbours are alike for as long as a packet, from one point for as long as two.
    const std::size_t in_packet = rays.size() % 256;
    const PatchRay next = maker.next(kKinds[rays.size() / 256 % 4]);
    if (in_packet >= 128 || in_packet % 64 == 0) {
      ray = next;
    } else {
      for (int a = 0; a < 3; ++a)
        ray.direction[a] = next.origin[a] + next.direction[a] - ray.origin[a];
    }
    rays.push_back({{ray.origin[0], ray.origin[1], ray.origin[2]},
                    {ray.direction[0], ray.direction[1], ray.direction[2]},
                    0,
                    Bounds3f::kInf});
    CastRay& last = rays.back();
    if (maker.any().one_in(8)) last.t_max = 2 * maker.any().share();
    if (maker.any().one_in(16)) last.t_min = 0.3f;
    if (maker.any().one_in(128)) last.direction.x = NAN;
    if (maker.any().one_in(64)) last.direction.y = 0;
  }
  return rays;
}

bool is_same(const CastHit& a, const CastHit& b) {
  const auto bits = [](float x) { return std::bit_cast<std::uint32_t>(x); };
  return a.is_hit == b.is_hit && a.primitive == b.primitive && bits(a.t) == bits(b.t) &&
         bits(a.u) == bits(b.u) && bits(a.v) == bits(b.v);
}

// least_hits: one in so many rays has to hit.
void expect_as_brute_force(const Scene& scene, const std::string& shape, std::size_t count,
                           std::size_t least_hits = 4) {
  const auto prepared = PreparedScene::build(scene, {});
  ASSERT_TRUE(prepared.is_ok());
  BruteForce brute_force(scene);
  const std::vector<CastRay> rays = rays_at(shape, count);
  std::vector<CastHit> wanted;
  std::size_t hit_count = 0;
  for (const CastRay& ray : rays) {
    wanted.push_back(brute_force.trace(ray));
    hit_count += wanted.back().is_hit;
  }
  EXPECT_GT(hit_count, count / least_hits);
  for (const Isa isa : test::isas_here()) {
    for (const int bundle : {1, 4, 16, 64}) {
      SCOPED_TRACE(std::string(isa_name(isa)) + " bundle " + std::to_string(bundle));
      CastOptions options;
      options.isa = isa;
      options.bundle = bundle;
      std::vector<CastHit> hits(rays.size()), any(rays.size());
      cast_rays(**prepared, rays, options, hits);
      options.is_any = true;
      cast_rays(**prepared, rays, options, any);
      for (std::size_t i = 0; i < rays.size(); ++i) {
        ASSERT_TRUE(is_same(hits[i], wanted[i]))
            << "ray " << i << ": " << hits[i].is_hit << " " << hits[i].primitive << " at "
            << hits[i].t << " for " << wanted[i].is_hit << " " << wanted[i].primitive << " at "
            << wanted[i].t;
        ASSERT_EQ(any[i].is_hit, wanted[i].is_hit) << "any hit of ray " << i;
      }
    }
  }
}

std::size_t count_of(std::size_t usual) {
  return std::getenv("TESSERA_LONG") != nullptr ? 10 * usual : usual;
}

TEST(PatchScenes, CastRaysFindWhatBruteForceFinds) {
  for (const char* shape : {"teapot", "sphere", "torus", "cone", "degree15x9", "cusp", "fold"}) {
    SCOPED_TRACE(shape);
    expect_as_brute_force(test::patch_scene_of(shape), shape, count_of(1024));
  }
}

// A mesh in front, a moved and a mirrored surface, a mesh behind.
Scene mixed_scene() {
  Scene scene = test::patch_scene_of("torus");
  scene.surfaces.push_back(test::surface_of(test::patch_shape("sphere")));
  scene.meshes = {std::make_shared<const Mesh>(test::make_icosphere(2)),
                  std::make_shared<const Mesh>(test::make_random_triangles(200, 0.3f, 7))};
  const auto surface = ObjectKind::kPatchSurface;
  scene.instances = {{0, test::turned_and_moved(0.4f, {0.5f, 0, 0}, false)},
                     {0, {}, surface},
                     {1, test::turned_and_moved(0.3f, {-0.6f, 0.2f, 0.1f}, true), surface},
                     {1, {}},
                     {1, test::turned_and_moved(0.2f, {0.1f, 0.7f, 0}, false), surface}};
  return scene;
}

TEST(PatchScenes, MeshesAndMovedSurfacesAreMetAndCountedInOrder) {
  expect_as_brute_force(mixed_scene(), "torus", count_of(4096));
}

// No cut tells triangles of one box apart: a leaf holds blocks of them.
TEST(PatchScenes, TrianglesOfOneBoxAreMetInAllBlocksOfTheirLeaf) {
  Scene scene = test::patch_scene_of("torus");
  Mesh mesh = test::make_random_triangles(100, 0.3f, 7);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    mesh.positions[3 * t] = {-1, -1, -1};
    mesh.positions[3 * t + 1] = {1, 1, 1};
  }
  scene.meshes = {std::make_shared<const Mesh>(std::move(mesh))};
  scene.instances.push_back({0, {}});
  expect_as_brute_force(scene, "torus", count_of(2048));
}

// A loop of four lines around (u, v).
void cut_square(PatchSurface& surface, float u, float v, float half) {
  const auto in = [](float x) { return std::clamp(x, 0.0f, 1.0f); };
  surface.loop_counts.resize(surface.patches.size());
  ++surface.loop_counts.back();
  surface.segment_counts.push_back(4);
  for (const auto& [x, y] : {std::pair{-half, -half}, {half, -half}, {half, half}, {-half, half}}) {
    surface.degrees.push_back(1);
    surface.trim_points.push_back({in(u + x), in(v + y), 1});
  }
}

CastHit cast_one(const PreparedScene& scene, const CastRay& ray) {
  CastHit hit;
  CastOptions options;
  options.bundle = 1;
  cast_rays(scene, {&ray, 1}, options, {&hit, 1});
  return hit;
}

TEST(PatchScenes, TrimmedPatchesAreMetWhereTheyAreKept) {
  for (const bool keeps_outside : {false, true}) {
    for (const char* shape : {"plane", "degree15x9", "fold"}) {
      SCOPED_TRACE(std::string(shape) + (keeps_outside ? " out" : " in"));
      Scene scene = test::patch_scene_of(shape);
      auto surface = std::make_shared<PatchSurface>(*scene.surfaces[0]);
      // A circle of two halves with weights, and a square in it.
      surface->loop_counts = {1};
      surface->segment_counts = {4};
      surface->degrees = {2, 2, 2, 2};
      const float w = std::sqrt(0.5f);
      surface->trim_points = {{0.9f, 0.5f, 1}, {0.9f, 0.9f, w}, {0.5f, 0.9f, 1}, {0.1f, 0.9f, w},
                              {0.1f, 0.5f, 1}, {0.1f, 0.1f, w}, {0.5f, 0.1f, 1}, {0.9f, 0.1f, w}};
      cut_square(*surface, 0.5f, 0.5f, 0.125f);
      surface->patches[0].keeps_outside = keeps_outside;
      scene.surfaces = {surface};
      const Transform to_world = test::turned_and_moved(1, {0, 0, 0}, false);
      scene.instances[0].object_to_world = to_world;
      expect_as_brute_force(scene, shape, count_of(2048), 16);
      std::size_t hits = 0;
      const auto prepared = PreparedScene::build(scene, {}).value();
      for (const CastRay& ray : rays_at(shape, 512)) {
        const CastHit hit = cast_one(*prepared, ray);
        if (!hit.is_hit) continue;
        ++hits;
        const float radius = std::hypot(hit.u - 0.5f, hit.v - 0.5f);
        const float across = std::max(std::fabs(hit.u - 0.5f), std::fabs(hit.v - 0.5f));
        const bool is_enclosed = radius < 0.4f && across > 0.125f;
        const bool is_near = std::fabs(radius - 0.4f) < 1e-6f || std::fabs(across - 0.125f) < 1e-6f;
        EXPECT_TRUE(is_near || is_enclosed != keeps_outside) << hit.u << " " << hit.v;
      }
      EXPECT_GT(hits, 20u);
    }
  }
}

// What is behind a hole is seen through it, the same patch as well.
TEST(PatchScenes, SheetsBehindAHoleAreMet) {
  for (const char* shape : {"fold", "sheets"}) {
    SCOPED_TRACE(shape);
    const Scene whole = test::patch_scene_of(shape);
    const auto prepared = PreparedScene::build(whole, {}).value();
    std::size_t seen = 0;
    for (CastRay ray : rays_at(shape, 512)) {
      const CastHit first = cast_one(*prepared, ray);
      if (!first.is_hit) continue;
      CastRay behind = ray;
      behind.t_min = first.t * 1.001f + 1e-4f;
      const CastHit second = cast_one(*prepared, behind);
      constexpr float kHalf = 0.01f;
      if (!second.is_hit ||
          std::max(std::fabs(second.u - first.u), std::fabs(second.v - first.v)) < 2 * kHalf)
        continue;
      Scene cut = whole;
      auto surface = std::make_shared<PatchSurface>(*whole.surfaces[0]);
      cut_square(*surface, first.u, first.v, kHalf);
      surface->patches[0].keeps_outside = 1;
      cut.surfaces = {surface};
      const CastHit through = cast_one(*PreparedScene::build(cut, {}).value(), ray);
      // Between both there may be a third root, next to the first one.
      if (through.is_hit && through.t < second.t) continue;
      ++seen;
      EXPECT_TRUE(through.is_hit && through.t == second.t) << first.t << " " << second.t;
    }
    EXPECT_GT(seen, 10u);
  }
}

// A surface that was split before it was placed is met where the placed one is that is split there.
TEST(PatchScenes, PlacedPartsAnswerAsPartsThatAreSplitInPlace) {
  Scene scene = test::patch_scene_of("torus");
  const Transform to_world = test::turned_and_moved(0.3f, {-0.6f, 0.2f, 0.1f}, true);
  scene.instances[0].object_to_world = to_world;
  PatchSurface there = *scene.surfaces[0];
  for (std::size_t k = 0; k < there.numbers.size(); k += 4) {
    const Vec3f p = to_world.point({there.numbers[k], there.numbers[k + 1], there.numbers[k + 2]});
    for (int a = 0; a < 3; ++a) there.numbers[k + static_cast<std::size_t>(a)] = p[a];
  }
  Scene other = scene;
  other.surfaces = {std::make_shared<const PatchSurface>(there)};
  other.instances[0].object_to_world = {};
  BruteForce placed(scene), split_there(other);
  std::size_t hits = 0, apart = 0;
  for (CastRay ray : rays_at("torus", count_of(4096))) {
    if (!(ray.direction.x == ray.direction.x)) continue;
    ray.origin = to_world.point(ray.origin);
    ray.direction = to_world.direction(ray.direction);
    const CastHit a = placed.trace(ray), b = split_there.trace(ray);
    hits += a.is_hit;
    if (a.is_hit != b.is_hit || a.primitive != b.primitive) {
      ++apart;  // silhouettes, and borders where both are met at one t
    } else if (a.is_hit) {
      EXPECT_NEAR(a.t, b.t, 4e-6f * b.t + 1e-7f);
    }
  }
  EXPECT_GT(hits, 1000u);
  EXPECT_LT(apart, hits / 100);
}

TEST(PatchScenes, TrianglesAndPatchesAreCountedAndKdTreesRefused) {
  const Scene scene = mixed_scene();
  EXPECT_EQ((*PreparedScene::build(scene, {}))->primitive_count(), 320u + 16 + 8 + 200 + 8);
  BuildOptions options;
  options.structure = Structure::kKd;
  const auto refused = PreparedScene::build(scene, options);
  ASSERT_FALSE(refused.is_ok());
  EXPECT_NE(refused.status().message().find("--structure bvh"), std::string::npos);
}

}  // namespace
}  // namespace tessera::core
