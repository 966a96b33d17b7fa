// SPDX-License-Identifier: Apache-2.0
// A small scene that uses every kind of scene value: meshes with and without normals and uvs, a
// texture, every part of a material, a turned instance, lights of each kind, a camera.
// Threads. Pure function.
#pragma once

#include "common/scene/scene.h"

namespace tessera::test {

inline Scene make_small_scene() {
  Scene scene;
  auto plain = std::make_shared<Mesh>();
  plain->positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  plain->triangles = {{0, 1, 2}, {0, 2, 3}};
  plain->materials = {0, 1};
  auto rich = std::make_shared<Mesh>();
  rich->positions = {{0, 0, 1}, {2, 0, 1}, {0, 2, 1}};
  rich->normals = {{0, 0, 1}, {0, 0, 1}, {0, 1, 1}};
  rich->uvs = {{0, 0}, {1, 0}, {0, 1}};
  rich->uvs1 = {{0.5f, 0}, {1, 0.5f}, {0, 2}};
  rich->tangents = {{1, 0, 0, 1}, {1, 0, 0, -1}, {0, 1, 0, 1}};
  rich->colors = {{1, 0.5f, 0.25f, 1}, {1, 1, 1, 0.5f}, {0, 1, 0, 1}};
  rich->triangles = {{0, 1, 2}};
  rich->materials = {2};
  scene.meshes = {plain, rich};
  auto texture = std::make_shared<Texture>();
  texture->width_px = 2;
  texture->height_px = 1;
  texture->rgba = {255, 0, 0, 255, 0, 255, 0, 128};
  auto other = std::make_shared<Texture>();
  other->width_px = other->height_px = 1;
  other->is_srgb = false;
  other->wrap_u = TextureWrap::kMirror;
  other->wrap_v = TextureWrap::kClamp;
  other->is_nearest = true;
  other->rgba = {255, 1, 2, 156};
  scene.textures = {texture, other};
  scene.materials.resize(3);
  scene.materials[0].name = "plain";
  scene.materials[1].emission = {5, 4, 3};
  Material& rich_material = scene.materials[2];
  rich_material.albedo_texture = rich_material.roughness_metalness_texture = 0;
  rich_material.emission_texture = rich_material.normal_texture = 0;
  rich_material.normal_scale = 0.75f;
  rich_material.bsdf = BsdfKind::kGlossy;
  rich_material.specular = {0.5f, 0.25f, 0.125f};
  rich_material.roughness = 0.3f;
  rich_material.metalness = 0.7f;
  rich_material.ior = 1.7f;
  rich_material.specular_f90 = 0.9f;
  rich_material.specular_texture = rich_material.specular_color_texture = 1;
  rich_material.clearcoat = {0.4f, 0.1f, 0, 1, 0, 0.5f};
  rich_material.sheen = {{0.1f, 0.2f, 0.3f}, 0.6f, 0, 1};
  rich_material.transmission = {0.25f, 1, false, {0.9f, 0.8f, 0.7f}, 2.5f};
  rich_material.anisotropy = {0.5f, 1.25f, 1};
  rich_material.anisotropy.texture.uv_set = 1;
  rich_material.anisotropy.texture.uv_map = {2, 0, 0.5f, 0, 3, -0.5f};
  rich_material.alpha = {AlphaMode::kBlend, 0.75f, 0.25f, 0, 2};
  rich_material.is_double_sided = true;
  rich_material.surface = {SurfaceKind::kBrick, {0.5f, 0.25f, 0.125f, 0.4f, 0.3f, 0.2f, 0.1f}};
  Transform turned;
  turned.m = {{{0, -1, 0, 5}, {1, 0, 0, -2}, {0, 0, 1, 0.5f}}};
  scene.instances = {{0, Transform{}}, {1, turned}, {0, turned}};
  scene.lights = {{LightKind::kPoint, {1, 2, 3}, {0, -1, 0}, {10, 10, 10}, 1, 0},
                  {LightKind::kSpot, {0, 3, 0}, {0, -1, 0}, {5, 5, 5}, 0.9f, 0.7f},
                  {LightKind::kDirectional, {}, {1, -1, 0}, {1, 1, 0.5f}, 1, 0}};
  scene.environment = {0.5f, 1, 2};
  auto sky = std::make_shared<EnvironmentMap>();
  sky->width_px = 2;
  sky->height_px = 1;
  sky->rgb = {0, 0.25f, 1, 3, 2, 1e5f};
  scene.environment_map = sky;
  scene.background = {BackgroundKind::kGradient, {0.1f, 0.2f, 0.3f}, {0.4f, 0.5f, 0.6f}};
  scene.cameras = {{"first", {{0, 1, 6}, {0, 0.5f, 0}, {0, 1, 0}, 40}},
                   {"second", {{3, 1, 6}, {0, 0.5f, 0}, {0, 1, 0}, 30}}};
  scene.camera = Camera{{0, 1, 6}, {0, 0.5f, 0}, {0, 1, 0}, 40};
  return scene;
}

}  // namespace tessera::test
