// SPDX-License-Identifier: Apache-2.0
// The inside of PreparedScene, for the renderer, tests and tools that trace rays of their own.
// Threads. Immutable after construction, as prepared_scene.h says.
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "slave/core/light/feature.h"
#include "slave/core/light/light_set.h"
#include "slave/core/primitive/patch/patch_support.h"
#include "slave/core/scene/geometry.h"
#include "slave/core/scene/prepared_scene.h"
#include "slave/core/scene/texture_table.h"
#include "slave/core/surface/texture.h"
#include "slave/core/trace/alpha_surfaces.h"

namespace tessera::core {

// What the scene at hand uses; shading skips the rest.
struct SurfaceFeatures {
  Feature has_textures{};
  Feature has_normals{};  // that differ from those of the triangles
  Feature has_programs{};
  Feature has_glossy{};    // any that scatter in lobes
  Feature has_specular{};  // mirror, glass, or glossy surfaces that pass light
  Feature has_colors{};    // of vertices
  Feature has_unlit{};
  Feature has_lobes{};         // optional ones of glossy surfaces
  Feature has_transmission{};  // glossy surfaces that pass light, or glass that dims it
  Feature is_rich{};           // any of these

  bool is_diffuse() const { return !has_glossy && !has_specular; }
  bool needs_cones() const { return has_textures || has_programs; }
};

struct PreparedScene::Impl {
  explicit Impl(std::shared_ptr<const Geometry> of)
      : geometry(std::move(of)),
        triangles(geometry->triangles),
        patches(geometry->patches.get()),
        index(geometry->index),
        meshes(geometry->meshes()),
        instances(geometry->instances) {}

  const std::shared_ptr<const Geometry> geometry;
  const TriangleStore& triangles;  // this and the next four belong to geometry
  const PatchStore* patches;       // null where the scene has none
  const PrimitiveIndex& index;
  const std::vector<std::shared_ptr<const Mesh>>& meshes;
  const std::vector<Instance>& instances;
  LightSet lights;
  SurfaceFeatures features;
  std::vector<std::shared_ptr<const MipMap>> textures;
  std::vector<TextureView> texture_views;  // of textures
  std::vector<TextureTable>
      texture_tables;  // by material; empty where features.has_textures is not
  std::vector<Material> materials;
  std::unique_ptr<const AlphaSurfaces> alpha;  // null: rays go through nothing

  // Whether what is placed is a surface of patches, and no mesh.
  bool is_patched(std::uint32_t instance) const {
    return kKnowsPatches && patches != nullptr &&
           instances[instance].kind == ObjectKind::kPatchSurface;
  }
  // The sub-patch that is the given primitive of an instance of patches, in world space, with its
  // patch. The answer holds until the thread asks again.
  PartInWorld part(std::uint32_t instance, std::uint64_t primitive) const {
    return patches->part_at(instance, primitive - triangles.instance_first[instance]);
  }
  // The number of its patch within the instance's surface.
  std::uint64_t patch_of_part(std::uint32_t instance, std::uint64_t primitive) const {
    return patches->patch_of_part(instance, primitive - triangles.instance_first[instance]);
  }
  // Whether any surface sends light of its own to the camera.
  bool has_glow() const {
    return !lights.emitters.empty() || lights.has_partial_emission || features.has_unlit;
  }
};

}  // namespace tessera::core
