// SPDX-License-Identifier: Apache-2.0
#include "common/scene/validate.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <span>
#include <utility>

#include "tests/support/small_scene.h"

namespace tessera {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInf = std::numeric_limits<float>::infinity();

// Changes a copy of mesh `index`.
void change_mesh(Scene& scene, std::size_t index, const std::function<void(Mesh&)>& change) {
  auto mesh = std::make_shared<Mesh>(*scene.meshes[index]);
  change(*mesh);
  scene.meshes[index] = mesh;
}

template <class Change>
void change_sky(Scene& scene, Change change) {
  auto sky = std::make_shared<EnvironmentMap>(*scene.environment_map);
  change(*sky);
  scene.environment_map = sky;
}

TEST(ValidateScene, TheSmallSceneIsValid) {
  const Status status = validate_scene(test::make_small_scene());
  EXPECT_TRUE(status.is_ok()) << status.message();
}

TEST(ValidateScene, DefaultsOfEverySurfaceProgramAreInRange) {
  for (const SurfaceProgramShape& shape : surface_programs()) {
    Scene scene = test::make_small_scene();
    scene.materials[0].surface = {shape.kind, shape.defaults};
    EXPECT_TRUE(validate_scene(scene).is_ok()) << shape.name;
    EXPECT_EQ(find_surface_program(shape.name), find_surface_program(shape.kind));
  }
}

struct Spoiled {
  const char* word;
  std::function<void(Scene&)> spoil;
};

void expect_refused(std::span<const Spoiled> cases) {
  for (const auto& c : cases) {
    Scene scene = test::make_small_scene();
    SceneValidator warm;  // which knows the scene as it was
    EXPECT_TRUE(warm.validate(scene).is_ok());
    c.spoil(scene);
    const Status status = validate_scene(scene);
    EXPECT_EQ(warm.validate(scene).message(), status.message());
    EXPECT_FALSE(status.is_ok()) << c.word;
    EXPECT_NE(status.message().find(c.word), std::string::npos) << status.message();
  }
}

// One change of a scene, that may spoil it.
void change_something(Scene& scene, std::mt19937& random) {
  const auto below = [&random](std::size_t end) { return random() % end; };
  const bool is_any = !scene.instances.empty() && !scene.meshes.empty();
  switch (below(9)) {
    case 0:
      if (is_any) scene.instances[below(scene.instances.size())].object_to_world.m[0][3] += 1;
      break;
    case 1:
      if (is_any)
        scene.instances[below(scene.instances.size())].object_to_world.m[1][3] =
            below(3) == 0   ? kNan
            : below(2) == 0 ? 3e38f
                            : -3e38f;
      break;
    case 2:
      if (is_any)
        scene.instances[below(scene.instances.size())].mesh =
            static_cast<std::uint32_t>(below(scene.meshes.size() + 1));
      break;
    case 3:
      scene.instances.push_back({static_cast<std::uint32_t>(below(scene.meshes.size() + 1)), {}});
      break;
    case 4:
      if (!scene.instances.empty()) scene.instances.pop_back();
      break;
    case 5:
      if (is_any)
        change_mesh(scene, below(scene.meshes.size()), [&](Mesh& m) {
          constexpr float kPlaces[] = {kInf, 3e38f, -3e38f};
          const std::size_t place = below(6);
          m.positions[0].x = place < 3 ? kPlaces[place] : static_cast<float>(place);
        });
      break;
    case 6:
      if (!scene.meshes.empty())
        std::swap(scene.meshes[below(scene.meshes.size())], scene.meshes[0]);
      break;
    case 7:
      scene.materials.resize(1 + below(4));
      break;
    default:
      if (!scene.lights.empty()) scene.lights[0].intensity.x = below(3) == 0 ? -1.0f : 1.0f;
  }
}

TEST(ValidateScene, OneThatKnowsTheScenesBeforeSaysTheSame) {
  int good = 0, bad = 0;
  for (unsigned seed = 0; seed < 200; ++seed) {
    std::mt19937 random(seed);
    Scene scene = test::make_small_scene();
    Scene last_good = scene;
    SceneValidator warm;
    for (int step = 0; step < 30; ++step) {
      for (auto changes = random() % 3; changes > 0; --changes) change_something(scene, random);
      const Status status = validate_scene(scene);
      ASSERT_EQ(warm.validate(scene).message(), status.message()) << seed << ", " << step;
      ++(status.is_ok() ? good : bad);
      if (status.is_ok())
        last_good = scene;
      else if (random() % 2 == 0)
        scene = last_good;
    }
  }
  EXPECT_GT(good, 1000);
  EXPECT_GT(bad, 1000);
}

TEST(ValidateScene, SkiesThatCannotBeAreRefused) {
  const Spoiled cases[] = {
      {"environment's sides", [](Scene& s) { change_sky(s, [](auto& sky) { sky.width_px = 0; }); }},
      {"environment's sides",
       [](Scene& s) { change_sky(s, [](auto& sky) { sky.height_px = 1 << 20; }); }},
      {"do not fit", [](Scene& s) { change_sky(s, [](auto& sky) { sky.rgb.pop_back(); }); }},
      {"environment's texels",
       [](Scene& s) { change_sky(s, [](auto& sky) { sky.rgb[1] = kNan; }); }},
      {"environment's texels", [](Scene& s) { change_sky(s, [](auto& sky) { sky.rgb[1] = -1; }); }},
      {"environment's texels",
       [](Scene& s) { change_sky(s, [](auto& sky) { sky.rgb[1] = 1e30f; }); }},
  };
  expect_refused(cases);
}

TEST(ValidateScene, WhatCannotBeRenderedIsRefusedByName) {
  const Spoiled cases[] = {
      {"mesh 0", [](Scene& s) { change_mesh(s, 0, [](Mesh& m) { m.positions[2].y = kNan; }); }},
      {"mesh 0", [](Scene& s) { change_mesh(s, 0, [](Mesh& m) { m.positions[0].x = kInf; }); }},
      {"mesh 0", [](Scene& s) { change_mesh(s, 0, [](Mesh& m) { m.triangles[1][2] = 4; }); }},
      {"mesh 1", [](Scene& s) { change_mesh(s, 1, [](Mesh& m) { m.normals.pop_back(); }); }},
      {"mesh 1", [](Scene& s) { change_mesh(s, 1, [](Mesh& m) { m.uvs[0].x = kNan; }); }},
      {"mesh 0", [](Scene& s) { change_mesh(s, 0, [](Mesh& m) { m.materials.clear(); }); }},
      {"mesh 0", [](Scene& s) { change_mesh(s, 0, [](Mesh& m) { m.materials[1] = 3; }); }},
      {"mesh 1", [](Scene& s) { s.meshes[1] = nullptr; }},
      {"texture 0",
       [](Scene& s) {
         auto t = std::make_shared<Texture>(*s.textures[0]);
         t->rgba.pop_back();
         s.textures[0] = t;
       }},
      {"texture 0",
       [](Scene& s) {
         auto t = std::make_shared<Texture>(*s.textures[0]);
         t->width_px = 0;
         s.textures[0] = t;
       }},
      {"material 2", [](Scene& s) { s.materials[2].albedo_texture = 2; }},
      {"material 2", [](Scene& s) { s.materials[2].roughness_metalness_texture = 2; }},
      {"material 2", [](Scene& s) { s.materials[2].emission_texture = 2; }},
      {"material 2", [](Scene& s) { s.materials[2].normal_texture = 2; }},
      {"normals", [](Scene& s) { s.materials[2].normal_scale = kInf; }},
      {"specular", [](Scene& s) { s.materials[0].specular.y = 1.5f; }},
      {"roughness", [](Scene& s) { s.materials[0].roughness = kNan; }},
      {"metalness", [](Scene& s) { s.materials[0].metalness = -0.1f; }},
      {"refraction", [](Scene& s) { s.materials[0].ior = 0.9f; }},
      {"refraction", [](Scene& s) { s.materials[0].ior = kInf; }},
      {"BSDF", [](Scene& s) { s.materials[0].bsdf = static_cast<BsdfKind>(4); }},
      {"program", [](Scene& s) { s.materials[0].surface.kind = static_cast<SurfaceKind>(4); }},
      {"'height'", [](Scene& s) { s.materials[2].surface.parameters[1] = 0; }},
      {"'mortar'", [](Scene& s) { s.materials[2].surface.parameters[6] = kNan; }},
      {"material 0", [](Scene& s) { s.materials[0].albedo.x = kNan; }},
      {"material 1", [](Scene& s) { s.materials[1].emission.z = -1; }},
      {"material 1", [](Scene& s) { s.materials[1].emission.z = kInf; }},
      {"material", [](Scene& s) { s.materials.clear(); }},
      {"instance 2", [](Scene& s) { s.instances[2].mesh = 2; }},
      {"instance 1", [](Scene& s) { s.instances[1].object_to_world.m[0][3] = kNan; }},
      {"light 0", [](Scene& s) { s.lights[0].intensity.x = -1; }},
      {"light 1", [](Scene& s) { s.lights[1].direction = {}; }},
      {"light 1", [](Scene& s) { s.lights[1].cos_outer = 0.95f; }},
      {"light 2", [](Scene& s) { s.lights[2].direction.y = kInf; }},
      {"camera", [](Scene& s) { s.camera->up = {}; }},
      {"box",
       [](Scene& s) {
         s.instances[0].object_to_world.m[0][3] = 3e38f;
         s.instances[1].object_to_world.m[0][3] = -3e38f;
       }},
  };
  expect_refused(cases);
}

TEST(ValidateScene, LobesThatCannotBeAreRefusedByName) {
  const Spoiled cases[] = {
      {"grazing", [](Scene& s) { s.materials[2].specular_f90 = 1.5f; }},
      {"clearcoat", [](Scene& s) { s.materials[2].clearcoat.weight = kNan; }},
      {"clearcoat", [](Scene& s) { s.materials[2].clearcoat.roughness = 2; }},
      {"clearcoat normals", [](Scene& s) { s.materials[2].clearcoat.normal_scale = kInf; }},
      {"sheen", [](Scene& s) { s.materials[2].sheen.color.y = -1; }},
      {"transmission", [](Scene& s) { s.materials[2].transmission.weight = 1.01f; }},
      {"attenuation colour",
       [](Scene& s) { s.materials[2].transmission.attenuation_color.x = kNan; }},
      {"attenuation distance",
       [](Scene& s) { s.materials[2].transmission.attenuation_distance = -1; }},
      {"anisotropy", [](Scene& s) { s.materials[2].anisotropy.rotation = kInf; }},
      {"opacity", [](Scene& s) { s.materials[2].alpha.value = kNan; }},
      {"cutoff", [](Scene& s) { s.materials[2].alpha.cutoff = -0.1f; }},
      {"channel", [](Scene& s) { s.materials[2].alpha.channel = 4; }},
      {"set 0 or 1", [](Scene& s) { s.materials[2].sheen.color_texture.uv_set = 2; }},
      {"place", [](Scene& s) { s.materials[2].albedo_texture.uv_map[5] = kNan; }},
      {"texture 9 of 2", [](Scene& s) { s.materials[2].alpha.texture = 9; }},
      {"background", [](Scene& s) { s.background.high.z = -1; }},
      {"camera 'second'", [](Scene& s) { s.cameras[1].camera.vfov_degrees = 0; }},
      {"colour 1", [](Scene& s) { change_mesh(s, 1, [](Mesh& m) { m.colors[1].w = 1.25f; }); }},
      {"tangent 2", [](Scene& s) { change_mesh(s, 1, [](Mesh& m) { m.tangents[2].x = kNan; }); }},
      {"second texture", [](Scene& s) { change_mesh(s, 1, [](Mesh& m) { m.uvs1.pop_back(); }); }},
  };
  expect_refused(cases);
}

TEST(ValidateScene, BoundsHoldEveryInstance) {
  const Bounds3f bounds = scene_bounds(test::make_small_scene());
  // Mesh 1, turned by 90 degrees and moved: (2, 0, 1) becomes (5, 0, 1.5), (0, 2, 1) (3, -2, 1.5).
  EXPECT_EQ(bounds.lower, (Vec3f{0, -2, 0}));
  EXPECT_EQ(bounds.upper, (Vec3f{5, 1, 1.5f}));
  EXPECT_TRUE(scene_bounds(Scene{}).is_empty());
}

}  // namespace
}  // namespace tessera
