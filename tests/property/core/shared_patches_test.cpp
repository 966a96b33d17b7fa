// SPDX-License-Identifier: Apache-2.0
// Property: a scene whose places share surfaces of patches gives the bits of the same scene
// flattened, whatever the maps, for single rays, bundles and fans, closest and any hit, on every
// instruction set, and by every method.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <random>
#include <string_view>

#include "slave/core/integrate/tile_renderer.h"
#include "slave/core/primitive/freeform/placed_parts.h"
#include "slave/core/scene/prepared_scene_impl.h"
#include "tests/support/flattened_twin.h"
#include "tests/support/gaping_solids.h"
#include "tests/support/packets.h"
#include "tests/support/patch_scene_of.h"
#include "tests/support/seed.h"
#include "tests/support/test_meshes.h"

namespace tessera::core {
namespace {

using Random = std::mt19937;
constexpr ObjectKind kSurface = ObjectKind::kPatchSurface;

float unit(Random& random) { return std::uniform_real_distribution<float>(-1, 1)(random); }
Vec3f any_vector(Random& random) { return {unit(random), unit(random), unit(random)}; }

struct Class {
  const char* name;
  float scale;  // exponent of ten
  float shear;
  float far;  // from the world's origin, in units of the scene
  bool is_mirrored = false;
  bool is_uneven = false;  // axes are scaled apart by up to 1e2
};

constexpr Class kClasses[] = {{"moved", 0, 0, 0},     {"mirrored", 0, 0, 0, true},
                              {"sheared", 0, 3, 0},   {"tiny", -6, 0.2f, 0},
                              {"huge", 6, 0.2f, 0},   {"uneven", 0, 0.5f, 0, true, true},
                              {"far", 0, 0.3f, 1e4f}, {"very_far", 0, 0.3f, 1e5f}};

Transform map_of(const Class& c, int number, Random& random) {
  Transform t;
  if (std::string_view(c.name) == "moved" && number == 0) return t;
  const Vec3f a = normalize(any_vector(random)), b = normalize(cross(a, any_vector(random)));
  const Vec3f axes[3] = {a, b, cross(a, b)};
  const float all = std::pow(10.0f, c.scale);
  Transform by;
  by.m[0][1] = c.shear * unit(random);
  by.m[1][2] = c.shear * unit(random);
  if (c.is_mirrored && number % 2 == 0) by.m[0][0] = -1;
  if (c.is_uneven) by.m[1][1] = std::pow(10.0f, 2 * unit(random));
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) t.m[i][j] = axes[j][static_cast<int>(i)];
  }
  t = t * by;
  for (auto& row : t.m) {
    for (std::size_t j = 0; j < 3; ++j) row[j] *= all;
    row[3] = all * (2 * unit(random) + c.far);
  }
  return t;
}

Scene scene_of(const Class& c, Random& random) {
  Scene scene = test::patch_scene_of("teapot");
  for (const char* shape : {"torus", "degree15x9", "sphere"})
    scene.surfaces.push_back(test::surface_of(test::patch_shape(shape)));
  scene.instances.clear();
  for (int i = 0; i < 9; ++i)
    scene.instances.push_back({static_cast<std::uint32_t>(i % 4), map_of(c, i, random), kSurface});
  return scene;
}

std::shared_ptr<const PreparedScene> prepared(const Scene& scene, Instancing instancing,
                                              const PreparedScene* other = nullptr) {
  BuildOptions options;
  options.instancing = instancing;
  options.other = other;
  auto built = PreparedScene::build(scene, options);
  EXPECT_TRUE(built.is_ok());
  return *built;
}

const SharedPlaces& places_of(const PreparedScene& scene) { return scene.impl().patches->shared; }

// A control point of an instance, in world space; for meshes a corner.
Vec3f any_point(const Scene& scene, Random& random) {
  const Instance& instance = scene.instances[random() % scene.instances.size()];
  if (instance.kind == ObjectKind::kMesh) {
    const Mesh& mesh = *scene.meshes[instance.mesh];
    return instance.object_to_world.point(mesh.positions[random() % mesh.positions.size()]);
  }
  const PatchSurface& surface = *scene.surfaces[instance.mesh];
  const std::size_t skipped = random() % surface.patches.size();
  PatchCursor at(surface);
  for (std::size_t i = 0; i < skipped; ++i) at.advance();
  return instance.object_to_world.point(at.point(random() % at.form().point_count()));
}

// Rays at control points and past them: fans, bundles, rays from near the surface that have nothing
// in common, narrow fans. Lengths of directions differ.
std::vector<CastRay> rays_at(const Scene& scene, std::size_t count, Random& random) {
  std::vector<CastRay> rays;
  Vec3f eye{}, first{};
  float size = 1;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t kind = i / 64 % 4;
    Vec3f target = any_point(scene, random);
    if (i % 64 == 0) {
      first = target;
      size = std::max(length(any_point(scene, random) - first), 1e-7f * length(first));
      eye = first + any_vector(random) * (3 * size);
    }
    CastRay ray{eye, target - eye, 0, Bounds3f::kInf};
    if (kind == 1) {
      ray.origin = eye + any_vector(random) * (0.05f * size);
      ray.direction = first - eye + any_vector(random) * (0.2f * size);
    } else if (kind == 2) {
      ray.origin = target + any_vector(random) * (0.1f * size);
      ray.direction = any_vector(random);
      if (i % 3 == 0) ray.t_max = size;
    } else if (kind == 3) {
      const float scale = std::ldexp(1.0f, -static_cast<int>(i / 256 % 8));
      target = first + any_vector(random) * (size * scale);
      ray.direction = (target - eye) * scale;
    }
    if (random() % 64 == 0) ray.direction.y = 0;
    if (random() % 64 == 0) ray.t_min = 0.3f;
    rays.push_back(ray);
  }
  return rays;
}

void expect_same_bounds(const PreparedScene& flat, const PreparedScene& shared) {
  const Bounds3f a = flat.impl().index.bounds(), b = shared.impl().index.bounds();
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(a.lower[i], b.lower[i]) << i;
    EXPECT_EQ(a.upper[i], b.upper[i]) << i;
  }
}

class SharedPatches : public testing::TestWithParam<Class> {};

TEST_P(SharedPatches, GiveTheBitsOfTheFlattenedScene) {
  const unsigned seed = test::seed();
  TESSERA_TRACE_SEED(seed);
  Random random(seed);
  for (int round = 0; round < 3; ++round) {
    const Scene scene = scene_of(GetParam(), random);
    const auto flat = prepared(scene, Instancing::kNever);
    const auto shared = prepared(scene, Instancing::kAlways);
    ASSERT_TRUE(places_of(*flat).places.empty());
    ASSERT_EQ(places_of(*shared).places.size(), scene.instances.size());
    EXPECT_EQ(flat->primitive_count(), shared->primitive_count());
    expect_same_bounds(*flat, *shared);
    const std::vector<CastRay> rays = rays_at(scene, 64 * 64, random);
    EXPECT_GT(test::compare_with_flattened(*flat, *shared, rays), rays.size());
  }
}

INSTANTIATE_TEST_SUITE_P(Maps, SharedPatches, testing::ValuesIn(kClasses),
                         [](const auto& info) { return std::string(info.param.name); });

TEST(SharedPatches, AreMetByEveryMethodAsTheFlattenedScene) {
  const unsigned seed = test::seed();
  TESSERA_TRACE_SEED(seed);
  Random random(seed);
  const Scene scene = scene_of(kClasses[2], random);
  const auto flat = prepared(scene, Instancing::kNever);
  const auto shared = prepared(scene, Instancing::kAlways);
  const std::vector<CastRay> rays = rays_at(scene, 64 * 8, random);
  for (const PatchMethod method : kPatchMethods) {
    std::size_t hits = 0;
    for (const bool is_any : {false, true}) {
      const CastOptions options{test::isas_here().back(), 64, 1, is_any, method};
      std::vector<CastHit> wanted(rays.size()), found(rays.size());
      cast_rays(*flat, rays, options, wanted);
      cast_rays(*shared, rays, options, found);
      for (std::size_t i = 0; i < rays.size(); ++i) {
        ASSERT_EQ(wanted[i].is_hit, found[i].is_hit) << patch_method_name(method) << ", ray " << i;
        ASSERT_EQ(wanted[i].primitive, found[i].primitive);
        ASSERT_EQ(std::bit_cast<std::uint32_t>(wanted[i].t),
                  std::bit_cast<std::uint32_t>(found[i].t));
        hits += wanted[i].is_hit;
      }
    }
    EXPECT_GT(hits, rays.size() / 8) << patch_method_name(method);
  }
}

// A field of teapots, which share from the place on that the rule names; packets that see all of it
// need more parts than a thread keeps.
TEST(SharedPatches, ThatAreManyShareByTheirRule) {
  const unsigned seed = test::seed();
  TESSERA_TRACE_SEED(seed);
  Random random(seed);
  Scene scene = test::patch_scene_of("teapot");
  scene.instances.clear();
  for (int i = 0; i < 2048; ++i) {
    Instance teapot{0, test::turned_and_moved(1, {}, i % 3 == 0), kSurface};
    const auto at = [](int k) { return static_cast<float>(k); };
    teapot.object_to_world.m[0][3] = 1.3f * at(i % 13);
    teapot.object_to_world.m[1][3] = 1.3f * at(i / 13 % 13);
    teapot.object_to_world.m[2][3] = 1.3f * at(i / 169);
    scene.instances.push_back(teapot);
  }
  EXPECT_TRUE(places_of(*prepared(scene, Instancing::kAuto)).places.empty());
  scene.instances.push_back({0, {}, kSurface});
  const auto flat = prepared(scene, Instancing::kNever);
  const auto shared = prepared(scene, Instancing::kAuto);
  ASSERT_EQ(places_of(*shared).places.size(), 2049u);
  ASSERT_GT(places_of(*shared).surfaces[0]->parts.size() * 64, std::size_t{kPlacedPartsMax});
  expect_same_bounds(*flat, *shared);
  EXPECT_LT(20 * shared->memory_bytes(), flat->memory_bytes());
  std::vector<CastRay> rays = rays_at(scene, 64 * 24, random);
  for (int i = 0; i < 64 * 16; ++i) {
    const Vec3f eye = i % 128 < 64 ? Vec3f{-30, 5, 8} : Vec3f{8, 8, 60} + any_vector(random);
    rays.push_back({eye, any_point(scene, random) - eye, 0, Bounds3f::kInf});
  }
  EXPECT_GT(test::compare_with_flattened(*flat, *shared, rays), rays.size());
}

// What a thread keeps has the bits of what is made anew, when it was dropped meanwhile, too.
TEST(SharedPatches, AreKeptInATableThatIsDroppedAsAWhole) {
  Random random(5);
  const Scene scene = scene_of(kClasses[0], random);
  const auto shared = prepared(scene, Instancing::kAlways);
  const SharedPlaces& places = places_of(*shared);
  const InstanceBlock& place = places.places[1];
  const SharedSurface& surface = *places.surfaces[place.mesh];
  PlacedParts kept;
  const auto part_of = [&](std::uint64_t number, std::size_t part) {
    const SubPatch& own = surface.parts[part];
    return kept.find(place, number, surface.patches[own.patch], own);
  };
  const PartInWorld first = part_of(7, 0);
  const SubPatch copy = *first.part;
  std::uint64_t number = 8;
  for (; kept.has_room(); ++number) {
    EXPECT_NE(part_of(number, 0).part, first.part);
    EXPECT_EQ(part_of(7, 0).part, first.part);
  }
  EXPECT_LE(number, 8u + kPlacedPartsMax);
  EXPECT_EQ(part_of(number, 0).part, first.part);  // all others are gone
  const PartInWorld again = part_of(7, 0);
  EXPECT_NE(again.part, first.part);
  EXPECT_EQ(std::memcmp(again.part, &copy, sizeof copy), 0);
}

// A surface without trims beside one whose border is widened, one that sheds light, meshes, and
// places that have no inverse, or leave patches without extent.
Scene rich_scene() {
  Scene scene = test::patch_scene_of("teapot");
  scene.materials.resize(3);
  scene.materials[1].emission = {4, 4, 3};
  scene.materials[2].bsdf = BsdfKind::kMirror;
  test::SolidWriter writer;
  writer.add_plane({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  writer.add_side({1, 0}, {1, 1}, 0.01);
  scene.surfaces.push_back(std::make_shared<const PatchSurface>(writer.surface()));
  auto lamp = std::make_shared<PatchSurface>(*test::surface_of(test::patch_shape("sphere")));
  lamp->materials = {1};
  scene.surfaces.push_back(lamp);
  auto mirror = std::make_shared<PatchSurface>(*scene.surfaces[0]);
  mirror->materials.assign(mirror->patches.size(), 0);
  for (std::size_t i = 0; i < mirror->materials.size(); i += 2) mirror->materials[i] = 2;
  scene.surfaces.push_back(mirror);
  scene.meshes = {std::make_shared<const Mesh>(test::make_icosphere(2))};
  Transform flat_map = test::turned_and_moved(1, {1, 1, 1}, false), far_map = flat_map;
  for (auto& row : flat_map.m) row[2] = 0;
  far_map.m[0][3] = 1e8f;
  scene.instances = {{0, test::turned_and_moved(0.5f, {0, 0, 0}, false), kSurface},
                     {0, test::turned_and_moved(0.4f, {-1.5f, 0.3f, 0}, false)},
                     {3, test::turned_and_moved(0.7f, {1.5f, 0.2f, 0}, true), kSurface},
                     {1, test::turned_and_moved(2, {-1, -1, -0.5f}, false), kSurface},
                     {2, test::turned_and_moved(0.3f, {0, 0, 2}, false), kSurface},
                     {0, flat_map, kSurface},
                     {0, far_map, kSurface},
                     {3, {}, kSurface}};
  scene.camera = Camera{{3, -4, 2}, {0, 0, 0}, {0, 0, 1}, 40};
  return scene;
}

TEST(SharedPatches, LeaveFlattenedWhatCannotBeShared) {
  const Scene scene = rich_scene();
  const auto shared = prepared(scene, Instancing::kAlways);
  std::vector<bool> is_shared;
  for (std::size_t i = 0; i < scene.instances.size(); ++i)
    is_shared.push_back(places_of(*shared).has(i));
  EXPECT_EQ(is_shared, (std::vector<bool>{true, false, true, false, false, false, false, true}));
  const auto flat = prepared(scene, Instancing::kNever);
  expect_same_bounds(*flat, *shared);
  Random random(6);
  Scene near = scene;
  near.instances.erase(near.instances.begin() + 6);  // rays stay where the others are
  const std::vector<CastRay> rays = rays_at(near, 64 * 64, random);
  EXPECT_GT(test::compare_with_flattened(*flat, *shared, rays), rays.size());
}

// Limits of t in object space would be below what float32 holds, were they made in one step.
TEST(SharedPatches, ThatAreTinyInTheirOwnPlaceAreMetByVerySlowRays) {
  const unsigned seed = test::seed();
  TESSERA_TRACE_SEED(seed);
  Random random(seed);
  Scene scene = scene_of(kClasses[2], random);
  for (auto& surface : scene.surfaces) {
    auto tiny = std::make_shared<PatchSurface>(*surface);
    PatchCursor at(*surface);
    for (std::size_t n = 0; n < tiny->numbers.size(); at.advance()) {
      const std::size_t width = at.form().is_rational != 0 ? 4 : 3;
      const std::size_t end = n + at.form().number_count();
      for (; n < end; n += width)
        for (std::size_t a = 0; a < 3; ++a) tiny->numbers[n + a] *= 0x1p-30f;
    }
    surface = tiny;
  }
  for (Instance& instance : scene.instances) {
    for (auto& row : instance.object_to_world.m)
      for (std::size_t j = 0; j < 3; ++j) row[j] *= 0x1p30f;
  }
  const auto flat = prepared(scene, Instancing::kNever);
  const auto shared = prepared(scene, Instancing::kAlways);
  ASSERT_EQ(places_of(*shared).places.size(), scene.instances.size());
  std::vector<CastRay> rays = rays_at(scene, 64 * 16, random);
  for (CastRay& ray : rays) {
    ray.direction = ray.direction * 0x1p-118f;
    ray.t_min *= 0x1p118f;
    if (ray.t_max < Bounds3f::kInf) ray.t_max *= 0x1p118f;
  }
  EXPECT_GT(test::compare_with_flattened(*flat, *shared, rays), rays.size());
}

// Each of its parts is a lamp, and lamps are known by the parts of flattened places.
TEST(SharedPatches, ThatBeginToShedLightAreFlattened) {
  Scene scene = rich_scene();
  const auto dark = prepared(scene, Instancing::kAlways);
  ASSERT_TRUE(places_of(*dark).has(0));
  scene.materials[0].emission = {1, 1, 1};
  const auto shining = prepared(scene, Instancing::kAlways, dark.get());
  EXPECT_FALSE(places_of(*shining).has(0));
  EXPECT_EQ(shining->impl().lights.emitters.size(),
            prepared(scene, Instancing::kNever)->impl().lights.emitters.size());
  scene.materials[0].emission = {};
  EXPECT_TRUE(places_of(*prepared(scene, Instancing::kAlways, shining.get())).has(0));
  scene.materials[1].emission = {1, 1, 1};  // of what was a lamp before
  EXPECT_TRUE(prepared(scene, Instancing::kAlways, dark.get())->has_geometry_of(*dark));
}

TEST(SharedPatches, ArePicturedAsTheFlattenedScene) {
  Scene scene = rich_scene();
  scene.instances.erase(scene.instances.begin() + 6);
  const auto flat = prepared(scene, Instancing::kNever);
  const auto shared = prepared(scene, Instancing::kAlways);
  FrameSettings settings;
  settings.width_px = 80;
  settings.height_px = 60;
  settings.camera = *scene.camera;
  for (const Renderer renderer :
       {Renderer::kPrimary, Renderer::kDirect, Renderer::kPath, Renderer::kIgi}) {
    settings.renderer = renderer;
    const TileRect rect{0, 0, 80, 60};
    std::vector<float> wanted(3 * 80 * 60), found = wanted;
    TileRenderer tiles;
    tiles.render(*flat, settings, test::isas_here().back(), rect, wanted, nullptr, nullptr);
    tiles.render(*shared, settings, test::isas_here().back(), rect, found, nullptr, nullptr);
    EXPECT_EQ(wanted, found) << static_cast<int>(renderer);
  }
}

TEST(SharedPatches, ThatMoveAppearAndVanishSplitNoSurfaceAgain) {
  const unsigned seed = test::seed();
  TESSERA_TRACE_SEED(seed);
  Random random(seed);
  Scene scene = scene_of(kClasses[1], random);
  auto before = prepared(scene, Instancing::kAlways);
  for (int version = 0; version < 6; ++version) {
    if (version % 3 == 0) scene.instances[1].object_to_world = map_of(kClasses[1], 1, random);
    if (version % 3 == 1)
      scene.instances.push_back({0, map_of(kClasses[0], version, random), kSurface});
    if (version % 3 == 2) scene.instances.erase(scene.instances.begin() + 8);
    const auto after = prepared(scene, Instancing::kAlways, before.get());
    // splitting_of() may change with the number of patches, which it does not here.
    for (std::size_t s = 0; s < scene.surfaces.size(); ++s)
      EXPECT_EQ(places_of(*before).surfaces[s], places_of(*after).surfaces[s]);
    EXPECT_EQ(after->built_primitives(), scene.instances.size());
    const auto flat = prepared(scene, Instancing::kNever);
    expect_same_bounds(*flat, *after);
    const std::vector<CastRay> rays = rays_at(scene, 64 * 12, random);
    EXPECT_GT(test::compare_with_flattened(*flat, *after, rays), 0u);
    before = after;
  }
}

}  // namespace
}  // namespace tessera::core
