// SPDX-License-Identifier: Apache-2.0
// Property: each method for patches meets what the usual one meets, but for what its weakness
// loses, which is counted; where both meet a surface the method is off it by no more than it
// states; its bits are the same on every instruction set and in every bundle; and light that leaves
// what it has met does not meet it again.
#include "slave/core/primitive/patch/methods/patch_methods.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <cstring>

#include "common/math/vec3d.h"
#include "slave/core/primitive/patch/patch_evaluation.h"
#include "slave/core/scene/prepared_scene_impl.h"
#include "slave/core/scene/ray_caster.h"
#include "tests/support/packets.h"
#include "tests/support/patch_rays.h"
#include "tests/support/patch_scene_of.h"
#include "tests/support/render.h"
#include "tests/support/seed.h"
#include "tests/support/test_meshes.h"
#include "tests/support/trim_shapes.h"

namespace tessera::core {
namespace {

Vec3d vector(const double (&a)[3]) { return {a[0], a[1], a[2]}; }

// The distance of a point from the surface near (u, v), by steps to the foot of its perpendicular.
double distance_from(const Patch& patch, double u, double v, Vec3d point) {
  double least = std::numeric_limits<double>::infinity();
  for (int step = 0; step < 12; ++step) {
    const PatchJet jet = evaluate(patch, u, v);
    const Vec3d off = point - vector(jet.point), du = vector(jet.du), dv = vector(jet.dv);
    least = std::min(least, length(off));
    const double a = dot(du, du), b = dot(du, dv), c = dot(dv, dv);
    const double f = dot(du, off), g = dot(dv, off), determinant = a * c - b * b;
    if (!(determinant > 0)) break;
    u = std::clamp(u + (f * c - g * b) / determinant, 0.0, 1.0);
    v = std::clamp(v + (g * a - f * b) / determinant, 0.0, 1.0);
  }
  return least;
}

std::vector<CastRay> rays_at(const std::string& shape, test::PatchRays kind, std::size_t count) {
  const test::PatchScene scene(test::patch_shape(shape));
  test::PatchRayMaker maker(scene, shape == "torus", test::seed(43));
  std::vector<CastRay> rays;
  for (std::size_t i = 0; i < count; ++i) {
    const PatchRay ray = maker.next(kind);
    rays.push_back({{ray.origin[0], ray.origin[1], ray.origin[2]},
                    {ray.direction[0], ray.direction[1], ray.direction[2]},
                    0,
                    Bounds3f::kInf});
  }
  return rays;
}

std::vector<CastHit> cast(const PreparedScene& scene, const std::vector<CastRay>& rays,
                          PatchMethod method, Isa isa = test::isas_here().back(), int bundle = 64,
                          bool is_any = false) {
  std::vector<CastHit> hits(rays.size());
  CastOptions options;
  options.isa = isa;
  options.bundle = bundle;
  options.is_any = is_any;
  options.patch_method = method;
  cast_rays(scene, rays, options, hits);
  return hits;
}

struct Tally {
  std::size_t hits = 0, missed = 0, invented = 0, elsewhere = 0;
  double off = 0;  // of the stated error and the roundings of t, at most
};

// elsewhere: where another sheet is met.
Tally compared(const PreparedScene& scene, const std::vector<CastRay>& rays,
               const std::vector<CastHit>& wanted, const std::vector<CastHit>& got,
               PatchMethod method) {
  Tally tally;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    tally.hits += wanted[i].is_hit;
    tally.missed += wanted[i].is_hit && !got[i].is_hit;
    tally.invented += !wanted[i].is_hit && got[i].is_hit;
    if (!got[i].is_hit) continue;
    const Patch& patch = scene.impl().patches->patches[got[i].primitive];
    const Vec3d o = widened(rays[i].origin), d = widened(rays[i].direction);
    const double t = double{got[i].t};
    const double off = distance_from(patch, double{got[i].u}, double{got[i].v}, o + t * d);
    tally.off = std::max(tally.off, off / (method_error(method, patch) + 0x1p-22 * t * length(d) +
                                           0x1p-22 * patch.extent));
    if (wanted[i].is_hit)
      tally.elsewhere += std::fabs(t - double{wanted[i].t}) * length(d) > 2e-2 * patch.extent;
  }
  return tally;
}

std::size_t count_of(std::size_t usual) {
  return std::getenv("TESSERA_LONG") != nullptr ? 10 * usual : usual;
}

// What a method may lose of all hits: missed, invented or on another sheet. Rays at borders are
// among them, those that graze are apart. Each is some two to three times what was counted.
// Silhouettes of facets are polygons, and borders of open surfaces their silhouettes; what Newton
// loses are rays at silhouettes and folds, and poles; the other two stop at rays in tangents.
struct Losses {
  PatchMethod method;
  double closed, open, grazing;
};
constexpr Losses kLosses[] = {{PatchMethod::kRefine, 1e-2, 1.2e-1, 8e-1},
                              {PatchMethod::kNewton, 1.5e-2, 5e-2, 5e-1},
                              {PatchMethod::kKrawczyk, 2e-4, 1e-3, 2e-3},
                              {PatchMethod::kClip, 2e-4, 1e-3, 2e-3}};

Scene trimmed(const std::string& shape, bool keeps_outside) {
  Scene scene = test::patch_scene_of(shape);
  auto surface = std::make_shared<PatchSurface>(*scene.surfaces[0]);
  surface->loop_counts.resize(surface->patches.size());
  test::add_circle(*surface, 0.5f, 0.5f, 0.3f);
  surface->patches.back().keeps_outside = keeps_outside;
  scene.surfaces = {surface};
  return scene;
}

void expect_few_losses(const Scene& scene, const std::string& shape, const Losses& losses) {
  const auto prepared = PreparedScene::build(scene, {}).value();
  const bool is_open = shape == "degree15x9" || shape == "fold";
  Tally usual, grazing;
  for (const auto kind : {test::PatchRays::kCamera, test::PatchRays::kBorder,
                          test::PatchRays::kInside, test::PatchRays::kGrazing}) {
    const std::size_t count = shape == "degree15x9" ? 1024 : 2048;  // whose rays take longest
    const std::vector<CastRay> rays = rays_at(shape, kind, count_of(count));
    const Tally t = compared(*prepared, rays, cast(*prepared, rays, PatchMethod::kAuto),
                             cast(*prepared, rays, losses.method), losses.method);
    Tally& sum = kind == test::PatchRays::kGrazing ? grazing : usual;
    sum.hits += t.hits;
    sum.missed += t.missed;
    sum.invented += t.invented;
    sum.elsewhere += t.elsewhere;
    sum.off = std::max(sum.off, t.off);
  }
  for (const Tally* const tally : {&usual, &grazing}) {
    const double allowed = tally == &grazing ? losses.grazing
                           : is_open         ? losses.open
                                             : losses.closed;
    const auto lost = static_cast<double>(tally->missed + tally->invented + tally->elsewhere);
    EXPECT_GT(tally->hits, 300u);
    EXPECT_LE(lost, allowed * static_cast<double>(tally->hits))
        << patch_method_name(losses.method) << " " << shape << ": of " << tally->hits
        << " hits missed " << tally->missed << ", invented " << tally->invented << ", elsewhere "
        << tally->elsewhere;
    EXPECT_LE(tally->off, 1) << "of what is stated: " << patch_method_name(losses.method);
  }
}

TEST(PatchMethods, MeetWhatTheUsualOneMeetsWithinTheirErrors) {
  for (const Losses& losses : kLosses) {
    for (const char* shape : {"teapot", "sphere", "torus", "degree15x9"})
      expect_few_losses(test::patch_scene_of(shape), shape, losses);
    for (const bool keeps_outside : {false, true})
      expect_few_losses(trimmed("fold", keeps_outside), "fold", losses);
  }
}

// Where a hole is, no method meets anything, but what lies behind.
TEST(PatchMethods, KeepOutOfHoles) {
  const auto prepared = PreparedScene::build(trimmed("degree15x9", true), {}).value();
  const std::vector<CastRay> rays = rays_at("degree15x9", test::PatchRays::kCamera, 4096);
  for (const PatchMethod method : kPatchMethods) {
    std::size_t hits = 0;
    for (const CastHit& hit : cast(*prepared, rays, method)) {
      if (!hit.is_hit) continue;
      ++hits;
      EXPECT_GE(std::hypot(hit.u - 0.5f, hit.v - 0.5f), 0.3f - 1e-6f);
    }
    EXPECT_GT(hits, 300u) << patch_method_name(method);
  }
}

TEST(PatchMethods, HaveTheSameBitsOnEveryInstructionSetAndInEveryBundle) {
  for (const char* shape : {"teapot", "sphere", "fold"}) {
    const Scene scene =
        shape == std::string("fold") ? trimmed(shape, true) : test::patch_scene_of(shape);
    const auto prepared = PreparedScene::build(scene, {}).value();
    std::vector<CastRay> rays = rays_at(shape, test::PatchRays::kCamera, 512);
    for (std::size_t i = 64; i < 256; ++i) rays[i].origin = rays[64].origin;  // fans
    for (const PatchMethod method : kPatchMethods) {
      const auto wanted = cast(*prepared, rays, method, Isa::kScalar, 1);
      for (const Isa isa : test::isas_here()) {
        for (const int bundle : {1, 4, 16, 64}) {
          const auto got = cast(*prepared, rays, method, isa, bundle);
          const auto any = cast(*prepared, rays, method, isa, bundle, /*is_any=*/true);
          for (std::size_t i = 0; i < rays.size(); ++i) {
            ASSERT_EQ(std::memcmp(&got[i].t, &wanted[i].t, 3 * sizeof(float)), 0)
                << shape << " " << patch_method_name(method) << " " << isa_name(isa) << " " << i;
            ASSERT_EQ(got[i].primitive, wanted[i].primitive);
            ASSERT_EQ(any[i].is_hit, wanted[i].is_hit);
          }
        }
      }
    }
  }
}

// A convex body under an even sky reflects its albedo: what a ray leaves it does not meet again,
// though facets lie within the surface.
TEST(PatchMethods, ConvexBodyUnderAnEvenSkyReflectsItsAlbedo) {
  Scene scene = test::patch_scene_of("sphere");
  scene.materials[0].albedo = {0.7f, 0.7f, 0.7f};
  scene.environment = {1, 1, 1};
  for (const PatchMethod method : kPatchMethods) {
    FrameSettings settings;
    settings.width_px = settings.height_px = 32;
    settings.renderer = Renderer::kPath;
    settings.bounces = 2;
    settings.samples_per_pixel = 4;
    settings.patch_method = method;
    settings.camera = {{0, 0, 1.8f}, {0, 0, 0}, {0, 1, 0}, 30};
    std::size_t dark = 0;
    for (const float x : test::render(scene, settings)) dark += std::fabs(x - 0.7f) > 1e-6f;
    EXPECT_EQ(dark, 0u) << patch_method_name(method);
  }
}

// Pictures by all renderers are near to the usual ones, with meshes, holes and what lets light
// through beside the patches.
TEST(PatchMethods, PicturesAreNearToTheUsualOnes) {
  Scene scene = test::patch_scene_of("teapot");
  scene.materials.resize(2);
  scene.materials[1].alpha.mode = AlphaMode::kBlend;
  scene.materials[1].alpha.value = 0.5f;
  auto leaf = std::make_shared<PatchSurface>(*test::surface_of(test::patch_shape("plane")));
  leaf->materials = {1};
  scene.surfaces.push_back(leaf);
  scene.instances.push_back(
      {1, test::turned_and_moved(3, {2, -3, 1}, false), ObjectKind::kPatchSurface});
  scene.meshes = {std::make_shared<const Mesh>(test::make_icosphere(2))};
  scene.instances.push_back({0, test::turned_and_moved(0.5f, {2, 2, 1}, false)});
  scene.environment = {1, 1, 1};
  const auto prepared = PreparedScene::build(scene, {});
  ASSERT_TRUE(prepared.is_ok());
  for (const Renderer renderer : {Renderer::kPrimary, Renderer::kDirect, Renderer::kIgi}) {
    FrameSettings settings;
    settings.width_px = settings.height_px = 32;
    settings.renderer = renderer;
    settings.camera = {{6, -6, 4}, {0, 0, 1.5f}, {0, 0, 1}, 45};
    const auto wanted = test::render_in_tiles(**prepared, settings, Isa::kScalar, 32);
    for (const PatchMethod method : kPatchMethods) {
      settings.patch_method = method;
      double off = 0;
      const auto got = test::render_in_tiles(**prepared, settings, test::isas_here().back(), 16);
      for (std::size_t i = 0; i < got.size(); ++i)
        off += std::fabs(double{got[i]} - double{wanted[i]}) / static_cast<double>(got.size());
      EXPECT_LE(off, method == PatchMethod::kAuto ? 0 : 0.01)
          << renderer_name(renderer) << " " << patch_method_name(method);
    }
  }
}

TEST(PatchMethods, ChangeNothingWhereThereAreNoPatches) {
  Scene scene;
  scene.materials.resize(1);
  scene.meshes = {std::make_shared<const Mesh>(test::make_icosphere(2))};
  scene.instances = {{0, {}}};
  const auto prepared = PreparedScene::build(scene, {}).value();
  const std::vector<CastRay> rays = rays_at("sphere", test::PatchRays::kCamera, 256);
  const auto wanted = cast(*prepared, rays, PatchMethod::kAuto);
  for (const PatchMethod method : kPatchMethods) {
    const auto got = cast(*prepared, rays, method);
    for (std::size_t i = 0; i < rays.size(); ++i) {
      ASSERT_EQ(got[i].t, wanted[i].t);
      ASSERT_EQ(got[i].primitive, wanted[i].primitive);
    }
  }
}

}  // namespace
}  // namespace tessera::core
