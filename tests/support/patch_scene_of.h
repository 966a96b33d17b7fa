// SPDX-License-Identifier: Apache-2.0
// Patches as an application describes them.
// Threads. Pure functions.
#pragma once

#include <memory>
#include <string>

#include "common/scene/scene.h"
#include "tests/support/patch_shapes.h"

namespace tessera::test {

inline std::shared_ptr<const PatchSurface> surface_of(
    const std::vector<core::CheckedPatch>& patches) {
  auto surface = std::make_shared<PatchSurface>();
  surface->materials = {0};
  for (const core::CheckedPatch& patch : patches) {
    surface->patches.push_back({static_cast<std::uint8_t>(patch.degree_u),
                                static_cast<std::uint8_t>(patch.degree_v),
                                std::uint8_t{patch.is_rational}});
    surface->numbers.insert(surface->numbers.end(), patch.numbers.begin(), patch.numbers.end());
  }
  return surface;
}

// A scene of one surface, by its name in patch_shapes.h, with one material.
inline Scene patch_scene_of(const std::string& shape) {
  Scene scene;
  scene.materials.resize(1);
  scene.surfaces = {surface_of(patch_shape(shape))};
  scene.instances = {{0, {}, ObjectKind::kPatchSurface}};
  return scene;
}

// Turned about z, and mirrored along it or not.
inline Transform turned_and_moved(float size, Vec3f to, bool is_mirrored) {
  Transform t;
  t.m[0] = {size * 0.8f, -size * 0.6f, 0, to.x};
  t.m[1] = {size * 0.6f, size * 0.8f, 0, to.y};
  t.m[2] = {0, 0, is_mirrored ? -size : size, to.z};
  return t;
}

}  // namespace tessera::test
